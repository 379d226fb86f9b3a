//! Singularity indices.

use crate::common::*;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::statics::Constraints;

/// Computes the actuation and constraint indices of a robot at one configuration.
fn distances(
    robot: Robot,
    targets: &[stiction_core::kinematics::Target<f64>],
    mobility: usize,
) -> (f64, f64) {
    let solver = InverseDynamics::new(
        robot.mechanism,
        &robot.initial_poses,
        &robot.coordinates,
        targets,
        Settings::default(),
    )
    .unwrap();
    let statics = solver.statics();
    (statics.actuation_distance(0), Constraints::new(&statics).distance(mobility))
}

#[test]
fn the_printed_robot_is_singular_in_both_ways() {
    let (actuation, constraint) = distances(printed_robot(false), &printed_motion(0.1), 3);
    assert!(actuation < 1e-14 && constraint < 1e-14, "{actuation:e} {constraint:e}");
}

#[test]
fn its_twin_is_not() {
    let (actuation, constraint) = distances(regular_twin(0.0, 0.0), &twin_motion(0.1), 3);
    assert!(actuation > 0.01 && constraint > 0.01, "{actuation:e} {constraint:e}");
}

/// A slider-crank driven at the crank has no singular configuration. Its index does not depend on
/// the redundant constraints of a planar linkage in space.
#[test]
fn mobility_of_a_planar_linkage_is_one() {
    let robot = slider_crank();
    let target = stiction_core::kinematics::Target { value: 0.7, rate: 1.0, acceleration: 0.0 };
    let solver = InverseDynamics::new(
        robot.mechanism,
        &robot.initial_poses,
        &robot.coordinates,
        &[target],
        Settings::default(),
    )
    .unwrap();
    let statics = solver.statics();
    let constraints = Constraints::new(&statics);
    assert_eq!(constraints.mobility(), 1);
    assert_eq!(statics.redundancy(), 3);
    assert!(constraints.distance(1) > 0.01 && constraints.distance(0) < 1e-14);
}
