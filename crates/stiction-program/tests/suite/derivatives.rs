//! Derivatives of actuator forces compared with dual numbers in the general kernel, and with finite
//! differences of the general solver.

use crate::common::{Robot, model};
use stiction_core::dynamics::{AppliedLoad, FrictionMode, Settings};
use stiction_core::kinematics::Target;
use stiction_core::mechanism::{BodyId, JointId};
use stiction_core::parameters::Parameters;
use stiction_core::random::Random;
use stiction_core::scalar::Dual;
use stiction_core::spatial::{Pose, Vec3};
use stiction_format::gallery;
use stiction_program::{DerivativeProgram, Quantity, RecordError};

/// All gallery models that can be recorded. The crank of Andrews' mechanism turns by more than the
/// half turn within which poses determine an angle.
const ROBOTS: [(&str, Option<&str>); 14] = [
    ("3rps", None),
    ("zhang2018-regular", Some("L1")),
    ("gough", None),
    ("3upu", None),
    ("delta", None),
    ("four-bar", None),
    ("bricard", None),
    ("five-bar", None),
    ("slider-crank", None),
    ("spherical-3rrr", None),
    ("andrews", None),
    ("6sps", None),
    ("4ups-upu", None),
    ("3rrr", None),
];

fn of_motion(robot: &Robot) -> Vec<Quantity> {
    let count = robot.signal[0].len();
    let of = |k| [Quantity::Value(k), Quantity::Rate(k), Quantity::Acceleration(k)];
    (0..count).flat_map(of).collect()
}

/// Some quantities of every kind of a mechanism.
fn of_mechanism(robot: &Robot) -> Vec<Quantity> {
    let mechanism = robot.solver.mechanism();
    let parameters = robot.solver.parameters();
    let mut quantities = Vec::new();
    for body in (1..mechanism.bodies().len()).map(BodyId) {
        quantities.push(Quantity::Mass(body));
        quantities.push(Quantity::CentreOfMass(body, body.0 % 3));
        quantities.push(Quantity::Inertia(body, (body.0 + 1) % 3));
    }
    for joint in (0..mechanism.joints().len()).map(JointId) {
        quantities.push(Quantity::PlaceInPredecessor(joint, joint.0 % 3));
        quantities.push(Quantity::PlaceInSuccessor(joint, (joint.0 + 1) % 3));
    }
    for (interface, content) in parameters.interfaces.iter().enumerate() {
        quantities.extend([Quantity::Mu(interface), Quantity::Viscous(interface)]);
        if content.shape.dofs().len() == 1 && content.radius != 1.0 {
            quantities.push(Quantity::Radius(interface));
        }
    }
    quantities
}

type D = Dual<f64, 1>;

/// Parameter of the mechanism, as a dual number, that a quantity denotes.
fn number(parameters: &mut Parameters<D>, quantity: Quantity) -> Option<&mut D> {
    fn part(v: &mut Vec3<D>, axis: usize) -> &mut D {
        match axis {
            0 => &mut v.x,
            1 => &mut v.y,
            _ => &mut v.z,
        }
    }
    Some(match quantity {
        Quantity::Mass(body) => &mut parameters.mass[body.0],
        Quantity::CentreOfMass(body, axis) => part(&mut parameters.com[body.0], axis),
        Quantity::Inertia(body, axis) => part(&mut parameters.inertia[body.0].columns[axis], axis),
        Quantity::PlaceInPredecessor(joint, axis) => {
            part(&mut parameters.frame_j[joint.0].position, axis)
        }
        Quantity::PlaceInSuccessor(joint, axis) => {
            part(&mut parameters.frame_k[joint.0].position, axis)
        }
        Quantity::Mu(interface) => &mut parameters.interfaces[interface].law.mu,
        Quantity::Viscous(interface) => &mut parameters.interfaces[interface].law.viscous,
        Quantity::Radius(interface) => &mut parameters.interfaces[interface].radius,
        _ => return None,
    })
}

/// Derivatives of the actuator forces along a direction, by the general kernel over dual numbers.
fn by_duals(
    robot: &Robot,
    targets: &[Target<f64>],
    quantities: &[Quantity],
    direction: &[f64],
) -> Vec<D> {
    let compiled = robot.solver.model().unwrap();
    let mut parameters = Parameters::<D>::new(robot.solver.mechanism());
    let mut own: Vec<Target<D>> = targets.iter().map(|target| target.lift()).collect();
    for (&quantity, &slope) in quantities.iter().zip(direction) {
        match quantity {
            Quantity::Value(k) => own[k].value.slope[0] = slope,
            Quantity::Rate(k) => own[k].rate.slope[0] = slope,
            Quantity::Acceleration(k) => own[k].acceleration.slope[0] = slope,
            _ => number(&mut parameters, quantity).unwrap().slope[0] = slope,
        }
    }
    let loads: Vec<AppliedLoad<D>> = robot.loads.iter().map(|load| load.lift()).collect();
    // A fixed number of steps, because the derivative of the friction forces converges one step
    // after their value.
    let settings = Settings {
        friction: FrictionMode::Converged,
        friction_tolerance: 0.0,
        friction_steps: 12,
        ..Settings::default()
    };
    let mut data = compiled.data(robot.solver.state(), settings);
    compiled.evaluate(&parameters, &mut data, &own, &loads);
    data.inverse.efforts().to_vec()
}

/// Derivatives along random directions of all quantities agree with dual numbers.
#[test]
fn slopes_are_those_of_dual_numbers() {
    for (name, load) in ROBOTS {
        let mut robot = Robot::new(name, load);
        let all = [of_motion(&robot), of_mechanism(&robot)].concat();
        let mut machines = vec![true];
        if name == "3rps" {
            machines.push(false);
        }
        let motion = of_motion(&robot);
        let cases = machines.into_iter().flat_map(|m| [(m, motion.clone()), (m, all.clone())]);
        for (machine, quantities) in cases {
            let program = DerivativeProgram::record_with(
                &robot.solver,
                &robot.signal,
                &robot.loads,
                &quantities,
                machine,
            )
            .unwrap();
            let mut memory = program.memory();
            let mut random = Random::new(11);
            for targets in robot.signal.clone().iter().step_by(3) {
                robot.solver.move_to(targets).unwrap();
                let state = robot.solver.state().clone();
                assert!(program.run(&mut memory, &state, targets, &robot.loads));
                let directions: Vec<Vec<f64>> = (0..program.lanes())
                    .map(|_| quantities.iter().map(|_| random.number()).collect())
                    .collect();
                for (lane, direction) in directions.iter().enumerate() {
                    program.set_direction(&mut memory, lane, direction);
                }
                program.differentiate(&mut memory);
                for (lane, direction) in directions.iter().enumerate().take(3) {
                    let wanted = by_duals(&robot, targets, &quantities, direction);
                    let largest = wanted.iter().fold(0.0_f64, |max, d| max.max(d.slope[0].abs()));
                    for (drive, wanted) in wanted.iter().enumerate() {
                        let value = program.inverse().drive(program.forces(&memory), 0, drive);
                        assert!((value - wanted.value).abs() < 1e-11 * value.abs().max(1.0));
                        let slope = program.slope(&memory, lane, drive);
                        let difference = (slope - wanted.slope[0]).abs() / largest;
                        // Rounding magnified by condition numbers of some hundred, squared in
                        // derivatives. Thin rods with local DOFs make those of the Delta robot
                        // larger.
                        let most = if name == "delta" { 1e-9 } else { 1e-11 };
                        assert!(difference < most, "{name}: {difference:e}");
                    }
                }
            }
        }
    }
}

/// Compares each derivative with dual numbers, in the given part of the motion.
fn assert_slopes(name: &str, robot: &mut Robot, positions: std::ops::Range<usize>) {
    let quantities = [of_motion(robot), of_mechanism(robot)].concat();
    let (signal, loads) = (&robot.signal, &robot.loads);
    let program = DerivativeProgram::record(&robot.solver, signal, loads, &quantities).unwrap();
    let mut memory = program.memory();
    let mut compared = 0;
    for targets in robot.signal.clone().drain(positions) {
        robot.solver.move_to(&targets).unwrap();
        let state = robot.solver.state().clone();
        // A speed may lie in an interval of a table that contains no sample.
        if !program.run(&mut memory, &state, &targets, &robot.loads) {
            continue;
        }
        compared += 1;
        let count = robot.solver.mechanism().actuators().count();
        let mut jacobian = vec![f64::NAN; count * quantities.len()];
        program.jacobian(&mut memory, &mut jacobian);
        for (k, quantity) in quantities.iter().enumerate() {
            let mut direction = vec![0.0; quantities.len()];
            direction[k] = 1.0;
            let wanted = by_duals(robot, &targets, &quantities, &direction);
            let largest = wanted.iter().fold(0.0_f64, |max, d| max.max(d.slope[0].abs()));
            for (drive, wanted) in wanted.iter().enumerate() {
                let (found, wanted) = (jacobian[drive * quantities.len() + k], wanted.slope[0]);
                // Where derivatives vanish, the rounding error of large terms remains.
                let most = 1e-9 * largest + 1e-8;
                assert!((found - wanted).abs() < most, "{name} {quantity:?}: {found} {wanted}");
            }
        }
    }
    assert!(compared > 0, "{name}");
}

/// A quantity of small influence, such as a viscous coefficient, is correct beside one of large
/// influence.
#[test]
fn each_slope_alone_is_that_of_dual_numbers() {
    for name in ["delta", "spherical-3rrr"] {
        assert_slopes(name, &mut Robot::new(name, None), 0..1);
    }
}

/// Covers all dependences of friction and normal loads, and more actuators than DOFs.
#[test]
fn slopes_hold_for_all_kinds_of_friction() {
    let text = gallery::get("3rps").unwrap();
    let (of_guides, of_pins) = (
        "friction = { mu = 0.12, viscous = \"0.02 N s/m\" }\n\n[legs.joints.S]",
        "radius = \"12.5 mm\" }",
    );
    assert!(text.contains(of_guides) && text.contains(of_pins));
    for keys in [
        "mu = 0.08, mu_static = 0.2, stribeck_velocity = \"0.05 m/s\"",
        "mu = 0.08, mu_static = 0.2, stribeck_velocity = \"0.05 m/s\", stribeck_exponent = 1.5",
        "table = [[\"0 m/s\", 0.2], [\"0.05 m/s\", 0.1], [\"1 m/s\", 0.15]]",
        "mu = 0.1, regularised = \"tanh\", regularisation_velocity = \"0.01 m/s\"",
        "mu = 0.1, backward = { mu = 0.2 }",
        "mu = 0.1, bending_span = \"100 mm\", combine = \"pads\"",
        "mu = 0.1, bending_span = \"100 mm\", combine = \"root-sum-square\", preload = \"10 N\"",
        "mu = 0.1, bending_span = \"100 mm\", smoothing = \"1 N\", supports = \"to\"",
        "mu = 0.1, gland = \"300 mm\", piston = \"-300 mm\"",
        "mu = 0.1",
    ] {
        let guides = of_guides.replace("mu = 0.12", keys);
        let mut text = text.replace(of_guides, &guides);
        if keys == "mu = 0.1" {
            text = text.replace(of_pins, &format!("{of_pins}\nactuated = true"));
        }
        let mut robot = Robot::of(&model("3rps", &text), None);
        let actuators = robot.solver.mechanism().actuators().count();
        assert_eq!(actuators, if keys == "mu = 0.1" { 6 } else { 3 });
        assert_slopes(keys, &mut robot, 0..5);
    }
}

/// Central differences of sixth order.
fn difference(step: f64, mut of: impl FnMut(f64) -> Vec<f64>) -> Vec<f64> {
    let mut sum = Vec::new();
    for (k, weight) in [(1.0, 45.0), (2.0, -9.0), (3.0, 1.0)] {
        let (ahead, behind) = (of(k * step), of(-k * step));
        sum.resize(ahead.len(), 0.0);
        for ((sum, ahead), behind) in sum.iter_mut().zip(&ahead).zip(&behind) {
            *sum += weight * (ahead - behind) / (60.0 * step);
        }
    }
    sum
}

/// Direction of sliding of each interface in the last solution, `true` for positive.
fn senses_of(robot: &Robot) -> Vec<bool> {
    robot.solver.forces().interfaces.iter().map(|interface| interface.velocity > 0.0).collect()
}

fn drives(robot: &mut Robot, targets: &[Target<f64>]) -> Vec<f64> {
    robot.solver.move_to(targets).unwrap();
    robot.solver.solve(&robot.loads).unwrap().efforts.clone()
}

/// All partial derivatives with respect to the motion agree with finite differences of the solver
/// if no interface reverses, because friction jumps at a reversal.
#[test]
fn derivatives_by_the_motion_are_differences() {
    for (name, load) in ROBOTS {
        let mut random = Random::new(12);
        let mut compared = 0;
        let mut robot = Robot::new(name, load);
        let quantities = of_motion(&robot);
        let program =
            DerivativeProgram::record(&robot.solver, &robot.signal, &robot.loads, &quantities)
                .unwrap();
        let mut memory = program.memory();
        for mut targets in robot.signal.clone() {
            targets.iter_mut().for_each(|target| target.rate = random.number());
            robot.solver.move_to(&targets).unwrap();
            if robot.solver.solve(&robot.loads).is_err() {
                continue;
            }
            let state = robot.solver.state().clone();
            // Friction may lock some of the random motions.
            if compared >= 30 || !program.run(&mut memory, &state, &targets, &robot.loads) {
                continue;
            }
            let senses = senses_of(&robot);
            let count = robot.solver.mechanism().actuators().count();
            let mut jacobian = vec![f64::NAN; count * quantities.len()];
            program.jacobian(&mut memory, &mut jacobian);
            for (k, &quantity) in quantities.iter().enumerate() {
                let mut jumps = false;
                let wanted = difference(2e-5, |step| {
                    let mut moved = targets.clone();
                    match quantity {
                        Quantity::Value(k) => moved[k].value += step,
                        Quantity::Rate(k) => moved[k].rate += step,
                        Quantity::Acceleration(k) => moved[k].acceleration += step,
                        _ => {}
                    }
                    let drives = drives(&mut robot, &moved);
                    jumps |= senses_of(&robot) != senses;
                    drives
                });
                if jumps {
                    continue;
                }
                compared += 1;
                let largest = wanted.iter().fold(1.0_f64, |max, d| max.max(d.abs()));
                for (drive, wanted) in wanted.iter().enumerate() {
                    let found = jacobian[drive * quantities.len() + k];
                    // Rounding of the forces, 1e-12 of some hundred newton, divided by the step.
                    let error = (found - wanted).abs() / largest;
                    assert!(error < 1e-6, "{name} {quantity:?}: {found} {wanted}");
                }
            }
        }
        assert!(compared > 20, "{name}: {compared}");
    }
}

/// Text before and after a number, the number, its relative change, and the direction in parameter
/// space that corresponds to the change.
type Case = ([&'static str; 2], f64, f64, Vec<(Quantity, f64)>);

/// Compares derivatives with differences for dimensions, masses and coefficients that the test
/// changes in the model's text.
#[test]
fn derivatives_by_the_mechanism_are_differences() {
    let nominal = Robot::new("3rps", None);
    let mechanism = nominal.solver.mechanism();
    let bodies = |part: &str| -> Vec<BodyId> {
        let named = |&k: &usize| mechanism.bodies()[k].name.contains(part);
        (0..mechanism.bodies().len()).filter(named).map(BodyId).collect()
    };
    let joint = |k: usize| JointId(k);
    // The joints R at the foot of each leg, their distance from the centre, and their positions.
    let feet: Vec<(JointId, Vec3<f64>)> = (0..mechanism.joints().len())
        .filter(|&k| mechanism.joints()[k].predecessor == BodyId::GROUND)
        .map(|k| {
            let pose: Pose<f64> = mechanism.joints()[k].frame_j;
            (joint(k), pose.position * (1.0 / pose.position.norm()))
        })
        .collect();
    assert_eq!((feet.len(), bodies("rod").len(), bodies("cylinder").len()), (3, 3, 3));
    let interfaces = nominal.solver.parameters().interfaces.len();
    let mut cases: Vec<Case> = Vec::new();
    let of_all = |quantities: Vec<Quantity>| quantities.into_iter().map(|q| (q, 1.0)).collect();
    cases.push((
        ["base_radius = \"450 mm\"", "base_radius = \"VALUE m\""],
        0.45,
        1e-3,
        feet.iter()
            .flat_map(|&(foot, along)| {
                let parts = along.to_array();
                (0..3).map(move |axis| (Quantity::PlaceInPredecessor(foot, axis), parts[axis]))
            })
            .collect(),
    ));
    cases.push((
        ["rod_com = \"128.48 mm\"", "rod_com = \"VALUE m\""],
        0.12848,
        1e-2,
        bodies("rod").into_iter().map(|rod| (Quantity::CentreOfMass(rod, 2), -1.0)).collect(),
    ));
    cases.push((
        ["mass = \"5.15 kg\"", "mass = \"VALUE kg\""],
        5.15,
        1e-2,
        of_all(bodies("cylinder").into_iter().map(Quantity::Mass).collect()),
    ));
    cases.push((
        ["mu = 0.12,", "mu = VALUE,"],
        0.12,
        1e-2,
        of_all((0..interfaces).map(Quantity::Mu).collect()),
    ));
    cases.push((
        ["viscous = \"0.02 N s/m\"", "viscous = \"VALUE N s/m\""],
        0.02,
        0.3,
        of_all((0..interfaces).map(Quantity::Viscous).collect()),
    ));
    for ([was, becomes], nominal_value, part, direction) in cases {
        let quantities: Vec<Quantity> = direction.iter().map(|(quantity, _)| *quantity).collect();
        let slopes: Vec<f64> = direction.iter().map(|(_, slope)| *slope).collect();
        let mut own = Robot::new("3rps", None);
        let program =
            DerivativeProgram::record(&own.solver, &own.signal, &own.loads, &quantities).unwrap();
        let mut memory = program.memory();
        let targets = own.signal[4].clone();
        own.solver.move_to(&targets).unwrap();
        let state = own.solver.state().clone();
        assert!(program.run(&mut memory, &state, &targets, &own.loads));
        program.set_direction(&mut memory, 0, &slopes);
        program.differentiate(&mut memory);
        let wanted = difference(part * nominal_value, |step| {
            let value = format!("{:.17}", nominal_value + step);
            let text = gallery::get("3rps").unwrap();
            assert!(text.contains(was), "{was}");
            let text = text.replace(was, &becomes.replace("VALUE", &value));
            let mut changed = Robot::of(&model("3rps", &text), None);
            drives(&mut changed, &targets)
        });
        let largest = wanted.iter().fold(0.0_f64, |max, d| max.max(d.abs()));
        assert!(largest > 0.0);
        for (drive, wanted) in wanted.iter().enumerate() {
            let found = program.slope(&memory, 0, drive);
            // Rounding of forces, about 1e-13 of a hundred newton, relative to the effect of the
            // step.
            assert!((found - wanted).abs() < 1e-8 * largest, "{was}: {found} {wanted}");
        }
    }
}

#[test]
fn expressions_without_derivatives_are_refused() {
    let robot = Robot::new("3rps", None);
    let record = |quantities: &[Quantity]| {
        DerivativeProgram::record(&robot.solver, &robot.signal, &robot.loads, quantities)
    };
    assert_eq!(record(&[]).map(|_| ()), Err(RecordError::NoQuantity));
    for wrong in [
        Quantity::Value(3),
        Quantity::Mass(BodyId(8)),
        Quantity::CentreOfMass(BodyId(1), 3),
        Quantity::Mu(9),
        Quantity::PlaceInSuccessor(JointId(9), 0),
    ] {
        assert_eq!(record(&[wrong]).map(|_| ()), Err(RecordError::UnknownQuantity(wrong)));
    }
}

/// Without a run, or after an invalid one, the program does not return derivatives of another
/// state.
#[test]
fn derivatives_are_never_those_of_another_state() {
    let robot = Robot::new("3rps", None);
    let quantities = of_motion(&robot);
    let (solver, signal, loads) = (&robot.solver, &robot.signal, &robot.loads);
    let program = DerivativeProgram::record(solver, signal, loads, &quantities).unwrap();
    let mut memory = program.memory();
    let mut jacobian = vec![0.0; quantities.len() * solver.mechanism().actuators().count()];
    program.jacobian(&mut memory, &mut jacobian);
    assert!(jacobian.iter().all(|slope| slope.is_nan()));

    let mut targets = signal[0].clone();
    targets.iter_mut().for_each(|target| target.rate = 0.1);
    let mut solver = solver.clone();
    solver.move_to(&targets).unwrap();
    assert!(program.run(&mut memory, solver.state(), &targets, loads));
    program.jacobian(&mut memory, &mut jacobian);
    assert!(jacobian.iter().all(|slope| slope.is_finite()));

    // Programs do not support interfaces at rest.
    targets.iter_mut().for_each(|target| target.rate = 0.0);
    solver.move_to(&targets).unwrap();
    assert!(!program.run(&mut memory, solver.state(), &targets, loads));
    program.jacobian(&mut memory, &mut jacobian);
    assert!(jacobian.iter().all(|slope| slope.is_nan()));
}
