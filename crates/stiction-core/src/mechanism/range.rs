//! Permitted ranges of joint coordinates. Leaving a range only causes a caution.

use super::Joint;
use crate::joint::{Dof, JointType};
use crate::spatial::{Pose, Vec3};

/// Quantity of a joint bounded by a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RangeOf {
    /// Coordinate of the degree of freedom with this index, rad or m.
    Dof(usize),
    /// Tilt of a U or S joint, rad: see [`RangeOf::tilt`].
    Tilt,
}

/// Permitted range of one quantity of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointRange {
    /// The quantity that `limits` bound.
    pub of: RangeOf,
    /// Least and greatest permitted value, rad or m.
    pub limits: (f64, f64),
}

impl RangeOf {
    /// Computes the tilt of a joint, rad, from 0 to pi. For an S joint, the tilt is the angle
    /// between the z axes of frames J and K. For a U joint, the tilt is the angle between the y
    /// axes of frames J and K, which are normal to both joint axes at zero tilt. Both frames must
    /// be given in the same axes.
    pub fn tilt(joint_type: JointType, frame_j: &Pose<f64>, frame_k: &Pose<f64>) -> f64 {
        let axis = if joint_type == JointType::Universal { 1 } else { 2 };
        let column =
            |frame: &Pose<f64>| Vec3::from(std::array::from_fn(|i| frame.rotation.at(i, axis)));
        let (j, k) = (column(frame_j), column(frame_k));
        j.cross(k).norm().atan2(j.dot(k))
    }

    /// Returns `true` if a joint of the given type has this quantity.
    pub(crate) fn is_of(self, joint_type: JointType) -> bool {
        match self {
            Self::Dof(dof) => joint_type.has_scalar_coordinates() && dof < joint_type.dofs().len(),
            Self::Tilt => matches!(joint_type, JointType::Universal | JointType::Spherical),
        }
    }
}

impl Joint {
    /// Returns the name of a quantity with a range: the joint's name, followed by the name of the
    /// degree of freedom if the joint has several, or by `tilt`.
    pub fn range_name(&self, of: RangeOf) -> String {
        match of {
            RangeOf::Dof(dof) => self.dof_name(dof),
            RangeOf::Tilt => format!("{}.tilt", self.name),
        }
    }

    /// Returns `true` if a quantity with a range is a displacement (m), `false` if it is an angle
    /// (rad).
    pub fn range_translates(&self, of: RangeOf) -> bool {
        match of {
            RangeOf::Dof(dof) => self.joint_type.dofs().get(dof).is_some_and(Dof::translates),
            RangeOf::Tilt => false,
        }
    }
}
