//! Twists and wrenches: motion and force of a rigid body.

use super::Vec3;
use crate::scalar::{Lanes, Scalar};
use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// Twist: the velocity of a rigid body about the reference point. The type also represents
/// instantaneous motions, axes of joint degrees of freedom, and accelerations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist<T> {
    /// Angular velocity, rad/s.
    pub angular: Vec3<T>,
    /// Velocity of the body-fixed point that coincides with the reference point, m/s.
    pub linear: Vec3<T>,
}

/// Wrench: force and moment on a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench<T> {
    /// Force, N.
    pub force: Vec3<T>,
    /// Moment about the reference point, N m.
    pub moment: Vec3<T>,
}

impl<T: Scalar> Twist<T> {
    /// The zero twist: no motion.
    #[inline(always)]
    pub fn zero() -> Self {
        Self { angular: Vec3::zero(), linear: Vec3::zero() }
    }

    /// Twist of a unit rotation about the line through `point` along the unit vector `axis`.
    #[inline(always)]
    pub fn rotation(axis: Vec3<T>, point: Vec3<T>) -> Self {
        Self { angular: axis, linear: point.cross(axis) }
    }

    /// Twist of a unit translation along the unit vector `axis`.
    #[inline(always)]
    pub fn translation(axis: Vec3<T>) -> Self {
        Self { angular: Vec3::zero(), linear: axis }
    }

    /// Velocity of the body-fixed point at the position `point` relative to the reference point.
    #[inline(always)]
    pub fn velocity_at(self, point: Vec3<T>) -> Vec3<T> {
        self.linear + self.angular.cross(point)
    }

    /// Returns the twist of the same motion about another reference point, given by its position
    /// `point` relative to the present one.
    #[inline(always)]
    pub fn about(self, point: Vec3<T>) -> Self {
        Self { angular: self.angular, linear: self.velocity_at(point) }
    }

    /// Computes the rate of change of `other`, a twist that is fixed in a body moving with this
    /// twist: the cross product `self x other` of spatial motion vectors.
    #[inline(always)]
    pub fn carry(self, other: Self) -> Self {
        Self {
            angular: self.angular.cross(other.angular),
            linear: self.angular.cross(other.linear) + self.linear.cross(other.angular),
        }
    }

    /// Computes the power of `wrench` on this twist (the reciprocal product of screws).
    #[inline(always)]
    pub fn power(self, wrench: Wrench<T>) -> T {
        self.angular.dot(wrench.moment) + self.linear.dot(wrench.force)
    }
}

impl<T: Scalar> Wrench<T> {
    /// The zero wrench: no load.
    #[inline(always)]
    pub fn zero() -> Self {
        Self { force: Vec3::zero(), moment: Vec3::zero() }
    }

    /// A unit force along `axis` through `point`.
    #[inline(always)]
    pub fn force_through(axis: Vec3<T>, point: Vec3<T>) -> Self {
        Self { force: axis, moment: point.cross(axis) }
    }

    /// A pure couple with the given moment.
    #[inline(always)]
    pub fn couple(moment: Vec3<T>) -> Self {
        Self { force: Vec3::zero(), moment }
    }

    /// Returns the moment of the wrench about `point`, a position relative to the reference point.
    #[inline(always)]
    pub fn moment_about(self, point: Vec3<T>) -> Vec3<T> {
        self.moment - point.cross(self.force)
    }
}

impl<const N: usize> Wrench<Lanes<f64, N>> {
    /// Returns the wrench in one SIMD lane.
    #[inline]
    pub(crate) fn lane(&self, lane: usize) -> Wrench<f64> {
        let of = |v: Vec3<Lanes<f64, N>>| Vec3::new(v.x.0[lane], v.y.0[lane], v.z.0[lane]);
        Wrench { force: of(self.force), moment: of(self.moment) }
    }
}

macro_rules! vector_space {
    ($name:ident { $a:ident, $b:ident }) => {
        impl<T: Scalar> $name<T> {
            /// Returns the components as constants with zero derivatives, see [`Scalar::held`].
            #[inline(always)]
            pub fn held(self) -> Self {
                Self { $a: self.$a.held(), $b: self.$b.held() }
            }
        }

        impl $name<f64> {
            /// Converts all components to constants of another scalar type.
            #[inline(always)]
            pub fn lift<T: Scalar>(self) -> $name<T> {
                $name { $a: self.$a.lift(), $b: self.$b.lift() }
            }
        }

        impl<T: Scalar> Add for $name<T> {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self { $a: self.$a + other.$a, $b: self.$b + other.$b }
            }
        }
        impl<T: Scalar> Sub for $name<T> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                Self { $a: self.$a - other.$a, $b: self.$b - other.$b }
            }
        }
        impl<T: Scalar> Neg for $name<T> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self { $a: -self.$a, $b: -self.$b }
            }
        }
        impl<T: Scalar> Mul<T> for $name<T> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, factor: T) -> Self {
                Self { $a: self.$a * factor, $b: self.$b * factor }
            }
        }
        impl<T: Scalar> AddAssign for $name<T> {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }
        impl<T: Scalar> SubAssign for $name<T> {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }
    };
}
vector_space!(Twist { angular, linear });
vector_space!(Wrench { force, moment });
