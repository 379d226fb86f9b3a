//! Values, rates and second derivatives of prescribed coordinates, computed from the motion of the
//! bodies.

use super::bodies::Bodies;
use super::coordinate::{AngleOrder, Coordinate, Target};
use super::rotation_vector::RotationVector;
use crate::mechanism::BodyId;
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Pose, Vec3, Wrench};
use crate::topology::{Link, Role, Topology};

/// Value of a coordinate, and the covector whose product with a twist is the rate of the
/// coordinate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured<T> {
    pub(super) value: T,
    /// Covector with `rate = twist.power(covector)`. The twist is that of the coordinate's body
    /// or, for a joint coordinate, that of the successor relative to the predecessor.
    pub(super) covector: Wrench<T>,
}

/// Angles of one body at one configuration, and the axes of the rotations. Motions usually
/// prescribe several angles of the same body, which are computed together.
#[derive(Clone, Copy, Debug)]
pub(super) struct BodyAngles<T> {
    body: BodyId,
    order: AngleOrder,
    angles: [T; 3],
    /// Unit vectors along the axes of the three rotations, in the ground frame.
    axes: [Vec3<T>; 3],
    /// Rows of the matrix that maps the angular velocity to the rates of the angles.
    rows: [Vec3<T>; 3],
}

impl<T: Scalar> BodyAngles<T> {
    /// Returns the angles of `body` from `known`, which must belong to the configuration of
    /// `bodies`. Computes them if `known` contains the angles of another body or order.
    fn at(known: &mut Option<Self>, body: BodyId, order: AngleOrder, bodies: &Bodies<T>) -> Self {
        if let Some(known) = known.filter(|known| known.body == body && known.order == order) {
            return known;
        }
        let angles = intrinsic_angles(seen_from(bodies.pose[0], bodies.pose[body.0]), order);
        let axes = axes_of(order, angles);
        *known.insert(Self { body, order, angles, axes, rows: rate_rows(axes) })
    }
}

/// Rule for the subtraction of two values of a coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Difference {
    /// Ordinary subtraction.
    Plain,
    /// Subtraction of angles, modulo a full turn.
    Angle,
}

/// Lists the spanning-tree nodes on which the coordinate depends. The sign of a node, 1 or -1,
/// states whether its motion counts positive or negative.
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

/// Returns the rule for subtracting values of a coordinate. Joint coordinates of the spanning tree
/// count full turns; angles computed from a pose are known only modulo a full turn.
pub(crate) fn difference(topology: &Topology, coordinate: Coordinate) -> Difference {
    match coordinate {
        Coordinate::Angle { .. } => Difference::Angle,
        Coordinate::Joint { joint, dof } => {
            let unit = topology.joint_types[joint.0].dofs()[dof].motion;
            let turns = unit == crate::joint::Motion::Rotation;
            let read_off = matches!(topology.role[joint.0], Role::Cut { .. });
            if turns && read_off { Difference::Angle } else { Difference::Plain }
        }
        _ => Difference::Plain,
    }
}

/// Returns the index of the coordinate among the spanning tree's coordinates if it is an angle of
/// a joint in the tree, otherwise `None`.
pub(super) fn tree_angle(topology: &Topology, coordinate: Coordinate) -> Option<usize> {
    let Coordinate::Joint { joint, dof } = coordinate else { return None };
    let node = topology.node_of(joint.0)?;
    let unit = topology.joint_types[joint.0].dofs()[dof].motion;
    let turns = unit == crate::joint::Motion::Rotation;
    turns.then(|| node.coordinates.start + dof)
}

/// Computes `found - reference`; an angle difference is wrapped to (-pi, pi].
pub(crate) fn deviation<T: Scalar>(difference: Difference, found: T, reference: T) -> T {
    match difference {
        Difference::Plain => found - reference,
        Difference::Angle => {
            let (s, c) = (found - reference).sin_cos();
            s.atan2(c)
        }
    }
}

/// Computes the value of a coordinate and its covector from the poses of the bodies, which must be
/// up to date. `known` contains the angles of a body at this configuration, if they are known.
pub(super) fn measure<T: Scalar>(
    coordinate: Coordinate,
    topology: &Topology,
    parameters: &Parameters<T>,
    (bodies, known): (&Bodies<T>, &mut Option<BodyAngles<T>>),
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
            let BodyAngles { angles, rows, .. } = BodyAngles::at(known, body, order, bodies);
            let covector = Wrench::couple(ground.rotation * rows[index]);
            Measured { value: angles[index], covector }
        }
        Coordinate::RotationVector { body, axis } => {
            let vector = RotationVector::of(seen_from(ground, bodies.pose[body.0]));
            let row = vector.rate_matrix().transpose() * Vec3::unit(axis);
            let covector = Wrench::couple(ground.rotation * row);
            Measured { value: vector.value.component(axis), covector }
        }
        Coordinate::Joint { joint, dof } => {
            let joint = joint.0;
            let joint_type = topology.joint_types[joint];
            let covector = bodies.effort(&joint_type.dofs()[dof], joint);
            let value = match topology.role[joint] {
                Role::Tree { node } => tree[topology.nodes[node].coordinates.start + dof],
                Role::Cut { .. } => {
                    let relative = bodies.frame_j[joint].inverse() * bodies.frame_k[joint];
                    joint_type.misfit(relative, parameters.pitch[joint]).1[dof]
                }
            };
            Measured { value, covector }
        }
    }
}

/// Computes the value and rate of a coordinate from the poses and twists of the bodies. The
/// acceleration in the returned target is zero.
pub fn measure_motion<T: Scalar>(
    coordinate: Coordinate,
    topology: &Topology,
    parameters: &Parameters<T>,
    bodies: &Bodies<T>,
    tree: &[T],
) -> Target<T> {
    let at = (bodies, &mut None);
    let Measured { value, covector } = measure(coordinate, topology, parameters, at, tree);
    let rate = match coordinate {
        Coordinate::Position { body, .. }
        | Coordinate::Angle { body, .. }
        | Coordinate::RotationVector { body, .. } => bodies.twist[body.0].power(covector),
        Coordinate::Joint { joint, dof } => bodies.joint_rates(topology, joint.0)[dof],
    };
    Target { value, rate, acceleration: T::zero() }
}

/// Computes the second time derivative that a coordinate has if all accelerations of the spanning
/// tree are zero. The twists of the bodies must be up to date. `known` contains the angles of a
/// body at this configuration, if they are known.
pub(super) fn bias<T: Scalar>(
    coordinate: Coordinate,
    topology: &Topology,
    parameters: &Parameters<T>,
    (bodies, known): (&Bodies<T>, &mut Option<BodyAngles<T>>),
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
            let omega = ground.rotation.transpose_mul(bodies.twist[body.0].angular);
            let BodyAngles { axes, rows, .. } = BodyAngles::at(known, body, order, bodies);
            let rates = rows.map(|row| row.dot(omega));
            // The axes rotate: omega' = E angles'' + E' angles'.
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
            // The rate is itself a rate of the spanning tree, so it has no velocity-dependent
            // part.
            Role::Tree { .. } => T::zero(),
            Role::Cut { .. } => {
                let (predecessor, successor) = topology.ends[joint.0];
                let own = bodies.joint_bias(topology, parameters, joint.0);
                (bodies.bias[successor] - bodies.bias[predecessor] - own).power(covector)
            }
        },
    }
}

/// Computes the rotation matrix of a body relative to the ground.
pub(super) fn seen_from<T: Scalar>(ground: Pose<T>, body: Pose<T>) -> Mat3<T> {
    ground.rotation.transpose() * body.rotation
}

/// Returns the axes of a rotation order and the sign of their permutation. For orders like zxz,
/// the third returned axis is the one that the order does not contain.
fn parity(order: AngleOrder) -> (usize, usize, usize, f64) {
    let [i, j, last] = order.axes();
    let k = if order.is_tait_bryan() { last } else { 3 - i - j };
    (i, j, k, if (i + 1) % 3 == j { 1.0 } else { -1.0 })
}

/// Computes the three intrinsic angles of a rotation matrix, rad. The second angle is in [-pi/2,
/// pi/2] for orders of three different axes, and in [0, pi] for orders like zxz.
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

/// Computes the unit vectors along the axes of the three successive rotations, in the frame
/// relative to which the body is rotated.
fn axes_of<T: Scalar>(order: AngleOrder, angles: [T; 3]) -> [Vec3<T>; 3] {
    let [a, b, c] = order.axes();
    let first = Mat3::about_axis(a, angles[0].sin_cos());
    let second = first * Mat3::about_axis(b, angles[1].sin_cos());
    [Vec3::unit(a), first.columns[b], second.columns[c]]
}

/// Computes the rows of the matrix that maps the angular velocity to the rates of the three
/// angles. The rows are the basis reciprocal to the rotation axes.
fn rate_rows<T: Scalar>([a, b, c]: [Vec3<T>; 3]) -> [Vec3<T>; 3] {
    let over = a.dot(b.cross(c)).recip();
    [b.cross(c) * over, c.cross(a) * over, a.cross(b) * over]
}

#[cfg(test)]
mod tests {
    use super::*;
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
    }
}
