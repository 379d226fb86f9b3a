//! Fixed joint: no degree of freedom.

use super::{Constraint, Dof};
use crate::scalar::Scalar;
use crate::spatial::Pose;

pub(super) const SYMBOL: &str = "fixed";
pub(super) const COORDINATES: usize = 0;
pub(super) const FREEDOMS: &[Dof] = &[];
pub(super) const CONSTRAINTS: &[Constraint] = &[
    Constraint::Force(0),
    Constraint::Force(1),
    Constraint::Force(2),
    Constraint::Moment(0),
    Constraint::Moment(1),
    Constraint::Moment(2),
];

#[inline]
pub(super) fn pose<T: Scalar>(_q: &[T], _pitch: T) -> Pose<T> {
    Pose::identity()
}

#[inline]
pub(super) fn nearest<T: Scalar>(_relative: Pose<T>, _pitch: T) -> (Pose<T>, [T; 3]) {
    (Pose::identity(), [T::zero(); 3])
}
