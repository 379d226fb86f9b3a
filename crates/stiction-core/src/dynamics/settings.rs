//! Friction mode, tolerances and iteration limits of inverse dynamics.

/// Method of coupling friction and reactions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum FrictionMode {
    /// Friction and reactions are solved simultaneously, to round-off.
    #[default]
    Converged,
    /// Friction is computed once, from the frictionless reactions (decoupled, as in Zhang et al.
    /// 2018).
    OnePass,
    /// No friction.
    Off,
}

/// Friction mode, tolerances and iteration limits of inverse dynamics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Method of coupling friction and reactions.
    pub friction: FrictionMode,
    /// Sliding speed at the surface, m/s, up to which a friction interface counts as at rest.
    pub rest_speed: f64,
    /// Largest number of Newton steps of the iteration between friction and reactions.
    pub friction_steps: usize,
    /// Relative tolerance of the coupled solution: the largest change of a normal force in one
    /// Newton step, divided by the largest normal force.
    pub friction_tolerance: f64,
    /// Number of Newton steps to close the loops in [`Model::evaluate`](super::Model::evaluate).
    pub position_steps: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            friction: FrictionMode::Converged,
            rest_speed: 1e-9,
            friction_steps: 40,
            // Round-off of a solution is about 1e-15; Newton's method squares the relative change
            // in each step.
            friction_tolerance: 1e-13,
            position_steps: 3,
        }
    }
}

impl Settings {
    /// Returns true if the change of the normal forces is at most the tolerance times the largest
    /// normal force. Returns false for infinite normal forces.
    pub(super) fn is_settled(&self, change: f64, largest: f64) -> bool {
        change.is_finite() && change <= self.friction_tolerance * largest
    }
}
