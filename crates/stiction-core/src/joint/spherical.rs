//! Spherical joint (S): all rotations about a point; coordinates are a unit quaternion, rates the
//! angular velocity in K.

use super::{Carrier::Successor, Constraint, Dof, Motion, dof};
use crate::scalar::Scalar;
use crate::spatial::{Pose, Quaternion, Vec3};

pub(super) const SYMBOL: &str = "S";
pub(super) const COORDINATES: usize = 4;
pub(super) const FREEDOMS: &[Dof] = &[
    dof(Motion::Rotation, 0, Successor, "wx"),
    dof(Motion::Rotation, 1, Successor, "wy"),
    dof(Motion::Rotation, 2, Successor, "wz"),
];
pub(super) const CONSTRAINTS: &[Constraint] =
    &[Constraint::Force(0), Constraint::Force(1), Constraint::Force(2)];

#[inline]
pub(super) fn pose<T: Scalar>(q: &[T], _pitch: T) -> Pose<T> {
    Pose { rotation: Quaternion::from_coordinates(q).rotation(), position: Vec3::zero() }
}

#[inline]
pub(super) fn nearest<T: Scalar>(relative: Pose<T>, _pitch: T) -> (Pose<T>, [T; 3]) {
    (Pose { rotation: relative.rotation, position: Vec3::zero() }, [T::zero(); 3])
}
