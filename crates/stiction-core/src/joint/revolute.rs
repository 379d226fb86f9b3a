//! Revolute joint (R): rotation about z.

use super::{Carrier::Predecessor, Constraint, Dof, Motion, angle_about_z, dof};
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Pose, Vec3};

pub(super) const SYMBOL: &str = "R";
pub(super) const COORDINATES: usize = 1;
pub(super) const FREEDOMS: &[Dof] = &[dof(Motion::Rotation, 2, Predecessor, "angle")];
pub(super) const CONSTRAINTS: &[Constraint] = &[
    Constraint::Force(0),
    Constraint::Force(1),
    Constraint::Force(2),
    Constraint::Moment(0),
    Constraint::Moment(1),
];

#[inline]
pub(super) fn pose<T: Scalar>(q: &[T], _pitch: T) -> Pose<T> {
    Pose { rotation: Mat3::about_axis(2, q[0].sin_cos()), position: Vec3::zero() }
}

#[inline]
pub(super) fn nearest<T: Scalar>(relative: Pose<T>, pitch: T) -> (Pose<T>, [T; 3]) {
    let angle = angle_about_z(&relative.rotation);
    (pose(&[angle], pitch), [angle, T::zero(), T::zero()])
}
