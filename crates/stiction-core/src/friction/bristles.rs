//! Friction laws with an internal state: Dahl's law and the LuGre model.
//!
//! Equation (L2) of the book.

use crate::scalar::Scalar;

/// Bristles between two surfaces. Their mean deflection `z` is the internal state:
///
/// ```text
/// dz/dt = v - stiffness |v| z / mu(v)
/// force = load (stiffness z + damping dz/dt) + viscous v
/// ```
///
/// with the sliding velocity `v` and the speed-dependent coefficient `mu(v)` of the law. Without
/// damping and with a constant coefficient, this is Dahl's law. At constant velocity and load,
/// `stiffness z` converges to `mu(v) sgn v` for any stiffness. Steady friction therefore follows
/// `mu(v)`, and inverse dynamics uses this steady value.
///
/// Stiffness and damping are per newton of normal load, so friction vanishes together with the
/// normal load. Divide data-sheet values in N/m and N s/m at a constant load by that load.
///
/// Sources: P. R. Dahl 1968 (A solid friction model, The Aerospace Corporation); Canudas de Wit,
/// Olsson, Åström, Lischinsky 1995 (IEEE Transactions on Automatic Control 40(3), 419-425); the form
/// with the normal load as a factor: Canudas de Wit, Tsiotras, Velenis, Basset, Gissinger 2003 (Vehicle
/// System Dynamics 39(3), 189-226).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bristles<T = f64> {
    /// Stiffness per newton of normal load, 1/m, positive (`sigma0`).
    pub stiffness: T,
    /// Damping per newton of normal load, s/m, nonnegative (`sigma1`); zero in Dahl's law.
    pub damping: T,
}

impl<T: Scalar> Bristles<T> {
    /// Computes the rate, m/s, of the deflection `z`, m, at a sliding velocity, m/s; `mu` is the
    /// positive friction coefficient at this velocity.
    #[inline]
    pub fn rate(&self, z: T, velocity: T, mu: T) -> T {
        velocity - self.stiffness * velocity.abs() * z / mu
    }

    /// Computes the friction force per newton of normal load, without the viscous part, for the
    /// deflection `z`, m, and its `rate`, m/s. The sign is that of the velocity that the friction
    /// opposes.
    #[inline]
    pub fn coefficient(&self, z: T, rate: T) -> T {
        self.stiffness * z + self.damping * rate
    }

    /// Computes the steady deflection, m, at a sliding velocity, m/s, with the friction coefficient
    /// `mu`. Returns zero at zero velocity.
    #[inline]
    pub fn steady(&self, velocity: T, mu: T) -> T {
        let size = mu / self.stiffness;
        velocity.if_positive(size, velocity.abs().if_positive(-size, T::zero()))
    }
}

impl Bristles {
    /// Converts stiffness and damping to constants of another scalar type.
    pub fn lift<T: Scalar>(self) -> Bristles<T> {
        Bristles { stiffness: T::from_f64(self.stiffness), damping: T::from_f64(self.damping) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::{Dual, Lanes};

    #[test]
    fn steady_bristles_agree_with_the_curve() {
        for damping in [0.0, 30.0] {
            let bristles = Bristles { stiffness: 2e5, damping };
            for (velocity, mu) in [(0.3, 0.1), (-0.02, 0.25), (1e-9, 0.4)] {
                let z = bristles.steady(velocity, mu);
                let rate = bristles.rate(z, velocity, mu);
                assert!(rate.abs() < 1e-15 * velocity.abs());
                let coefficient = bristles.coefficient(z, rate);
                assert!((coefficient - mu.copysign(velocity)).abs() < 1e-15);
            }
        }
    }

    /// Checks that Dahl's friction follows `mu (1 - exp(-stiffness x / mu))` as a function of the
    /// displacement `x` from rest, at any speed. The rate of the deflection is integrated by the
    /// fourth-order Runge-Kutta method in SIMD lanes of dual numbers.
    #[test]
    fn dahl_rises_exponentially_with_displacement() {
        type S = Dual<Lanes<f64, 2>, 1>;
        let (mu, stiffness, steps) = (0.2, 1e4, 400);
        let bristles = Bristles { stiffness, damping: 0.0 }.lift::<S>();
        let speeds = S::constant(Lanes([1e-3, 0.7]));
        let (mu_s, way) = (S::from_f64(mu), 5e-5);
        let step = S::from_f64(way / f64::from(steps)) / speeds;
        let (half, sixth) = (S::from_f64(0.5), S::from_f64(1.0 / 6.0));
        let rate = |z: S| bristles.rate(z, speeds, mu_s);
        let mut z = S::variable(Lanes::from_f64(0.0), 0);
        for _ in 0..steps {
            let k1 = rate(z);
            let k2 = rate(z + step * half * k1);
            let k3 = rate(z + step * half * k2);
            let k4 = rate(z + step * k3);
            z += step * sixth * (k1 + (k2 + k3) * S::from_f64(2.0) + k4);
        }
        let left = (-stiffness * way / mu).exp();
        for lane in 0..2 {
            // The method's error is of the order (2.5 / 400)^4 = 1.5e-9.
            let found = bristles.coefficient(z, rate(z)).value.0[lane];
            assert!((found - mu * (1.0 - left)).abs() < 1e-9, "{found}");
            // The slope is the fraction that remains of a small initial deflection.
            assert!((z.slope[0].0[lane] - left).abs() < 1e-8);
        }
    }
}
