//! Configurations along a motion, which the scan of the motion stores for the computation of
//! forces.

use stiction_core::kinematics::State;

/// Configurations at the first samples of a motion. The scan of the motion computes these
/// configurations, and the computation of forces restores them.
#[derive(Debug, Default)]
pub(super) struct Track {
    /// Values of each sample: coordinates, rates and accelerations of the spanning tree, followed
    /// by the sign of the determinant of the loop constraints with locked actuators; NaN if the
    /// sign is undetermined.
    numbers: Vec<f64>,
    /// Number of coordinates and number of degrees of freedom of the spanning tree.
    widths: [usize; 2],
    is_full: bool,
}

/// Stored configuration of one sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known<'a> {
    /// Coordinates, rates and accelerations of the spanning tree.
    pub(super) state: [&'a [f64]; 3],
    /// Sign of the determinant of the loop constraints with locked actuators, see
    /// [`InverseDynamics::side`](stiction_core::dynamics::InverseDynamics::side).
    pub(super) side: Option<f64>,
}

impl Track {
    /// Largest number of stored values, so that the memory use does not grow with the length of a
    /// motion.
    const MOST: usize = 1 << 21;

    fn width(&self) -> usize {
        self.widths[0] + 2 * self.widths[1] + 1
    }

    /// Appends the configuration of the next sample.
    pub(super) fn add(&mut self, state: &State<f64>, side: Option<f64>) {
        let State { coordinates, rates, accelerations } = state;
        self.widths = [coordinates.len(), rates.len()];
        for part in [coordinates, rates, accelerations] {
            self.numbers.extend_from_slice(part);
        }
        self.numbers.push(side.unwrap_or(f64::NAN));
    }

    /// Appends the configurations of the samples in `other`, which follow those already stored.
    /// Discards these and all later configurations once the storage is full.
    pub(super) fn append(&mut self, other: &Self) {
        if !other.numbers.is_empty() {
            self.widths = other.widths;
        }
        self.is_full |= self.numbers.len() + other.numbers.len() > Self::MOST;
        if !self.is_full {
            self.numbers.extend_from_slice(&other.numbers);
        }
    }

    /// Returns the configuration of the sample with this index, if the configuration is stored.
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
