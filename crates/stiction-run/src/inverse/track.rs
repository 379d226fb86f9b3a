//! Configurations along a motion, which the scan of the motion stores for the computation of
//! forces.

use stiction_core::dynamics::InverseDynamics;
use stiction_core::kinematics::{State, Target};

/// Configurations at the first samples of a motion. The scan of the motion computes these
/// configurations, and the computation of forces restores them.
#[derive(Debug, Default)]
pub(super) struct Track {
    /// Values of each sample: coordinates, rates and accelerations of the spanning tree.
    numbers: Vec<f64>,
    /// Prescribed coordinates of each sample.
    targets: Vec<Target<f64>>,
    /// Side of each sample, see [`InverseDynamics::side`].
    sides: Vec<Option<f64>>,
    /// Loop-closure error of each sample, m.
    closures: Vec<f64>,
    /// Number of coordinates and number of degrees of freedom of the spanning tree.
    widths: [usize; 2],
    /// Number of prescribed coordinates.
    prescribed: usize,
    is_full: bool,
}

/// Stored configuration of one sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known<'a> {
    /// Coordinates, rates and accelerations of the spanning tree.
    pub(super) state: [&'a [f64]; 3],
    /// Prescribed coordinates.
    pub(super) targets: &'a [Target<f64>],
    /// Sign of the determinant of the loop constraints with locked actuators, see
    /// [`InverseDynamics::side`].
    pub(super) side: Option<f64>,
    /// Loop-closure error, m.
    pub(super) closure: f64,
}

impl Track {
    /// Largest number of stored values, so that the memory use does not grow with the length of a
    /// motion.
    const MOST: usize = 1 << 21;

    fn width(&self) -> usize {
        self.widths[0] + 2 * self.widths[1]
    }

    /// Appends the present configuration of `solver` as that of the next sample.
    pub(super) fn add(&mut self, solver: &mut InverseDynamics) {
        let first = self.numbers.len();
        let State { coordinates, rates, accelerations } = solver.state();
        self.widths = [coordinates.len(), rates.len()];
        self.prescribed = solver.targets().len();
        for part in [coordinates, rates, accelerations] {
            self.numbers.extend_from_slice(part);
        }
        self.targets.extend_from_slice(solver.targets());
        self.closures.push(solver.closure_error());
        // The equations of motion are still factored here, unlike after a return to a stored
        // configuration. A mechanism at rest stays on its side.
        let (before, now) = self.numbers.split_at(first);
        let last = self.sides.last().filter(|_| before.ends_with(now)).copied();
        self.sides.push(last.unwrap_or_else(|| solver.side()));
    }

    /// Appends the configurations of the samples in `other`, which follow those already stored.
    /// Discards these and all later configurations once the storage is full.
    pub(super) fn append(&mut self, other: &Self) {
        if !other.numbers.is_empty() {
            (self.widths, self.prescribed) = (other.widths, other.prescribed);
        }
        let count =
            |track: &Self| track.numbers.len() + 3 * track.targets.len() + 3 * track.sides.len();
        self.is_full |= count(self) + count(other) > Self::MOST;
        if !self.is_full {
            self.numbers.extend_from_slice(&other.numbers);
            self.targets.extend_from_slice(&other.targets);
            self.sides.extend_from_slice(&other.sides);
            self.closures.extend_from_slice(&other.closures);
        }
    }

    /// Returns the configuration of the sample with this index, if the configuration is stored.
    pub(super) fn at(&self, sample: usize) -> Option<Known<'_>> {
        let (width, prescribed) = (self.width(), self.prescribed);
        if width == 0 {
            return None;
        }
        let numbers = self.numbers.get(sample * width..(sample + 1) * width)?;
        let targets = self.targets.get(sample * prescribed..(sample + 1) * prescribed)?;
        let (side, closure) = (*self.sides.get(sample)?, *self.closures.get(sample)?);
        let (coordinates, rest) = numbers.split_at(self.widths[0]);
        let (rates, accelerations) = rest.split_at(self.widths[1]);
        Some(Known { state: [coordinates, rates, accelerations], targets, side, closure })
    }
}
