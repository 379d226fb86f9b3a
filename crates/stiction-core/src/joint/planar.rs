//! Planar joint (E): translations along x and y of J, and rotation about the plane's normal z.

use super::{
    Carrier::{Predecessor, Successor},
    Constraint, Dof, Motion, angle_about_z, dof,
};
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Pose, Vec3};

pub(super) const SYMBOL: &str = "E";
pub(super) const COORDINATES: usize = 3;
pub(super) const FREEDOMS: &[Dof] = &[
    dof(Motion::Translation, 0, Predecessor, "x"),
    dof(Motion::Translation, 1, Predecessor, "y"),
    dof(Motion::Rotation, 2, Successor, "angle"),
];
pub(super) const CONSTRAINTS: &[Constraint] =
    &[Constraint::Force(2), Constraint::Moment(0), Constraint::Moment(1)];

#[inline]
pub(super) fn pose<T: Scalar>(q: &[T], _pitch: T) -> Pose<T> {
    Pose {
        rotation: Mat3::about_axis(2, q[2].sin_cos()),
        position: Vec3::new(q[0], q[1], T::zero()),
    }
}

#[inline]
pub(super) fn nearest<T: Scalar>(relative: Pose<T>, pitch: T) -> (Pose<T>, [T; 3]) {
    let angle = angle_about_z(&relative.rotation);
    let coordinates = [relative.position.x, relative.position.y, angle];
    (pose(&coordinates, pitch), coordinates)
}
