//! The scalar type of the kernels.
//!
//! A kernel that is generic over [`Scalar`] runs with `f64`, with [`Lanes`] (several states or
//! parameter sets side by side), with [`Dual`] numbers (exact derivatives), and with combinations
//! of these. A kernel must therefore not branch on values, because the lanes may need different
//! branches. [`Scalar::if_positive`] replaces branches. The caller, not the kernel, tests for
//! convergence, by evaluating [`Scalar::largest`] between steps.

mod dual;
mod lanes;

pub use dual::Dual;
pub use lanes::Lanes;

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// Real number type of the kernels: `f64`, [`Lanes`], [`Dual`], or a combination of them.
///
/// Implementations follow IEEE arithmetic in every lane and never panic.
pub trait Scalar:
    Copy
    + Debug
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// The constant `value`, in every lane, with zero derivative.
    fn from_f64(value: f64) -> Self;

    /// Square root. The derivative at zero is infinite: see [`Scalar::norm_of_square`].
    fn sqrt(self) -> Self;

    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);

    /// Angle of the point (`x`, `self`), in (-pi, pi].
    fn atan2(self, x: Self) -> Self;

    /// The exponential.
    fn exp(self) -> Self;

    /// The natural logarithm, of a positive number.
    fn ln(self) -> Self;

    /// Selects lane by lane: `yes` if the value is greater than zero, otherwise `no`.
    fn if_positive(self, yes: Self, no: Self) -> Self;

    /// Largest magnitude of the value over all lanes, NaN if any lane is NaN. Use it for decisions
    /// *between* kernel calls, never inside a kernel.
    fn largest(self) -> f64;

    /// Returns `true` for types with derivatives. Solving a linear system in such a type requires
    /// one additional step, see [`Self::held`].
    #[inline(always)]
    fn has_slope() -> bool {
        false
    }

    /// Returns the value of every lane as a constant with zero derivative.
    ///
    /// Kernels use constants for quantities that affect a solution at second order only. For
    /// example, a Newton step from a solution does not need the derivative of the matrix, because
    /// the residual carries all derivatives (equation (P8) of the book's theory).
    #[inline(always)]
    fn held(self) -> Self {
        self
    }

    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::from_f64(0.0)
    }

    /// One.
    #[inline(always)]
    fn one() -> Self {
        Self::from_f64(1.0)
    }

    /// `1 / self`.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::one() / self
    }

    /// Absolute value.
    #[inline(always)]
    fn abs(self) -> Self {
        self.if_positive(self, -self)
    }

    /// Square root of a squared norm, with derivative zero at zero (a subgradient of the norm), so
    /// that the derivative at zero normal load is finite. NaN is propagated.
    #[inline(always)]
    fn norm_of_square(self) -> Self {
        let safe = self.if_positive(self, Self::one());
        self.if_positive(safe.sqrt(), self * Self::zero())
    }
}

impl Scalar for f64 {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        f64::atan2(self, x)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        f64::exp(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        f64::ln(self)
    }
    #[inline(always)]
    fn if_positive(self, yes: Self, no: Self) -> Self {
        if self > 0.0 { yes } else { no }
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        f64::abs(self)
    }
}
