use super::*;
use crate::robot::Robot;
use crate::screws::{gap_of_roll, leg_twists, power, reciprocal, roll_within};
use crate::sections::structure::{poses, ranks};

/// Equations (1) to (3): five independent twists and one reciprocal wrench.
#[test]
fn screws_of_a_leg() {
    for robot in robots() {
        let found = ranks(&robot, 300);
        assert_eq!(found.leg, (5, 5));
        assert!(found.reciprocity < 1e-15, "{}", found.reciprocity);
    }
    // The product is not identically zero: a force along z does work on the prismatic joint.
    let robot = Robot::printed();
    let pose = [0.02, 0.5, 1.3];
    let slide = leg_twists(&robot, 1, pose)[1];
    let mut wrench = reciprocal(&robot, 1, pose);
    wrench[2] = 1.0;
    assert!(power(&wrench, &slide) > 0.5);
}

/// The printed robot has rank 2 and rank 5 everywhere, with the self-stress (-2, 1, 1); the regular
/// variant has full rank except at singularities.
#[test]
fn constraints_have_rank_two() {
    let [printed, regular] = robots();
    let found = ranks(&printed, 1000);
    assert_eq!((found.constraints, found.all), ((2, 2), (5, 5)));
    assert!(found.stress < 1e-13, "{}", found.stress);
    let found = ranks(&regular, 1000);
    assert_eq!((found.constraints, found.all), ((3, 3), (6, 6)));
}

/// Clearances of 1, 10 and 100 um permit 0.16, 0.50 and 1.59 deg of roll.
#[test]
fn roll_within_clearance() {
    let robot = Robot::printed();
    for (clearance, degrees) in [(1e-6, 0.16), (1e-5, 0.50), (1e-4, 1.59)] {
        let roll = roll_within(&robot, clearance);
        near(roll.to_degrees(), degrees, 2);
        // The gap agrees to second order; the next term is roll^2 / 12 of it.
        let gap = gap_of_roll(&robot, roll);
        assert!((gap / clearance - 1.0).abs() < roll * roll / 11.0, "{gap}");
    }
}

/// The poses fill their box.
#[test]
fn poses_are_spread() {
    let all: Vec<_> = poses(1000).collect();
    for (i, (low, high)) in [(-0.15, 0.15), (0.35, 0.65)].into_iter().enumerate() {
        let eighths: std::collections::HashSet<i64> =
            all.iter().map(|p| ((p[i] - low) / (high - low) * 8.0) as i64).collect();
        assert_eq!(eighths.len(), 8);
        assert!(all.iter().all(|p| p[i] >= low && p[i] <= high));
    }
}
