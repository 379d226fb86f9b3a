//! Copies of a mechanism with changed inertia, friction or drive trains, for parameter
//! identification.

use super::{Body, DriveTrain, Joint, Mechanism};

/// Parts of a mechanism that parameter identification may change. Names, topology and geometry must
/// not be changed.
#[doc(hidden)]
#[derive(Debug)]
pub struct Changeable<'a> {
    /// Bodies, whose mass, centre of mass and inertia may change.
    pub bodies: &'a mut [Body],
    /// Joints, whose friction may change.
    pub joints: &'a mut [Joint],
    /// Drive trains, whose rotor inertia, motor friction and torque constant may change.
    pub drive_trains: &'a mut [DriveTrain],
}

impl Mechanism {
    /// Returns a copy of the mechanism after `change` has modified its inertia, friction or drive
    /// trains. The caller must set physically valid values. The characteristic length of the copy
    /// is unchanged.
    #[doc(hidden)]
    pub fn with_changes(&self, change: impl FnOnce(Changeable<'_>)) -> Self {
        let mut other = self.clone();
        let Self { bodies, joints, drive_trains, .. } = &mut other;
        change(Changeable { bodies, joints, drive_trains });
        other
    }
}
