//! Planar linkages against references R8 and R9.

use crate::common::*;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, LoadAxes, Settings};
use stiction_core::kinematics::Target;
use stiction_core::spatial::Vec3;

#[test]
fn slider_crank_with_friction_in_all_joints() {
    let robot = slider_crank();
    let load = AppliedLoad {
        body: robot.mechanism.body_id("slider").unwrap(),
        point: Vec3::zero(),
        axes: LoadAxes::World,
        force: v(-100.0, 0.0, 0.0),
        moment: Vec3::zero(),
    };
    let at = |t: f64| Target { value: 10.0 * t, rate: 10.0, acceleration: 0.0 };
    let mut solver = InverseDynamics::new(
        robot.mechanism,
        &robot.initial_poses,
        &robot.coordinates,
        &[at(0.0)],
        Settings::default(),
    )
    .unwrap();
    // Crank angle, torque without and with friction, forces at A, B, C and at the guide.
    let rows: [[f64; 7]; 3] = [
        [30.0, -3.447334000, -3.050682842, 56.845662, 61.476467, 77.400784, 36.769097355],
        [60.0, -8.506718049, -7.801557188, 81.293050, 84.999450, 93.389043, 49.943387241],
        [210.0, 3.246730104, 3.537393733, 137.332221, 129.816773, 115.182916, 7.861372153],
    ];
    let mut before = 0.0;
    for [degrees, frictionless, torque, a, b, c, guide] in rows {
        let targets = |t: f64, targets: &mut [Target<f64>]| targets[0] = at(t);
        let t = degrees.to_radians() / 10.0;
        solver.follow(before, t, targets).unwrap();
        before = t;
        let forces = solver.solve(&[load]).unwrap();
        assert!((forces.efforts_frictionless[0] - frictionless).abs() < 1e-9);
        assert!((forces.efforts[0] - torque).abs() < 1e-9);
        for (joint, expected) in [a, b, c].into_iter().enumerate() {
            let found = forces.reactions[joint].0.norm();
            assert!((found - expected).abs() < 1e-6, "{degrees}: {joint} {found} {expected}");
        }
        assert!((forces.reactions[3].0.y.abs() - guide).abs() < 1e-8);
        assert!(forces.power.residual().abs() <= 1e-13 * forces.power.turnover);
    }
}

#[test]
fn three_rrr_at_one_state() {
    let robot = planar_3rrr();
    let target = |value, rate, acceleration| Target { value, rate, acceleration };
    let targets = [target(0.05, 0.3, 1.5), target(-0.03, -0.4, 2.0), target(0.2, 0.8, -3.0)];
    let settings = Settings { friction: FrictionMode::Off, ..Settings::default() };
    let mut solver = InverseDynamics::new(
        robot.mechanism,
        &robot.initial_poses,
        &robot.coordinates,
        &targets,
        settings,
    )
    .unwrap();
    let drives = &solver.solve(&[]).unwrap().efforts;
    let expected = [16.80837220529022, -2.718582445783226, -9.500616292200838];
    for (found, expected) in drives.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-13, "{drives:?}");
    }
}
