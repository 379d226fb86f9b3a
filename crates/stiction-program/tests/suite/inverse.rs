//! Programs of inverse dynamics compared with the general solvers from which they were recorded.

use crate::common::Robot;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, LoadAxes};
use stiction_core::mechanism::BodyId;
use stiction_core::spatial::Vec3;
use stiction_program::{InverseProgram, RecordError, StateOfMotion};

/// Largest differences between a program and the solver along the motion, without and with
/// friction, relative to the largest force; moments are divided by the characteristic length.
fn compare(robot: &mut Robot, program: &InverseProgram) -> f64 {
    let (drives, joints, interfaces) = program.sizes();
    let length = robot.solver.mechanism().characteristic_length();
    let mut memory = program.memory(1);
    let mut worst = 0.0_f64;
    let mut settled = [false];
    for targets in robot.signal.clone() {
        robot.solver.move_to(&targets).unwrap();
        robot.solver.settings_mut().friction = FrictionMode::Converged;
        let forces = robot.solver.solve(&robot.loads).unwrap().clone();
        let state = robot.solver.state();
        program.set(&mut memory, 0, state, &targets, &robot.loads);
        program.run_frictionless(&mut memory, &mut settled);
        assert!(settled[0]);
        let ideal: Vec<f64> = (0..drives).map(|k| program.ideal_drive(&memory, 0, k)).collect();
        program.run(&mut memory, &mut settled);
        assert!(settled[0]);
        let scale = forces.reactions.iter().map(|(f, _)| f.norm()).fold(1e-300, f64::max);
        let mut differs = |found: f64, expected: f64, unit: f64| {
            worst = worst.max((found - expected).abs() / (scale * unit));
        };
        for drive in 0..drives {
            let found = program.drive(&memory, 0, drive);
            differs(found, forces.efforts[drive], length.max(1.0));
            differs(ideal[drive], forces.efforts_frictionless[drive], length.max(1.0));
        }
        for joint in 0..joints {
            let found = program.reaction(&memory, 0, joint);
            let (force, moment) = forces.reactions[joint];
            for i in 0..3 {
                differs(found[i], force.to_array()[i], 1.0);
                differs(found[3 + i], moment.to_array()[i], length);
            }
        }
        for interface in 0..interfaces {
            let [load, velocity, friction] = program.interface(&memory, 0, interface);
            let expected = &forces.interfaces[interface];
            differs(load, expected.load, 1.0);
            differs(friction, expected.limit, 1.0);
            assert!((velocity - expected.velocity).abs() < 1e-12);
        }
    }
    worst
}

const ROBOTS: [(&str, Option<&str>); 12] = [
    ("6sps", None),
    ("delta", None),
    ("four-bar", None),
    ("bricard", None),
    ("five-bar", None),
    ("slider-crank", None),
    ("3rrr", None),
    ("andrews", None),
    ("3rps", None),
    ("zhang2018-regular", Some("L1")),
    ("gough", None),
    ("3upu", None),
];

/// Actuator forces, reactions, normal loads and frictions agree with the solver, interpreted and
/// compiled.
#[test]
fn programs_agree_with_their_solvers() {
    for (name, load) in ROBOTS {
        let mut robot = Robot::new(name, load);
        for machine in [false, true] {
            let (signal, loads) = (robot.signal.clone(), robot.loads.clone());
            let program = InverseProgram::record_with(&robot.solver, &signal, &loads, machine)
                .unwrap_or_else(|error| panic!("{name}: {error}"));
            // Rounding magnified by condition numbers of some hundred.
            let worst = compare(&mut robot, &program);
            assert!(worst < 1e-12, "{name}, machine {machine}: {worst}");
        }
    }
}

/// Code for several lanes has the same result for each state as code for one state. A state with an
/// interface at rest is detected, even if it is the only one among its neighbours.
#[test]
fn lanes_are_states_of_their_own() {
    for (name, load) in ROBOTS {
        let mut robot = Robot::new(name, load);
        let (signal, loads) = (robot.signal.clone(), robot.loads.clone());
        let program = InverseProgram::record(&robot.solver, &signal, &loads).unwrap();
        let lanes = program.lanes();
        let (mut one, mut many) = (program.memory(1), program.memory(lanes));
        let mut settled = vec![false; lanes];
        let mut expected = Vec::new();
        for lane in 0..lanes {
            let mut targets = signal[lane % signal.len()].clone();
            if lane == 1 {
                // Everything is at rest.
                targets.iter_mut().for_each(|target| target.rate = 0.0);
            }
            robot.solver.move_to(&targets).unwrap();
            let state = robot.solver.state();
            program.set(&mut one, 0, state, &targets, &loads);
            program.set(&mut many, lane, state, &targets, &loads);
            let mut alone = [false];
            program.run(&mut one, &mut alone);
            let drives: Vec<f64> =
                (0..program.sizes().0).map(|k| program.drive(&one, 0, k)).collect();
            expected.push((alone[0], drives));
        }
        program.run(&mut many, &mut settled);
        let has_friction = program.sizes().2 > 0;
        for (lane, (alone, drives)) in expected.iter().enumerate() {
            assert_eq!(
                (settled[lane], *alone),
                (lane != 1 || !has_friction, settled[lane]),
                "{name}"
            );
            for (k, drive) in drives.iter().enumerate().filter(|_| *alone) {
                let found = program.drive(&many, lane, k);
                assert!(
                    (found - drive).abs() <= 1e-12 * drive.abs().max(1.0),
                    "{name}: {found} {drive}"
                );
            }
        }
    }
}

/// Many states at once: states at which the program is invalid are left to the solver and counted.
#[test]
fn invalid_states_are_solved_again() {
    let mut robot = Robot::new("3rps", None);
    let program = InverseProgram::record(&robot.solver, &robot.signal, &robot.loads).unwrap();
    let mut solver = robot.solver.clone();
    let mut targets = robot.signal.clone();
    // Everything is at rest, interfaces included.
    for rest in [3, 7] {
        targets[rest].iter_mut().for_each(|target| target.rate = 0.0);
    }
    let mut motions = Vec::new();
    let mut expected = Vec::new();
    for targets in &targets {
        robot.solver.move_to(targets).unwrap();
        motions.push(program.motions(robot.solver.state()));
        expected.push(robot.solver.solve(&robot.loads).unwrap().clone());
    }
    let states: Vec<StateOfMotion<'_>> = targets
        .iter()
        .zip(&motions)
        .map(|(targets, bodies)| {
            let loads = &robot.loads;
            StateOfMotion { bodies, coordinates: &[], targets, loads }
        })
        .collect();
    let mut told = Vec::new();
    let redone = program.run_all(&mut solver, &states, |forces| {
        let expected = &expected[forces.state];
        for (found, wanted) in forces.drives.iter().zip(&expected.efforts) {
            assert!((found - wanted).abs() <= 1e-12 * wanted.abs().max(1.0), "{}", forces.state);
        }
        for (found, (force, moment)) in forces.reactions.iter().zip(&expected.reactions) {
            let wanted = [force.to_array(), moment.to_array()].concat();
            for (found, wanted) in found.iter().zip(wanted) {
                assert!((found - wanted).abs() <= 1e-10, "{}", forces.state);
            }
        }
        told.push((forces.state, forces.redone));
    });
    assert_eq!(redone.unwrap(), 2);
    let wanted: Vec<_> = (0..10).map(|state| (state, state == 3 || state == 7)).collect();
    assert_eq!(told, wanted);
}

/// A motion that cannot be followed, or an empty one, is rejected.
#[test]
fn mechanisms_without_a_program_are_refused() {
    let robot = Robot::new("3rps", None);
    let mut signal = robot.signal.clone();
    signal[3][0].value = 1e3;
    let refused = |signal: &[_]| {
        InverseProgram::record(&robot.solver, signal, &robot.loads).map(|_| ()).unwrap_err()
    };
    assert!(matches!(refused(&signal), RecordError::Signal { position: 3, .. }));
    assert_eq!(refused(&[]), RecordError::EmptySignal);
}

/// Programs are small: the equations of motion of a robot with three legs and all its reactions
/// take less than a thousand operations.
#[test]
fn equal_values_are_computed_once() {
    let robot = Robot::new("3rps", None);
    let program = InverseProgram::record(&robot.solver, &robot.signal, &robot.loads).unwrap();
    let [ideal, first, step, last] = program.operations();
    assert!(ideal < 900 && first < 1200 && step < 480 && last < 230, "{:?}", program.operations());
}

/// Inputs have no names, so a wrong number of inputs must be rejected.
#[test]
fn inputs_must_match_the_recording() {
    let robot = Robot::new("3rps", None);
    let (solver, signal, loads) = (&robot.solver, &robot.signal, &robot.loads);
    let program = InverseProgram::record(solver, signal, loads).unwrap();
    let state = solver.state();
    let is_refused = |lane: usize, loads: &[AppliedLoad<f64>], flags: usize| {
        let run = || {
            let mut memory = program.memory(1);
            program.set(&mut memory, lane, state, &signal[0], loads);
            program.run(&mut memory, &mut vec![false; flags]);
        };
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err()
    };
    let elsewhere: Vec<_> = loads
        .iter()
        .map(|load| AppliedLoad { point: load.point + Vec3::new(0.1, 0.0, 0.0), ..*load })
        .collect();
    let zero = Vec3::new(0.0, 0.0, 0.0);
    let one = AppliedLoad {
        body: BodyId(1),
        point: zero,
        axes: LoadAxes::World,
        force: zero,
        moment: zero,
    };
    let more = [&loads[..], &[one]].concat();
    assert!(!is_refused(0, loads, 1));
    assert!(is_refused(1, loads, 1) && is_refused(0, loads, 0) && is_refused(0, &more, 1));
    assert!(loads.is_empty() || is_refused(0, &elsewhere, 1));
}
