//! Poses of frames, and unit quaternions, which serve as orientation coordinates.

use super::{Mat3, Vec3};
use crate::scalar::Scalar;
use core::ops::Mul;

/// Pose `X_AB`: orientation and origin of frame B with respect to frame A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<T> {
    /// Rotation matrix `R_AB`: its columns are the axes of frame B in frame A.
    pub rotation: Mat3<T>,
    /// Origin of frame B in frame A, m.
    pub position: Vec3<T>,
}

impl<T: Scalar> Pose<T> {
    /// Identity pose: frames A and B coincide.
    #[inline(always)]
    pub fn identity() -> Self {
        Self { rotation: Mat3::identity(), position: Vec3::zero() }
    }

    /// Inverse pose: `X_BA` from `X_AB`.
    #[inline(always)]
    pub fn inverse(self) -> Self {
        Self {
            rotation: self.rotation.transpose(),
            position: -self.rotation.transpose_mul(self.position),
        }
    }

    /// Transforms a point from frame B to frame A.
    #[inline(always)]
    pub fn apply(self, point: Vec3<T>) -> Vec3<T> {
        self.rotation * point + self.position
    }
}

impl Pose<f64> {
    /// Converts all components to constants of another scalar type.
    #[inline(always)]
    pub fn lift<T: Scalar>(self) -> Pose<T> {
        Pose { rotation: self.rotation.lift(), position: self.position.lift() }
    }

    /// Pose of a frame B that is parallel to A, with the origin of B at `position` (in A).
    pub fn at(position: Vec3<f64>) -> Self {
        Self { rotation: Mat3::identity(), position }
    }
}

impl<T: Scalar> Mul for Pose<T> {
    type Output = Self;
    /// Composes poses: `X_AB * X_BC = X_AC`.
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { rotation: self.rotation * other.rotation, position: self.apply(other.position) }
    }
}

/// A unit quaternion, `w` first; the orientation coordinates of spherical and free joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion<T> {
    /// Real part: the cosine of half the rotation angle.
    pub w: T,
    /// Imaginary part: the unit vector of the rotation axis times the sine of half the rotation
    /// angle.
    pub v: Vec3<T>,
}

impl<T: Scalar> Quaternion<T> {
    /// Reads four coordinates in the order `w, x, y, z`.
    #[inline(always)]
    pub fn from_coordinates(c: &[T]) -> Self {
        Self { w: c[0], v: Vec3::new(c[1], c[2], c[3]) }
    }

    /// Writes four coordinates in the order `w, x, y, z`.
    #[inline(always)]
    pub fn write(self, c: &mut [T]) {
        (c[0], c[1], c[2], c[3]) = (self.w, self.v.x, self.v.y, self.v.z);
    }

    /// Returns the quaternion product `self * other`: the rotation `other` followed by the rotation
    /// `self`.
    #[inline(always)]
    pub fn compose(self, other: Self) -> Self {
        Self {
            w: self.w * other.w - self.v.dot(other.v),
            v: other.v * self.w + self.v * other.w + self.v.cross(other.v),
        }
    }

    /// Returns this quaternion scaled to unit length.
    #[inline(always)]
    pub fn normalised(self) -> Self {
        let scale = (self.w * self.w + self.v.norm_squared()).sqrt().recip();
        Self { w: self.w * scale, v: self.v * scale }
    }

    /// Computes the quaternion of a small rotation vector (rad). The result is accurate to second
    /// order in this vector, and always has unit length.
    #[inline(always)]
    pub fn of_small(rotation: Vec3<T>) -> Self {
        Self { w: T::one(), v: rotation * T::from_f64(0.5) }.normalised()
    }

    /// Returns the rotation matrix of this unit quaternion.
    #[inline(always)]
    pub fn rotation(self) -> Mat3<T> {
        let two = T::from_f64(2.0);
        let v = self.v;
        let column = |e: Vec3<T>| {
            let t = v.cross(e) * two;
            e + t * self.w + v.cross(t)
        };
        Mat3::from_columns(column(Vec3::unit(0)), column(Vec3::unit(1)), column(Vec3::unit(2)))
    }
}

impl Quaternion<f64> {
    /// Computes the unit quaternion of a rotation matrix.
    pub fn from_rotation(rotation: Mat3<f64>) -> Self {
        let vector = rotation.rotation_vector();
        let angle = vector.norm();
        let (s, c) = (0.5 * angle).sin_cos();
        let scale = if angle > 1e-9 { s / angle } else { 0.5 };
        Self { w: c, v: vector * scale }.normalised()
    }
}
