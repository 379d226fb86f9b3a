//! 3x3 matrices, for rotations and inertia tensors.

use super::Vec3;
use crate::scalar::Scalar;
use core::ops::{Add, Mul};

/// A 3x3 matrix, stored by columns. If it is a rotation `R_AB`, its columns are the axes of B in A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mat3<T> {
    /// Columns of the matrix, from left to right.
    pub columns: [Vec3<T>; 3],
}

impl<T: Scalar> Mat3<T> {
    /// The matrix with the given columns.
    #[inline(always)]
    pub fn from_columns(x: Vec3<T>, y: Vec3<T>, z: Vec3<T>) -> Self {
        Self { columns: [x, y, z] }
    }

    /// The identity matrix.
    #[inline(always)]
    pub fn identity() -> Self {
        Self::from_columns(Vec3::unit(0), Vec3::unit(1), Vec3::unit(2))
    }

    /// The zero matrix.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::from_columns(Vec3::zero(), Vec3::zero(), Vec3::zero())
    }

    /// The diagonal matrix with the components of `d` on its diagonal.
    #[inline(always)]
    pub fn diagonal(d: Vec3<T>) -> Self {
        Self::from_columns(Vec3::unit(0) * d.x, Vec3::unit(1) * d.y, Vec3::unit(2) * d.z)
    }

    /// Rotation about coordinate axis `k` (0, 1, 2 for x, y, z) by an angle given by its sine and
    /// cosine.
    #[inline(always)]
    pub fn about_axis(k: usize, (s, c): (T, T)) -> Self {
        let (o, l) = (T::zero(), T::one());
        match k {
            0 => Self::from_columns(Vec3::new(l, o, o), Vec3::new(o, c, s), Vec3::new(o, -s, c)),
            1 => Self::from_columns(Vec3::new(c, o, -s), Vec3::new(o, l, o), Vec3::new(s, o, c)),
            _ => Self::from_columns(Vec3::new(c, s, o), Vec3::new(-s, c, o), Vec3::new(o, o, l)),
        }
    }

    /// Entry in row `i` and column `j`, counted from zero.
    #[inline(always)]
    pub fn at(self, i: usize, j: usize) -> T {
        self.columns[j].component(i)
    }

    /// Returns the transpose, which is the inverse of a rotation.
    #[inline(always)]
    pub fn transpose(self) -> Self {
        let [a, b, c] = self.columns;
        Self::from_columns(
            Vec3::new(a.x, b.x, c.x),
            Vec3::new(a.y, b.y, c.y),
            Vec3::new(a.z, b.z, c.z),
        )
    }

    /// Multiplies the transpose by a vector: `transpose(self) * v`.
    #[inline(always)]
    pub fn transpose_mul(self, v: Vec3<T>) -> Vec3<T> {
        Vec3::new(self.columns[0].dot(v), self.columns[1].dot(v), self.columns[2].dot(v))
    }

    /// Sum of the diagonal.
    #[inline(always)]
    pub fn trace(self) -> T {
        self.columns[0].x + self.columns[1].y + self.columns[2].z
    }

    /// Returns the vector `w` whose cross-product matrix is the skew-symmetric part `(self -
    /// transpose(self)) / 2`. For a rotation by the angle `a` about the unit vector `n`, `w` is `n
    /// sin a`.
    #[inline(always)]
    pub fn skew_part(self) -> Vec3<T> {
        let [a, b, c] = self.columns;
        Vec3::new(b.z - c.y, c.x - a.z, a.y - b.x) * T::from_f64(0.5)
    }
}

impl Mat3<f64> {
    /// Converts all entries to constants of another scalar type.
    #[inline(always)]
    pub fn lift<T: Scalar>(self) -> Mat3<T> {
        Mat3 { columns: self.columns.map(Vec3::lift) }
    }

    /// Computes the rotation by `angle` (rad) about the direction `axis` (of any nonzero length),
    /// by Rodrigues' formula. Returns the identity for a zero axis.
    pub fn rotation(axis: Vec3<f64>, angle: f64) -> Self {
        let Some(n) = axis.direction() else { return Self::identity() };
        let (s, c) = angle.sin_cos();
        let column = |k| {
            let e = Vec3::unit(k);
            e * c + n.cross(e) * s + n * (n.dot(e) * (1.0 - c))
        };
        Self::from_columns(column(0), column(1), column(2))
    }

    /// Computes the smallest rotation that turns direction `from` into direction `to`. For opposite
    /// directions, this is a half turn about some perpendicular axis. Returns the identity if a
    /// vector has no direction.
    pub fn between(from: Vec3<f64>, to: Vec3<f64>) -> Self {
        let (Some(a), Some(b)) = (from.direction(), to.direction()) else {
            return Self::identity();
        };
        let axis = a.cross(b);
        let sine = axis.norm();
        if sine == 0.0 {
            return if a.dot(b) > 0.0 {
                Self::identity()
            } else {
                Self::rotation(a.any_perpendicular(), core::f64::consts::PI)
            };
        }
        Self::rotation(axis, sine.atan2(a.dot(b)))
    }

    /// Computes the rotation vector (axis times angle, rad) of this rotation; its length is at most
    /// pi.
    pub fn rotation_vector(self) -> Vec3<f64> {
        let w = self.skew_part();
        let (sine, cosine) = (w.norm(), 0.5 * (self.trace() - 1.0));
        let angle = sine.atan2(cosine);
        if cosine > -0.9 {
            // The factor angle / sin(angle) tends to 1 for small angles.
            return w * if sine > 1e-9 { angle / sine } else { 1.0 };
        }
        // Near a half turn the skew part is small. The axis then follows from the largest column of
        // the symmetric part, since (R + R^T)/2 = cos a I + (1 - cos a) n n^T.
        let symmetric = |i: usize, j: usize| {
            0.5 * (self.at(i, j) + self.at(j, i)) - if i == j { cosine } else { 0.0 }
        };
        let k = (0..3).max_by(|&i, &j| symmetric(i, i).total_cmp(&symmetric(j, j))).unwrap_or(0);
        let n = Vec3::new(symmetric(0, k), symmetric(1, k), symmetric(2, k));
        let n = n.direction().unwrap_or(Vec3::unit(k));
        n * if n.dot(w) < 0.0 { -angle } else { angle }
    }
}

impl From<nalgebra::Matrix3<f64>> for Mat3<f64> {
    fn from(m: nalgebra::Matrix3<f64>) -> Self {
        Self { columns: [0, 1, 2].map(|k| m.column(k).into_owned().into()) }
    }
}

impl From<Mat3<f64>> for nalgebra::Matrix3<f64> {
    fn from(m: Mat3<f64>) -> Self {
        Self::from_fn(|i, j| m.at(i, j))
    }
}

impl<T: Scalar> Mul<Vec3<T>> for Mat3<T> {
    type Output = Vec3<T>;
    #[inline(always)]
    fn mul(self, v: Vec3<T>) -> Vec3<T> {
        self.columns[0] * v.x + self.columns[1] * v.y + self.columns[2] * v.z
    }
}

impl<T: Scalar> Mul for Mat3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { columns: other.columns.map(|column| self * column) }
    }
}

impl<T: Scalar> Mul<T> for Mat3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        Self { columns: self.columns.map(|column| column * factor) }
    }
}

impl<T: Scalar> Add for Mat3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { columns: core::array::from_fn(|k| self.columns[k] + other.columns[k]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vec3<f64>> {
        prop::array::uniform3(-1.0..1.0).prop_map(Vec3::from)
    }

    proptest! {
        #[test]
        fn rotation_vector_inverts_rotation(axis in vector(), angle in -3.0..3.0f64) {
            prop_assume!(axis.norm() > 1e-3);
            let expected = axis.direction().unwrap() * angle;
            let found = Mat3::rotation(axis, angle).rotation_vector();
            prop_assert!((found - expected).norm() < 1e-9);
        }

        #[test]
        fn between_takes_one_direction_to_the_other(a in vector(), b in vector()) {
            prop_assume!(a.norm() > 1e-3 && b.norm() > 1e-3);
            let moved = Mat3::between(a, b) * a.direction().unwrap();
            prop_assert!((moved - b.direction().unwrap()).norm() < 1e-14);
        }
    }

    #[test]
    fn half_turns() {
        for k in 0..3 {
            let e = Vec3::unit(k);
            let half = Mat3::rotation(e, core::f64::consts::PI).rotation_vector();
            assert!((half.norm() - core::f64::consts::PI).abs() < 1e-15);
            assert!(half.cross(e).norm() < 1e-15);
            assert!((Mat3::between(e, -e) * e + e).norm() < 1e-15);
        }
    }
}
