//! Friction laws: friction force as a function of sliding speed and normal load.
//!
//! Equation (F1) of the book's theory.

use super::Bristles;
use crate::scalar::Scalar;

/// Friction law, affine in the normal load: `force = viscous * speed + coefficient(speed) * load`,
/// opposite to the motion.
///
/// Source of the special case of Coulomb and viscous friction: Zhang et al. 2018, section 5.1. The
/// result here is a force, not a torque.
#[derive(Clone, Debug, PartialEq)]
pub struct Law<T = f64> {
    /// Kinetic friction coefficient, dimensionless and nonnegative. If the coefficient depends on
    /// speed, this is the limit at high speed; [`Curve::Table`] ignores it.
    pub mu: T,
    /// Viscous coefficient at the sliding surface, N s/m, nonnegative.
    pub viscous: T,
    /// Dependence of the friction coefficient on speed, including the coefficient at rest.
    pub curve: Curve<T>,
    /// Regularisation speed, m/s: the friction coefficient is multiplied by `tanh(speed /
    /// regularisation)` and vanishes at rest, so that the surfaces creep instead of sticking.
    /// `None` for a law without regularisation.
    pub regularisation: Option<T>,
    /// Internal state of the law (bristle deflection); the other fields then describe steady
    /// sliding. `None` for a law without a state.
    pub bristles: Option<Bristles<T>>,
}

/// Dependence of a friction coefficient on the sliding speed.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve<T = f64> {
    /// Same coefficient at all speeds and at rest.
    Constant,
    /// Same coefficient at all nonzero speeds, with a different coefficient at rest.
    Static {
        /// Static friction coefficient.
        mu_static: T,
    },
    /// Stribeck's curve, `mu + (mu_static - mu) exp(-(speed / velocity)^exponent)`; the
    /// exponent is two in most of the literature, and one in the exponential law.
    ///
    /// Source: Armstrong-Hélouvry, Dupont, Canudas de Wit 1994.
    Stribeck {
        /// Static friction coefficient, the limit at vanishing speed.
        mu_static: T,
        /// Stribeck velocity, m/s.
        velocity: T,
        /// Exponent of the speed ratio.
        exponent: Exponent<T>,
    },
    /// Table of speed (m/s) and coefficient, interpolated linearly and constant beyond the last
    /// row. Speeds increase from zero.
    Table(Vec<[T; 2]>),
}

/// Exponent of Stribeck's curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exponent<T = f64> {
    /// Exponent 1: the exponential law.
    One,
    /// Exponent 2: a Gaussian.
    Two,
    /// Any other positive exponent.
    Other(T),
}

/// Friction law evaluated at one speed: `force = coefficient * load + constant`. Each Newton step
/// of the friction coupling is a linear system, because the force is affine in the normal load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resistance<T> {
    /// Friction force per newton of normal load.
    pub coefficient: T,
    /// Friction force at zero normal load, N: the viscous part of a law, nonnegative.
    pub constant: T,
}

impl<T: Scalar> Resistance<T> {
    /// Evaluates Coulomb and viscous friction, with the kinetic coefficient `mu` and the viscous
    /// coefficient `viscous`, N s/m, at the sliding speed `speed`, m/s.
    #[inline]
    pub fn coulomb_viscous(mu: T, viscous: T, speed: T) -> Self {
        Self { coefficient: mu, constant: viscous * speed }
    }

    /// Computes the magnitude of the friction force, N, under the normal load `load`, N.
    #[inline]
    pub fn force(&self, load: T) -> T {
        self.constant + self.coefficient * load
    }
}

impl<T: Scalar> Law<T> {
    /// Creates a law of Coulomb and viscous friction, with the kinetic coefficient `mu`, which is
    /// also the static coefficient, and the viscous coefficient `viscous`, N s/m.
    pub fn coulomb_viscous(mu: T, viscous: T) -> Self {
        Self { mu, viscous, curve: Curve::Constant, regularisation: None, bristles: None }
    }

    /// Evaluates the law at a sliding speed of magnitude `speed`, m/s.
    #[inline]
    pub fn sliding(&self, speed: T) -> Resistance<T> {
        let mut resistance = Resistance::coulomb_viscous(self.mu, self.viscous, speed);
        if !self.is_constant() {
            resistance.coefficient = self.coefficient(speed);
        }
        resistance
    }

    /// Computes the friction coefficient at a sliding speed of magnitude `speed`, m/s. Not inlined,
    /// to keep kernels of dual numbers small.
    pub fn coefficient(&self, speed: T) -> T {
        let coefficient = match &self.curve {
            Curve::Constant | Curve::Static { .. } => self.mu,
            Curve::Stribeck { mu_static, velocity, exponent } => {
                let decay = (-exponent.of(speed / *velocity)).exp();
                self.mu + (*mu_static - self.mu) * decay
            }
            Curve::Table(rows) => interpolated(rows, speed),
        };
        match self.regularisation {
            None => coefficient,
            Some(velocity) => {
                // tanh x = (1 - exp -2x) / (1 + exp -2x), without overflow.
                let decay = (speed * T::from_f64(-2.0) / velocity).exp();
                coefficient * ((T::one() - decay) / (T::one() + decay))
            }
        }
    }

    /// Static friction coefficient: the static friction limit per newton of normal load. Zero for a
    /// regularised law.
    pub fn at_rest(&self) -> T {
        if self.regularisation.is_some() {
            return T::zero();
        }
        match &self.curve {
            Curve::Constant => self.mu,
            Curve::Static { mu_static } | Curve::Stribeck { mu_static, .. } => *mu_static,
            Curve::Table(rows) => rows.first().map_or(self.mu, |row| row[1]),
        }
    }

    /// Returns `true` if the friction coefficient is the same at all speeds and at rest.
    #[inline]
    pub fn is_constant(&self) -> bool {
        matches!(self.curve, Curve::Constant) && self.regularisation.is_none()
    }
}

impl Law {
    /// Returns `true` if friction at vanishing sliding speed equals the static friction limit, so
    /// that friction does not drop at slip onset.
    pub(crate) fn slides_as_at_its_limit(&self) -> bool {
        self.coefficient(0.0) == self.at_rest()
    }

    /// Converts all parameters to constants of another scalar type.
    pub fn lift<T: Scalar>(&self) -> Law<T> {
        let lift = T::from_f64;
        Law {
            mu: lift(self.mu),
            viscous: lift(self.viscous),
            curve: match &self.curve {
                Curve::Constant => Curve::Constant,
                Curve::Static { mu_static } => Curve::Static { mu_static: lift(*mu_static) },
                Curve::Stribeck { mu_static, velocity, exponent } => Curve::Stribeck {
                    mu_static: lift(*mu_static),
                    velocity: lift(*velocity),
                    exponent: match exponent {
                        Exponent::One => Exponent::One,
                        Exponent::Two => Exponent::Two,
                        Exponent::Other(exponent) => Exponent::Other(lift(*exponent)),
                    },
                },
                Curve::Table(rows) => Curve::Table(rows.iter().map(|row| row.map(lift)).collect()),
            },
            regularisation: self.regularisation.map(lift),
            bristles: self.bristles.map(|bristles| bristles.lift()),
        }
    }
}

impl Exponent {
    /// Creates the exponent from its value.
    pub fn new(exponent: f64) -> Self {
        match exponent {
            1.0 => Self::One,
            2.0 => Self::Two,
            other => Self::Other(other),
        }
    }

    /// Value of the exponent.
    pub fn value(self) -> f64 {
        match self {
            Self::One => 1.0,
            Self::Two => 2.0,
            Self::Other(other) => other,
        }
    }
}

impl<T: Scalar> Exponent<T> {
    /// Raises a nonnegative `x` to this power.
    fn of(self, x: T) -> T {
        match self {
            Self::One => x,
            Self::Two => x * x,
            Self::Other(exponent) => {
                // The logarithm of zero would make derivatives NaN.
                let safe = x.if_positive(x, T::one());
                x.if_positive((safe.ln() * exponent).exp(), x * T::zero())
            }
        }
    }
}

/// Interpolates a table linearly at `speed`. The loop visits all rows, because each SIMD lane may
/// need a different row.
fn interpolated<T: Scalar>(rows: &[[T; 2]], speed: T) -> T {
    let mut value = rows.last().map_or(T::zero(), |row| row[1]);
    for (&[speed_0, value_0], &[speed_1, value_1]) in rows.iter().zip(rows.iter().skip(1)).rev() {
        let slope = (value_1 - value_0) / (speed_1 - speed_0);
        value = (speed_1 - speed).if_positive(value_0 + slope * (speed - speed_0), value);
    }
    // Comparisons ignore NaN; the sum propagates NaN.
    value + speed * T::zero()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::{Dual, Lanes};
    use proptest::prelude::*;

    fn law(curve: Curve, regularisation: Option<f64>) -> Law {
        Law { curve, regularisation, ..Law::coulomb_viscous(0.1, 3.0) }
    }

    /// Creates laws that cover all kinds of curves, some of them regularised.
    fn laws() -> Vec<Law> {
        let stribeck = |exponent| Curve::Stribeck {
            mu_static: 0.25,
            velocity: 0.02,
            exponent: Exponent::new(exponent),
        };
        let table = vec![[0.0, 0.3], [0.01, 0.12], [0.05, 0.1], [0.4, 0.2]];
        let mut laws = vec![law(Curve::Constant, None), law(Curve::Constant, Some(0.003))];
        laws.push(law(Curve::Static { mu_static: 0.15 }, None));
        laws.extend([0.7, 1.0, 2.0, 3.5].map(|exponent| law(stribeck(exponent), None)));
        laws.push(law(stribeck(2.0), Some(0.002)));
        laws.push(law(Curve::Table(table), None));
        laws
    }

    #[test]
    fn curves_agree_with_their_formulas() {
        let found = |curve: Curve, speed: f64| law(curve, None).sliding(speed).coefficient;
        let stribeck = |exponent, velocity| Curve::Stribeck { mu_static: 0.3, velocity, exponent };
        // At the Stribeck velocity, 1/e of the difference between static and kinetic coefficient
        // remains, for any exponent.
        let one_over_e = 0.1 + 0.2 / std::f64::consts::E;
        for exponent in [1.0, 2.0, 0.5, 7.0] {
            let curve = stribeck(Exponent::new(exponent), 0.04);
            assert!((found(curve.clone(), 0.04) - one_over_e).abs() < 1e-16);
            assert_eq!(found(curve, 0.0), 0.3);
        }
        // At twice the Stribeck velocity, e^-4 of the difference remains, or e^-2 for the
        // exponential law.
        let (gauss, exponential) = (Exponent::new(2.0), Exponent::new(1.0));
        let expected = [0.1 + 0.2 * 0.018_315_638_888_734_18, 0.1 + 0.2 * 0.135_335_283_236_612_7];
        assert!((found(stribeck(gauss, 0.04), 0.08) - expected[0]).abs() < 1e-16);
        assert!((found(stribeck(exponential, 0.04), 0.08) - expected[1]).abs() < 1e-16);

        let table = Curve::Table(vec![[0.0, 0.3], [0.1, 0.2], [0.3, 0.4]]);
        for (speed, expected) in
            [(0.0, 0.3), (0.05, 0.25), (0.1, 0.2), (0.2, 0.3), (0.3, 0.4), (9.0, 0.4)]
        {
            assert!((found(table.clone(), speed) - expected).abs() < 1e-16, "{speed}");
        }
        assert_eq!(law(table, None).at_rest(), 0.3);

        let tanh = law(Curve::Constant, Some(0.01));
        for speed in [0.0, 1e-4, 0.005, 0.03, 2.0_f64] {
            let expected = 0.1 * (speed / 0.01).tanh();
            assert!((tanh.sliding(speed).coefficient - expected).abs() < 1e-16);
        }
        assert_eq!(tanh.at_rest(), 0.0);
    }

    proptest! {
        /// Checks that eight SIMD lanes yield the same digits as eight single numbers, that dual
        /// numbers yield the derivative with respect to speed, and that no law yields negative
        /// friction.
        #[test]
        fn all_scalars_agree(speeds in prop::array::uniform8(0.0..0.5_f64)) {
            for law in laws() {
                let lanes = law.lift::<Lanes<f64, 8>>().sliding(Lanes(speeds));
                let duals = law.lift::<Dual<f64, 1>>();
                for (lane, &speed) in speeds.iter().enumerate() {
                    let at = |speed| law.sliding(speed);
                    let resistance = at(speed);
                    prop_assert_eq!(lanes.coefficient.0[lane], resistance.coefficient);
                    prop_assert_eq!(lanes.constant.0[lane], resistance.constant);
                    prop_assert!(resistance.coefficient >= 0.0 && resistance.constant >= 0.0);

                    let dual = duals.sliding(Dual::variable(speed, 0));
                    prop_assert_eq!(dual.coefficient.value, resistance.coefficient);
                    let step = 1e-6;
                    let (ahead, behind) = (at(speed + step), at((speed - step).max(0.0)));
                    let near_kink = match &law.curve {
                        Curve::Table(rows) => rows.iter().any(|row| (row[0] - speed).abs() < 2.0 * step),
                        _ => speed < 1e-3,
                    };
                    if !near_kink {
                        let slope = (ahead.coefficient - behind.coefficient) / (2.0 * step);
                        // Error of second-order differences for curves that change within 2 mm/s:
                        // the third derivative is about mu / (2 mm/s)^3, and the step is 1e-6 m/s.
                        let error = (dual.coefficient.slope[0] - slope).abs();
                        prop_assert!(error < 1e-4 * (1.0 + slope.abs()), "{law:?} {speed} {error}");
                    }
                }
            }
        }
    }

    /// Checks that the derivative of the friction coefficient with respect to speed is finite at
    /// zero speed.
    #[test]
    fn no_law_has_an_infinite_slope_at_rest() {
        for law in laws() {
            let dual = law.lift::<Dual<f64, 1>>().sliding(Dual::variable(0.0, 0));
            assert!(dual.coefficient.slope[0].is_finite(), "{law:?}");
        }
    }
}
