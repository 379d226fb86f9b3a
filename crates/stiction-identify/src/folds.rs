//! Division of a block of rows into pieces for cross-validation.

use crate::block::Block;
use crate::period::Period;
use crate::repetition::Repetition;

/// Division of a block into pieces, each of which is left out once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Folds {
    count: usize,
    /// Number of instants in each piece.
    length: usize,
    /// Period of the motion; `None` if the motion is not repeated.
    period: Option<Period>,
    /// Place in a motion that other logs repeat.
    repetition: Option<Repetition>,
}

impl Folds {
    /// Divides a block into `count` pieces of equal length. If the motion is repeated, in this block or in others, each
    /// piece consists of the same part of all repetitions, because each repetition predicts the others.
    pub(crate) fn new(block: &Block, count: usize) -> Self {
        let last = block.channels.iter().filter_map(|rows| rows.steps.last()).max();
        let repetition = block.repetition();
        let all = repetition.map_or(last.map_or(1, |last| last + 1), |own| own.length);
        let length = all.div_ceil(count).max(1);
        Self { count, length, period: block.period(), repetition }
    }

    /// Returns the index of the piece that contains the instant `step`.
    pub(crate) fn of(self, step: usize) -> usize {
        let step = self.repetition.map_or(step, |own| own.instant(step));
        match self.period {
            Some(period) => period.part(step, self.count),
            None => (step / self.length).min(self.count - 1),
        }
    }
}
