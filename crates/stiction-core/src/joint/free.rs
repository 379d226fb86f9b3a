//! Free joint: no constraint; coordinates are the position in J and a unit quaternion, rates are the
//! velocity in J and the angular velocity in K.

use super::{
    Carrier::{Predecessor, Successor},
    Constraint, Dof, Motion, dof,
};
use crate::scalar::Scalar;
use crate::spatial::{Pose, Quaternion, Vec3};

pub(super) const SYMBOL: &str = "free";
pub(super) const COORDINATES: usize = 7;
pub(super) const FREEDOMS: &[Dof] = &[
    dof(Motion::Translation, 0, Predecessor, "x"),
    dof(Motion::Translation, 1, Predecessor, "y"),
    dof(Motion::Translation, 2, Predecessor, "z"),
    dof(Motion::Rotation, 0, Successor, "wx"),
    dof(Motion::Rotation, 1, Successor, "wy"),
    dof(Motion::Rotation, 2, Successor, "wz"),
];
pub(super) const CONSTRAINTS: &[Constraint] = &[];

#[inline]
pub(super) fn pose<T: Scalar>(q: &[T], _pitch: T) -> Pose<T> {
    Pose {
        rotation: Quaternion::from_coordinates(&q[3..]).rotation(),
        position: Vec3::new(q[0], q[1], q[2]),
    }
}

#[inline]
pub(super) fn nearest<T: Scalar>(relative: Pose<T>, _pitch: T) -> (Pose<T>, [T; 3]) {
    (relative, [T::zero(); 3])
}
