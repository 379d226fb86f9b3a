//! Prismatic joint (P): translation along z.

use super::{Carrier::Predecessor, Constraint, Dof, Motion, dof};
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Pose, Vec3};

pub(super) const SYMBOL: &str = "P";
pub(super) const COORDINATES: usize = 1;
pub(super) const FREEDOMS: &[Dof] = &[dof(Motion::Translation, 2, Predecessor, "slide")];
pub(super) const CONSTRAINTS: &[Constraint] = &[
    Constraint::Force(0),
    Constraint::Force(1),
    Constraint::Moment(0),
    Constraint::Moment(1),
    Constraint::Moment(2),
];

#[inline]
pub(super) fn pose<T: Scalar>(q: &[T], _pitch: T) -> Pose<T> {
    Pose { rotation: Mat3::identity(), position: Vec3::unit(2) * q[0] }
}

#[inline]
pub(super) fn nearest<T: Scalar>(relative: Pose<T>, pitch: T) -> (Pose<T>, [T; 3]) {
    // Displacement along the successor's z axis, which a small tilt changes only at second order.
    let slide = relative.rotation.columns[2].dot(relative.position);
    (pose(&[slide], pitch), [slide, T::zero(), T::zero()])
}
