//! Instants at which the uniqueness bound of the normal loads is computed.
//!
//! The bound needs the responses to all unit frictions, which cost more than an evaluation of
//! accelerations. Its value changes gradually with the configuration, so a bound far below one need
//! not be computed again in every step.

use super::Simulation;
use crate::forward::Forward;
use crate::forward::coupling::CERTAIN;
use crate::forward::instant::Instant;
use crate::friction::Curve;

/// Motion after which the bound is computed again, rad or characteristic lengths, at singularity
/// indices up to [`CLOSE`]. Responses change with the motion in inverse proportion to the index, so
/// this motion grows with the index, up to [`FAR`] times.
const LITTLE: f64 = 0.01;
const CLOSE: f64 = 0.1;
/// Largest factor of [`LITTLE`], at singularity indices above half.
const FAR: f64 = 5.0;
/// Largest factor by which this motion grows further where the bound changes slowly: the expected
/// change is at most the part [`EXPECTED`] of the distance of the bound from one.
const STEADY: f64 = 4.0;
const EXPECTED: f64 = 0.25;
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
        self.motion_since_bound > self.bound_reach * self.little()
            || self.now.coupling.is_none_or(|bound| bound > CERTAIN)
            || self.model.has_variable_coefficients()
    }

    /// Counts the largest turn, rad, of a direction of slip of a ball or plate as motion.
    pub(super) fn count_turn(&mut self, turn: f64) {
        self.motion_since_bound += turn * (self.bound_reach * self.little() / LITTLE_TURN);
    }

    /// Counts motion from the present instant on, whose modes or inertias are others than before.
    pub(super) fn restart_bound(&mut self) {
        (self.motion_since_bound, self.bound_reach) = (0.0, 1.0);
    }

    /// Returns the motion after which the bound is computed again, rad or characteristic lengths.
    fn little(&self) -> f64 {
        LITTLE * (self.now.distance / CLOSE).clamp(1.0, FAR)
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
        if let Some(bound) = arrived.coupling.filter(|_| self.needs_bound()) {
            let change = self.now.coupling.map_or(f64::INFINITY, |before| (bound - before).abs());
            let allowed = EXPECTED * (1.0 - bound) * self.motion_since_bound;
            let reach = allowed / (change * self.little());
            self.bound_reach = if reach.is_nan() { 1.0 } else { reach.clamp(1.0, STEADY) };
            self.motion_since_bound = 0.0;
            return;
        }
        let each = arrived.state.rates.iter().zip(&self.model.columns);
        let fastest = each.map(|(rate, column)| (rate / column).abs()).fold(0.0, f64::max);
        self.motion_since_bound += fastest * (arrived.time - self.now.time).abs();
    }
}
