//! Configurations where no finite actuator force exists, or where forces are not unique.

use crate::common::*;
use stiction_core::dynamics::{AppliedLoad, InverseDynamics, InverseError, LoadAxes, Settings};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{AssemblyError, Coordinate, Target};
use stiction_core::mechanism::{BodySpec, JointSpec, Mechanism, MechanismBuilder};
use stiction_core::spatial::{Pose, Vec3};

fn printed(friction: bool) -> (InverseDynamics, AppliedLoad<f64>) {
    let robot = printed_robot(friction);
    let load = AppliedLoad {
        body: robot.mechanism.body_id("platform").unwrap(),
        point: Vec3::zero(),
        axes: LoadAxes::World,
        force: v(100.0, 100.0, 100.0),
        moment: v(80.0, 80.0, 80.0),
    };
    let targets = printed_motion(0.0);
    let settings = Settings::default();
    let solver = InverseDynamics::new(
        robot.mechanism,
        &robot.initial_poses,
        &robot.coordinates,
        &targets,
        settings,
    );
    (solver.unwrap(), load)
}

/// Motion and load of Zhang et al. 2018: a moment about y of 53.9 to 55.6 N m cannot be balanced.
#[test]
fn the_papers_load_cannot_be_carried() {
    let (mut solver, load) = printed(true);
    let (mut least, mut greatest) = (f64::INFINITY, 0.0f64);
    let mut before = 0.0;
    for k in 0..=100 {
        let t = 0.01 * k as f64;
        solver.follow(before, t, |t, targets| targets.copy_from_slice(&printed_motion(t))).unwrap();
        before = t;
        let error = solver.solve(&[load]).err().unwrap();
        let InverseError::CannotCarry { body, motion, missing, unit } = &error else {
            panic!("{error}")
        };
        assert_eq!((body.as_str(), *unit), ("platform", "N m"));
        assert!(motion.starts_with("rotation about y through"), "{motion}");
        least = least.min(*missing);
        greatest = greatest.max(*missing);
        let statics = solver.statics();
        assert_eq!((statics.rank(), statics.open_motions(), statics.redundancy()), (41, 1, 1));
    }
    assert!(
        (53.85..53.95).contains(&least) && (55.55..55.65).contains(&greatest),
        "{least} {greatest}"
    );
}

/// Without a load, the balance has solutions at t = 0: the actuator forces are unique, the
/// reactions are not.
#[test]
fn in_range_at_a_singular_position() {
    let (mut solver, _) = printed(false);
    let drives = solver.solve(&[]).unwrap().efforts.clone();
    for (drive, expected) in drives.iter().zip([37.79, 46.81, 46.81]) {
        assert!((drive - expected).abs() < 0.005, "{drives:?}");
    }
    let statics = solver.statics();
    let determined = statics.determined_reactions();
    // The redundant forces act along y, at every ball.
    for leg in 1..=3 {
        let ball = solver.mechanism().joint_id(&format!("leg{leg}.S")).unwrap().0;
        assert_eq!(determined[ball], [true, false, true, true, true, true]);
    }
}

/// At first order, nothing constrains the platform's roll about the line through balls 2 and 3.
#[test]
fn three_coordinates_leave_the_roll_open() {
    let robot = printed_robot(false);
    let some = [0, 2, 4];
    let coordinates = some.map(|k| robot.coordinates[k]);
    let targets = some.map(|k| printed_motion(0.1)[k]);
    let error = InverseDynamics::new(
        robot.mechanism,
        &robot.initial_poses,
        &coordinates,
        &targets,
        Settings::default(),
    )
    .err()
    .unwrap();
    let AssemblyError::Open { open } = &error else { panic!("{error}") };
    assert_eq!(open.len(), 1);
    assert_eq!(open[0].body, "platform");
    assert!(open[0].motion.starts_with("rotation about x"), "{}", open[0].motion);
}

/// The loops close at the configuration, but they do not permit the prescribed rate: the rate of a
/// welded arm is prescribed.
#[test]
fn rates_that_loops_do_not_allow_are_refused() {
    let arm = || BodySpec::new("arm").mass(1.0).inertia(diagonal(0.1, 0.1, 0.1));
    let at = |x: f64| Pose::at(v(x, 0.0, 0.0));
    let told = |mechanism: Mechanism, joint: &str, rate: f64, acceleration: f64| {
        let joint = mechanism.joint_id(joint).unwrap();
        let coordinates = [Coordinate::Joint { joint, dof: 0 }];
        let targets = [Target { value: 0.0, rate, acceleration }];
        let settings = Settings::default();
        InverseDynamics::new(mechanism, &[], &coordinates, &targets, settings).map(|_| ())
    };
    let welded = || {
        MechanismBuilder::new("welded")
            .body(arm())
            .joint(
                JointSpec::new("pin", JointType::Revolute, "ground", "arm")
                    .frames(at(0.0), at(0.0))
                    .actuated(),
            )
            .joint(
                JointSpec::new("weld", JointType::Fixed, "ground", "arm").frames(at(0.0), at(0.0)),
            )
            .build()
            .unwrap()
    };
    assert_eq!(told(welded(), "pin", 0.0, 0.0), Ok(()));
    for (rate, acceleration, wanted) in [(1.0, 0.0, "rates"), (0.0, 1.0, "accelerations")] {
        let error = told(welded(), "pin", rate, acceleration).unwrap_err();
        let AssemblyError::Contradiction { order, by, .. } = &error else { panic!("{error}") };
        assert_eq!(*order, wanted);
        assert!((by - 1.0).abs() < 1e-12, "{error}");
    }
}
