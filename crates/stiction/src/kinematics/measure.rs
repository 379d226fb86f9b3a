//! Prescribed coordinates as functions of the bodies' motion.

use super::bodies::Bodies;
use super::coordinate::{AngleOrder, Coordinate};
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Pose, Vec3, Wrench};
use crate::topology::{Link, Role, Topology};

/// A coordinate's value, the covector that gives its rate from a twist, and the part of its second
/// derivative that velocities cause.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured<T> {
    pub(super) value: T,
    /// `rate = twist.power(covector)`, where the twist is the body's, or the joint's relative one.
    pub(super) covector: Wrench<T>,
}

/// How the difference of two values of a coordinate is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Difference {
    /// As of numbers.
    Plain,
    /// As of angles, modulo a full turn.
    Angle,
}

/// Which bodies' motion a coordinate measures, as nodes and signs.
pub(super) fn path(topology: &Topology, coordinate: Coordinate) -> Vec<(usize, f64)> {
    match coordinate {
        Coordinate::Position { body, .. }
        | Coordinate::Angle { body, .. }
        | Coordinate::RotationVector { body, .. } => {
            topology.ancestors(body.0).into_iter().map(|node| (node, 1.0)).collect()
        }
        Coordinate::Joint { joint, .. } => match topology.role[joint.0] {
            Role::Cut { cut } => topology.cuts[cut].path.clone(),
            Role::Tree { node } => {
                let reversed =
                    matches!(topology.nodes[node].link, Link::Joint { reversed: true, .. });
                vec![(node, if reversed { -1.0 } else { 1.0 })]
            }
        },
    }
}

/// How differences of the coordinate are taken. Joint coordinates of the tree are kept as they
/// are, also over several turns; what is read off a pose is known only modulo a turn.
pub(super) fn difference(topology: &Topology, coordinate: Coordinate) -> Difference {
    match coordinate {
        Coordinate::Angle { .. } => Difference::Angle,
        Coordinate::Joint { joint, freedom } => {
            let unit = topology.joint_types[joint.0].freedoms()[freedom].motion;
            let turns = unit == crate::joint::Motion::Rotation;
            let read_off = matches!(topology.role[joint.0], Role::Cut { .. });
            if turns && read_off { Difference::Angle } else { Difference::Plain }
        }
        _ => Difference::Plain,
    }
}

/// `found - wanted` in the sense of `difference`.
#[inline(always)]
pub(super) fn deviation<T: Scalar>(difference: Difference, found: T, wanted: T) -> T {
    match difference {
        Difference::Plain => found - wanted,
        Difference::Angle => {
            let (s, c) = (found - wanted).sin_cos();
            s.atan2(c)
        }
    }
}

/// Measures a coordinate; needs the bodies placed.
#[inline(always)]
pub(super) fn measure<T: Scalar>(
    coordinate: Coordinate,
    topology: &Topology,
    parameters: &Parameters<T>,
    bodies: &Bodies<T>,
    tree: &[T],
) -> Measured<T> {
    let ground = bodies.pose[0];
    match coordinate {
        Coordinate::Position { body, axis } => {
            let p = bodies.pose[body.0].position;
            let e = ground.rotation.columns[axis];
            Measured { value: e.dot(p - ground.position), covector: Wrench::force_through(e, p) }
        }
        Coordinate::Angle { body, order, index } => {
            let rotation = seen_from(ground, bodies.pose[body.0]);
            let angles = intrinsic_angles(rotation, order);
            let rows = rate_rows(axes_of(order, angles));
            let covector = Wrench::couple(ground.rotation * rows[index]);
            Measured { value: angles[index], covector }
        }
        Coordinate::RotationVector { body, axis } => {
            let vector = RotationVector::of(seen_from(ground, bodies.pose[body.0]));
            let row = vector.rate_matrix().transpose() * Vec3::unit(axis);
            let covector = Wrench::couple(ground.rotation * row);
            Measured { value: vector.value.component(axis), covector }
        }
        Coordinate::Joint { joint, freedom } => {
            let joint = joint.0;
            let joint_type = topology.joint_types[joint];
            let covector = bodies.effort(&joint_type.freedoms()[freedom], joint);
            let value = match topology.role[joint] {
                Role::Tree { node } => tree[topology.nodes[node].coordinates.start + freedom],
                Role::Cut { .. } => {
                    let relative = bodies.frame_j[joint].inverse() * bodies.frame_k[joint];
                    joint_type.misfit(relative, parameters.pitch[joint]).1[freedom]
                }
            };
            Measured { value, covector }
        }
    }
}

/// The second derivative of a coordinate when the tree's accelerations are zero; needs the bodies
/// moving.
#[inline(always)]
pub(super) fn bias<T: Scalar>(
    coordinate: Coordinate,
    topology: &Topology,
    parameters: &Parameters<T>,
    bodies: &Bodies<T>,
    covector: Wrench<T>,
) -> T {
    let ground = bodies.pose[0];
    match coordinate {
        Coordinate::Position { body, axis } => {
            let (p, twist) = (bodies.pose[body.0].position, bodies.twist[body.0]);
            let centripetal = twist.angular.cross(twist.velocity_at(p));
            bodies.bias[body.0].power(covector) + ground.rotation.columns[axis].dot(centripetal)
        }
        Coordinate::Angle { body, order, index } => {
            let rotation = seen_from(ground, bodies.pose[body.0]);
            let omega = ground.rotation.transpose_mul(bodies.twist[body.0].angular);
            let axes = axes_of(order, intrinsic_angles(rotation, order));
            let rows = rate_rows(axes);
            let rates = rows.map(|row| row.dot(omega));
            // The axes turn: omega' = E angles'' + E' angles'.
            let turning = (axes[0] * rates[0]).cross(axes[1]) * rates[1]
                + (axes[0] * rates[0] + axes[1] * rates[1]).cross(axes[2]) * rates[2];
            bodies.bias[body.0].power(covector) - rows[index].dot(turning)
        }
        Coordinate::RotationVector { body, axis } => {
            let vector = RotationVector::of(seen_from(ground, bodies.pose[body.0]));
            let omega = ground.rotation.transpose_mul(bodies.twist[body.0].angular);
            let turning = vector.rate_matrix_change(omega) * omega;
            bodies.bias[body.0].power(covector) + turning.component(axis)
        }
        Coordinate::Joint { joint, .. } => match topology.role[joint.0] {
            // The rate is a rate of the tree.
            Role::Tree { .. } => T::zero(),
            Role::Cut { .. } => {
                let (predecessor, successor) = topology.ends[joint.0];
                let own = bodies.joint_bias(topology, parameters, joint.0);
                (bodies.bias[successor] - bodies.bias[predecessor] - own).power(covector)
            }
        },
    }
}

#[inline(always)]
fn seen_from<T: Scalar>(ground: Pose<T>, body: Pose<T>) -> Mat3<T> {
    ground.rotation.transpose() * body.rotation
}

/// Whether the axes are in cyclic order, as a sign. For orders like zxz the third axis is the one
/// that does not occur.
fn parity(order: AngleOrder) -> (usize, usize, usize, f64) {
    let [i, j, last] = order.axes();
    let k = if order.is_tait_bryan() { last } else { 3 - i - j };
    (i, j, k, if (i + 1) % 3 == j { 1.0 } else { -1.0 })
}

/// The three angles of a rotation matrix. The second is in [-pi/2, pi/2] for orders of three
/// different axes, in [0, pi] for orders like zxz.
#[inline(always)]
pub(super) fn intrinsic_angles<T: Scalar>(r: Mat3<T>, order: AngleOrder) -> [T; 3] {
    let (i, j, k, sign) = parity(order);
    let sign = T::from_f64(sign);
    if order.is_tait_bryan() {
        let across = (r.at(i, i) * r.at(i, i) + r.at(i, j) * r.at(i, j)).norm_of_square();
        [
            (-sign * r.at(j, k)).atan2(r.at(k, k)),
            (sign * r.at(i, k)).atan2(across),
            (-sign * r.at(i, j)).atan2(r.at(i, i)),
        ]
    } else {
        let across = (r.at(i, j) * r.at(i, j) + r.at(i, k) * r.at(i, k)).norm_of_square();
        [
            r.at(j, i).atan2(-sign * r.at(k, i)),
            across.atan2(r.at(i, i)),
            r.at(i, j).atan2(sign * r.at(i, k)),
        ]
    }
}

/// The axes about which the three angles turn, as they stand in the outer frame.
#[inline(always)]
fn axes_of<T: Scalar>(order: AngleOrder, angles: [T; 3]) -> [Vec3<T>; 3] {
    let [a, b, c] = order.axes();
    let first = Mat3::about_axis(a, angles[0].sin_cos());
    let second = first * Mat3::about_axis(b, angles[1].sin_cos());
    [Vec3::unit(a), first.columns[b], second.columns[c]]
}

/// Rows that give the rates of the angles from the angular velocity: the basis reciprocal to the
/// axes.
#[inline(always)]
fn rate_rows<T: Scalar>([a, b, c]: [Vec3<T>; 3]) -> [Vec3<T>; 3] {
    let over = a.dot(b.cross(c)).recip();
    [b.cross(c) * over, c.cross(a) * over, a.cross(b) * over]
}

/// A rotation vector and the coefficients of its rate:
/// `r' = omega - r x omega / 2 + c r x (r x omega)`, `c = 1/a^2 - (1 + cos a) / (2 a sin a)`.
struct RotationVector<T> {
    value: Vec3<T>,
    /// `c`.
    coefficient: T,
    /// `(dc/da) / a`.
    slope: T,
}

impl<T: Scalar> RotationVector<T> {
    #[inline(always)]
    fn of(rotation: Mat3<T>) -> Self {
        let w = rotation.skew_part();
        let half = T::from_f64(0.5);
        let sine = w.norm();
        let angle = sine.atan2((rotation.trace() - T::one()) * half);
        // Near zero: power series; the switch at a = 0.1 leaves both sides better than 1e-13.
        let large = angle - T::from_f64(0.1);
        let safe = large.if_positive(angle, T::one());
        let (s, c) = safe.sin_cos();
        let a2 = safe * safe;
        let versine = T::one() + c;
        let closed = a2.recip() - versine * half / (safe * s);
        // d/da of c, over a; the derivative of (1 + cos a)/sin a is -(1 + cos a)/sin^2 a.
        let closed_slope =
            T::from_f64(-2.0) / (a2 * a2) + versine * half * (s + safe) / (a2 * safe * s * s);
        let x = w.norm_squared();
        // a^2 in terms of sin^2 a = x, and a / sin a.
        let asin2 = x * series(
            x,
            &[1.0, 1.0 / 3.0, 8.0 / 45.0, 4.0 / 35.0, 128.0 / 1575.0, 128.0 / 2079.0],
        );
        let ratio = series(
            x,
            &[
                1.0,
                1.0 / 6.0,
                3.0 / 40.0,
                15.0 / 336.0,
                105.0 / 3456.0,
                945.0 / 42240.0,
                10395.0 / 599_040.0,
            ],
        );
        let small = series(
            asin2,
            &[1.0 / 12.0, 1.0 / 720.0, 1.0 / 30_240.0, 1.0 / 1_209_600.0, 1.0 / 47_900_160.0],
        );
        let small_slope =
            series(asin2, &[1.0 / 360.0, 1.0 / 7560.0, 1.0 / 201_600.0, 1.0 / 5_987_520.0]);
        let safe_sine = large.if_positive(sine, T::one());
        Self {
            value: w * large.if_positive(angle / safe_sine, ratio),
            coefficient: large.if_positive(closed, small),
            slope: large.if_positive(closed_slope, small_slope),
        }
    }

    /// The matrix `A` of `r' = A omega`.
    #[inline(always)]
    fn rate_matrix(&self) -> Mat3<T> {
        self.matrix(|r, e| {
            e - r.cross(e) * T::from_f64(0.5) + r.cross(r.cross(e)) * self.coefficient
        })
    }

    /// The time derivative of [`Self::rate_matrix`].
    #[inline(always)]
    fn rate_matrix_change(&self, omega: Vec3<T>) -> Mat3<T> {
        let rate = self.rate_matrix() * omega;
        let change = self.slope * self.value.dot(rate);
        self.matrix(|r, e| {
            (rate.cross(r.cross(e)) + r.cross(rate.cross(e))) * self.coefficient
                + r.cross(r.cross(e)) * change
                - rate.cross(e) * T::from_f64(0.5)
        })
    }

    #[inline(always)]
    fn matrix(&self, column: impl Fn(Vec3<T>, Vec3<T>) -> Vec3<T>) -> Mat3<T> {
        Mat3::from_columns(
            column(self.value, Vec3::unit(0)),
            column(self.value, Vec3::unit(1)),
            column(self.value, Vec3::unit(2)),
        )
    }
}

/// A polynomial in `x`, lowest power first.
#[inline(always)]
fn series<T: Scalar>(x: T, coefficients: &[f64]) -> T {
    let mut sum = T::zero();
    for &coefficient in coefficients.iter().rev() {
        sum = sum * x + T::from_f64(coefficient);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Dual;
    use proptest::prelude::*;

    const ORDERS: [&str; 12] =
        ["xyz", "yzx", "zxy", "xzy", "zyx", "yxz", "xyx", "yzy", "zxz", "xzx", "zyz", "yxy"];

    proptest! {
        #[test]
        fn angles_of_all_orders_are_read_back(
            first in -3.1..3.1f64, second in 0.05..1.5f64, third in -3.1..3.1f64,
        ) {
            for name in ORDERS {
                let order = AngleOrder::from_name(name).unwrap();
                let angles = [first, second, third];
                let [a, b, c] = order.axes();
                let rotation = Mat3::about_axis(a, first.sin_cos())
                    * Mat3::about_axis(b, second.sin_cos())
                    * Mat3::about_axis(c, third.sin_cos());
                let found = intrinsic_angles(rotation, order);
                for (found, expected) in found.iter().zip(angles) {
                    prop_assert!((found - expected).abs() < 1e-12, "{name}");
                }
            }
        }

        /// Along r(t) = r0 + r1 t the rate matrix turns the angular velocity into r1, and its change
        /// is its derivative; the angular velocity by dual numbers from the rotation itself.
        #[test]
        fn rotation_vector_rates_are_exact(
            r0 in prop::array::uniform3(-1.7..1.7f64),
            r1 in prop::array::uniform3(-1.0..1.0f64),
            shrink in prop::sample::select(vec![1.0, 0.1, 0.06, 0.05, 1e-3, 1e-8]),
        ) {
            let r0 = Vec3::from(r0) * shrink;
            let r1 = Vec3::from(r1);
            prop_assume!(r0.norm() < 3.0);
            type D = Dual<f64, 1>;
            let at = |t: D| Vec3::new(D::from_f64(r0.x), D::from_f64(r0.y), D::from_f64(r0.z))
                + Vec3::new(D::from_f64(r1.x), D::from_f64(r1.y), D::from_f64(r1.z)) * t;
            // exp by its series, exact for these sizes; w = R' R^T.
            let exp = |r: Vec3<D>| {
                let column = |e: Vec3<D>| {
                    let (mut term, mut sum) = (e, e);
                    for n in 1..40 {
                        term = r.cross(term) * D::from_f64(1.0 / n as f64);
                        sum += term;
                    }
                    sum
                };
                Mat3::from_columns(column(Vec3::unit(0)), column(Vec3::unit(1)), column(Vec3::unit(2)))
            };
            let rotation = exp(at(D::variable(0.0, 0)));
            let value = Mat3 { columns: rotation.columns.map(|c| Vec3::new(c.x.value, c.y.value, c.z.value)) };
            let rate = Mat3 { columns: rotation.columns.map(|c| Vec3::new(c.x.slope[0], c.y.slope[0], c.z.slope[0])) };
            let omega = (rate * value.transpose()).skew_part();

            let vector = RotationVector::of(value);
            prop_assert!((vector.value - r0).norm() < 1e-12);
            let error = (vector.rate_matrix() * omega - r1).norm();
            prop_assert!(error < 1e-11, "rate {error:e}");

            // The same object over dual numbers differentiates the matrix.
            let dual = RotationVector::of(rotation).rate_matrix();
            let change = vector.rate_matrix_change(omega);
            for k in 0..3 {
                let c = dual.columns[k];
                let expected = Vec3::new(c.x.slope[0], c.y.slope[0], c.z.slope[0]);
                let error = (change.columns[k] - expected).norm();
                prop_assert!(error < 1e-9, "change {error:e} at {:e}", r0.norm());
            }
        }
    }
}
