//! Joint compliance, which determines how redundant constraints share a load; rigid bodies leave
//! this distribution indeterminate.

use crate::joint::JointType;
use crate::spatial::Vec3;

/// Deflections of a joint per unit of its reaction, along and about the joint axis (z of frame J).
/// The joint is rigid in directions with zero compliance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Compliance {
    /// Compliance perpendicular to the axis, m/N; for a spherical joint, compliance in all
    /// directions.
    pub radial: f64,
    /// Compliance along the axis, m/N.
    pub axial: f64,
    /// Compliance against tilting of the axis, rad/(N m).
    pub bending: f64,
    /// Compliance against twisting about the axis, rad/(N m); for a universal joint, about the
    /// common normal of its axes.
    pub torsional: f64,
}

impl Compliance {
    /// Returns the four compliances with their names.
    pub fn parts(&self) -> [(&'static str, f64); 4] {
        [
            ("radial", self.radial),
            ("axial", self.axial),
            ("bending", self.bending),
            ("torsional", self.torsional),
        ]
    }

    /// Returns `true` if a joint of this type transmits the reaction component that loads the
    /// compliance named `part` (a name from [`Self::parts`]).
    pub fn applies(joint_type: JointType, part: &str) -> bool {
        use JointType::{
            Cylindrical, Fixed, Free, Helical, Planar, Prismatic, Revolute, Spherical, Universal,
        };
        let parts: &[&str] = match joint_type {
            Revolute | Helical => &["radial", "axial", "bending"],
            Prismatic => &["radial", "bending", "torsional"],
            Cylindrical => &["radial", "bending"],
            Universal => &["radial", "axial", "torsional"],
            Spherical => &["radial"],
            Planar => &["axial", "bending"],
            Fixed => &["radial", "axial", "bending", "torsional"],
            Free => &[],
        };
        parts.contains(&part)
    }

    /// Returns two vectors: the compliances along the x, y and z axes of joint frame J, m/N, and
    /// the compliances about these axes, rad/(N m).
    pub fn along_axes(&self, joint_type: JointType) -> (Vec3<f64>, Vec3<f64>) {
        let Self { radial, axial, bending, torsional } = *self;
        match joint_type {
            JointType::Spherical => (Vec3::new(radial, radial, radial), Vec3::zero()),
            // The joint transmits one moment, whose direction is not fixed in J, so its compliance
            // is entered for all axes.
            JointType::Universal => {
                (Vec3::new(radial, radial, axial), Vec3::new(torsional, torsional, torsional))
            }
            _ => (Vec3::new(radial, radial, axial), Vec3::new(bending, bending, torsional)),
        }
    }
}
