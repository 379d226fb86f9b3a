//! Friction laws: from sliding speed and load to friction force.

use crate::scalar::Scalar;

/// Coulomb and viscous friction: `force = viscous * speed + coulomb * load * sgn(speed)`.
///
/// Source: Zhang et al. 2018, section 5.1, with the force (not a torque) as its result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Coefficient of friction, dimensionless, not negative.
    pub coulomb: f64,
    /// Viscous coefficient at the sliding surface, N s/m, not negative.
    pub viscous: f64,
}

/// What a law says at one speed. Every law is affine in the load, which is what lets the coupling
/// of friction and reactions be solved by Newton steps of linear systems.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resistance<T> {
    /// Friction force for each newton of load.
    pub coefficient: T,
    /// Friction force without load, N, not negative.
    pub viscous: T,
}

impl<T: Scalar> Resistance<T> {
    /// Coulomb and viscous friction at a sliding speed of magnitude `speed`, m/s.
    #[inline(always)]
    pub fn coulomb_viscous(coulomb: T, viscous: T, speed: T) -> Self {
        Self { coefficient: coulomb, viscous: viscous * speed }
    }

    /// The magnitude of the friction force under a load, N.
    #[inline(always)]
    pub fn force(&self, load: T) -> T {
        self.viscous + self.coefficient * load
    }
}
