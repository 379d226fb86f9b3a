//! Friction laws of the interfaces in a complementarity problem.

use crate::friction::OwnFriction;

/// Friction law of a member (one interface of the complementarity problem).
#[derive(Clone, Debug)]
pub(crate) enum MemberLaw {
    /// Coulomb and viscous friction; the solver determines whether the interface sticks or slips.
    Dry(DryFriction),
    /// Friction of an interface that slides in a known direction. The unknown of this interface is
    /// its normal load, so the influence of the interface on rates and wrenches is stored per
    /// newton of normal load.
    Sliding(OwnFriction<f64>),
    /// Friction as a smooth function of the sliding velocity.
    Smooth(Box<dyn SmoothFriction>),
}

/// Coulomb and viscous friction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DryFriction {
    /// Friction coefficient for positive surface rates.
    pub(crate) forward: f64,
    /// Friction coefficient for negative surface rates.
    pub(crate) backward: f64,
    /// Viscous friction coefficient at the sliding surface, N s/m.
    pub(crate) viscous: f64,
}

impl DryFriction {
    /// Friction coefficient for a surface rate of the given sign.
    pub(crate) fn coefficient(self, sign: f64) -> f64 {
        if sign < 0.0 { self.backward } else { self.forward }
    }
}

/// Friction law that is a smooth function of the sliding velocity.
pub(crate) trait SmoothFriction: std::fmt::Debug {
    /// Computes the friction at the surface, N, under a normal load (N) at a sliding velocity
    /// (m/s).
    fn friction(&self, load: f64, velocity: [f64; 3]) -> [f64; 3];

    /// Clones the law into a new box.
    fn boxed(&self) -> Box<dyn SmoothFriction>;
}

impl Clone for Box<dyn SmoothFriction> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}
