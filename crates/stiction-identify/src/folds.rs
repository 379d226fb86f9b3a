//! Division of a block of rows into pieces for cross-validation.

use crate::block::Block;
use crate::period::{Period, instants};

/// Division of a block into pieces, each of which is left out once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Folds {
    count: usize,
    /// Number of instants in each piece.
    length: usize,
    /// Period of the motion; `None` if the motion is not repeated.
    period: Option<Period>,
    /// Instant, in the motion that other logs repeat, at which the block begins; zero for a motion of this block alone.
    begin: usize,
}

impl Folds {
    /// Divides a block into `count` pieces of equal length. If the motion is repeated, in this block or in others, each
    /// piece consists of the same part of all repetitions, because each repetition predicts the others.
    pub(crate) fn new(block: &Block, count: usize) -> Self {
        let all = block.repetition().map_or_else(|| instants(&block.channels), |own| own.length);
        let length = all.div_ceil(count).max(1);
        Self { count, length, period: block.period(), begin: block.instant(0) }
    }

    /// Returns the index of the piece that contains the instant `step`.
    pub(crate) fn of(self, step: usize) -> usize {
        let step = self.begin + step;
        match self.period {
            Some(period) => period.part(step, self.count),
            None => (step / self.length).min(self.count - 1),
        }
    }
}
