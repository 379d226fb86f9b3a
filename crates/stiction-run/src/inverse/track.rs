//! Positions along a motion that two passes share.

/// Positions along a motion, found by a first pass, to which the next pass returns.
#[derive(Debug, Default)]
pub(super) struct Track {
    /// Coordinates of the tree, sample after sample.
    numbers: Vec<f64>,
    /// Number of coordinates.
    width: usize,
    is_full: bool,
}

impl Track {
    /// Largest number of stored coordinates: memory must not grow with the length of a motion.
    const MOST: usize = 1 << 20;

    /// Appends the position of the next sample.
    pub(super) fn add(&mut self, coordinates: &[f64]) {
        self.width = coordinates.len();
        self.numbers.extend_from_slice(coordinates);
    }

    /// Appends the positions of the samples that follow, as long as there is space.
    pub(super) fn append(&mut self, other: &Self) {
        self.width = self.width.max(other.width);
        self.is_full |= self.numbers.len() + other.numbers.len() > Self::MOST;
        if !self.is_full {
            self.numbers.extend_from_slice(&other.numbers);
        }
    }

    /// Coordinates of the tree at a sample, if they are stored.
    pub(super) fn at(&self, sample: usize) -> Option<&[f64]> {
        self.numbers.get(sample * self.width..(sample + 1) * self.width).filter(|q| !q.is_empty())
    }
}
