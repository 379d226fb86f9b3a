//! Whether what was computed is a solution.

use super::Inverse;
use crate::dynamics::interfaces::InterfaceState;
use crate::dynamics::model::Model;
use crate::dynamics::settings::{FrictionMode, Settings};
use crate::parameters::{InterfaceParameters, Parameters};
use crate::scalar::Scalar;

/// Changes of loads below this part of the largest are rounding where they do not fall any more.
pub(in crate::dynamics) const STAGNATED: f64 = 1e-9;

impl<T: Scalar> Inverse<T> {
    /// Whether the coupling of friction and reactions is solved, on the branch that begins at no
    /// friction as far as the determinant's sign tells.
    pub fn friction_settled(&self, settings: &Settings) -> bool {
        if self.mode != FrictionMode::Converged || self.interfaces.states.is_empty() {
            return true;
        }
        let loads = self.interfaces.states.iter().map(|c| c.load.value.largest());
        let largest = loads.fold(0.0, f64::max);
        settings.is_settled(self.friction_change.largest(), largest)
            && (self.orientation() - T::one()).largest() == 0.0
    }

    /// Whether the coupling is solved as far as rounding lets it be: near locking, where loads grow,
    /// Newton's method comes to a stand before its change is that of a single solve.
    pub(in crate::dynamics) fn friction_stagnated(&self) -> bool {
        let loads = self.interfaces.states.iter().map(|c| c.load.value.largest());
        let largest = loads.fold(0.0, f64::max);
        let change = self.friction_change.largest();
        change.is_finite()
            && change <= STAGNATED * largest
            && (self.orientation() - T::one()).largest() == 0.0
    }

    /// Whether the balance holds to round-off and its reactions are in proportion to what is
    /// demanded. If not, the order of elimination does not suit the position.
    pub fn is_balanced(&self, model: &Model, parameters: &Parameters<T>) -> bool {
        // Beyond this growth a reaction keeps fewer than eight digits.
        const GROWTH: f64 = 1e8;
        let (residual, demanded, carried) =
            self.balance.size_of_residual(&model.balance, parameters);
        // What friction asks for whatever the reactions are.
        let without_load = |(state, interface): (&InterfaceState<T>, &InterfaceParameters<T>)| {
            state.resistance.force(interface.load.preload).largest()
        };
        let frictions = self.interfaces.states.iter().zip(&parameters.interfaces).map(without_load);
        let demanded = frictions.fold(demanded, f64::max);
        residual.is_finite() && residual <= 1e-9 * carried && carried <= GROWTH * demanded
    }

    /// One where the balance with friction is connected to that without, minus one where its
    /// determinant changed sign on the way: then friction locks the mechanism.
    pub fn orientation(&self) -> T {
        self.sign_without * self.sign_with
    }
}
