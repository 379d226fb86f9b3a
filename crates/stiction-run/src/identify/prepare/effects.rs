//! Regressor signals of effects on the efforts that a model may lack.
//!
//! The statistical test of a signal is equation (I7) of the book's theory.

use super::Prepared;
use nalgebra::DVector;

/// Effect on the effort of an actuator that a model may lack. Unless stated otherwise, the
/// regressor signal of an effect is dimensionless with a magnitude of at most about one, so that
/// its coefficient is an effort, N or N m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) enum Effect {
    /// Constant error of the effort.
    Offset,
    /// Delay of the effort relative to the positions; the coefficient of this effect is a time, s.
    Delay,
    /// Additional friction at low speed. The number is the speed at which the additional friction
    /// has decreased to 1/e, as a fraction of the highest speed in the log.
    SlowFriction(f64),
    /// Friction that grows with the square of the rate.
    FastFriction,
    /// Effort proportional to the sine of the actuator's angle or, for a displacement, to the
    /// distance from the middle of its range in the log.
    Position,
    /// Effort proportional to the cosine of the actuator's angle or, for a displacement, to the
    /// squared distance from the middle of its range in the log.
    PositionSquare,
    /// Friction that changes in proportion to the distance of the position from the middle of its
    /// range in the log.
    PositionFriction,
    /// Friction proportional to the magnitude of the frictionless effort.
    LoadFriction,
    /// Friction independent of speed (Coulomb friction) that drifts linearly with time during the
    /// log.
    FrictionDrift,
    /// Viscous friction that drifts linearly with time during the log.
    ViscousDrift,
    /// Error of the measured effort that drifts linearly with time during the log.
    EffortDrift,
}

/// Speeds at which the additional friction of [`Effect::SlowFriction`] has decreased to 1/e, as
/// fractions of the highest speed in the log.
const SLOW: [f64; 2] = [0.05, 0.2];

/// Effects whose signals are nonlinear functions of the motion. These signals are computed at each
/// instant and then filtered like the efforts.
pub(super) const FILTERED: [Effect; 7] = [
    Effect::SlowFriction(SLOW[0]),
    Effect::SlowFriction(SLOW[1]),
    Effect::FastFriction,
    Effect::Position,
    Effect::PositionSquare,
    Effect::PositionFriction,
    Effect::LoadFriction,
];

/// All effects, in the order of increasing complexity.
pub(in crate::identify) const ALL: [Effect; 12] = [
    Effect::Offset,
    Effect::Delay,
    Effect::SlowFriction(SLOW[0]),
    Effect::SlowFriction(SLOW[1]),
    Effect::FastFriction,
    Effect::Position,
    Effect::PositionSquare,
    Effect::PositionFriction,
    Effect::LoadFriction,
    Effect::FrictionDrift,
    Effect::ViscousDrift,
    Effect::EffortDrift,
];

/// Motion and frictionless effort of one actuator at an instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    pub(super) direction: f64,
    pub(super) rate: f64,
    /// Position of the actuator, rad or m; `None` if the actuator's coordinate is not prescribed.
    pub(super) position: Option<f64>,
    /// Effort of the actuator in the model without friction, N or N m.
    pub(super) known: f64,
}

/// Scales of the motion and the effort of an actuator in a log, which make the signals of effects
/// dimensionless.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    rate: f64,
    middle: f64,
    half_range: f64,
    known: f64,
    is_angle: bool,
}

impl Scales {
    pub(super) fn of(states: &[State], is_angle: bool) -> Self {
        let largest = |pick: fn(&State) -> f64| {
            states.iter().map(|state| pick(state).abs()).fold(0.0, f64::max).max(1e-300)
        };
        let positions = || states.iter().filter_map(|state| state.position);
        let (low, high) = positions()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| (low.min(q), high.max(q)));
        let is_moving = high > low;
        Self {
            rate: largest(|state| state.rate),
            middle: if is_moving { 0.5 * (low + high) } else { 0.0 },
            half_range: if is_moving { 0.5 * (high - low) } else { f64::INFINITY },
            known: largest(|state| state.known),
            is_angle,
        }
    }

    /// Computes the unfiltered signals of the effects in [`FILTERED`] at an instant.
    pub(super) fn signals(&self, state: &State) -> [f64; FILTERED.len()] {
        let State { direction, known, .. } = *state;
        let speed = state.rate / self.rate;
        let distance = state.position.map_or(0.0, |q| (q - self.middle) / self.half_range);
        let angle = state.position.filter(|_| self.is_angle && self.half_range.is_finite());
        FILTERED.map(|effect| match effect {
            Effect::SlowFriction(part) => direction * (-(speed / part).powi(2)).exp(),
            Effect::FastFriction => speed * speed.abs(),
            Effect::Position => angle.map_or(distance, f64::sin),
            Effect::PositionSquare => angle.map_or(distance * distance, f64::cos),
            Effect::PositionFriction => direction * distance,
            Effect::LoadFriction => direction * (known / self.known).abs(),
            _ => 0.0,
        })
    }
}

impl Prepared {
    /// Computes the signal of an effect in the regression rows of an actuator. `None` if the signal
    /// cannot be computed for these rows, or is constant and therefore cannot be distinguished from
    /// an offset.
    pub(in crate::identify) fn effect(
        &self,
        channel: usize,
        effect: Effect,
    ) -> Option<DVector<f64>> {
        let rows = &self.block.channels[channel];
        let directions = &self.directions[channel];
        let fastest = directions.iter().map(|[_, rate]| rate.abs()).fold(0.0, f64::max).max(1e-300);
        let (first, last) = (self.times.first()?, self.times.last()?);
        let (middle, half) = (0.5 * (first + last), 0.5 * (last - first));
        let elapsed = |row: usize| (self.times[rows.steps[row]] - middle) / half.max(1e-300);
        let each =
            |signal: &dyn Fn(usize) -> f64| DVector::from_fn(rows.len(), |row, _| signal(row));
        // A drift depends on time, which rows of steady motions do not have.
        let is_recorded = self.cutoff.is_some();
        let signal = match effect {
            Effect::Offset => each(&|_| 1.0),
            Effect::Delay => {
                self.efforts.as_ref()?.slope(channel, &rows.steps, &self.times)? * -1.0
            }
            Effect::FrictionDrift if is_recorded => each(&|row| directions[row][0] * elapsed(row)),
            Effect::ViscousDrift if is_recorded => {
                each(&|row| directions[row][1] / fastest * elapsed(row))
            }
            Effect::EffortDrift if is_recorded => each(&elapsed),
            Effect::FrictionDrift | Effect::ViscousDrift | Effect::EffortDrift => return None,
            filtered => {
                let place = FILTERED.iter().position(|own| *own == filtered)?;
                each(&|row| self.effects[channel][row][place])
            }
        };
        // A constant signal cannot be distinguished from an offset.
        let changes = || signal.max() - signal.min() > 1e-6 * signal.amax();
        (effect == Effect::Offset || (!signal.is_empty() && changes())).then_some(signal)
    }
}
