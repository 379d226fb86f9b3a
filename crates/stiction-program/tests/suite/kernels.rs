//! Solvers with a recorded program in place of their kernels, compared with solvers without one.

use crate::common::Robot;
use stiction_core::dynamics::{FrictionMode, InverseDynamics};
use stiction_core::statics::AppliedLoad;
use stiction_program::{RecordError, RecordedKernels};

/// Returns the numbers of a solved sample, each list with the scale of its differences.
fn numbers(solver: &mut InverseDynamics, loads: &[AppliedLoad<f64>]) -> Vec<(Vec<f64>, f64)> {
    let forces = solver.solve(loads).unwrap().clone();
    let length = solver.mechanism().characteristic_length();
    let scale = forces.reactions.iter().map(|(f, _)| f.norm()).fold(1e-300, f64::max);
    let vectors = |all: &[[f64; 3]]| all.concat();
    let (force, moment): (Vec<_>, Vec<_>) =
        forces.reactions.iter().map(|(f, m)| (f.to_array(), m.to_array())).unzip();
    let bodies = solver.bodies();
    let twists = bodies.twist.iter().chain(&bodies.acceleration);
    let twists: Vec<f64> =
        twists.flat_map(|t| [t.angular.to_array(), t.linear.to_array()].concat()).collect();
    let places: Vec<f64> = bodies.pose.iter().flat_map(|p| p.position.to_array()).collect();
    let largest = twists.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
    let coupling = vec![solver.coupling().unwrap()];
    let reversed = solver.reversed_efforts().unwrap_or_default();
    let actuators = forces.efforts.len();
    let shares = solver.shares();
    let shares: Vec<f64> = (0..actuators).flat_map(|k| shares.of_actuator(k)).collect();
    let effort = scale * length.max(1.0);
    vec![
        (forces.efforts, effort),
        (forces.efforts_frictionless, effort),
        (shares, effort),
        (reversed, effort),
        (vectors(&force), scale),
        (vectors(&moment), scale * length),
        (forces.interfaces.iter().map(|interface| interface.load).collect(), scale),
        (twists, largest),
        (places, length),
        (coupling, 1.0),
        (vec![solver.side().unwrap_or(0.0), solver.closure_error()], 1.0),
    ]
}

/// Forces, motions, contributions and bounds agree with those of the kernels; so do those at rest
/// and under other loads, where the kernels compute them.
#[test]
fn solvers_with_programs_agree_with_their_kernels() {
    let mut recorded = 0;
    for (name, load) in [
        ("3rps", None),
        ("gough", None),
        ("delta", None),
        ("zhang2018-regular", Some("L1")),
        ("3upu", None),
        ("five-bar", None),
        ("slider-crank", None),
    ] {
        let Robot { mut solver, signal, loads } = Robot::new(name, load);
        solver.settings_mut().friction = FrictionMode::Converged;
        let program = match RecordedKernels::record(&solver, &signal, &loads) {
            Ok(program) => program,
            Err(RecordError::NotNative) => return,
            Err(error) => {
                assert_eq!(error, RecordError::Redundant, "{name}");
                continue;
            }
        };
        recorded += 1;
        let mut with = solver.clone();
        assert!(with.use_program(program, &loads), "{name}");
        for (k, targets) in signal.iter().enumerate() {
            let mut targets = targets.clone();
            let mut loads = loads.clone();
            match k {
                3 => targets.iter_mut().for_each(|target| target.rate = 0.0),
                4 => loads.clear(),
                _ => {}
            }
            solver.move_to(&targets).unwrap();
            with.move_to(&targets).unwrap();
            assert!(with.moves_by_program(), "{name} {k}");
            let expected = numbers(&mut solver, &loads);
            for (list, ((found, scale), (expected, _))) in
                numbers(&mut with, &loads).into_iter().zip(expected).enumerate()
            {
                assert_eq!(found.len(), expected.len(), "{name} {k} {list}");
                for (found, expected) in found.into_iter().zip(expected) {
                    let error = (found - expected).abs() / scale;
                    assert!(error < 1e-12, "{name} {k} {list}: {found} {expected}");
                }
            }
        }
    }
    assert!(recorded >= 2, "{recorded}");
}
