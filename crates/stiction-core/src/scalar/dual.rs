//! Dual numbers: values with derivatives.
//!
//! Equation (P1) of the book's theory.

use super::Scalar;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// Dual number: a value with its derivatives in `D` directions, for forward-mode differentiation
/// that is exact to round-off.
///
/// With [`super::Lanes`] as `T`, several states are differentiated at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<T, const D: usize> {
    /// Value of the number.
    pub value: T,
    /// Derivatives of the value, one for each direction of differentiation.
    pub slope: [T; D],
}

impl<T: Scalar, const D: usize> Dual<T, D> {
    /// Creates a constant: all derivatives are zero.
    #[inline(always)]
    pub fn constant(value: T) -> Self {
        Self { value, slope: [T::zero(); D] }
    }

    /// Creates a variable: the derivative is one in `direction` and zero in all other directions. A
    /// direction that does not exist yields a constant.
    #[inline(always)]
    pub fn variable(value: T, direction: usize) -> Self {
        Self {
            value,
            slope: core::array::from_fn(|i| if i == direction { T::one() } else { T::zero() }),
        }
    }

    /// Returns `f(self)` by the chain rule, where `value` and `derivative` are those of the
    /// function `f` at `self.value`.
    #[inline(always)]
    fn chain(self, value: T, derivative: T) -> Self {
        Self { value, slope: self.slope.map(|s| s * derivative) }
    }

    #[inline(always)]
    fn zip(self, other: Self, value: T, f: impl Fn(T, T) -> T) -> Self {
        Self { value, slope: core::array::from_fn(|i| f(self.slope[i], other.slope[i])) }
    }
}

impl<T: Scalar, const D: usize> Add for Dual<T, D> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, self.value + other.value, |a, b| a + b)
    }
}

impl<T: Scalar, const D: usize> Sub for Dual<T, D> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, self.value - other.value, |a, b| a - b)
    }
}

impl<T: Scalar, const D: usize> Mul for Dual<T, D> {
    type Output = Self;
    #[inline(always)]
    #[expect(clippy::suspicious_arithmetic_impl, reason = "the product rule")]
    fn mul(self, other: Self) -> Self {
        let (u, v) = (self.value, other.value);
        self.zip(other, u * v, |du, dv| du * v + u * dv)
    }
}

impl<T: Scalar, const D: usize> Div for Dual<T, D> {
    type Output = Self;
    #[inline(always)]
    #[expect(clippy::suspicious_arithmetic_impl, reason = "the quotient rule")]
    fn div(self, other: Self) -> Self {
        let over = other.value.recip();
        let quotient = self.value / other.value;
        self.zip(other, quotient, |du, dv| (du - quotient * dv) * over)
    }
}

impl<T: Scalar, const D: usize> Neg for Dual<T, D> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: -self.value, slope: self.slope.map(Neg::neg) }
    }
}

macro_rules! by_operator {
    ($($operator:ident :: $method:ident by $symbol:tt),*) => {$(
        impl<T: Scalar, const D: usize> $operator for Dual<T, D> {
            #[inline(always)]
            fn $method(&mut self, other: Self) {
                *self = *self $symbol other;
            }
        }
    )*};
}
by_operator!(AddAssign::add_assign by +, SubAssign::sub_assign by -, MulAssign::mul_assign by *);

impl<T: Scalar, const D: usize> Scalar for Dual<T, D> {
    #[inline(always)]
    fn has_slope() -> bool {
        true
    }
    #[inline(always)]
    fn held(self) -> Self {
        Self::constant(self.value)
    }
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self::constant(T::from_f64(value))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, T::from_f64(0.5) / root)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.chain(s, c), self.chain(c, -s))
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        let (u, v) = (self.value, x.value);
        let over = (u * u + v * v).recip();
        self.zip(x, u.atan2(v), |du, dv| (du * v - u * dv) * over)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let value = self.value.exp();
        self.chain(value, value)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        self.chain(self.value.ln(), self.value.recip())
    }
    #[inline(always)]
    fn if_positive(self, yes: Self, no: Self) -> Self {
        Self {
            value: self.value.if_positive(yes.value, no.value),
            slope: core::array::from_fn(|i| self.value.if_positive(yes.slope[i], no.slope[i])),
        }
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        self.value.largest()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the derivative of each operation against an analytic derivative.
    #[test]
    fn derivatives_follow_the_rules() {
        let x = Dual::<f64, 1>::variable(0.7, 0);
        let two = Dual::from_f64(2.0);
        let (sin, cos) = x.sin_cos();
        let cases = [
            (x * x, 2.0 * 0.7),
            (two / x, -2.0 / 0.49),
            (x.sqrt(), 0.5 / 0.7_f64.sqrt()),
            (sin, 0.7_f64.cos()),
            (cos, -0.7_f64.sin()),
            (sin.atan2(cos), 1.0),
            (x.exp(), 0.7_f64.exp()),
            (x.ln(), 1.0 / 0.7),
            ((-x).abs(), 1.0),
            ((x * x).norm_of_square(), 1.0),
            (x.held() * x, 0.7),
        ];
        for (i, (dual, expected)) in cases.into_iter().enumerate() {
            assert!((dual.slope[0] - expected).abs() < 1e-15, "case {i}: {}", dual.slope[0]);
        }
    }

    #[test]
    fn a_vanishing_norm_has_a_finite_slope() {
        let x = Dual::<f64, 1>::variable(0.0, 0);
        assert_eq!((x * x).norm_of_square(), Dual::constant(0.0));
    }
}
