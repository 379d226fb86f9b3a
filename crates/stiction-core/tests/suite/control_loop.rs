//! The real-time function of a controller, [`Model::inverse_dynamics`]: the same forces as the
//! checked solver, a correct status if there are no forces, and no allocation.

use crate::common::random::*;
use crate::common::*;
use crate::counting::allocations;
use stiction_core::dynamics::{Data, FrictionMode, InverseDynamics, Model, Settings, Status};
use stiction_core::joint::JointType::*;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{BodySpec, JointId, JointSpec, Mechanism, MechanismBuilder};
use stiction_core::spatial::Pose;

/// Splits targets into values, rates and accelerations.
fn split(targets: &[Target<f64>]) -> [Vec<f64>; 3] {
    let each = |part: fn(&Target<f64>) -> f64| targets.iter().map(part).collect();
    [each(|t| t.value), each(|t| t.rate), each(|t| t.acceleration)]
}

#[test]
fn agrees_with_the_checked_solver_and_allocates_nothing() {
    let (mut compared, mut locked) = (0, 0);
    for class in CLASSES {
        for (mode, seed) in [
            (FrictionMode::Off, 3),
            (FrictionMode::OnePass, 4),
            (FrictionMode::Converged, 5),
            (FrictionMode::Converged, 6),
        ] {
            let what = format!("{class:?} {mode:?} {seed}");
            let (_, case) = case(class, seed, 0.05);
            let Some((mut solver, _)) = case.regular_solver(mode) else { continue };
            let Ok(model) = solver.model() else { continue };
            let mut data = model.data(solver.state(), *solver.settings());
            let [q, v, a] = split(&case.targets);
            // Start beside the configuration: every prescribed coordinate has a small error.
            let beside: Vec<f64> = q.iter().map(|q| q + 1e-4).collect();
            let _ = model.inverse_dynamics(&mut data, &beside, &v, &a, &case.loads);
            let mut status = Status::Singular;
            let run = || status = model.inverse_dynamics(&mut data, &q, &v, &a, &case.loads);
            assert_eq!(allocations(run), 0, "{what}");
            let Ok(forces) = solver.solve(&case.loads) else {
                assert!(!status.is_converged(), "{what}: {status:?}");
                locked += 1;
                continue;
            };
            if !status.is_converged() {
                // Cases that only the checked solver solves, by continuation from zero friction.
                assert!(matches!(
                    status,
                    Status::FrictionNotConverged { .. } | Status::FrictionLocks
                ));
                continue;
            }
            compared += 1;
            let scale = forces.reactions.iter().map(|(f, _)| f.norm()).fold(1e-3, f64::max);
            let close = |a: f64, b: f64| (a - b).abs() < 1e-9 * scale;
            assert!(
                data.efforts().iter().zip(&forces.efforts).all(|(a, b)| close(*a, *b)),
                "{what}"
            );
            for (joint, (force, moment)) in forces.reactions.iter().enumerate() {
                let (f, m) = data.reaction(joint);
                let apart = (f - *force).norm().max((m - *moment).norm());
                assert!(close(apart, 0.0), "{what}: joint {joint}, {apart:e} of {scale}");
            }
            for (a, b) in data.friction().iter().zip(&forces.interfaces) {
                assert!(close(a.friction, b.friction) && close(a.load, b.load), "{what}");
            }
            assert!(data.power().residual().abs() <= 1e-9 * (1e-3 + data.power().turnover));
        }
    }
    assert!(compared > 20, "only {compared} compared, {locked} without forces");
}

/// Creates a four-bar linkage with dry friction at the pins; the crank of 0.1 m is prescribed and
/// actuated.
fn four_bar(mu: f64) -> (InverseDynamics, Model, Data<f64>) {
    let solver = InverseDynamics::new(
        four_bar_mechanism(mu),
        &[],
        &[Coordinate::Joint { joint: JointId(0), dof: 0 }],
        &[Target { value: 1.0, rate: 0.0, acceleration: 0.0 }],
        Settings::default(),
    )
    .unwrap();
    let model = solver.model().unwrap();
    let data = model.data(solver.state(), Settings::default());
    (solver, model, data)
}

fn four_bar_mechanism(mu: f64) -> Mechanism {
    let bar = |name: &str, length: f64| {
        BodySpec::new(name)
            .mass(1.0)
            .com(v(length / 2.0, 0.0, 0.0))
            .inertia(diagonal(1e-3, 1e-3, 1e-3))
    };
    let at = |x| Pose::at(v(x, 0.0, 0.0));
    let dry = friction(mu, 0.0, Some(0.01));
    let pin = |name: &str, from: &str, to: &str| {
        JointSpec::new(name, Revolute, from, to).friction(dry.clone())
    };
    MechanismBuilder::new("four-bar")
        .gravity(v(0.0, -9.81, 0.0))
        .body(bar("crank", 0.1))
        .body(bar("coupler", 0.4))
        .body(bar("rocker", 0.3))
        .joint(pin("A", "ground", "crank").actuated().start([1.0]))
        .joint(pin("B", "crank", "coupler").frames(at(0.1), at(0.0)).start([-0.5]))
        .joint(pin("C", "coupler", "rocker").frames(at(0.4), at(0.3)).start([1.0]))
        .joint(pin("D", "ground", "rocker").frames(at(0.4), at(0.0)).start([1.5]))
        .build()
        .unwrap()
}

/// A full turn of the crank at 1 kHz: the loop stays closed, with each step starting from the
/// previous one.
#[test]
fn follows_a_motion_at_the_clock_of_a_controller() {
    let (mut solver, model, mut data) = four_bar(0.15);
    let rate = std::f64::consts::TAU;
    let mut before = 0.0;
    for step in 0..=1000 {
        let time = f64::from(step) * 1e-3;
        let status = model.inverse_dynamics(&mut data, &[1.0 + rate * time], &[rate], &[0.0], &[]);
        assert_eq!(status, Status::Converged, "at {time} s");
        let target = |t: f64| Target { value: 1.0 + rate * t, rate, acceleration: 0.0 };
        if step == 0 {
            solver.move_to(&[target(0.0)]).unwrap();
        }
        solver.follow(before, time, |t, targets| targets[0] = target(t)).unwrap();
        before = time;
        let expected = solver.solve(&[]).unwrap().efforts[0];
        let effort = data.efforts()[0];
        assert!((effort - expected).abs() < 1e-10, "{effort} instead of {expected} at {time} s");
    }
}

#[test]
fn parameters_are_tuned_at_run_time() {
    let (_, model, mut data) = four_bar(0.15);
    let mut parameters = model.parameters().clone();
    for interface in &mut parameters.interfaces {
        interface.law.mu = 0.3;
    }
    let status = model.inverse_dynamics_with(&parameters, &mut data, &[1.0], &[2.0], &[0.0], &[]);
    assert_eq!(status, Status::Converged);
    let (_, other, mut expected) = four_bar(0.3);
    assert!(other.inverse_dynamics(&mut expected, &[1.0], &[2.0], &[0.0], &[]).is_converged());
    assert!((data.efforts()[0] - expected.efforts()[0]).abs() < 1e-12);
}

#[test]
fn missing_forces_are_explained() {
    let (_, model, mut data) = four_bar(0.15);
    let mut run = |q: f64, v: f64| model.inverse_dynamics(&mut data, &[q], &[v], &[0.0], &[]);
    assert_eq!(run(1.0, 1.0), Status::Converged);
    assert_eq!(run(f64::NAN, 1.0), Status::InputNotFinite);
    assert_eq!(run(1.0, f64::INFINITY), Status::InputNotFinite);
    assert_eq!(run(1.01, 1.0), Status::Converged, "the warm start is still good");

    // Out of reach: with a crank of 0.5 m, the four-bar linkage cannot turn fully.
    let mut parameters = model.parameters().clone();
    parameters.frame_j[1].position = v(0.5, 0.0, 0.0);
    let status = model.inverse_dynamics_with(&parameters, &mut data, &[3.1], &[1.0], &[0.0], &[]);
    assert!(matches!(status, Status::LoopsOpen { .. }), "{status:?}");
    let status = model.inverse_dynamics(&mut data, &[1.02], &[1.0], &[0.0], &[]);
    assert_eq!(status, Status::Converged, "the warm start is the last closed configuration");

    // One step of the friction coupling is not enough.
    data.settings.friction_steps = 1;
    let status = model.inverse_dynamics(&mut data, &[1.03], &[1.0], &[0.0], &[]);
    assert!(
        matches!(status, Status::FrictionNotConverged { change } if change > 0.0),
        "{status:?}"
    );
}
