//! Cylindrical joint (C): rotation about and translation along z.

use super::{Carrier::Predecessor, Constraint, Dof, Motion, angle_about_z, dof};
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Pose, Vec3};

pub(super) const SYMBOL: &str = "C";
pub(super) const COORDINATES: usize = 2;
pub(super) const FREEDOMS: &[Dof] = &[
    dof(Motion::Rotation, 2, Predecessor, "angle"),
    dof(Motion::Translation, 2, Predecessor, "slide"),
];
pub(super) const CONSTRAINTS: &[Constraint] =
    &[Constraint::Force(0), Constraint::Force(1), Constraint::Moment(0), Constraint::Moment(1)];

#[inline]
pub(super) fn pose<T: Scalar>(q: &[T], _pitch: T) -> Pose<T> {
    Pose { rotation: Mat3::about_axis(2, q[0].sin_cos()), position: Vec3::unit(2) * q[1] }
}

#[inline]
pub(super) fn nearest<T: Scalar>(relative: Pose<T>, pitch: T) -> (Pose<T>, [T; 3]) {
    let angle = angle_about_z(&relative.rotation);
    let slide = relative.rotation.columns[2].dot(relative.position);
    (pose(&[angle, slide], pitch), [angle, slide, T::zero()])
}
