//! Section 1 of the paper: screw equations (1) to (3) and their consequences.
//!
//! Twists are (angular; linear), wrenches (force; moment), both about one point in fixed axes;
//! their product is the power.

use super::robot::{Pose, Robot, arm, leg_vector};
use nalgebra::{DMatrix, Vector3, Vector6};
use stiction_core::linalg::Svd;

/// Equations (1) and (2): the five joint twists of leg n about its R joint, in the order R, P and
/// the three axes of S.
pub(super) fn leg_twists(robot: &Robot, n: usize, pose: Pose<f64>) -> [Vector6<f64>; 5] {
    let [dx, dz] = leg_vector(robot, n, pose);
    let r = Vector3::new(dx, 0.0, dz);
    let u = r.normalize();
    let turn = |axis: Vector3<f64>, through: Vector3<f64>| stack(axis, through.cross(&axis));
    [
        turn(Vector3::y(), Vector3::zeros()),
        stack(Vector3::zeros(), u),
        turn(Vector3::x(), r),
        turn(Vector3::y(), r),
        turn(Vector3::z(), r),
    ]
}

/// Equation (3): the wrench about the R joint reciprocal to these twists, a force along y through
/// the ball.
pub(super) fn reciprocal(robot: &Robot, n: usize, pose: Pose<f64>) -> Vector6<f64> {
    let [dx, dz] = leg_vector(robot, n, pose);
    stack(Vector3::y(), Vector3::new(dx, 0.0, dz).cross(&Vector3::y()))
}

/// Power of a unit wrench (force; moment) on a unit twist (angular; linear).
pub(super) fn power(wrench: &Vector6<f64>, twist: &Vector6<f64>) -> f64 {
    wrench.fixed_rows::<3>(0).dot(&twist.fixed_rows::<3>(3))
        + wrench.fixed_rows::<3>(3).dot(&twist.fixed_rows::<3>(0))
}

/// The three constraint wrenches (3) on the platform about O2, moments in units of k.
pub(super) fn constraint_wrenches(robot: &Robot, pose: Pose<f64>) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(6, 3);
    for n in 0..3 {
        let [ax, az] = arm(robot, n, pose[2]);
        let moment = Vector3::new(ax, robot.s[n][1], az).cross(&Vector3::y()) / robot.k;
        matrix.column_mut(n).copy_from(&stack(Vector3::y(), moment));
    }
    matrix
}

/// Wrenches of the three actuators on the platform about O2, moments in units of k.
pub(super) fn actuation_wrenches(robot: &Robot, pose: Pose<f64>) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(6, 3);
    for n in 0..3 {
        let [ax, az] = arm(robot, n, pose[2]);
        let [dx, dz] = leg_vector(robot, n, pose);
        let u = Vector3::new(dx, 0.0, dz).normalize();
        let moment = Vector3::new(ax, robot.s[n][1], az).cross(&u) / robot.k;
        matrix.column_mut(n).copy_from(&stack(u, moment));
    }
    matrix
}

/// Rank tolerance: smaller singular values, relative to the largest, count as zero.
pub(super) const NEGLIGIBLE: f64 = 1e-10;

/// Rank of a set of screws.
pub(super) fn rank(screws: &DMatrix<f64>) -> usize {
    Svd::new(screws).rank(NEGLIGIBLE)
}

/// Self-stress of the three constraint forces, scaled to -2 in leg 1; none if the forces are
/// independent.
pub(super) fn self_stress(robot: &Robot, pose: Pose<f64>) -> Option<[f64; 3]> {
    let svd = Svd::new(&constraint_wrenches(robot, pose));
    let rank = svd.rank(NEGLIGIBLE);
    let [null] = svd.null_space(rank).try_into().ok()?;
    let scale = -2.0 / null[0];
    Some([null[0] * scale, null[1] * scale, null[2] * scale])
}

/// Roll of the platform about S2 S3 permitted by joint clearance, rad. To second order the loop in
/// y opens by (sqrt(3) / 2) k roll^2.
pub(super) fn roll_within(robot: &Robot, clearance: f64) -> f64 {
    (clearance / (3.0_f64.sqrt() / 2.0 * robot.k)).sqrt()
}

/// Exact gap sqrt(3) k (1 - cos roll) for a roll angle.
pub(super) fn gap_of_roll(robot: &Robot, roll: f64) -> f64 {
    3.0_f64.sqrt() * robot.k * (1.0 - roll.cos())
}

fn stack(a: Vector3<f64>, b: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z)
}
