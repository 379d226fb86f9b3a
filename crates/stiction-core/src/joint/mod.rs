//! Joint types with their degrees of freedom and constraints. Each joint type has its own module;
//! all these modules define the same set of items.
//!
//! A joint connects frame J, fixed in its *predecessor* body, with frame K, fixed in its
//! *successor*. At zero coordinates the frames coincide. The axis of a joint is the z axis of J.
//!
//! | type | coordinates | degrees of freedom (unit twists) | constraints (unit wrenches, in J) |
//! | --- | --- | --- | --- |
//! | R revolute | angle | rotation z of J | force x y z, moment x y |
//! | P prismatic | slide | translation z of J | force x y, moment x y z |
//! | H helical | angle | rotation z of J and `pitch` times translation z | force x y, moment x y, (force z, -`pitch` moment z) |
//! | C cylindrical | angle, slide | rotation z, translation z of J | force x y, moment x y |
//! | U universal | two angles | rotation z of J, rotation x of K | force x y z, moment along the common normal |
//! | S spherical | unit quaternion | rotation x y z of K | force x y z |
//! | E planar | x, y, angle | translation x y of J, rotation z of K | force z, moment x y |
//! | fixed | none | none | all six |
//! | free | position, unit quaternion | translation x y z of J, rotation x y z of K | nothing |
//!
//! Forces pass through the origin of J. The twist of each degree of freedom is constant in the body
//! that carries it (the carrier). The rate of change of every joint's motion subspace therefore has
//! one formula: `d/dt S_k = (twist of the carrier) x S_k`.
//!
//! Equation (K3) of the book's theory.

mod cylindrical;
mod fixed;
mod free;
mod helical;
mod planar;
mod prismatic;
mod revolute;
mod spherical;
mod universal;

use crate::scalar::Scalar;
use crate::spatial::{Mat3, Pose, Quaternion, Twist, Vec3, Wrench};
/// Largest number of degrees of freedom of a joint.
pub(crate) const MOST_DOFS: usize = 6;

/// Type of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JointType {
    /// Rotation about one axis.
    Revolute,
    /// Translation along one axis.
    Prismatic,
    /// Screw: rotation and translation coupled by a pitch.
    Helical,
    /// Rotation about and translation along one axis.
    Cylindrical,
    /// Two rotations about perpendicular, intersecting axes (Hooke or Cardan joint).
    Universal,
    /// All three rotations about one point (ball joint).
    Spherical,
    /// Two translations in a plane and the rotation about its normal.
    Planar,
    /// No degree of freedom: a rigid connection.
    Fixed,
    /// Six degrees of freedom, no constraints.
    Free,
}

/// Body of a joint in which the unit twist of a degree of freedom is constant.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carrier {
    /// Predecessor body: the axis of the motion is an axis of frame J, through the origin of J.
    Predecessor,
    /// Successor body: the axis of the motion is an axis of frame K, through the origin of K.
    Successor,
}

/// One degree of freedom of a joint: a unit twist along a coordinate axis of the carrier's joint frame.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dof {
    /// Kind of motion: rotation, translation or screw.
    pub motion: Motion,
    /// Axis: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Body to which the axis of the motion is fixed.
    pub carrier: Carrier,
    /// Name of the coordinate, unique within the joint.
    pub name: &'static str,
}

/// Kind of motion of a degree of freedom.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Rotation; rates in rad/s, conjugate efforts in N m.
    Rotation,
    /// Translation; rates in m/s, conjugate efforts in N.
    Translation,
    /// Rotation combined with a translation of `pitch` (m/rad) times the angle; rates in rad/s,
    /// efforts in N m.
    Screw,
}

/// Constraint wrench of a joint in frame J; its power on the joint's degrees of freedom is zero.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constraint {
    /// Unit force along an axis, through the origin of J.
    Force(usize),
    /// Unit moment along an axis.
    Moment(usize),
    /// Unit force along z with the moment `-pitch` about z: the constraint of a screw.
    Thread,
    /// Unit moment along the common normal of a universal joint's axes.
    Normal,
}

const fn dof(motion: Motion, axis: usize, carrier: Carrier, name: &'static str) -> Dof {
    Dof { motion, axis, carrier, name }
}

/// Expands to the item with the given name, such as a constant or function, from the module of a
/// joint type.
macro_rules! of_type {
    ($joint_type:expr, $item:ident $($call:tt)*) => {
        match $joint_type {
            JointType::Revolute => revolute::$item $($call)*,
            JointType::Prismatic => prismatic::$item $($call)*,
            JointType::Helical => helical::$item $($call)*,
            JointType::Cylindrical => cylindrical::$item $($call)*,
            JointType::Universal => universal::$item $($call)*,
            JointType::Spherical => spherical::$item $($call)*,
            JointType::Planar => planar::$item $($call)*,
            JointType::Fixed => fixed::$item $($call)*,
            JointType::Free => free::$item $($call)*,
        }
    };
}

impl JointType {
    /// All joint types, in the order of the table in the module documentation.
    pub const ALL: [Self; 9] = [
        Self::Revolute,
        Self::Prismatic,
        Self::Helical,
        Self::Cylindrical,
        Self::Universal,
        Self::Spherical,
        Self::Planar,
        Self::Fixed,
        Self::Free,
    ];

    /// Symbol of the joint type: its letter in mechanism theory (R, P, H, C, U, S, E), or `fixed`
    /// or `free`.
    pub const fn symbol(self) -> &'static str {
        of_type!(self, SYMBOL)
    }

    /// Returns the joint type with the given [`Self::symbol`], or `None` if no type has this
    /// symbol.
    pub fn from_symbol(symbol: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|t| t.symbol() == symbol)
    }

    /// Degrees of freedom, in the order of the rates.
    #[inline]
    pub const fn dofs(self) -> &'static [Dof] {
        of_type!(self, FREEDOMS)
    }

    /// Constraint wrenches of the joint type.
    #[inline]
    pub const fn constraints(self) -> &'static [Constraint] {
        of_type!(self, CONSTRAINTS)
    }

    /// Number of coordinates; an orientation has four coordinates (a unit quaternion) but three
    /// degrees of freedom.
    #[inline]
    pub const fn coordinates(self) -> usize {
        of_type!(self, COORDINATES)
    }

    /// Returns `true` if every coordinate is the integral of the rate with the same index. This
    /// holds for all types without quaternions.
    pub const fn has_scalar_coordinates(self) -> bool {
        !matches!(self, Self::Spherical | Self::Free)
    }

    /// Computes the pose `X_JK` for the coordinates `q` (rad, m), which must have the length
    /// [`Self::coordinates`].
    #[inline]
    pub fn pose<T: Scalar>(self, q: &[T], pitch: T) -> Pose<T> {
        of_type!(self, pose(q, pitch))
    }

    /// Computes the pose permitted by the joint that is nearest to the actual pose `relative` of K
    /// in J. Also returns the scalar coordinates of the permitted pose (zeros for quaternions).
    #[inline]
    pub fn nearest<T: Scalar>(self, relative: Pose<T>, pitch: T) -> (Pose<T>, [T; 3]) {
        of_type!(self, nearest(relative, pitch))
    }

    /// Writes the coordinates for which frames J and K coincide.
    pub fn write_zero<T: Scalar>(self, q: &mut [T]) {
        q[..self.coordinates()].fill(T::zero());
        match self {
            Self::Spherical => q[0] = T::one(),
            Self::Free => q[3] = T::one(),
            _ => {}
        }
    }

    /// Writes the coordinates that belong to `relative`, a pose `X_JK` permitted by the joint.
    pub fn write_coordinates(self, relative: Pose<f64>, pitch: f64, q: &mut [f64]) {
        match self {
            Self::Spherical => Quaternion::from_rotation(relative.rotation).write(q),
            Self::Free => {
                q[..3].copy_from_slice(&relative.position.to_array());
                Quaternion::from_rotation(relative.rotation).write(&mut q[3..]);
            }
            _ => {
                let n = self.coordinates();
                q[..n].copy_from_slice(&self.nearest(relative, pitch).1[..n]);
            }
        }
    }

    /// Advances the coordinates by a small step (rad, m), one component per degree of freedom.
    /// Quaternions keep unit length.
    #[inline]
    pub fn advance<T: Scalar>(self, q: &mut [T], step: &[T]) {
        let turn = |q: &mut [T], step: &[T]| {
            let rotation = Vec3::new(step[0], step[1], step[2]);
            // The rates of a quaternion are in the successor's axes: compose on the right.
            Quaternion::from_coordinates(q)
                .compose(Quaternion::of_small(rotation))
                .normalised()
                .write(q);
        };
        match self {
            Self::Spherical => turn(q, step),
            Self::Free => {
                for k in 0..3 {
                    q[k] += step[k];
                }
                turn(&mut q[3..7], &step[3..6]);
            }
            _ => {
                for k in 0..self.coordinates() {
                    q[k] += step[k];
                }
            }
        }
    }
}

impl Dof {
    /// Returns `true` if the coordinate is a length (m, with efforts in N), `false` if it is an
    /// angle (rad, with efforts in N m).
    pub fn translates(&self) -> bool {
        self.motion == Motion::Translation
    }

    /// Computes the unit twist of the successor relative to the predecessor for the given joint
    /// frames J and K in the world.
    #[inline]
    pub fn twist<T: Scalar>(&self, j: &Pose<T>, k: &Pose<T>, pitch: T) -> Twist<T> {
        let frame = match self.carrier {
            Carrier::Predecessor => j,
            Carrier::Successor => k,
        };
        let axis = frame.rotation.columns[self.axis];
        match self.motion {
            Motion::Rotation => Twist::rotation(axis, frame.position),
            Motion::Translation => Twist::translation(axis),
            Motion::Screw => {
                Twist::rotation(axis, frame.position) + Twist::translation(axis * pitch)
            }
        }
    }

    /// Returns the units of the coordinate and of the conjugate effort: (rad, N m) or (m, N).
    pub const fn units(&self) -> (&'static str, &'static str) {
        match self.motion {
            Motion::Translation => ("m", "N"),
            Motion::Rotation | Motion::Screw => ("rad", "N m"),
        }
    }

    /// Computes the wrench of a unit effort on this degree of freedom, exerted by the predecessor
    /// on the successor: a couple along the axis, or a force along the axis through the origin of
    /// K. The power of this wrench on a relative twist equals the rate of this degree of freedom,
    /// so the wrench can also be used to extract the rate from a twist.
    #[inline]
    pub fn effort<T: Scalar>(&self, j: &Pose<T>, k: &Pose<T>) -> Wrench<T> {
        let frame = match self.carrier {
            Carrier::Predecessor => j,
            Carrier::Successor => k,
        };
        let axis = frame.rotation.columns[self.axis];
        match self.motion {
            Motion::Rotation | Motion::Screw => Wrench::couple(axis),
            Motion::Translation => Wrench::force_through(axis, k.position),
        }
    }

    /// Computes the rate of this degree of freedom in the twist `relative` of the successor
    /// relative to the predecessor: the power of [`Self::effort`] on this twist.
    #[inline]
    pub fn rate_of<T: Scalar>(&self, relative: Twist<T>, j: &Pose<T>, k: &Pose<T>) -> T {
        let frame = match self.carrier {
            Carrier::Predecessor => j,
            Carrier::Successor => k,
        };
        let axis = frame.rotation.columns[self.axis];
        match self.motion {
            Motion::Rotation | Motion::Screw => relative.angular.dot(axis),
            Motion::Translation => relative.velocity_at(k.position).dot(axis),
        }
    }
}

impl Constraint {
    /// Computes the unit constraint wrench, exerted by the predecessor on the successor, for the
    /// given joint frames J and K in the world.
    #[inline]
    pub fn wrench<T: Scalar>(&self, j: &Pose<T>, k: &Pose<T>, pitch: T) -> Wrench<T> {
        let axes = &j.rotation.columns;
        match *self {
            Constraint::Force(axis) => Wrench::force_through(axes[axis], j.position),
            Constraint::Moment(axis) => Wrench::couple(axes[axis]),
            Constraint::Thread => {
                Wrench::force_through(axes[2], j.position) + Wrench::couple(axes[2] * -pitch)
            }
            Constraint::Normal => Wrench::couple(axes[2].cross(k.rotation.columns[0])),
        }
    }

    /// Returns `true` if the multiplier of the wrench is a moment (N m), `false` if it is a force
    /// (N).
    pub const fn is_moment(&self) -> bool {
        matches!(self, Constraint::Moment(_) | Constraint::Normal)
    }

    /// Computes the component of a small displacement (in J, at the origin of J) that the
    /// constraint wrench blocks.
    #[inline]
    fn blocked<T: Scalar>(&self, displacement: Twist<T>, relative: &Pose<T>, pitch: T) -> T {
        match *self {
            Constraint::Force(axis) => displacement.linear.component(axis),
            Constraint::Moment(axis) => displacement.angular.component(axis),
            Constraint::Thread => displacement.linear.z - pitch * displacement.angular.z,
            Constraint::Normal => {
                let normal = Vec3::unit(2).cross(relative.rotation.columns[0]);
                displacement.angular.dot(normal)
            }
        }
    }
}

impl JointType {
    /// Computes the deviation of `relative` (the actual pose of K in J) from the nearest permitted
    /// pose along each constraint (m, rad). Also returns the scalar coordinates of the permitted
    /// pose. At zero deviation, the rates of the deviations equal the powers of the unit constraint
    /// wrenches on the relative twist.
    #[inline]
    pub fn misfit<T: Scalar>(self, relative: Pose<T>, pitch: T) -> ([T; 6], [T; 3]) {
        let (allowed, coordinates) = self.nearest(relative, pitch);
        let turn = relative.rotation * allowed.rotation.transpose();
        let displacement = Twist {
            angular: bounded_tangent(turn),
            linear: relative.position - turn * allowed.position,
        };
        let mut errors = [T::zero(); 6];
        for (error, constraint) in errors.iter_mut().zip(self.constraints()) {
            *error = constraint.blocked(displacement, &relative, pitch);
        }
        (errors, coordinates)
    }
}

/// Computes the vector `2 n tan(a/2)` for a rotation by the angle `a` about the axis `n`, with a
/// bound near a half turn. At first order, this is the rotation vector. Unlike the skew-symmetric
/// part of the rotation matrix, it does not decrease beyond a right angle. Assembly from a poor
/// initial guess relies on this property.
#[inline]
fn bounded_tangent<T: Scalar>(turn: Mat3<T>) -> Vec3<T> {
    const FLOOR: f64 = 1e-3;
    // (1 + cos a)/2 = (1 + trace)/4, with an offset that keeps the result finite at a half turn.
    let denominator = (T::one() + turn.trace()) * T::from_f64(0.25) + T::from_f64(FLOOR);
    turn.skew_part() * (T::from_f64(1.0 + FLOOR) / denominator)
}

/// Computes the angle of a rotation about z, rad.
#[inline]
fn angle_about_z<T: Scalar>(rotation: &Mat3<T>) -> T {
    // This is the best-fitting angle if the rotation is not exactly about z.
    (rotation.at(1, 0) - rotation.at(0, 1)).atan2(rotation.at(0, 0) + rotation.at(1, 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PITCH: f64 = 0.02;

    fn frames(joint_type: JointType, numbers: &[f64]) -> (Pose<f64>, Pose<f64>) {
        let j = Pose {
            rotation: Mat3::rotation(Vec3::new(numbers[0], numbers[1], 1.0), numbers[2]),
            position: Vec3::new(numbers[3], numbers[4], numbers[5]),
        };
        let mut q = vec![0.0; joint_type.coordinates()];
        joint_type.write_zero(&mut q);
        joint_type.advance(&mut q, &numbers[6..12]);
        (j, j * joint_type.pose(&q, PITCH))
    }

    fn numbers() -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(-1.0..1.0f64, 18)
    }

    proptest! {
        /// Checks that constraint wrenches do no work on the degrees of freedom, that each unit
        /// effort does work only on its own degree of freedom, and that constraint wrenches and
        /// unit efforts together span all wrenches.
        #[test]
        fn dofs_and_constraints_are_reciprocal(numbers in numbers()) {
            for joint_type in JointType::ALL {
                let (j, k) = frames(joint_type, &numbers);
                let dofs = joint_type.dofs();
                let constraints = joint_type.constraints();
                prop_assert_eq!(dofs.len() + constraints.len(), 6);
                for (m, dof) in dofs.iter().enumerate() {
                    let twist = dof.twist(&j, &k, PITCH);
                    for constraint in constraints {
                        let power = twist.power(constraint.wrench(&j, &k, PITCH));
                        prop_assert!(power.abs() < 1e-14, "{joint_type:?} {constraint:?} {power}");
                    }
                    for (n, other) in dofs.iter().enumerate() {
                        let expected = if m == n { 1.0 } else { 0.0 };
                        let power = twist.power(other.effort(&j, &k));
                        prop_assert!((power - expected).abs() < 1e-14, "{joint_type:?} {m} {n}");
                    }
                }
            }
        }

        /// Checks that the unit twists are the derivative of the pose, and that coordinates can be
        /// recovered from the pose.
        #[test]
        fn dofs_are_the_derivative_of_the_pose(numbers in numbers()) {
            let step = 1e-5;
            for joint_type in JointType::ALL {
                let (j, k) = frames(joint_type, &numbers);
                let mut q = vec![0.0; joint_type.coordinates()];
                joint_type.write_coordinates(j.inverse() * k, PITCH, &mut q);
                let again = j * joint_type.pose(&q, PITCH);
                prop_assert!((again.position - k.position).norm() < 1e-14);
                prop_assert!((again.rotation.transpose() * k.rotation).rotation_vector().norm() < 1e-14);

                for (m, dof) in joint_type.dofs().iter().enumerate() {
                    let moved = |size: f64| {
                        let mut q = q.clone();
                        let mut rates = [0.0; 6];
                        rates[m] = size;
                        joint_type.advance(&mut q, &rates);
                        j * joint_type.pose(&q, PITCH)
                    };
                    let (ahead, behind) = (moved(step), moved(-step));
                    let scale = 0.5 / step;
                    let angular = (ahead.rotation * behind.rotation.transpose()).rotation_vector() * scale;
                    let velocity = (ahead.position - behind.position) * scale;
                    let twist = dof.twist(&j, &k, PITCH);
                    // Central differences have an error of the order of the step squared.
                    prop_assert!((twist.angular - angular).norm() < 1e-9);
                    prop_assert!((twist.velocity_at(k.position) - velocity).norm() < 1e-9);
                }
            }
        }

        /// Checks that, at first order, the constraint errors of a displaced pose equal the work of
        /// the constraint wrenches on the displacement.
        #[test]
        fn misfit_is_reciprocal_to_the_constraints(numbers in numbers()) {
            let size = 1e-6;
            for joint_type in JointType::ALL {
                let (j, k) = frames(joint_type, &numbers);
                let turn = Vec3::new(numbers[12], numbers[13], numbers[14]) * size;
                let shift = Vec3::new(numbers[15], numbers[16], numbers[17]) * size;
                let wrong = Pose {
                    rotation: Mat3::rotation(turn, turn.norm()) * k.rotation,
                    position: k.position + shift + turn.cross(k.position),
                };
                let displacement = Twist { angular: turn, linear: shift };
                let (errors, _) = joint_type.misfit(j.inverse() * wrong, PITCH);
                for (error, constraint) in errors.iter().zip(joint_type.constraints()) {
                    let expected = displacement.power(constraint.wrench(&j, &k, PITCH));
                    // The remaining difference is of second order in the displacement.
                    prop_assert!((error - expected).abs() < 1e-10, "{joint_type:?} {constraint:?}");
                }
            }
        }
    }
}
