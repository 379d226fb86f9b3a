//! Helical joint (H): a screw about z. The coordinate is the angle; the pitch is in m/rad.

use super::{Carrier::Predecessor, Constraint, Dof, Motion, angle_about_z, dof};
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Pose, Vec3};

pub(super) const SYMBOL: &str = "H";
pub(super) const COORDINATES: usize = 1;
pub(super) const FREEDOMS: &[Dof] = &[dof(Motion::Screw, 2, Predecessor, "angle")];
pub(super) const CONSTRAINTS: &[Constraint] = &[
    Constraint::Force(0),
    Constraint::Force(1),
    Constraint::Moment(0),
    Constraint::Moment(1),
    Constraint::Thread,
];

#[inline]
pub(super) fn pose<T: Scalar>(q: &[T], pitch: T) -> Pose<T> {
    Pose { rotation: Mat3::about_axis(2, q[0].sin_cos()), position: Vec3::unit(2) * (pitch * q[0]) }
}

#[inline]
pub(super) fn nearest<T: Scalar>(relative: Pose<T>, pitch: T) -> (Pose<T>, [T; 3]) {
    // The displacement determines the number of turns, the orientation the angle within a turn.
    let coarse = relative.rotation.columns[2].dot(relative.position) / pitch;
    let (s, c) = (angle_about_z(&relative.rotation) - coarse).sin_cos();
    let angle = coarse + s.atan2(c);
    (pose(&[angle], pitch), [angle, T::zero(), T::zero()])
}
