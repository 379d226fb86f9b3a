//! Section 2 of the paper: equations (7), (9) to (15), and the Jacobian.
//!
//! With `T` a dual number in time, these functions give rates and accelerations to rounding error.

use super::robot::{Motion, Pose, Robot, leg_vector};
use stiction_core::scalar::{Dual, Scalar};

/// A number with its first and second time derivatives.
pub(super) type Timed = Dual<Dual<f64, 1>, 1>;

/// Length of leg n: equation (7) without subtraction of the length at zero input.
pub(super) fn leg_length<T: Scalar>(robot: &Robot, n: usize, pose: Pose<T>) -> T {
    let [dx, dz] = leg_vector(robot, n, pose);
    (dx * dx + dz * dz).sqrt()
}

/// Equation (7): the inputs q_n of the prismatic joints.
pub(super) fn inputs<T: Scalar>(robot: &Robot, pose: Pose<T>) -> [T; 3] {
    core::array::from_fn(|n| leg_length(robot, n, pose) - T::from_f64(robot.home[n]))
}

/// Equations (13) to (15): the angle of leg n with the x axis. The paper's arccos loses the sign;
/// this function agrees with it if the ball is above the base.
pub(super) fn leg_angle<T: Scalar>(robot: &Robot, n: usize, pose: Pose<T>) -> T {
    let [dx, dz] = leg_vector(robot, n, pose);
    dz.atan2(dx)
}

/// Equations (9) to (12): centre of mass of rod n, x and z.
pub(super) fn rod_centre<T: Scalar>(robot: &Robot, n: usize, pose: Pose<T>) -> [T; 2] {
    let [dx, dz] = leg_vector(robot, n, pose);
    let length = (dx * dx + dz * dz).sqrt();
    let part = T::one() - T::from_f64(robot.rod_com) / length;
    [T::from_f64(robot.b[n][0]) + dx * part, T::from_f64(robot.b[n][2]) + dz * part]
}

/// Centre of mass of base n, x and z, from the lengths before equation (20).
pub(super) fn base_centre<T: Scalar>(robot: &Robot, n: usize, pose: Pose<T>) -> [T; 2] {
    let [dx, dz] = leg_vector(robot, n, pose);
    let length = (dx * dx + dz * dz).sqrt();
    let part = T::from_f64(robot.base_com) / length;
    [T::from_f64(robot.b[n][0]) + dx * part, T::from_f64(robot.b[n][2]) + dz * part]
}

/// The matrix before section 3, J^-1: row n holds the derivatives of q_n with respect to x, z and
/// theta, u_n . dS_n/dX.
pub(super) fn inverse_jacobian(robot: &Robot, pose: Pose<f64>) -> [[f64; 3]; 3] {
    core::array::from_fn(|n| gradient(pose, |pose| leg_length(robot, n, pose)))
}

/// Derivatives of the leg angles (13) to (15) with respect to x, z and theta.
pub(super) fn angle_jacobian(robot: &Robot, pose: Pose<f64>) -> [[f64; 3]; 3] {
    core::array::from_fn(|n| gradient(pose, |pose| leg_angle(robot, n, pose)))
}

fn gradient(pose: Pose<f64>, f: impl Fn(Pose<Dual<f64, 3>>) -> Dual<f64, 3>) -> [f64; 3] {
    f(core::array::from_fn(|i| Dual::variable(pose[i], i))).slope
}

/// Determinant of J^-1 times all leg lengths, in closed form for the printed robot. It is zero at
/// theta = 90 deg for all x, z, k and l.
pub(super) fn determinant(robot: &Robot, [x, z, theta]: Pose<f64>) -> f64 {
    let (sin, cos) = theta.sin_cos();
    let (k, l) = (robot.k, robot.l);
    2.0 * k * l * cos * (k * (x * cos + z * sin) - l * z)
}

/// The motion as dual numbers with time derivatives.
pub(super) fn timed(motion: &Motion) -> Pose<Timed> {
    core::array::from_fn(|i| Dual {
        value: Dual { value: motion.pose[i], slope: [motion.rate[i]] },
        slope: [Dual { value: motion.rate[i], slope: [motion.acceleration[i]] }],
    })
}

/// Value, first and second derivative of a dual number.
pub(super) fn parts(number: Timed) -> [f64; 3] {
    [number.value.value, number.value.slope[0], number.slope[0].slope[0]]
}

/// Moving quantities of a leg, with first and second time derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct LegMotion {
    /// Length, m.
    pub(super) length: [f64; 3],
    /// The leg's rotation about +y, alpha = 90 deg - phi, rad.
    pub(super) turn: [f64; 3],
    /// The rod's centre of mass, x and z, m.
    pub(super) rod: [[f64; 3]; 2],
    /// The base's centre of mass, x and z, m.
    pub(super) base: [[f64; 3]; 2],
}

/// Rates of the P, R and S joints of each leg: m/s, rad/s, and rad/s about y.
pub(super) fn joint_rates(robot: &Robot, motion: &Motion) -> [[f64; 3]; 3] {
    core::array::from_fn(|n| {
        let leg = leg_motion(robot, n, motion);
        // beta = 90 deg - theta.
        [leg.length[1], leg.turn[1], -motion.rate[2] - leg.turn[1]]
    })
}

/// Moving quantities of leg n.
pub(super) fn leg_motion(robot: &Robot, n: usize, motion: &Motion) -> LegMotion {
    let pose = timed(motion);
    let [angle, rate, acceleration] = parts(leg_angle(robot, n, pose));
    LegMotion {
        length: parts(leg_length(robot, n, pose)),
        turn: [core::f64::consts::FRAC_PI_2 - angle, -rate, -acceleration],
        rod: rod_centre(robot, n, pose).map(parts),
        base: base_centre(robot, n, pose).map(parts),
    }
}
