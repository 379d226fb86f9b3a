//! Rotors that spin on links, compared with a model that contains the rotors as bodies.

use crate::drive_trains::relative_error;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::forward::{self, ConstantEfforts, Forward};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{
    BodySpec, DriveTrainSpec, JointId, JointSpec, Mechanism, MechanismBuilder,
};
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Rotor that is mounted on a link and geared to a joint of the arm.
struct Rotor {
    joint: usize,
    link: usize,
    at: Vec3<f64>,
    axis: Vec3<f64>,
    ratio: f64,
    mass: f64,
    /// Moments of inertia about the axis of the rotor, and about axes perpendicular to it, kg m^2.
    inertia: [f64; 2],
}

const LINKS: [&str; 4] = ["ground", "one", "two", "three"];

fn rotors() -> [Rotor; 3] {
    let unit = |x, y, z| Vec3::new(x, y, z).direction().unwrap();
    [
        Rotor {
            joint: 1,
            link: 1,
            at: Vec3::new(0.1, -0.05, 0.2),
            axis: unit(0.3, 0.9, -0.2),
            ratio: 30.0,
            mass: 1.2,
            inertia: [8e-4, 5e-4],
        },
        // Rotor on a link that is not connected by the joint to which the rotor is geared.
        Rotor {
            joint: 2,
            link: 1,
            at: Vec3::new(0.0, 0.1, 0.1),
            axis: unit(-0.6, 0.2, 0.7),
            ratio: -12.0,
            mass: 0.7,
            inertia: [2e-3, 4e-3],
        },
        // Rotor on a link that is moved by the joint to which the rotor is geared.
        Rotor {
            joint: 0,
            link: 3,
            at: Vec3::new(0.2, 0.0, 0.0),
            axis: unit(0.1, 0.5, 0.5),
            ratio: 5.0,
            mass: 0.3,
            inertia: [1e-3, 1e-3],
        },
    ]
}

fn turned(axis: Vec3<f64>) -> Mat3<f64> {
    Mat3::between(Vec3::unit(2), axis)
}

/// Creates a spatial arm of three links. Its rotors are separate bodies if `as_bodies` is true;
/// otherwise they spin on the links.
fn arm(as_bodies: bool) -> Mechanism {
    let axes = [Vec3::new(0.1, 0.0, 1.0), Vec3::new(0.2, 1.0, 0.1), Vec3::new(1.0, -0.3, 0.4)];
    let at = [Vec3::zero(), Vec3::new(0.1, 0.0, 0.4), Vec3::new(0.3, 0.1, 0.0)];
    let mut builder = MechanismBuilder::new("arm").gravity(Vec3::new(1.0, 2.0, -9.0));
    for (k, name) in LINKS.iter().enumerate().skip(1) {
        let size = k as f64;
        let mut mass = 4.0 / size;
        let mut com = Vec3::new(0.1, 0.02 * size, 0.1);
        let mut inertia = Mat3::diagonal(Vec3::new(0.05, 0.06, 0.04));
        for rotor in rotors().iter().filter(|rotor| rotor.link == k && !as_bodies) {
            // By the parallel axis theorem, the link with the rotor at rest on it is one rigid
            // body.
            let [along, across] = rotor.inertia;
            let r = turned(rotor.axis);
            let own = r * Mat3::diagonal(Vec3::new(across, across, along)) * r.transpose();
            let d = rotor.at - com;
            let reduced = mass * rotor.mass / (mass + rotor.mass);
            let square = d.dot(d);
            let steiner = Mat3::diagonal(Vec3::new(square, square, square))
                + Mat3::from_columns(d * d.x, d * d.y, d * d.z) * -1.0;
            inertia = inertia + own + steiner * reduced;
            com = (com * mass + rotor.at * rotor.mass) * (1.0 / (mass + rotor.mass));
            mass += rotor.mass;
        }
        builder = builder.body(BodySpec::new(*name).mass(mass).com(com).inertia(inertia));
    }
    for (k, pair) in LINKS.windows(2).enumerate() {
        let rotation = turned(axes[k].direction().unwrap());
        let frames = [at[k], Vec3::zero()].map(|position| Pose { position, rotation });
        let joint = JointSpec::new(format!("j{k}"), JointType::Revolute, pair[0], pair[1]);
        builder = builder.joint(joint.frames(frames[0], frames[1]).actuated());
    }
    for (k, rotor) in rotors().into_iter().enumerate() {
        let (name, link) = (format!("r{k}"), LINKS[rotor.link]);
        let [along, across] = rotor.inertia;
        if as_bodies {
            let inertia = Mat3::diagonal(Vec3::new(across, across, along));
            builder = builder.body(BodySpec::new(name.as_str()).mass(rotor.mass).inertia(inertia));
            let frame = Pose { position: rotor.at, rotation: turned(rotor.axis) };
            let joint = JointSpec::new(format!("spin{k}"), JointType::Revolute, link, name);
            builder = builder.joint(joint.frames(frame, Pose::identity()).actuated());
        } else {
            builder = builder.drive_train(
                DriveTrainSpec::new(name, format!("j{}", rotor.joint))
                    .ratio(rotor.ratio)
                    .rotor_inertia(along)
                    .rotor_axis(link, rotor.axis * 3.0),
            );
        }
    }
    builder.build().unwrap()
}

fn targets() -> Vec<Target<f64>> {
    let target = |value, rate, acceleration| Target { value, rate, acceleration };
    vec![target(0.4, 1.3, -2.0), target(-0.8, -0.9, 3.0), target(1.1, 2.2, 5.0)]
}

fn coordinates(count: usize) -> Vec<Coordinate> {
    (0..count).map(|joint| Coordinate::Joint { joint: JointId(joint), dof: 0 }).collect()
}

fn solved(mechanism: Mechanism, targets: &[Target<f64>]) -> InverseDynamics {
    let coordinates = coordinates(targets.len());
    let settings = Settings::default();
    let mut solver = InverseDynamics::new(mechanism, &[], &coordinates, targets, settings).unwrap();
    solver.solve(&[]).unwrap();
    solver
}

/// Tests that inverse dynamics yields the same efforts, motor torques and reactions for both
/// models, and that the dense system has the same right-hand side.
#[test]
fn rotors_as_bodies() {
    let mut all = targets();
    for rotor in rotors() {
        let Target { value, rate, acceleration } = all[rotor.joint];
        let n = rotor.ratio;
        all.push(Target { value: n * value, rate: n * rate, acceleration: n * acceleration });
    }
    let expected = solved(arm(true), &all);
    let found = solved(arm(false), &targets());
    for joint in 0..3 {
        let [found, expected] = [&found, &expected].map(InverseDynamics::forces);
        let error = (found.efforts[joint] - expected.efforts[joint]).abs();
        assert!(error < 1e-11, "{joint}: {} {}", found.efforts[joint], expected.efforts[joint]);
        let ((force, moment), (f, m)) = (found.reactions[joint], expected.reactions[joint]);
        assert!((force - f).norm() < 1e-11 && (moment - m).norm() < 1e-11, "{joint}");
    }
    let trains = found.mechanism().drive_trains().to_vec();
    let bodies = found.bodies().clone();
    let mut spin = 0.0_f64;
    for (k, train) in trains.iter().enumerate() {
        let carrier = train.acceleration_of_carrier(&bodies.pose, &bodies.acceleration);
        let Target { rate, acceleration, .. } = targets()[train.dofs[0].joint.0];
        let motor = train.motor(0.0, (0.0, 0.0), Some(rate), acceleration, carrier);
        let expected = expected.forces().efforts[3 + k];
        assert!((motor.torque - expected).abs() < 1e-12, "{k}: {} {expected}", motor.torque);
        spin = spin.max((train.rotor_inertia * carrier).abs());
    }
    assert!(spin > 1e-3, "the links turn the rotors");
    let power = &found.forces().power;
    assert!(power.residual().abs() < 1e-13 * power.turnover, "{power:?}");

    let system = found.balance();
    let mut rows = system.demand(found.parameters(), found.bodies(), &[]);
    let reactions = found.forces().reactions.iter().zip(&bodies.frame_j);
    for (joint, ((force, moment), frame)) in reactions.enumerate() {
        let moment = *moment + frame.position.cross(*force);
        let wrench = stiction_core::spatial::Wrench { force: *force, moment };
        system.add_joint_wrench(&mut rows, joint, -wrench);
    }
    assert!(rows.amax() < 1e-11, "{}", rows.amax());
}

/// Tests that the motor torques of inverse dynamics cause the motion, and that, without efforts,
/// the energy of the arm is conserved.
#[test]
fn rotors_in_simulations() {
    let mut inverse = solved(arm(false), &targets());
    let mut efforts = inverse.solve(&[]).unwrap().efforts.clone();
    let bodies = inverse.bodies();
    for train in inverse.mechanism().drive_trains() {
        let carrier = train.acceleration_of_carrier(&bodies.pose, &bodies.acceleration);
        let Target { rate, acceleration, .. } = targets()[train.dofs[0].joint.0];
        let motor = train.motor(0.0, (0.0, 0.0), Some(rate), acceleration, carrier);
        efforts[train.dofs[0].joint.0] += train.transmission() * motor.torque;
    }
    let model = Forward::new(arm(false), &[]);
    let state = model.assemble(&[], &coordinates(3), &targets()).unwrap();
    let settings = forward::Settings::default();
    let mut driven = ConstantEfforts(efforts);
    let simulation = model.start(0.0, state.clone(), settings, &mut driven).unwrap();
    for (joint, target) in targets().iter().enumerate() {
        let found = simulation.joint_motion(JointId(joint), 0).acceleration;
        assert!((found - target.acceleration).abs() < 1e-10, "{joint}: {found}");
    }
    for (joint, expected) in inverse.forces().reactions.iter().enumerate() {
        // The complete wrench of a joint includes the effort of its actuator.
        let (force, moment) = simulation.instant().reactions()[joint];
        let (f, m) = *expected;
        assert!((force - f).norm() < 1e-10 && (moment - m).norm() < 1e-10, "{joint}");
    }
    let mut none = ConstantEfforts(Vec::new());
    let mut simulation = model.start(0.0, state, settings, &mut none).unwrap();
    simulation.advance(2.0, &mut none).unwrap();
    assert!(relative_error(&simulation) < 1e-8, "{}", relative_error(&simulation));
}
