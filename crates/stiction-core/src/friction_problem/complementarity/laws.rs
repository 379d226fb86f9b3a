//! Friction laws of the interfaces in a complementarity problem.

use crate::friction::OwnFriction;

/// Friction law of a member, that is, of one interface in the problem.
#[derive(Clone, Debug)]
pub(crate) enum MemberLaw {
    /// Coulomb's law: stick or slip.
    Dry(DryFriction),
    /// Slip that is certain in advance: the unknown is the normal load, and the influence of friction is per
    /// newton of normal load.
    Sliding(OwnFriction<f64>),
    /// Friction as a smooth function of the rate.
    Smooth(Box<dyn SmoothFriction>),
}

/// Coulomb friction with viscous friction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DryFriction {
    /// Coefficient for positive rates.
    pub(crate) forward: f64,
    /// Coefficient for negative rates.
    pub(crate) backward: f64,
    /// Viscous friction, N s/m.
    pub(crate) viscous: f64,
}

impl DryFriction {
    /// Coefficient for a rate of this sign.
    pub(crate) fn coefficient(self, sign: f64) -> f64 {
        if sign < 0.0 { self.backward } else { self.forward }
    }
}

/// Friction as a smooth function of the sliding velocity.
pub(crate) trait SmoothFriction: std::fmt::Debug {
    /// Friction at the surface, N, under a normal load (N) at a velocity (m/s).
    fn friction(&self, load: f64, velocity: [f64; 3]) -> [f64; 3];

    /// A boxed clone.
    fn boxed(&self) -> Box<dyn SmoothFriction>;
}

impl Clone for Box<dyn SmoothFriction> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}
