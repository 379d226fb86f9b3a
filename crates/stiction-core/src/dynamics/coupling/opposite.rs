//! Friction and efforts in the opposite motion, for the backward efficiency.

use super::settle::Start;
use super::{Acting, FrictionCoupling, Sense};
use crate::dynamics::interfaces::InterfaceState;
use crate::friction_problem::normal_load::Configuration;
use crate::parameters::InterfaceParameters;

impl Acting {
    /// Creates the friction that acts at an interface in the opposite motion. An interface at rest
    /// has no friction.
    fn reversed(state: &InterfaceState<f64>, interface: &InterfaceParameters<f64>) -> Self {
        let reversed = state.reversed(interface);
        let parts = if state.sliding > 0.0 { [-1.0, 0.0, 0.0] } else { [0.0; 3] };
        Self { resistance: reversed.resistance, sense: reversed.sense, parts }
    }
}

impl FrictionCoupling {
    /// Computes the efforts in the opposite motion, N or N m, at the configuration, accelerations
    /// and loads of the present motion. `None` if the efforts may not be unique, if Newton's method
    /// fails, or if no responses are stored.
    pub(in crate::dynamics) fn reversed_efforts(
        &mut self,
        states: &[InterfaceState<f64>],
        at: Configuration<'_>,
    ) -> Option<Vec<f64>> {
        if !(self.is_current && self.is_stored) {
            return None;
        }
        let interfaces = &at.parameters.interfaces;
        let reversed = states.iter().zip(interfaces).map(|(s, i)| Acting::reversed(s, i));
        let is_constant = |interface: &InterfaceParameters<f64>| {
            interface.law.is_constant() && interface.backward.is_none()
        };
        if self.is_present && interfaces.iter().all(is_constant) {
            // All friction coefficients are the same in both directions.
            self.reverse(reversed, at);
        } else {
            self.act(reversed, at);
        }
        // With a separate friction law for backward sliding, the opposite motion has different
        // coefficients.
        let has_other_law = interfaces.iter().any(|interface| interface.backward.is_some());
        if has_other_law {
            self.strength = self.coupling_bound(at, None, Sense::Opposite);
            if self.strength >= 1.0 {
                return None;
            }
        }
        let settled = self.settle(at, Start::Opposite(states));
        let efforts = (0..self.efforts.len()).map(|actuator| self.effort(actuator));
        settled.then(|| efforts.collect())
    }

    /// Reverses the friction set by [`Self::act`]. `acting` is the friction in the opposite motion,
    /// which must have the same magnitudes.
    fn reverse(&mut self, acting: impl Iterator<Item = Acting>, at: Configuration<'_>) {
        self.acting.clear();
        self.acting.extend(acting);
        self.constant_changes.iter_mut().for_each(|change| *change = -*change);
        self.add_unknowns(at);
        self.problem.reverse_influence();
        self.is_present = false;
    }
}
