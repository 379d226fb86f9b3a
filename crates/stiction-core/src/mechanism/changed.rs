//! Mechanisms with changed inertia, friction or drive trains, for parameter identification.

use super::{Body, DriveTrain, Joint, Mechanism};

/// Parts of a mechanism that parameter identification may change. Names, topology and geometry must
/// stay the same.
#[doc(hidden)]
#[derive(Debug)]
pub struct Changeable<'a> {
    /// Bodies: mass, centre of mass, inertia.
    pub bodies: &'a mut [Body],
    /// Joints: friction.
    pub joints: &'a mut [Joint],
    /// Drive trains: rotor inertia, motor friction, torque constant.
    pub drive_trains: &'a mut [DriveTrain],
}

impl Mechanism {
    /// Returns the mechanism with changed inertia, friction and drive trains. The caller must provide
    /// physically valid values; the characteristic length does not change.
    #[doc(hidden)]
    pub fn with_changes(&self, change: impl FnOnce(Changeable<'_>)) -> Self {
        let mut other = self.clone();
        let Self { bodies, joints, drive_trains, .. } = &mut other;
        change(Changeable { bodies, joints, drive_trains });
        other
    }
}
