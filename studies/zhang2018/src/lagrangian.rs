//! Section 3 of the paper: energies (8) and (16) to (20), the Lagrangian, and equation (21).
//!
//! The Lagrangian has the form printed in the paper. Dual numbers differentiate it exactly.

use super::kinematics::{base_centre, inverse_jacobian, leg_angle, rod_centre};
use super::robot::{Load, Motion, Pose, Robot};
use nalgebra::{Matrix3, Vector3};
use stiction_core::scalar::{Dual, Scalar};

/// Moments of inertia taken as printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Printed {
    /// J'_d of equation (8): J_d + m_d (x^2 + z^2), which counts the translation twice.
    pub(super) platform: bool,
    /// J'_n1 of equation (16): J_n1 + m_n1 l_n1^2, which counts the translation twice.
    pub(super) rods: bool,
    /// J'_n2 of equation (17): about the axis O1 y1 for all three legs.
    pub(super) bases: bool,
}

impl Printed {
    /// All moments of inertia corrected.
    pub(super) const NONE: Self = Self { platform: false, rods: false, bases: false };
    /// All moments of inertia as printed.
    pub(super) const ALL: Self = Self { platform: true, rods: true, bases: true };
}

fn square_sum<T: Scalar>([a, b]: [T; 2]) -> T {
    a * a + b * b
}

/// Equation (8): kinetic energy of the platform, J.
pub(super) fn platform_energy<T: Scalar>(
    robot: &Robot,
    printed: bool,
    [x, z, _]: Pose<T>,
    [vx, vz, turn]: Pose<T>,
) -> T {
    let mass = T::from_f64(robot.mass[0]);
    let mut inertia = T::from_f64(robot.inertia[0]);
    if printed {
        inertia += mass * square_sum([x, z]);
    }
    (mass * square_sum([vx, vz]) + inertia * turn * turn) * T::from_f64(0.5)
}

/// Equation (16): kinetic energy of the three rods, J.
pub(super) fn rod_energy<T: Scalar>(
    robot: &Robot,
    printed: bool,
    pose: Pose<T>,
    rate: Pose<T>,
) -> T {
    let moving = moving(pose, rate);
    let mass = T::from_f64(robot.mass[1]);
    let mut sum = T::zero();
    for n in 0..3 {
        let centre = rod_centre(robot, n, moving);
        let turn = leg_angle(robot, n, moving).slope[0];
        let mut inertia = T::from_f64(robot.inertia[1]);
        if printed {
            inertia += mass * square_sum(centre.map(|c| c.value));
        }
        sum += mass * square_sum(centre.map(|c| c.slope[0])) + inertia * turn * turn;
    }
    sum * T::from_f64(0.5)
}

/// Equation (17): kinetic energy of the three bases, J. The moment of inertia about R_n is J_n2 +
/// m_n2 p^2.
pub(super) fn base_energy<T: Scalar>(
    robot: &Robot,
    printed: bool,
    pose: Pose<T>,
    rate: Pose<T>,
) -> T {
    let moving = moving(pose, rate);
    let mass = T::from_f64(robot.mass[2]);
    let mut sum = T::zero();
    for n in 0..3 {
        let turn = leg_angle(robot, n, moving).slope[0];
        let square = if printed {
            square_sum(base_centre(robot, n, pose))
        } else {
            T::from_f64(robot.base_com * robot.base_com)
        };
        sum += (T::from_f64(robot.inertia[2]) + mass * square) * turn * turn;
    }
    sum * T::from_f64(0.5)
}

/// Equations (18), (19) and (20): potential energy, J, zero in the plane of the R axes.
pub(super) fn potential<T: Scalar>(robot: &Robot, pose: Pose<T>) -> T {
    let mut moment = T::from_f64(robot.mass[0]) * pose[1];
    for n in 0..3 {
        moment += T::from_f64(robot.mass[1]) * rod_centre(robot, n, pose)[1];
        moment += T::from_f64(robot.mass[2]) * base_centre(robot, n, pose)[1];
    }
    moment * T::from_f64(robot.gravity)
}

/// The Lagrangian before equation (21).
pub(super) fn lagrangian<T: Scalar>(
    robot: &Robot,
    printed: Printed,
    pose: Pose<T>,
    rate: Pose<T>,
) -> T {
    platform_energy(robot, printed.platform, pose, rate)
        + rod_energy(robot, printed.rods, pose, rate)
        + base_energy(robot, printed.bases, pose, rate)
        - potential(robot, pose)
}

/// Pose as a dual number with its rate.
fn moving<T: Scalar>(pose: Pose<T>, rate: Pose<T>) -> Pose<Dual<T, 1>> {
    core::array::from_fn(|i| Dual { value: pose[i], slope: [rate[i]] })
}

/// Generalised force (F_x, F_z, M_theta) of the motion by Lagrange's equations, the line before
/// equation (21); N, N, N m.
pub(super) fn generalised_force(robot: &Robot, printed: Printed, motion: &Motion) -> [f64; 3] {
    // The inner dual number differentiates in time, the outer one with respect to the rates.
    let flow = |value: f64, slope: f64| Dual::<f64, 1> { value, slope: [slope] };
    let pose =
        core::array::from_fn(|i| Dual::<_, 3>::constant(flow(motion.pose[i], motion.rate[i])));
    let rate = core::array::from_fn(|i| {
        Dual::<_, 3>::variable(flow(motion.rate[i], motion.acceleration[i]), i)
    });
    let momentum = lagrangian(robot, printed, pose, rate).slope;
    let pose = core::array::from_fn(|i| Dual::<f64, 3>::variable(motion.pose[i], i));
    let rate = motion.rate.map(Dual::<f64, 3>::constant);
    let force = lagrangian(robot, printed, pose, rate).slope;
    core::array::from_fn(|i| momentum[i].slope[0] - force[i])
}

/// Converts a platform wrench to a generalised force; theta is opposite to +y.
pub(super) fn generalised_load([fx, _, fz, _, my, _]: Load) -> [f64; 3] {
    [fx, fz, -my]
}

/// Equation (21) with the missing external load: the actuator forces, N, from J_a^T tau = F - Q.
/// Returns `None` if the matrix is numerically singular.
pub(super) fn driving_forces(
    robot: &Robot,
    printed: Printed,
    motion: &Motion,
    load: Load,
) -> Option<[f64; 3]> {
    let force = generalised_force(robot, printed, motion);
    let external = generalised_load(load);
    drives_of(robot, motion.pose, core::array::from_fn(|i| force[i] - external[i]))
}

/// Actuator forces that are equivalent to a generalised force.
pub(super) fn drives_of(robot: &Robot, pose: Pose<f64>, force: [f64; 3]) -> Option<[f64; 3]> {
    let rows = inverse_jacobian(robot, pose);
    let matrix = Matrix3::from_fn(|i, n| rows[n][i]);
    // The third equation is a moment: scale it by k to a force.
    let unit = Vector3::new(1.0, 1.0, 1.0 / robot.k);
    let scaled = Matrix3::from_diagonal(&unit) * matrix;
    let smallest = scaled.singular_values().min();
    if smallest < 1e-9 {
        return None;
    }
    let solution = scaled.lu().solve(&unit.component_mul(&Vector3::from(force)))?;
    Some(solution.into())
}
