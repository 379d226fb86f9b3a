//! Coordinates by which a motion is prescribed.

use crate::joint::JointType;
use crate::mechanism::{BodyId, JointId};
use crate::scalar::Scalar;

/// A scalar coordinate of a mechanism that a motion may prescribe. Loop closure determines the rest
/// of the configuration.
///
/// Poses of bodies are in the frame of the ground ([`crate::mechanism::Mechanism::base`]), so the
/// motions of a robot do not depend on its mounting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Coordinate {
    /// A component of the position of a body's origin, m.
    Position {
        /// Body whose position is prescribed.
        body: BodyId,
        /// Axis: 0, 1, 2 for x, y, z.
        axis: usize,
    },
    /// One of three intrinsic rotation angles, rad: the body's rotation is
    /// `R(axis1, angle1) R(axis2, angle2) R(axis3, angle3)`.
    Angle {
        /// Body whose orientation is prescribed.
        body: BodyId,
        /// Order of the rotation axes.
        order: AngleOrder,
        /// Index of the angle: 0, 1, 2 for the first, second, third.
        index: usize,
    },
    /// A component of the rotation vector (axis times angle) of a body, rad. The length of the
    /// vector must stay below pi.
    RotationVector {
        /// Body whose orientation is prescribed.
        body: BodyId,
        /// Axis: 0, 1, 2 for x, y, z.
        axis: usize,
    },
    /// A coordinate of a joint whose coordinates are scalars (R, P, H, C, U, E), rad or m.
    Joint {
        /// Joint to which the coordinate belongs.
        joint: JointId,
        /// Index of the degree of freedom.
        dof: usize,
    },
}

impl Coordinate {
    /// Returns `true` if the coordinate is an angle (rad), `false` if it is a length (m).
    /// `joint_types` contains the types of all joints of the mechanism.
    pub fn is_angle(&self, joint_types: &[JointType]) -> bool {
        match *self {
            Self::Position { .. } => false,
            Self::Angle { .. } | Self::RotationVector { .. } => true,
            Self::Joint { joint, dof } => !joint_types[joint.0].dofs()[dof].translates(),
        }
    }
}

/// The order of axes of three intrinsic rotations; consecutive axes differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AngleOrder([usize; 3]);

impl AngleOrder {
    /// Rotation about x, then about the new y, then about the new z.
    pub const XYZ: Self = Self([0, 1, 2]);

    /// Returns the order named by three letters, such as `xyz` or `zxz`; `None` for any other name.
    pub fn from_name(name: &str) -> Option<Self> {
        let axes: Option<Vec<usize>> =
            name.chars().map(|c| "xyz".chars().position(|axis| axis == c)).collect();
        let [a, b, c] = axes?.try_into().ok()?;
        (a != b && b != c).then_some(Self([a, b, c]))
    }

    /// Axis indices in order; 0, 1, 2 for x, y, z.
    pub const fn axes(self) -> [usize; 3] {
        self.0
    }

    /// Returns `true` if all three axes differ (Tait-Bryan angles), so that each angle can be named
    /// by its axis.
    pub const fn is_tait_bryan(self) -> bool {
        self.0[0] != self.0[2]
    }
}

/// The prescribed value of a [`Coordinate`] at one instant, with its exact time derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target<T> {
    /// Value, rad or m.
    pub value: T,
    /// First time derivative, rad/s or m/s.
    pub rate: T,
    /// Second time derivative, rad/s^2 or m/s^2.
    pub acceleration: T,
}

impl Target<f64> {
    /// Target with zero value, rate and acceleration.
    pub(crate) const AT_ZERO: Self = Self { value: 0.0, rate: 0.0, acceleration: 0.0 };

    /// Converts the numbers to constants of another scalar type.
    pub fn lift<T: Scalar>(self) -> Target<T> {
        Target {
            value: T::from_f64(self.value),
            rate: T::from_f64(self.rate),
            acceleration: T::from_f64(self.acceleration),
        }
    }
}
