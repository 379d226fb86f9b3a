//! Friction laws: from sliding speed and load to friction force.

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
    /// Friction force without load, N; it has the sign of the speed.
    pub viscous: T,
}
