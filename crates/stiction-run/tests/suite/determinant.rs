//! The robot of Zhang et al. 2018 against formulas derived by hand.

use crate::common::*;
use nalgebra::Matrix3;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::kinematics::{AngleOrder, Coordinate, Target};
use stiction_core::random::Random;
use stiction_core::spatial::Pose;
use stiction_core::statics::Constraints;
use stiction_format::ModelFile;

/// Half of the side lengths of platform and base, m.
const K: f64 = 0.15;
const L: f64 = 0.45;

/// Returns a random pose of the platform: position x, z (m) and angle theta (rad).
fn some_pose(random: &mut Random) -> [f64; 3] {
    let theta = (90.0 + 40.0 * random.number()).to_radians();
    [0.15 * random.number(), 0.5 + 0.15 * random.number(), theta]
}

/// Creates the robot at a pose in its plane, with rates of x, z, theta. If `all` is true, all six
/// coordinates of the platform are prescribed, because the roll of the printed robot is free to
/// first order.
fn robot(
    model: &ModelFile,
    [x, z, theta]: [f64; 3],
    rates: [f64; 3],
    all: bool,
) -> InverseDynamics {
    let body = model.mechanism.body_id("platform").unwrap();
    let order = AngleOrder::XYZ;
    // Theta is the angle between the platform's normal and the horizontal.
    let ry = std::f64::consts::FRAC_PI_2 - theta;
    let mut prescribed = vec![
        (Coordinate::Position { body, axis: 0 }, x, rates[0]),
        (Coordinate::Position { body, axis: 2 }, z, rates[1]),
        (Coordinate::Angle { body, order, index: 1 }, ry, -rates[2]),
    ];
    let (_, home) = model.initial_poses.iter().find(|(known, _)| *known == body).unwrap();
    if all {
        prescribed.extend([
            (Coordinate::Position { body, axis: 1 }, home.position.y, 0.0),
            (Coordinate::Angle { body, order, index: 0 }, 0.0, 0.0),
            (Coordinate::Angle { body, order, index: 2 }, 0.0, 0.0),
        ]);
    }
    let coordinates: Vec<_> = prescribed.iter().map(|(coordinate, _, _)| *coordinate).collect();
    let targets: Vec<_> = prescribed
        .iter()
        .map(|&(_, value, rate)| Target { value, rate, acceleration: 0.0 })
        .collect();
    let rotation = stiction_core::spatial::Mat3::about_axis(1, ry.sin_cos());
    let position = stiction_core::spatial::Vec3::new(x, home.position.y, z);
    let initial_poses = [(body, Pose { rotation, position })];
    let mechanism = model.mechanism.clone();
    InverseDynamics::new(mechanism, &initial_poses, &coordinates, &targets, Settings::default())
        .unwrap()
}

/// Returns the length and the rate of a leg.
fn leg(solver: &InverseDynamics, n: usize) -> (f64, f64) {
    let mechanism = solver.mechanism();
    let id = mechanism.joint_id(&format!("leg{n}.P")).unwrap();
    let joint = &mechanism.joints()[id.0];
    let bodies = solver.bodies();
    let relative = bodies.twist[joint.successor.0] - bodies.twist[joint.predecessor.0];
    let axis = bodies.frame_j[id.0].rotation.columns[2];
    (solver.joint_coordinates(id)[0], relative.linear.dot(axis))
}

/// Tests `det(diag(rho) J^-1) = 2 k l cos(theta) (k (x cos(theta) + z sin(theta)) - l z)`, where
/// row n of `J^-1` contains the derivatives of leg n's length rho with respect to x, z and theta.
/// The formula is derived by hand: with the vectors `rho u` of the legs, row 2 + row 3 - 2 row 1 of
/// `diag(rho) J^-1` is `(0, 0, -2 k l cos(theta))`.
#[test]
fn determinant_of_the_legs_rates() {
    let model = model("zhang2018");
    let mut random = Random::new(1);
    let (mut worst, mut least, mut greatest) = (0.0_f64, f64::INFINITY, f64::NEG_INFINITY);
    for _ in 0..150 {
        let pose @ [x, z, theta] = some_pose(&mut random);
        let mut matrix = Matrix3::zeros();
        for column in 0..3 {
            let rates = std::array::from_fn(|k| if k == column { 1.0 } else { 0.0 });
            let solver = robot(&model, pose, rates, true);
            for n in 1..=3 {
                let (length, rate) = leg(&solver, n);
                assert!((0.1..1.2).contains(&length), "upright: {length}");
                matrix[(n - 1, column)] = length * rate;
            }
        }
        let (s, c) = theta.sin_cos();
        let expected = 2.0 * K * L * c * (K * (x * c + z * s) - L * z);
        let scale = 2.0 * K * L * (K * (x.abs() + z) + L * z);
        worst = worst.max((matrix.determinant() - expected).abs() / scale);
        least = least.min(expected / scale);
        greatest = greatest.max(expected / scale);
    }
    assert!(worst <= 1e-10, "{worst:e}");
    // Both signs occur, on either side of theta = 90 deg.
    assert!(least < -0.1 && greatest > 0.1, "{least} {greatest}");
}

/// Tests that, in every pose, one equation of the printed robot's equilibrium depends on the
/// others, with a self-stress of -2 : 1 : 1.
#[test]
fn the_printed_robot_is_singular_in_every_pose() {
    let model = model("zhang2018");
    let mut random = Random::new(2);
    for _ in 0..200 {
        let pose = some_pose(&mut random);
        let solver = robot(&model, pose, [0.0; 3], true);
        let statics = solver.statics();
        let values = statics.singular_values();
        assert_eq!((statics.rank(), values.len()), (41, 42), "{pose:?}");
        assert!(values[41] < 1e-13 * values[0] && values[40] > 1e-6 * values[0], "{values:?}");
        let stresses = Constraints::new(&statics).self_stresses();
        assert_eq!(stresses.len(), 1);
        let forces = [1, 2, 3].map(|n| {
            let ball = model.mechanism.joint_id(&format!("leg{n}.S")).unwrap();
            stresses[0].iter().find(|load| load.joint == ball).unwrap().force
        });
        let unit = forces[1].y;
        for (force, part) in forces.into_iter().zip([-2.0, 1.0, 1.0]) {
            let [x, y, z] = (force * (1.0 / unit)).to_array();
            assert!(x.abs().max((y - part).abs()).max(z.abs()) < 1e-11, "{pose:?} {forces:?}");
        }
    }
}

#[test]
fn its_twin_is_regular() {
    let model = model("zhang2018-regular");
    let mut random = Random::new(3);
    for _ in 0..200 {
        let pose = some_pose(&mut random);
        let statics = robot(&model, pose, [0.0; 3], false).statics();
        assert_eq!((statics.rank(), statics.redundancy(), statics.open_motions()), (42, 0, 0));
        let constraints = Constraints::new(&statics);
        assert!(constraints.self_stresses().is_empty() && constraints.mobility() == 3, "{pose:?}");
    }
}
