//! Joint types: what each allows, what each carries. One file a type, the same items in each.
//!
//! A joint connects frame J, fixed in its *predecessor* body, with frame K, fixed in its
//! *successor*. At zero coordinates the frames coincide. The axis of a joint is the z axis of J.
//!
//! | type | coordinates | freedoms (unit twists) | carries (unit wrenches, in J) |
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
//! Forces pass through the origin of J. Each freedom is constant in the body that carries it, which
//! makes the rate of change of every joint's motion subspace one formula:
//! `d/dt S_k = (twist of the carrier) x S_k`.

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

/// The most coordinates that a joint has (the free joint's).
pub const MOST_COORDINATES: usize = 7;
/// The most freedoms that a joint has.
pub const MOST_FREEDOMS: usize = 6;

/// The type of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JointType {
    /// One rotation.
    Revolute,
    /// One translation.
    Prismatic,
    /// A screw: rotation and translation tied by a pitch.
    Helical,
    /// Rotation about and translation along one axis.
    Cylindrical,
    /// Two rotations about axes at right angles that meet (Hooke, Cardan).
    Universal,
    /// All rotations about a point.
    Spherical,
    /// Two translations in a plane and the rotation about its normal.
    Planar,
    /// No freedom: the bodies are one.
    Fixed,
    /// All freedom: no connection but coordinates.
    Free,
}

/// The body of a joint in which a freedom's twist is constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carrier {
    /// The predecessor; axes and point are those of frame J.
    Predecessor,
    /// The successor; axes and point are those of frame K.
    Successor,
}

/// One freedom of a joint: a unit twist along a coordinate axis of the carrier's joint frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Freedom {
    /// Rotation, translation or screw.
    pub motion: Motion,
    /// Axis 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Where axis and point are fixed.
    pub carrier: Carrier,
    /// The coordinate's name among those of the joint.
    pub name: &'static str,
}

/// The kind of motion of a freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Rotation; rates in rad/s, conjugate efforts in N m.
    Rotation,
    /// Translation; rates in m/s, conjugate efforts in N.
    Translation,
    /// Rotation with `pitch` (m/rad) times translation; rates in rad/s, efforts in N m.
    Screw,
}

/// One wrench that a joint carries without working, in frame J.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constraint {
    /// Unit force along an axis, through the origin of J.
    Force(usize),
    /// Unit moment along an axis.
    Moment(usize),
    /// Unit force along z with the moment `-pitch` along z: the thread's.
    Thread,
    /// Unit moment along the common normal of a universal joint's axes.
    Normal,
}

const fn freedom(motion: Motion, axis: usize, carrier: Carrier, name: &'static str) -> Freedom {
    Freedom { motion, axis, carrier, name }
}

/// Picks the same item from the file of each type.
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
    /// All types, in the order of the table above.
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

    /// The letter of mechanism theory (R, P, H, C, U, S, E), or the word `fixed` or `free`.
    pub const fn symbol(self) -> &'static str {
        of_type!(self, SYMBOL)
    }

    /// The type with this symbol.
    pub fn from_symbol(symbol: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|t| t.symbol() == symbol)
    }

    /// The freedoms, in the order of the rates.
    #[inline(always)]
    pub const fn freedoms(self) -> &'static [Freedom] {
        of_type!(self, FREEDOMS)
    }

    /// The wrenches that it carries.
    #[inline(always)]
    pub const fn constraints(self) -> &'static [Constraint] {
        of_type!(self, CONSTRAINTS)
    }

    /// The number of coordinates (not of freedoms: orientations take four).
    #[inline(always)]
    pub const fn coordinates(self) -> usize {
        of_type!(self, COORDINATES)
    }

    /// Whether coordinate `k` is the integral of rate `k`: true but for quaternions.
    pub const fn has_scalar_coordinates(self) -> bool {
        !matches!(self, Self::Spherical | Self::Free)
    }

    /// `X_JK` at coordinates `q` (rad, m; as many as [`Self::coordinates`]).
    #[inline(always)]
    pub fn pose<T: Scalar>(self, q: &[T], pitch: T) -> Pose<T> {
        of_type!(self, pose(q, pitch))
    }

    /// The pose that the joint allows, nearest to `relative` (an actual `X_JK`), and its scalar
    /// coordinates (zeros for quaternions).
    #[inline(always)]
    pub fn nearest<T: Scalar>(self, relative: Pose<T>, pitch: T) -> (Pose<T>, [T; 3]) {
        of_type!(self, nearest(relative, pitch))
    }

    /// Writes the coordinates at which both frames coincide.
    pub fn write_zero<T: Scalar>(self, q: &mut [T]) {
        q[..self.coordinates()].fill(T::zero());
        match self {
            Self::Spherical => q[0] = T::one(),
            Self::Free => q[3] = T::one(),
            _ => {}
        }
    }

    /// Writes the coordinates of `relative`, an `X_JK` that the joint allows.
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

    /// Moves the coordinates by a small step in the rates (rad, m). Quaternions stay of unit length.
    #[inline(always)]
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

impl Freedom {
    /// The unit twist, given the joint frames J and K in the world; predecessor to successor.
    #[inline(always)]
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

    /// The unit of the rate's integral and of the conjugate effort: (rad, N m) or (m, N).
    pub const fn units(&self) -> (&'static str, &'static str) {
        match self.motion {
            Motion::Translation => ("m", "N"),
            Motion::Rotation | Motion::Screw => ("rad", "N m"),
        }
    }

    /// The rate of this freedom in a relative motion that the joint allows, `relative` being the
    /// twist of the successor minus that of the predecessor.
    #[inline(always)]
    pub fn rate<T: Scalar>(&self, relative: Twist<T>, j: &Pose<T>, k: &Pose<T>) -> T {
        let frame = match self.carrier {
            Carrier::Predecessor => j,
            Carrier::Successor => k,
        };
        let axis = frame.rotation.columns[self.axis];
        match self.motion {
            Motion::Rotation | Motion::Screw => axis.dot(relative.angular),
            // In every type with a translation the rotations' axes pass the origin of K.
            Motion::Translation => axis.dot(relative.velocity_at(k.position)),
        }
    }
}

impl Constraint {
    /// The unit wrench, given the joint frames J and K in the world; predecessor on successor.
    #[inline(always)]
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

    /// Whether the multiplier is a moment (N m) rather than a force (N).
    pub const fn is_moment(&self) -> bool {
        matches!(self, Constraint::Moment(_) | Constraint::Normal)
    }

    /// The component of a small displacement (in J, at the origin of J) that the wrench blocks.
    #[inline(always)]
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
    /// How far `relative` (an actual `X_JK`) is from what the joint allows, measured along each of
    /// its constraints (m, rad), and the scalar coordinates there. The errors' rates are the
    /// powers of the unit constraint wrenches on the relative twist, exactly so where they vanish.
    #[inline(always)]
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

/// A vector along the axis of `turn` that equals its rotation vector to first order and, unlike the
/// skew part, does not shrink again beyond a right angle: `2 n tan(a/2)`, bounded near a half turn.
/// Assembly from a poor first guess needs that; at the solution only the first order counts.
#[inline(always)]
fn bounded_tangent<T: Scalar>(turn: Mat3<T>) -> Vec3<T> {
    const FLOOR: f64 = 1e-3;
    // (1 + cos a)/2 = (1 + trace)/4, lifted so that a half turn stays finite.
    let denominator = (T::one() + turn.trace()) * T::from_f64(0.25) + T::from_f64(FLOOR);
    turn.skew_part() * (T::from_f64(1.0 + FLOOR) / denominator)
}

/// The angle of a rotation about z.
#[inline(always)]
fn angle_about_z<T: Scalar>(rotation: &Mat3<T>) -> T {
    // Best fit for a rotation that is not quite about z.
    (rotation.at(1, 0) - rotation.at(0, 1)).atan2(rotation.at(0, 0) + rotation.at(1, 1))
}
