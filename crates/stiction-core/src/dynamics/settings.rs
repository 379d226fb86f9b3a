//! What is computed, and how accurately.

/// How friction and reactions act on each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum FrictionMode {
    /// Friction loads the joints that make it; solved to round-off.
    #[default]
    Converged,
    /// Friction from the frictionless reactions, once: the way of Zhang et al. 2018.
    OnePass,
    /// No friction.
    Off,
}

/// What is computed, and how accurately.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How friction is coupled.
    pub friction: FrictionMode,
    /// Contacts that slide no faster than this (m/s, at the surface) rest.
    pub rest_speed: f64,
    /// Newton steps for the coupling of friction and reactions, at most.
    pub friction_steps: usize,
    /// The coupling counts as solved when no load changes by more than this part of the largest.
    pub friction_tolerance: f64,
    /// Newton steps for the position, where a kernel finds it by itself.
    pub position_steps: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            friction: FrictionMode::Converged,
            rest_speed: 1e-9,
            friction_steps: 40,
            // Round-off of a solve is some 1e-15; Newton squares the change in each step.
            friction_tolerance: 1e-13,
            position_steps: 3,
        }
    }
}

impl Settings {
    /// Whether a change of loads is round-off, given the largest load. Infinite loads are not
    /// settled.
    pub(super) fn is_settled(&self, change: f64, largest: f64) -> bool {
        change.is_finite() && change <= self.friction_tolerance * largest
    }
}
