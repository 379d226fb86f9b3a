//! Rows of the regression and bounds at rest of one log, for all actuators.

use crate::period::Period;
use crate::repetition::Repetition;
use crate::rows::{Rows, pop, push};
use nalgebra::DMatrix;

/// Bounds on the efforts of one actuator during dwells (periods of standstill), one row for each
/// dwell. The effort that the parameters explain without friction differs from the measured efforts
/// by at most the limit of static friction.
#[derive(Clone, Debug)]
pub struct Dwells {
    /// Effort without friction (rows: dwells) per unit of each parameter (columns).
    pub matrix: DMatrix<f64>,
    /// Static friction limit (rows: dwells) per unit of each parameter (columns), not negative.
    pub limits: DMatrix<f64>,
    /// Least and greatest measured effort minus the effort of the model without friction, N or N m.
    /// Friction that is not estimated raises the least and lowers the greatest value, which relaxes
    /// both inequalities.
    pub bounds: Vec<[f64; 2]>,
}

/// Rows of the regression, and bounds at rest, of one log.
#[derive(Clone, Debug)]
pub struct Block {
    /// Rows of each actuator.
    pub channels: Vec<Rows>,
    /// Bounds at rest for each actuator; empty without dwells.
    pub dwells: Vec<Dwells>,
    /// Number of independent samples per row. It is below one if rows are closer than half a period
    /// of the filter, because such rows partly repeat each other, and one for rows without order in
    /// time.
    pub independence: f64,
    /// Time from row to row, s, if it is known.
    pub spacing: Option<f64>,
    /// Period of the motion if it is repeated.
    period: Option<Period>,
    /// Place in a motion that other logs repeat.
    repetition: Option<Repetition>,
}

impl Block {
    /// Creates the block of a log without bounds at rest, and finds the period of its motion. For
    /// `independence` see [`Self::independence`].
    pub fn new(channels: Vec<Rows>, independence: f64) -> Self {
        // Rows of steady motions are independent and have no order in time.
        let period = if independence < 1.0 { Period::of(&channels) } else { None };
        let dwells = Vec::new();
        Self { channels, dwells, independence, spacing: None, period, repetition: None }
    }

    /// Period of the motion; `None` for a motion that is not repeated.
    pub(crate) fn period(&self) -> Option<Period> {
        self.period
    }

    /// Place in a motion that other logs repeat; `None` for a motion of this log alone.
    pub(crate) fn repetition(&self) -> Option<Repetition> {
        self.repetition
    }

    /// Sets the place in a motion of several logs and the period of this motion.
    pub(crate) fn repeat(&mut self, repetition: Option<Repetition>, period: Option<Period>) {
        (self.repetition, self.period) = (repetition, period);
    }

    /// Returns the instant, in the motion that this log shares with others, of its instant `step`.
    pub(crate) fn instant(&self, step: usize) -> usize {
        self.repetition.map_or(step, |own| own.instant(step))
    }
}

impl Dwells {
    /// Keeps the dwells for whose index `keep` returns true.
    pub fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        let kept: Vec<usize> = (0..self.bounds.len()).filter(|&k| keep(k)).collect();
        self.matrix = self.matrix.select_rows(&kept);
        self.limits = self.limits.select_rows(&kept);
        self.bounds = kept.iter().map(|&k| self.bounds[k]).collect();
    }

    /// Appends the column of a parameter whose effort per unit is `value` in each dwell, and which
    /// has no static friction.
    pub fn push_column(&mut self, value: f64) {
        push(&mut self.matrix, |_| value);
        push(&mut self.limits, |_| 0.0);
    }

    /// Removes the last column of the dwells' matrices.
    pub fn pop_column(&mut self) {
        [&mut self.matrix, &mut self.limits].into_iter().for_each(pop);
    }
}
