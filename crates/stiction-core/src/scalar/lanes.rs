//! Vectors of numbers for SIMD computation.

use super::Scalar;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// `N` numbers (SIMD lanes) that a kernel processes together, for `N` states or `N` parameter sets.
///
/// This is a plain array; the compiler turns operations on it into vector instructions of the width
/// available in the build. The results in every lane equal those of the same computation with
/// `f64`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Lanes<T, const N: usize>(pub [T; N]);

impl<T: Scalar, const N: usize> Lanes<T, N> {
    /// Creates lanes from a function of their index: lane `i` contains `f(i)`.
    #[inline(always)]
    pub fn from_fn(f: impl FnMut(usize) -> T) -> Self {
        Self(core::array::from_fn(f))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(T, T) -> T) -> Self {
        Self(core::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

macro_rules! lane_wise {
    ($($operator:ident :: $method:ident),*) => {$(
        impl<T: Scalar, const N: usize> $operator for Lanes<T, N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| $operator::$method(a, b))
            }
        }
    )*};
}
lane_wise!(Add::add, Sub::sub, Mul::mul, Div::div);

impl<T: Scalar, const N: usize> Neg for Lanes<T, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(Neg::neg))
    }
}

macro_rules! lane_wise_assign {
    ($($operator:ident :: $method:ident),*) => {$(
        impl<T: Scalar, const N: usize> $operator for Lanes<T, N> {
            #[inline(always)]
            fn $method(&mut self, other: Self) {
                for (a, b) in self.0.iter_mut().zip(other.0) {
                    $operator::$method(a, b);
                }
            }
        }
    )*};
}
lane_wise_assign!(AddAssign::add_assign, SubAssign::sub_assign, MulAssign::mul_assign);

impl<T: Scalar, const N: usize> Scalar for Lanes<T, N> {
    #[inline(always)]
    fn has_slope() -> bool {
        T::has_slope()
    }
    #[inline(always)]
    fn held(self) -> Self {
        Self(self.0.map(T::held))
    }
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self([T::from_f64(value); N])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(T::sqrt))
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let pairs = self.0.map(T::sin_cos);
        (Self(pairs.map(|p| p.0)), Self(pairs.map(|p| p.1)))
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        self.zip(x, T::atan2)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        Self(self.0.map(T::exp))
    }
    #[inline(always)]
    fn ln(self) -> Self {
        Self(self.0.map(T::ln))
    }
    #[inline(always)]
    fn if_positive(self, yes: Self, no: Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i].if_positive(yes.0[i], no.0[i])))
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        let mut worst = 0.0;
        for lane in self.0 {
            let size = lane.largest();
            // `f64::max` would ignore a NaN, which must remain visible.
            if size > worst || size.is_nan() {
                worst = size;
            }
            if worst.is_nan() {
                break;
            }
        }
        worst
    }
}
