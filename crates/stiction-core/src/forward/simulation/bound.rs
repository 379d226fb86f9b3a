//! Instants at which the uniqueness bound of the normal loads is computed.
//!
//! The bound needs the responses to all unit frictions, which cost more than an evaluation of
//! accelerations. Its value changes gradually with the configuration, so a bound far below one need
//! not be computed again in every step.

use super::Simulation;
use crate::forward::coupling::CERTAIN;
use crate::forward::instant::Instant;

/// Motion after which the bound is computed again, rad or characteristic lengths.
const LITTLE: f64 = 0.01;

impl Simulation<'_> {
    /// Returns true if the bound must be computed at the next instant: the last bound is close to
    /// one, unknown, or the mechanism has moved since.
    pub(super) fn needs_bound(&self) -> bool {
        self.motion_since_bound > LITTLE || self.now.coupling.is_none_or(|bound| bound > CERTAIN)
    }

    /// Adopts the last bound for an instant for which none was computed.
    pub(super) fn keep_bound(&self, at: &mut Instant) {
        if at.coupling.is_none() && !self.needs_bound() {
            at.coupling = self.now.coupling;
        }
    }

    /// Adds the motion of the step that ends at `arrived`, or starts anew if the bound was computed
    /// there. Called before the step is accepted.
    pub(super) fn count_motion(&mut self, arrived: &Instant) {
        if arrived.coupling.is_some() && self.needs_bound() {
            self.motion_since_bound = 0.0;
            return;
        }
        let each = arrived.state.rates.iter().zip(&self.model.columns);
        let fastest = each.map(|(rate, column)| (rate / column).abs()).fold(0.0, f64::max);
        self.motion_since_bound += fastest * (arrived.time - self.now.time).abs();
    }
}
