//! Positions along a motion that two passes share.

use stiction_core::kinematics::State;

/// Positions along a motion, found by a first pass, to which the next pass returns.
#[derive(Debug, Default)]
pub(super) struct Track {
    /// Numbers of the positions, sample after sample: coordinates, rates and accelerations of the tree,
    /// then the side of singular positions.
    numbers: Vec<f64>,
    /// Numbers of coordinates and of DOFs.
    widths: [usize; 2],
    is_full: bool,
}

/// Position at a sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known<'a> {
    /// Coordinates, rates and accelerations of the tree.
    pub(super) state: [&'a [f64]; 3],
    /// See [`InverseDynamics::side`](stiction_core::dynamics::InverseDynamics::side).
    pub(super) side: Option<f64>,
}

impl Track {
    /// Largest number of stored numbers: memory must not grow with the length of a motion.
    const MOST: usize = 1 << 21;

    fn width(&self) -> usize {
        self.widths[0] + 2 * self.widths[1] + 1
    }

    /// Appends the position of the next sample.
    pub(super) fn add(&mut self, state: &State<f64>, side: Option<f64>) {
        let State { coordinates, rates, accelerations } = state;
        self.widths = [coordinates.len(), rates.len()];
        for part in [coordinates, rates, accelerations] {
            self.numbers.extend_from_slice(part);
        }
        self.numbers.push(side.unwrap_or(f64::NAN));
    }

    /// Appends the positions of the samples that follow, as long as there is space.
    pub(super) fn append(&mut self, other: &Self) {
        if !other.numbers.is_empty() {
            self.widths = other.widths;
        }
        self.is_full |= self.numbers.len() + other.numbers.len() > Self::MOST;
        if !self.is_full {
            self.numbers.extend_from_slice(&other.numbers);
        }
    }

    /// Position at a sample, if it is stored.
    pub(super) fn at(&self, sample: usize) -> Option<Known<'_>> {
        let width = self.width();
        let numbers = self.numbers.get(sample * width..(sample + 1) * width)?;
        let (coordinates, rest) = numbers.split_at(self.widths[0]);
        let (rates, rest) = rest.split_at(self.widths[1]);
        let (accelerations, side) = rest.split_at(self.widths[1]);
        let side = side.first().copied().filter(|side| !side.is_nan());
        Some(Known { state: [coordinates, rates, accelerations], side })
    }
}
