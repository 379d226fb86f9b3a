//! Friction interfaces of joints: geometry, friction law and normal load map of the sliding
//! surfaces.

use super::{Law, NormalLoadMap};
use crate::joint::{Carrier, JointType};

/// Friction parameters of one friction interface of a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct JointFriction {
    /// Index of the interface in the list returned by [`interfaces_of`] for the joint's type.
    pub place: usize,
    /// Radius of the sliding surface, m; for a plate, the effective radius of friction against
    /// rotation. `None` for guides, which only translate.
    pub radius: Option<f64>,
    /// Friction law: friction force as a function of speed and normal load.
    pub law: Law,
    /// Friction law for backward sliding, if different from `law`; only for interfaces with one
    /// degree of freedom.
    pub backward: Option<Law>,
    /// Map from the joint's reaction to the normal load.
    pub load: NormalLoadMap<f64>,
}

impl JointFriction {
    /// Creates the friction parameters of the guide of a prismatic joint, with the lateral force as
    /// normal load.
    pub fn guide(law: Law) -> Self {
        Self { place: 0, radius: None, law, backward: None, load: NormalLoadMap::force_only() }
    }

    /// Creates the friction parameters of a joint's first interface (index 0), which rotates: a
    /// pin, ball, plate or thread with the given radius, m. The normal load depends only on the
    /// force of the joint's reaction, see [`NormalLoadMap::force_only`].
    pub fn round(radius: f64, law: Law) -> Self {
        Self { radius: Some(radius), ..Self::guide(law) }
    }

    /// Creates the friction parameters of the sleeve of a cylindrical joint: one surface that
    /// rotates and translates, with the given radius, m, and the lateral force as normal load. A
    /// joint has either a sleeve or a separate pin (index 0) and guide (index 1).
    pub fn sleeve(radius: f64, law: Law) -> Self {
        Self { place: SLEEVE, ..Self::round(radius, law) }
    }
}

/// Index of the sleeve among the friction interfaces of a cylindrical joint.
const SLEEVE: usize = 2;

/// Geometry of a friction interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InterfaceShape {
    /// Pin that rotates about a coordinate axis of frame J or K: `axis` is the number of the
    /// coordinate axis, and `carrier` the body in which it is fixed.
    Pin {
        /// Index of the rotation among the joint's degrees of freedom.
        dof: usize,
        /// Coordinate axis of the carrier's frame (0, 1, 2 for x, y, z).
        axis: usize,
        /// Body in which the axis is fixed.
        carrier: Carrier,
    },
    /// A guide that translates along the z axis of J.
    Guide {
        /// Index of the translation among the joint's degrees of freedom.
        dof: usize,
    },
    /// A thread about the z axis of J, whose flanks slide along the helix.
    Thread,
    /// A sleeve about the z axis of J: degree of freedom 0 is the rotation, 1 the translation.
    Sleeve,
    /// A ball: degrees of freedom 0, 1, 2 are the components of the angular velocity in K.
    Ball,
    /// Shaft of a motor, whose friction depends only on the effort that its gear transmits. Drive
    /// trains add this interface; no joint type has it.
    Shaft {
        /// Index of the driven degree of freedom.
        dof: usize,
        /// Type of the joint to which the driven degree of freedom belongs.
        joint_type: JointType,
    },
    /// A plate with its midpoint at the origin of K on a plane normal to the z axis of J: degrees
    /// of freedom 0 and 1 are the velocity of the midpoint, 2 is the rotation.
    Plate,
}

impl InterfaceShape {
    /// Indices of the degrees of freedom along which the surfaces slide.
    #[inline]
    pub const fn dofs(self) -> core::ops::Range<usize> {
        match self {
            Self::Pin { dof, .. } | Self::Guide { dof } | Self::Shaft { dof, .. } => dof..dof + 1,
            Self::Thread => 0..1,
            Self::Sleeve => 0..2,
            Self::Ball | Self::Plate => 0..3,
        }
    }

    /// Returns `true` if the surface rotates, in which case the interface has a radius.
    pub const fn turns(self) -> bool {
        !matches!(self, Self::Guide { .. } | Self::Shaft { .. })
    }

    /// Returns `true` if the interface has a single degree of freedom, so that its surfaces slide
    /// only forward or backward.
    pub const fn has_one_dof(self) -> bool {
        !matches!(self, Self::Ball | Self::Plate | Self::Sleeve)
    }
}

const PIN_Z: InterfaceShape =
    InterfaceShape::Pin { dof: 0, axis: 2, carrier: Carrier::Predecessor };

/// Returns the friction interfaces of a joint type, each with its name. The name is empty if there
/// is only one interface, and for the sleeve of a cylindrical joint. Fixed and free joints have no
/// interfaces. A cylindrical joint has either its sleeve or its pin and guide.
pub const fn interfaces_of(joint_type: JointType) -> &'static [(&'static str, InterfaceShape)] {
    match joint_type {
        JointType::Revolute => &[("", PIN_Z)],
        JointType::Prismatic => &[("", InterfaceShape::Guide { dof: 0 })],
        JointType::Helical => &[("", InterfaceShape::Thread)],
        JointType::Cylindrical => &[
            ("angle", PIN_Z),
            ("slide", InterfaceShape::Guide { dof: 1 }),
            ("", InterfaceShape::Sleeve),
        ],
        JointType::Universal => &[
            ("first", PIN_Z),
            ("second", InterfaceShape::Pin { dof: 1, axis: 0, carrier: Carrier::Successor }),
        ],
        JointType::Spherical => &[("", InterfaceShape::Ball)],
        JointType::Planar => &[("", InterfaceShape::Plate)],
        JointType::Fixed | JointType::Free => &[],
    }
}
