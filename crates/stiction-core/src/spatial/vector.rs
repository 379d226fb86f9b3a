//! Vectors with three components.

use crate::scalar::Scalar;
use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// A vector with three components. Axes and unit depend on the context.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Vec3<T> {
    /// First component.
    pub x: T,
    /// Second component.
    pub y: T,
    /// Third component.
    pub z: T,
}

impl<T: Scalar> Vec3<T> {
    /// The vector (`x`, `y`, `z`).
    #[inline(always)]
    pub fn new(x: T, y: T, z: T) -> Self {
        Self { x, y, z }
    }

    /// The zero vector.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::new(T::zero(), T::zero(), T::zero())
    }

    /// The unit vector along axis `k` (0, 1, 2 for x, y, z); zero for any other `k`.
    #[inline(always)]
    pub fn unit(k: usize) -> Self {
        let pick = |i| if i == k { T::one() } else { T::zero() };
        Self::new(pick(0), pick(1), pick(2))
    }

    /// Component `k` (0, 1, 2 for x, y, z; z for any other `k`).
    #[inline(always)]
    pub fn component(self, k: usize) -> T {
        match k {
            0 => self.x,
            1 => self.y,
            _ => self.z,
        }
    }

    /// The components as an array, in the order `x`, `y`, `z`.
    #[inline(always)]
    pub fn to_array(self) -> [T; 3] {
        [self.x, self.y, self.z]
    }

    /// Returns the components as constants with zero derivatives, see [`Scalar::held`].
    #[inline(always)]
    pub fn held(self) -> Self {
        Self::new(self.x.held(), self.y.held(), self.z.held())
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> T {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Vector product `self x other`.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    /// Squared length.
    #[inline(always)]
    pub fn norm_squared(self) -> T {
        self.dot(self)
    }

    /// Length; its derivative at the zero vector is defined as zero.
    #[inline(always)]
    pub fn norm(self) -> T {
        self.norm_squared().norm_of_square()
    }

    /// Returns the component of the vector that is perpendicular to the unit vector `axis`.
    #[inline(always)]
    pub fn across(self, axis: Self) -> Self {
        self - axis * self.dot(axis)
    }
}

impl Vec3<f64> {
    /// Converts all components to constants of another scalar type.
    #[inline(always)]
    pub fn lift<T: Scalar>(self) -> Vec3<T> {
        Vec3::new(T::from_f64(self.x), T::from_f64(self.y), T::from_f64(self.z))
    }

    /// Returns the unit vector along this vector, or `None` if the vector is too short to have a
    /// direction.
    pub fn direction(self) -> Option<Self> {
        let length = self.norm();
        let unit = self * (1.0 / length);
        (length > 0.0 && unit.is_finite()).then_some(unit)
    }

    /// Returns a unit vector perpendicular to this vector, which can have any nonzero length.
    pub fn any_perpendicular(self) -> Self {
        // Vector product with the coordinate axis that is farthest from parallel.
        let [x, y, z] = self.to_array().map(f64::abs);
        let helper = Vec3::unit(if x <= y && x <= z {
            0
        } else if y <= z {
            1
        } else {
            2
        });
        self.cross(helper).direction().unwrap_or(Vec3::unit(0))
    }

    /// Returns `true` if all components are finite.
    pub fn is_finite(self) -> bool {
        self.to_array().iter().all(|c| c.is_finite())
    }
}

impl<T> From<[T; 3]> for Vec3<T> {
    fn from([x, y, z]: [T; 3]) -> Self {
        Self { x, y, z }
    }
}

impl From<nalgebra::Vector3<f64>> for Vec3<f64> {
    fn from(v: nalgebra::Vector3<f64>) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<Vec3<f64>> for nalgebra::Vector3<f64> {
    fn from(v: Vec3<f64>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl<T: Scalar> Add for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<T: Scalar> Sub for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<T: Scalar> Neg for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<T: Scalar> Mul<T> for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl<T: Scalar> AddAssign for Vec3<T> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<T: Scalar> SubAssign for Vec3<T> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
