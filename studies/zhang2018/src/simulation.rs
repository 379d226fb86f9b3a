//! Section 6 of the paper: solvability of the equations along the motion (29).

use super::friction::{joint_friction, virtual_work};
use super::kinematics::{inverse_jacobian, joint_rates};
use super::lagrangian::{Printed, generalised_force, generalised_load};
use super::reactions::{Form, PITCH, SIZE, System};
use super::robot::{Load, Motion, Robot, leg_lengths};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use stiction_core::linalg::Svd;

/// Tests for a moment, N m, among the 42 unknowns: M_R or M_P of a leg.
fn is_moment(column: usize) -> bool {
    let place = column % super::reactions::OF_LEG;
    (3..5).contains(&place) || (7..10).contains(&place)
}

/// Tests for a moment equation among the 42 rows.
fn is_moment_row(row: usize) -> bool {
    (row / 3) % 2 == 1
}

/// Converts the 42 equations to a length unit of 1 / `per_metre` m.
pub(super) fn in_units(system: &System, per_metre: f64) -> (DMatrix<f64>, DVector<f64>) {
    let row_factor = |row: usize| if is_moment_row(row) { per_metre } else { 1.0 };
    let column_factor = |column: usize| if is_moment(column) { per_metre } else { 1.0 };
    let matrix = DMatrix::from_fn(SIZE, SIZE, |i, j| {
        system.matrix[(i, j)] * row_factor(i) / column_factor(j)
    });
    (matrix, DVector::from_fn(SIZE, |i, _| system.right[i] * row_factor(i)))
}

/// Unbalanced moment M_y on the platform, N m, at theta = 90 deg without friction. In the
/// projection along y all leg lines meet in one point there, so a resultant is balanced only if k z
/// / (k - l) F_x - k x / (k - l) F_z + M_y = 0. The result is positive if a moment about +y is
/// missing.
pub(super) fn missing_moment(robot: &Robot, motion: &Motion, load: Load) -> f64 {
    let force = generalised_force(robot, Printed::NONE, motion);
    let load = generalised_load(load);
    let needed: [f64; 3] = core::array::from_fn(|i| force[i] - load[i]);
    let [x, z, _] = motion.pose;
    let lever = robot.k / (robot.k - robot.l);
    // The third generalised force acts along theta, which is opposite to +y.
    lever * z * needed[0] - lever * x * needed[1] - needed[2]
}

/// Platform load (F, M) at O2 in fixed axes that the 42 equations of the printed robot cannot
/// balance: the platform part of the left null vector, scaled to its largest component. A load with
/// a component along this vector has no solution for any actuator forces. Returns `None` if the
/// rank is not 41.
///
/// Also returns the imbalance under `load`, in the same scale.
pub(super) fn out_of_range(robot: &Robot, motion: &Motion, load: Load) -> Option<([f64; 6], f64)> {
    let system = System::new(robot, motion, load, Form::Corrected);
    let [null] = Svd::new(&system.matrix.transpose()).null_space(SIZE - 1).try_into().ok()?;
    let part: [f64; 6] = core::array::from_fn(|i| null[SIZE - 6 + i]);
    let largest = part.into_iter().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    Some((part.map(|x| x / largest), null.dot(&system.right) / largest))
}

/// Solves the printed robot with friction and the self-stress (-2, 1, 1) f of its legs, with an
/// auxiliary support of the platform's moment about y. Returns the generalised force of motion and
/// friction, N, N, N m, and the moment of the support about y, N m; `None` if the iteration does
/// not converge.
pub(super) fn with_friction(
    robot: &Robot,
    motion: &Motion,
    load: Load,
    f: f64,
) -> Option<([f64; 3], f64)> {
    let system = System::new(robot, motion, load, Form::Corrected);
    let borne = system.with_self_stress(f);
    let lu = borne.matrix.clone().lu();
    let rates = joint_rates(robot, motion);
    let mut unknowns = lu.solve(&borne.right)?;
    let mut last = f64::INFINITY;
    for _ in 0..200 {
        let friction = joint_friction(robot, &rates, &System::loads(&unknowns), true);
        let mut right = borne.right.clone();
        borne.add_friction(&friction, &mut right);
        // Friction does not enter the self-stress row.
        right[PITCH] = f;
        let next = lu.solve(&right)?;
        let change = (&next - &unknowns).amax();
        unknowns = next;
        if change == 0.0 || (change >= last && change < 1e-9) {
            let mut right = system.right.clone();
            system.add_friction(&friction, &mut right);
            let force = generalised_force(robot, Printed::NONE, motion);
            let added = virtual_work(robot, motion, &friction);
            let force = core::array::from_fn(|i| force[i] + added[i]);
            return Some((force, system.missing_pitch(&unknowns, &right)));
        }
        last = change;
    }
    None
}

/// Minimum-norm least-squares actuator forces, N, and the norm of the residual, in the chosen
/// units. The result depends on these units.
pub(super) fn least_squares(
    system: &System,
    per_metre: f64,
    without_pitch: bool,
) -> ([f64; 3], f64) {
    let (mut matrix, mut right) = in_units(system, per_metre);
    if without_pitch {
        // Moment equation of the platform about y.
        matrix = matrix.remove_row(40);
        right = right.remove_row(40);
    }
    let svd = Svd::new(&matrix);
    let unknowns = svd.solve(&right, 41);
    let residual = (&matrix * &unknowns - &right).norm();
    (System::drives(&unknowns), residual)
}

/// Least-squares solution of the three equations (21).
pub(super) fn planar_least_squares(
    robot: &Robot,
    motion: &Motion,
    load: Load,
    per_metre: f64,
) -> [f64; 3] {
    let rows = inverse_jacobian(robot, motion.pose);
    let force = generalised_force(robot, Printed::NONE, motion);
    let load = generalised_load(load);
    let unit = |i: usize| if i == 2 { per_metre } else { 1.0 };
    let matrix = DMatrix::from_fn(3, 3, |i, n| rows[n][i] * unit(i));
    let right = DVector::from_fn(3, |i, _| (force[i] - load[i]) * unit(i));
    let solution = Svd::new(&matrix).solve(&right, 2);
    [solution[0], solution[1], solution[2]]
}

/// Forward kinematics near the motion (29): the pose closest to a platform rotation of `turn` rad,
/// for the leg lengths at `time` with leg 1 longer by `longer` m. Returns `None` if the loops do
/// not close.
pub(super) fn fold(robot: &Robot, time: f64, longer: f64, turn: f64) -> Option<[f64; 3]> {
    let start = Robot::printed_motion(time).pose;
    let mut lengths = leg_lengths(robot, start);
    lengths[0] += longer;
    let mut pose = [start[0], start[1], start[2] + turn];
    for _ in 0..60 {
        let now = leg_lengths(robot, pose);
        let misfit = Vector3::from_fn(|n, _| lengths[n] - now[n]);
        let rows = inverse_jacobian(robot, pose);
        let step = Matrix3::from_fn(|n, i| rows[n][i]).lu().solve(&misfit)?;
        // Limit the step: near a fold Newton's method diverges.
        let step = step * (0.05 / step.norm()).min(1.0);
        for (value, step) in pose.iter_mut().zip(step.iter()) {
            *value += step;
        }
        if (pose[2] - start[2]).abs() > 0.2 {
            return None;
        }
    }
    let now = leg_lengths(robot, pose);
    let closed = (0..3).all(|n| (now[n] - lengths[n]).abs() < 1e-12);
    closed.then_some(pose)
}
