//! Convergence checks of an inverse-dynamics solution.

use super::Inverse;
use crate::dynamics::interfaces::InterfaceState;
use crate::dynamics::model::Model;
use crate::dynamics::settings::{FrictionMode, Settings};
use crate::parameters::{InterfaceParameters, Parameters};
use crate::scalar::Scalar;

/// Changes of the normal forces below this fraction of the largest normal force count as round-off.
const STAGNATED: f64 = 1e-9;
/// Largest accepted residual of the balance, relative to the largest joint wrench.
pub(in crate::dynamics) const BALANCED: f64 = 1e-9;

impl<T: Scalar> Inverse<T> {
    /// Returns true if the iteration between friction and reactions has converged, and if the
    /// determinants of the balance with and without friction have the same sign. Also returns true
    /// if no iteration is required. If the signs differ, the solution is not connected to the
    /// frictionless solution.
    pub fn friction_settled(&self, settings: &Settings) -> bool {
        if self.mode != FrictionMode::Converged || self.interfaces.states.is_empty() {
            return true;
        }
        let loads = self.interfaces.states.iter().map(|c| c.load.value.largest());
        let largest = loads.fold(0.0, f64::max);
        settings.is_settled(self.friction_change.largest(), largest)
            && (self.orientation() - T::one()).largest() == 0.0
    }

    /// Returns true if the iteration between friction and reactions has converged as far as
    /// round-off permits. Near friction locking the normal forces are large, and the Newton
    /// corrections stop decreasing above the round-off of a single solution.
    pub(in crate::dynamics) fn friction_stagnated(&self) -> bool {
        let loads = self.interfaces.states.iter().map(|c| c.load.value.largest());
        let largest = loads.fold(0.0, f64::max);
        let change = self.friction_change.largest();
        change.is_finite()
            && change <= STAGNATED * largest
            && (self.orientation() - T::one()).largest() == 0.0
    }

    /// Returns true if the balance is satisfied to round-off, and if the reactions are not large
    /// compared with the load. Otherwise the elimination order is not suited to the configuration.
    pub fn is_balanced(&self, model: &Model, parameters: &Parameters<T>) -> bool {
        self.is_balanced_to(BALANCED, model, parameters)
    }

    /// Returns [`Self::is_balanced`] for another tolerance, relative to the largest joint wrench.
    pub(super) fn is_balanced_to(
        &self,
        tolerance: f64,
        model: &Model,
        parameters: &Parameters<T>,
    ) -> bool {
        // With larger growth, fewer than eight digits of a reaction would be accurate.
        const GROWTH: f64 = 1e8;
        let (residual, demanded, carried) =
            self.balance.size_of_residual(&model.balance, parameters);
        // Part of the friction that is independent of the reactions.
        let without_load = |(state, interface): (&InterfaceState<T>, &InterfaceParameters<T>)| {
            state.resistance.force(interface.load.preload).largest()
        };
        let frictions = self.interfaces.states.iter().zip(&parameters.interfaces).map(without_load);
        let demanded = frictions.fold(demanded, f64::max);
        residual.is_finite() && residual <= tolerance * carried && carried <= GROWTH * demanded
    }

    /// Returns the relative sign of the determinants of the balance with and without friction: 1 if
    /// both signs are equal, -1 otherwise. The sign changes where friction locks the mechanism.
    pub fn orientation(&self) -> T {
        self.sign_without * self.sign_with
    }
}
