//! What friction of a member may be.

use crate::friction::OwnFriction;

/// What kind of law a member obeys.
#[derive(Clone, Debug)]
pub(in crate::forward) enum Kind {
    /// Coulomb's law.
    Dry(Dry),
    /// It slides for sure: the unknown is its load, what it does is in its unit.
    Slides(OwnFriction<f64>),
    /// A smooth law of the rate.
    Smooth(Box<dyn Smooth>),
}

/// Dry friction, with viscous friction beside it.
#[derive(Clone, Copy, Debug)]
pub(in crate::forward) struct Dry {
    /// The coefficient for positive rates.
    pub(in crate::forward) forward: f64,
    /// The coefficient for negative rates.
    pub(in crate::forward) backward: f64,
    /// N s/m.
    pub(in crate::forward) viscous: f64,
}

impl Dry {
    /// The coefficient for this sense.
    pub(in crate::forward) fn coefficient(self, sense: f64) -> f64 {
        if sense < 0.0 { self.backward } else { self.forward }
    }
}

/// Friction as a smooth function of the sliding velocity.
pub(in crate::forward) trait Smooth: std::fmt::Debug {
    /// Friction at the surface under a load.
    fn friction(&self, load: f64, velocity: [f64; 3]) -> [f64; 3];
    fn boxed(&self) -> Box<dyn Smooth>;
}

impl Clone for Box<dyn Smooth> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}
