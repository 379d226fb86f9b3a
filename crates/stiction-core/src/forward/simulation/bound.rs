//! Instants at which the uniqueness bound of the normal loads is computed.
//!
//! The bound needs the responses to all unit frictions, which cost more than an evaluation of
//! accelerations. Its value changes gradually with the configuration, so a bound far below one need
//! not be computed again in every step.

use super::Simulation;
use crate::forward::Forward;
use crate::forward::affine_friction::norm;
use crate::forward::coupling::CERTAIN;
use crate::forward::instant::Instant;
use crate::friction::Curve;

/// Motion after which the bound is computed again, rad or characteristic lengths.
const LITTLE: f64 = 0.01;
/// Turn of a direction of slip after which the bound is computed again, rad.
const LITTLE_TURN: f64 = 0.1;

impl Forward {
    /// Returns true if a coefficient of friction depends on the speed, or on bristles.
    fn has_variable_coefficients(&self) -> bool {
        let mut laws = self.parameters.interfaces.iter().flat_map(|interface| interface.laws());
        laws.any(|law| {
            let varies = matches!(law.curve, Curve::Stribeck { .. } | Curve::Table(_));
            varies || law.bristles.is_some() || law.regularisation.is_some()
        })
    }
}

impl Simulation<'_> {
    /// Returns true if the bound must be computed at the next instant: the last bound is close to
    /// one or unknown, the mechanism has moved since, or coefficients of friction change with the
    /// speed or with bristles.
    pub(super) fn needs_bound(&self) -> bool {
        self.motion_since_bound > LITTLE
            || self.now.coupling.is_none_or(|bound| bound > CERTAIN)
            || self.model.has_variable_coefficients()
    }

    /// Counts the change between two directions of slip of a ball or plate as motion.
    pub(super) fn count_turn(&mut self, from: [f64; 3], to: [f64; 3]) {
        let turn = norm([0, 1, 2].map(|i| to[i] - from[i]));
        self.motion_since_bound += turn * (LITTLE / LITTLE_TURN);
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
