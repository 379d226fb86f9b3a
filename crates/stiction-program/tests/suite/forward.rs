//! Programs of forward dynamics compared with the general solvers of inverse and forward dynamics.

use crate::common::{Robot, model};
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, Settings};
use stiction_core::forward::{
    Event, EventKind, Forward, Inputs, Settings as ForwardSettings, View,
};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{BodyId, JointId};
use stiction_core::random::Random;
use stiction_core::spatial::{Pose, Vec3};
use stiction_format::gallery;
use stiction_program::{ForwardProgram, Memory, RecordError};

/// The same robot with its actuators prescribed along the same motion.
fn by_actuators(robot: &Robot) -> Robot {
    let mechanism = robot.solver.mechanism().clone();
    let actuators: Vec<(JointId, usize)> = mechanism.actuators().collect();
    let coordinates: Vec<_> =
        actuators.iter().map(|&(joint, dof)| Coordinate::Joint { joint, dof }).collect();
    let mut solver = robot.solver.clone();
    let mut signal = Vec::new();
    for targets in &robot.signal {
        solver.move_to(targets).unwrap();
        let rates = solver.actuator_rates();
        let at = |(&(joint, dof), rate): (&(JointId, usize), f64)| Target {
            value: solver.joint_coordinates(joint)[dof],
            rate,
            acceleration: 1.0,
        };
        signal.push(actuators.iter().zip(rates).map(at).collect::<Vec<_>>());
    }
    solver.move_to(&robot.signal[0]).unwrap();
    let initial_poses: Vec<_> = (1..mechanism.bodies().len())
        .map(|body| (BodyId(body), mechanism.base().inverse() * world_pose(&solver, body)))
        .collect();
    let solver = InverseDynamics::new(
        mechanism,
        &initial_poses,
        &coordinates,
        &signal[0],
        Settings::default(),
    )
    .unwrap();
    Robot { solver, signal, loads: robot.loads.clone() }
}

fn world_pose(solver: &InverseDynamics, body: usize) -> Pose<f64> {
    let pose = solver.bodies().pose[body];
    Pose { position: pose.position + solver.parameters().origin, ..pose }
}

fn record(robot: &Robot, machine: bool) -> ForwardProgram {
    ForwardProgram::record_with(&robot.solver, &robot.signal, &robot.loads, machine).unwrap()
}

/// Largest difference relative to the largest number of both lists.
fn apart(found: &[f64], wanted: &[f64]) -> f64 {
    assert_eq!(found.len(), wanted.len());
    let largest = found.iter().chain(wanted).fold(1e-9_f64, |max, x| max.max(x.abs()));
    let each = found.iter().zip(wanted).map(|(a, b)| (a - b).abs());
    each.fold(0.0, |max, x| if x > max || x.is_nan() { x } else { max }) / largest
}

/// Forces and moments of the reactions, in separate lists.
fn split(reactions: impl Iterator<Item = [f64; 6]>) -> [Vec<f64>; 2] {
    let mut lists = [Vec::new(), Vec::new()];
    for wrench in reactions {
        lists[0].extend_from_slice(&wrench[..3]);
        lists[1].extend_from_slice(&wrench[3..]);
    }
    lists
}

fn wrenches(reactions: &[(Vec3<f64>, Vec3<f64>)]) -> [Vec<f64>; 2] {
    split(reactions.iter().map(|(f, m)| {
        let ([a, b, c], [d, e, g]) = (f.to_array(), m.to_array());
        [a, b, c, d, e, g]
    }))
}

struct Found {
    coordinates: Vec<f64>,
    tree: Vec<f64>,
    reactions: [Vec<f64>; 2],
    interfaces: Vec<[f64; 3]>,
}

fn found(program: &ForwardProgram, memory: &Memory, lane: usize, friction: bool) -> Found {
    let [targets, dofs, joints, interfaces] = program.sizes();
    Found {
        coordinates: (0..targets)
            .map(|k| match friction {
                true => program.acceleration(memory, lane, k),
                false => program.ideal_acceleration(memory, lane, k),
            })
            .collect(),
        tree: (0..dofs)
            .map(|k| match friction {
                true => program.tree_acceleration(memory, lane, k),
                false => program.ideal_tree_acceleration(memory, lane, k),
            })
            .collect(),
        reactions: split((0..joints).map(|k| match friction {
            true => program.reaction(memory, lane, k),
            false => program.ideal_reaction(memory, lane, k),
        })),
        interfaces: (0..interfaces).map(|k| program.interface(memory, lane, k)).collect(),
    }
}

const ROBOTS: [(&str, Option<&str>); 5] = [
    ("3rps", None),
    ("zhang2018-regular", Some("L1")),
    ("gough", None),
    ("3upu", None),
    ("4ups-upu", None),
];

/// Random rates and accelerations at a position of the motion.
fn random_rates(signal: &[Target<f64>], random: &mut Random, length: f64) -> Vec<Target<f64>> {
    let any = |target: &Target<f64>| Target {
        value: target.value + 0.01 * length.min(1.0) * random.number(),
        rate: 0.3 * random.number(),
        acceleration: 3.0 * random.number(),
    };
    signal.iter().map(any).collect()
}

/// The efforts from inverse dynamics cause the accelerations for which they were computed, and the
/// same reactions, for any choice of independent coordinates, interpreted and compiled.
#[test]
fn efforts_of_inverse_dynamics_cause_the_accelerations() {
    for (name, load) in ROBOTS {
        let given = Robot::new(name, load);
        // With its actuators as coordinates, the elimination of 4ups-upu lets the bounds on
        // rounding errors exceed all values.
        for mut robot in [by_actuators(&given), given] {
            for machine in [false, true] {
                let (compared, worst) = return_from_inverse(&mut robot, machine);
                // Rounding magnified by condition numbers of some hundred.
                assert!(worst < 1e-12, "{name}, machine {machine}: {worst:e}");
                assert!(compared >= 8, "{name}: {compared}");
            }
        }
    }
}

/// Returns the number of states at which forward and inverse dynamics were compared, and the
/// largest difference.
fn return_from_inverse(robot: &mut Robot, machine: bool) -> (usize, f64) {
    let length = robot.solver.mechanism().characteristic_length();
    let mut random = Random::new(5);
    let program = record(robot, machine);
    let mut memory = program.memory(1);
    let mut settled = [false];
    let (mut compared, mut worst) = (0, 0.0_f64);
    for signal in robot.signal.clone() {
        let targets = random_rates(&signal, &mut random, length);
        robot.solver.move_to(&targets).unwrap();
        robot.solver.settings_mut().friction = FrictionMode::Off;
        let ideal_forces = robot.solver.solve(&robot.loads).unwrap().clone();
        robot.solver.settings_mut().friction = FrictionMode::Converged;
        let state = robot.solver.state().clone();
        let derivatives: Vec<f64> = targets.iter().map(|t| t.acceleration).collect();
        let mut compare = |found: &Found, reactions: &[(Vec3<f64>, Vec3<f64>)]| {
            let reactions = wrenches(reactions);
            for difference in [
                apart(&found.coordinates, &derivatives),
                apart(&found.tree, &state.accelerations),
                apart(&found.reactions[0], &reactions[0]),
                apart(&found.reactions[1], &reactions[1]),
            ] {
                worst = if difference.is_nan() { f64::INFINITY } else { worst.max(difference) };
            }
        };
        program.set(&mut memory, 0, &state, &robot.loads, &ideal_forces.efforts);
        program.run_frictionless(&mut memory, &mut settled);
        assert!(settled[0]);
        compare(&found(&program, &memory, 0, false), &ideal_forces.reactions);
        // With strong friction, the same efforts may permit several motions.
        let Ok(forces) = robot.solver.solve(&robot.loads).cloned() else { continue };
        if robot.solver.coupling().is_none_or(|coupling| coupling > 0.9) {
            continue;
        }
        program.set(&mut memory, 0, &state, &robot.loads, &forces.efforts);
        program.run(&mut memory, &mut settled);
        // A value may have a sign that did not occur in any sample; the program then reports this.
        if !settled[0] {
            continue;
        }
        let real = found(&program, &memory, 0, true);
        compare(&real, &forces.reactions);
        let scale = forces.interfaces.iter().fold(1e-9_f64, |max, c| max.max(c.load));
        for ([load, velocity, friction], expected) in real.interfaces.iter().zip(&forces.interfaces)
        {
            worst = worst.max((load - expected.load).abs() / scale);
            worst = worst.max((friction - expected.limit).abs() / scale);
            assert!((velocity - expected.velocity).abs() < 1e-12);
        }
        compared += 1;
    }
    (compared, worst)
}

struct Given {
    efforts: Vec<f64>,
    loads: Vec<AppliedLoad<f64>>,
}

impl Inputs for Given {
    fn efforts(&mut self, _: &View<'_>, efforts: &mut [f64]) {
        efforts.copy_from_slice(&self.efforts);
    }
    fn loads(&mut self, _: &View<'_>, loads: &mut Vec<AppliedLoad<f64>>) {
        loads.extend_from_slice(&self.loads);
    }
}

/// For arbitrary efforts, programs agree with the general solver of forward dynamics, which uses
/// other unknowns and another elimination; lanes agree with single states.
#[test]
fn programs_agree_with_forward_dynamics() {
    for (name, load) in ROBOTS {
        agrees_with_forward_dynamics(name, Robot::new(name, load));
    }
}

/// The same with friction that does not depend on normal loads, in some joints or in all, with
/// preloads, and with lead screws.
#[test]
fn programs_agree_for_all_kinds_of_friction() {
    let universal = "friction = { mu = 0.05, radius = \"12 mm\" }";
    let guide = "friction = { mu = 0.08, viscous = \"60 N s/m\", bending_span = \"250 mm\" }";
    let ball = "friction = { mu = 0.1, radius = \"15 mm\" }";
    let viscous_guide = "friction = { mu = 0, viscous = \"600 N s/m\" }";
    let viscous = "friction = { mu = 0, viscous = \"2000 N s/m\", radius = \"15 mm\" }";
    let preloaded = "friction = { mu = 0.08, viscous = \"60 N s/m\", bending_span = \"250 mm\", preload = \"200 N\" }";
    let gough = gallery::get("gough").unwrap();
    for (name, changes) in [
        ("viscous guides", &[(guide, viscous_guide)][..]),
        ("viscous balls", &[(ball, viscous)]),
        ("viscous", &[(guide, viscous_guide), (ball, viscous), (universal, viscous)]),
        ("preloaded", &[(guide, preloaded)]),
        (
            "screws",
            &[
                (
                    "[legs.joints.P]\naxis = \"z\"\nstart = \"1 m\"",
                    "[legs.joints.H]\naxis = \"z\"\npitch = \"100 mm/rev\"\nstart = \"10 rev\"",
                ),
                ("U tube P* screw S", "U tube H* screw S"),
                (
                    guide,
                    "friction = { mu = 0.1, viscous = \"6 N s/m\", radius = \"16 mm\", flank_angle = \"15 deg\" }",
                ),
            ],
        ),
    ] {
        let text = changes.iter().fold(gough.to_owned(), |text, (from, to)| {
            assert!(text.contains(from), "{from}");
            text.replace(from, to)
        });
        agrees_with_forward_dynamics(name, Robot::of(&model(name, &text), None));
    }
}

fn agrees_with_forward_dynamics(name: &str, mut robot: Robot) {
    let length = robot.solver.mechanism().characteristic_length();
    // The states are those of the spanning tree of inverse dynamics.
    let mechanism = robot.solver.mechanism().clone();
    let general = Forward::new(mechanism, &[]);
    let mut random = Random::new(6);
    let program = record(&robot, true);
    let lanes = program.lanes();
    let (mut memory, mut many) = (program.memory(1), program.memory(lanes));
    let mut settled = vec![false; lanes];
    let (mut compared, mut singles) = (0, Vec::new());
    for k in 0..(2 * lanes).max(16) {
        let signal = &robot.signal[k % robot.signal.len()];
        let mut targets = random_rates(signal, &mut random, length);
        if k == 1 {
            // A state at rest among moving neighbours must be left to the general solver.
            targets.iter_mut().for_each(|target| target.rate = 0.0);
        }
        robot.solver.move_to(&targets).unwrap();
        robot.solver.settings_mut().friction = FrictionMode::Off;
        let mut efforts = robot.solver.solve(&robot.loads).unwrap().efforts.clone();
        let scale = efforts.iter().fold(1e-9_f64, |max, x| max.max(x.abs()));
        efforts.iter_mut().for_each(|effort| *effort += 0.2 * scale * random.number());
        let state = robot.solver.state().clone();
        program.set(&mut memory, 0, &state, &robot.loads, &efforts);
        let mut alone = [false];
        program.run(&mut memory, &mut alone);
        program.set(&mut many, k % lanes, &state, &robot.loads, &efforts);
        singles.push((alone[0], found(&program, &memory, 0, true)));
        if (k + 1) % lanes == 0 {
            program.run(&mut many, &mut settled);
            for (lane, (alone, single)) in singles.drain(..).enumerate() {
                assert_eq!(settled[lane], alone, "{name}");
                let wide = found(&program, &many, lane, true);
                if alone {
                    // The number of steps may be larger if neighbouring lanes need more steps.
                    assert!(apart(&wide.tree, &single.tree) < 1e-12, "{name}");
                    assert!(apart(&wide.reactions[0], &single.reactions[0]) < 1e-12, "{name}");
                    assert!(apart(&wide.reactions[1], &single.reactions[1]) < 1e-12, "{name}");
                }
            }
        }
        if !alone[0] {
            let has_friction = program.sizes()[3] > 0;
            assert!(k == 1 && has_friction, "{name} {k}");
            continue;
        }
        let mut given = Given { efforts, loads: robot.loads.clone() };
        let settings = ForwardSettings::default();
        let simulation = general.start(0.0, state, settings, &mut given).unwrap();
        let now = simulation.instant();
        let is_other = |event: &Event| matches!(event.kind, EventKind::NotUnique { .. });
        if simulation.events().iter().any(is_other) {
            continue;
        }
        compared += 1;
        let single = found(&program, &memory, 0, true);
        let reactions = wrenches(&now.reactions());
        let loads: Vec<f64> = now.interfaces.iter().map(|c| c.load).collect();
        let found_loads: Vec<f64> = single.interfaces.iter().map(|c| c[0]).collect();
        for difference in [
            apart(&single.tree, &now.state.accelerations),
            apart(&single.reactions[0], &reactions[0]),
            apart(&single.reactions[1], &reactions[1]),
            apart(&found_loads, &loads),
        ] {
            // Rounding of two programs, magnified by condition numbers of some hundred.
            assert!(difference < 1e-12, "{name}: {difference:e}");
        }
    }
    assert!(compared >= 5, "{name}: {compared}");
}

/// Mechanisms without unique accelerations, or with more actuators than coordinates, are refused.
#[test]
fn mechanisms_without_a_program_are_refused() {
    for (name, why) in [
        ("four-bar", RecordError::Redundant),
        ("delta", RecordError::IdleSpins),
        ("bricard", RecordError::Redundant),
    ] {
        let robot = Robot::new(name, None);
        let program = ForwardProgram::record(&robot.solver, &robot.signal, &robot.loads);
        assert_eq!(program.map(|_| ()), Err(why), "{name}");
    }
}

/// Accelerations and reactions of a robot with three legs take about two thousand operations
/// without friction.
#[test]
fn equal_values_are_computed_once() {
    let robot = Robot::new("3rps", None);
    let program = record(&robot, true);
    let [ideal, first, newton, chord, last] = program.operations();
    assert!(ideal < 2000 && first < 3800, "{:?}", program.operations());
    assert!(newton < 1100 && chord < 450 && last < 1100, "{:?}", program.operations());
}

/// Friction in a leg changes wrenches in other legs only through the accelerations of the platform,
/// so that a Newton step for 24 interfaces in six legs takes fewer operations than the elimination
/// of a full matrix of this size (24^3 / 3).
#[test]
fn legs_are_coupled_by_accelerations_only() {
    let robot = Robot::new("gough", None);
    let program = record(&robot, true);
    let [ideal, first, newton, chord, last] = program.operations();
    assert!(ideal < 6500 && first < 10500, "{:?}", program.operations());
    assert!(newton < 4000 && chord < 1400 && last < 3100, "{:?}", program.operations());
}
