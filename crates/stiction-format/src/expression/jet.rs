//! Second-order jets: a value with its exact first and second time derivatives.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value and its first and second time derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jet {
    pub(crate) value: f64,
    pub(crate) first: f64,
    pub(crate) second: f64,
}

impl Jet {
    /// Creates the jet of a constant, whose derivatives are zero.
    pub(crate) fn constant(value: f64) -> Self {
        Self { value, first: 0.0, second: 0.0 }
    }

    /// Creates the jet of the time itself at time `t`.
    pub(crate) fn time(t: f64) -> Self {
        Self { value: t, first: 1.0, second: 0.0 }
    }

    pub(crate) fn is_finite(self) -> bool {
        self.value.is_finite() && self.first.is_finite() && self.second.is_finite()
    }

    /// Composition `f(self)`, from the value of `f` and its first two derivatives at `self.value`.
    pub(crate) fn chain(self, f: f64, df: f64, ddf: f64) -> Self {
        Self {
            value: f,
            first: df * self.first,
            second: ddf * self.first * self.first + df * self.second,
        }
    }

    pub(crate) fn sin(self) -> Self {
        let (s, c) = self.value.sin_cos();
        self.chain(s, c, -s)
    }

    pub(crate) fn cos(self) -> Self {
        let (s, c) = self.value.sin_cos();
        self.chain(c, -s, -c)
    }

    pub(crate) fn tan(self) -> Self {
        let t = self.value.tan();
        let slope = 1.0 + t * t;
        self.chain(t, slope, 2.0 * t * slope)
    }

    pub(crate) fn asin(self) -> Self {
        let x = self.value;
        let cosine2 = (1.0 - x) * (1.0 + x);
        let slope = cosine2.sqrt().recip();
        self.chain(x.asin(), slope, x * slope / cosine2)
    }

    pub(crate) fn acos(self) -> Self {
        let x = self.value;
        let cosine2 = (1.0 - x) * (1.0 + x);
        let slope = -cosine2.sqrt().recip();
        self.chain(x.acos(), slope, x * slope / cosine2)
    }

    pub(crate) fn atan(self) -> Self {
        let x = self.value;
        let slope = (1.0 + x * x).recip();
        self.chain(x.atan(), slope, -2.0 * x * slope * slope)
    }

    /// Angle from the x axis to the point (`x`, `self`), rad, from -pi to pi, as computed by
    /// `atan2`.
    pub(crate) fn atan2(self, x: Self) -> Self {
        let y = self;
        let r2 = x.value * x.value + y.value * y.value;
        let turn = |dx: f64, dy: f64| (x.value * dy - y.value * dx) / r2;
        let first = turn(x.first, y.first);
        let radial = 2.0 * (x.value * x.first + y.value * y.first) / r2;
        Self {
            value: y.value.atan2(x.value),
            first,
            second: turn(x.second, y.second) - first * radial,
        }
    }

    pub(crate) fn sinh(self) -> Self {
        let (s, c) = (self.value.sinh(), self.value.cosh());
        self.chain(s, c, s)
    }

    pub(crate) fn cosh(self) -> Self {
        let (s, c) = (self.value.sinh(), self.value.cosh());
        self.chain(c, s, c)
    }

    pub(crate) fn tanh(self) -> Self {
        let t = self.value.tanh();
        // 1 - t^2, computed without cancellation for large arguments.
        let slope = self.value.cosh().recip().powi(2);
        self.chain(t, slope, -2.0 * t * slope)
    }

    pub(crate) fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e, e)
    }

    pub(crate) fn ln(self) -> Self {
        let inverse = self.value.recip();
        self.chain(self.value.ln(), inverse, -inverse * inverse)
    }

    pub(crate) fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let slope = 0.5 / root;
        self.chain(root, slope, -0.5 * slope / self.value)
    }

    /// Power of a jet with a constant exponent.
    pub(crate) fn powf(self, n: f64) -> Self {
        let x = self.value;
        // A zero factor takes precedence over an infinite power: the derivative of x^1 at 0 is 1,
        // that of x^0 is 0.
        let term = |factor: f64, power: f64| {
            if factor == 0.0 { 0.0 } else { factor * x.powf(power) }
        };
        self.chain(x.powf(n), term(n, n - 1.0), term(n * (n - 1.0), n - 2.0))
    }

    /// Power of a jet with a time-dependent exponent.
    pub(crate) fn pow(self, n: Self) -> Self {
        (self.ln() * n).exp()
    }

    /// Absolute value; at a kink the derivatives are one-sided, towards later times.
    pub(crate) fn abs(self) -> Self {
        if self.less_soon(Self::constant(0.0)) { -self } else { self }
    }

    /// Minimum of two jets. If their values are equal, returns the jet that is smaller immediately
    /// afterwards.
    pub(crate) fn min(self, other: Self) -> Self {
        if other.less_soon(self) { other } else { self }
    }

    /// Maximum of two jets. If their values are equal, returns the jet that is greater immediately
    /// afterwards.
    pub(crate) fn max(self, other: Self) -> Self {
        if self.less_soon(other) { other } else { self }
    }

    /// Tests if `self` is less than `other`. If the values are equal, compares the first
    /// derivatives, then the second.
    fn less_soon(self, other: Self) -> bool {
        let difference =
            [self.value - other.value, self.first - other.first, self.second - other.second];
        difference.into_iter().find(|d| *d != 0.0).is_some_and(|d| d < 0.0)
    }

    /// Smooth step from 0 at `from` to 1 at `to`, constant outside, with zero first and second
    /// derivatives at both ends: `6 u^5 - 15 u^4 + 10 u^3` with `u = (self - from)/(to - from)`.
    pub(crate) fn smooth(self, from: Self, to: Self) -> Self {
        let u = (self - from) / (to - from);
        match u.value {
            // A jump has no derivative.
            _ if from.value == to.value => Self::constant(f64::NAN),
            x if x <= 0.0 => Self::constant(0.0),
            x if x >= 1.0 => Self::constant(1.0),
            x => u.chain(
                x * x * x * (10.0 + x * (6.0 * x - 15.0)),
                30.0 * (x * (1.0 - x)).powi(2),
                60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
            ),
        }
    }
}

impl Add for Jet {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: self.first + other.first,
            second: self.second + other.second,
        }
    }
}

impl Sub for Jet {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Jet {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, first: -self.first, second: -self.second }
    }
}

impl Mul for Jet {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            first: self.first * other.value + self.value * other.first,
            second: self.second * other.value
                + 2.0 * self.first * other.first
                + self.value * other.second,
        }
    }
}

impl Div for Jet {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        let first = (self.first - value * other.first) / other.value;
        let second = (self.second - 2.0 * first * other.first - value * other.second) / other.value;
        Self { value, first, second }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    type Operation = (&'static str, fn(Jet) -> Jet);

    /// Functions to be tested, each of which maps its argument well inside its domain.
    const OPERATIONS: &[Operation] = &[
        ("sin", Jet::sin),
        ("cos", Jet::cos),
        ("tan", |x| (x * Jet::constant(0.5)).tan()),
        ("asin", |x| (x * Jet::constant(0.4)).asin()),
        ("acos", |x| (x * Jet::constant(0.4)).acos()),
        ("atan", Jet::atan),
        ("atan2", |x| x.atan2(x * x + Jet::constant(1.0))),
        ("sinh", Jet::sinh),
        ("cosh", Jet::cosh),
        ("tanh", Jet::tanh),
        ("exp", Jet::exp),
        ("log", |x| (x + Jet::constant(4.0)).ln()),
        ("sqrt", |x| (x + Jet::constant(4.0)).sqrt()),
        ("power", |x| (x + Jet::constant(4.0)).powf(-1.5)),
        ("square", |x| x.powf(2.0)),
        ("exponent", |x| (x + Jet::constant(4.0)).pow(x)),
        ("divide", |x| x.sin() / (x + Jet::constant(4.0))),
        ("smooth", |x| x.smooth(Jet::constant(-3.0), Jet::constant(3.0))),
    ];

    proptest! {
        /// Checks that the derivatives along x(t) = a + b t + c t^2 agree with central differences
        /// of the values.
        #[test]
        fn derivatives_are_those_of_the_values(
            a in -1.5..1.5f64, b in -1.0..1.0f64, c in -1.0..1.0f64,
        ) {
            // Central differences: truncation h^2 f''''/12 and rounding 4 eps |f| / h^2; the best h is
            // near eps^(1/4).
            let h = 1e-4;
            for (name, operation) in OPERATIONS {
                let at = |t: f64| operation(Jet {
                    value: a + b * t + c * t * t,
                    first: b + 2.0 * c * t,
                    second: 2.0 * c,
                });
                let (before, now, after) = (at(-h), at(0.0), at(h));
                let first = (after.value - before.value) / (2.0 * h);
                let second = (after.value - 2.0 * now.value + before.value) / (h * h);
                prop_assert!((now.first - first).abs() < 1e-5, "{name}: {} {first}", now.first);
                prop_assert!((now.second - second).abs() < 1e-4, "{name}: {} {second}", now.second);
            }
        }
    }

    #[test]
    fn derivatives_at_kinks_are_right_hand() {
        let falling = Jet { value: 0.0, first: -2.0, second: 0.0 };
        assert_eq!(falling.abs(), -falling);
        let (steep, flat) = (Jet::time(0.0), Jet::constant(0.0));
        assert_eq!(steep.max(flat), steep);
        assert_eq!(steep.min(flat), flat);
    }

    #[test]
    fn whole_powers_are_exact_at_zero() {
        let t = Jet::time(0.0);
        assert_eq!(t.powf(2.0), Jet { value: 0.0, first: 0.0, second: 2.0 });
        assert_eq!(t.powf(1.0), t);
        assert_eq!(t.powf(0.0), Jet::constant(1.0));
    }
}
