//! Universal joint (U): rotation about z of J, then about x of K; the two axes are perpendicular.

use super::{
    Carrier::{Predecessor, Successor},
    Constraint, Dof, Motion, dof,
};
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Pose, Vec3};

pub(super) const SYMBOL: &str = "U";
pub(super) const COORDINATES: usize = 2;
pub(super) const FREEDOMS: &[Dof] = &[
    dof(Motion::Rotation, 2, Predecessor, "first"),
    dof(Motion::Rotation, 0, Successor, "second"),
];
pub(super) const CONSTRAINTS: &[Constraint] =
    &[Constraint::Force(0), Constraint::Force(1), Constraint::Force(2), Constraint::Normal];

#[inline]
pub(super) fn pose<T: Scalar>(q: &[T], _pitch: T) -> Pose<T> {
    Pose {
        rotation: Mat3::about_axis(2, q[0].sin_cos()) * Mat3::about_axis(0, q[1].sin_cos()),
        position: Vec3::zero(),
    }
}

#[inline]
pub(super) fn nearest<T: Scalar>(relative: Pose<T>, pitch: T) -> (Pose<T>, [T; 3]) {
    let r = &relative.rotation;
    let first = r.at(1, 0).atan2(r.at(0, 0));
    let second = r.at(2, 1).atan2(r.at(2, 2));
    (pose(&[first, second], pitch), [first, second, T::zero()])
}
