//! Friction that acts at an interface.

use crate::dynamics::interfaces::InterfaceState;
use crate::friction::Resistance;

/// Friction that acts at one interface.
#[derive(Clone, Copy, Debug)]
pub(in crate::dynamics) struct Acting {
    pub(in crate::dynamics) resistance: Resistance<f64>,
    pub(in crate::dynamics) sense: f64,
    /// Components of the friction along the DOFs of an interface at rest, as fractions of the
    /// friction force. The first component is 1 for a sliding interface, and -1 for one in the
    /// opposite motion.
    pub(in crate::dynamics) parts: [f64; 3],
}

impl Acting {
    /// Creates the kinetic friction of a sliding interface or, for an interface at rest, the static
    /// friction with the components `held` (fractions of the friction limit).
    pub(in crate::dynamics) fn of(state: &InterfaceState<f64>, held: [f64; 3]) -> Self {
        let slides = state.sliding > 0.0;
        let parts = if slides { [1.0, 0.0, 0.0] } else { held };
        Self { resistance: state.resistance, sense: state.sense, parts }
    }

    pub(in crate::dynamics) fn is_coupled(&self) -> bool {
        self.resistance.coefficient > 0.0 && self.parts != [0.0; 3]
    }
}
