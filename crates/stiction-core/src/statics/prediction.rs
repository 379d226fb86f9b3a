//! Prediction of the smallest eigenvalue of a matrix and of its eigenvector along a motion, from
//! those at the preceding configurations.

use crate::linalg::{BLOCK, Part};

/// Relative residual at which inverse iteration without a shift stops. With a shift, the error of
/// the eigenvalue is the residual times the relative distance between shift and eigenvalue, so a
/// larger residual suffices. If the start vector contains little of the eigenvector, round-off
/// costs two more digits. Eigenvalues are therefore always accurate to 1e-9, and usually to
/// round-off, because the error is quadratic in the residual.
const ACCURACY: f64 = 2e-11;
/// Largest accepted bound on the relative error of an eigenvalue. A result computed with a shift is
/// rejected if its bound is larger.
const CERTAIN: f64 = 1e-9;
/// Distance of the shift from the predicted eigenvalue, as a multiple of the error of the preceding
/// prediction.
const SAFETY: f64 = 4.0;
/// Smallest relative distance of the shift from the predicted eigenvalue.
const NEAREST: f64 = 1e-4;
/// Largest relative distance of the shift from the predicted eigenvalue.
const FARTHEST: f64 = 0.5;
/// Relative distance of the shift from the predicted eigenvalue while the error of no prediction is
/// known.
const UNCHECKED: f64 = 0.1;
/// Weight of the preceding configuration's eigenvector in the start vector, relative to the weight
/// of a general vector. Because of the general vector, the iteration finds the smallest eigenvalue
/// even if its eigenvector is orthogonal to the preceding one.
const KNOWN: f64 = 4.0;

/// Smallest eigenvalues at the two most recent configurations, and the eigenvector at the most
/// recent one.
#[derive(Clone, Debug, Default)]
pub(super) struct Prediction {
    /// Smallest eigenvalue at the most recent configuration.
    last: Option<f64>,
    /// Smallest eigenvalue at the configuration before the most recent one.
    before: Option<f64>,
    /// Relative error of the prediction for the most recent configuration; `None` if there was no
    /// prediction.
    missed: Option<f64>,
    vector: Vec<Part>,
    /// General vector of the start vectors, which is computed at its first use.
    general: Vec<Part>,
}

/// Shift of the matrix for inverse iteration, and the residual at which the iteration may stop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shift {
    pub(super) by: f64,
    pub(super) accuracy: f64,
}

impl Shift {
    /// No shift: inverse iteration with the matrix itself.
    pub(super) const NONE: Self = Self { by: 0.0, accuracy: ACCURACY };

    /// Returns a shift below an approximate smallest eigenvalue whose relative error is at most
    /// `error`, or `None` if the shift would not be positive.
    pub(super) fn below(eigenvalue: f64, error: f64) -> Option<Self> {
        let margin = error.clamp(NEAREST, FARTHEST);
        let by = eigenvalue * (1.0 - margin);
        (by > 0.0).then_some(Self { by, accuracy: ACCURACY / margin })
    }

    /// Returns `true` if the relative error of an eigenvalue found with this shift is at most
    /// [`CERTAIN`]. The error may be larger if the eigenvalue is farther from the shift than
    /// predicted, for example when the motion continues after a pause.
    pub(super) fn is_certain(self, eigenvalue: f64) -> bool {
        (eigenvalue - self.by).abs() * self.accuracy <= CERTAIN * eigenvalue
    }
}

impl Prediction {
    /// Returns a shift slightly below the expected eigenvalue, or `None` if no positive eigenvalue
    /// is expected. The Cholesky decomposition of the shifted matrix exists only if no eigenvalue
    /// is below the shift.
    pub(super) fn shift(&self) -> Option<Shift> {
        let missed = self.missed.map_or(UNCHECKED, |missed| SAFETY * missed);
        Shift::below(self.expected()?, missed)
    }

    /// Returns true if the square root of the expected eigenvalue is below half of `limit`.
    pub(super) fn is_below(&self, limit: f64) -> bool {
        self.expected().is_some_and(|expected| expected < 0.25 * limit * limit)
    }

    fn expected(&self) -> Option<f64> {
        let last = self.last?;
        Some(self.before.map_or(last, |before| 2.0 * last - before))
    }

    /// Adds the smallest eigenvalue and its eigenvector at the next configuration, and computes the
    /// error of the prediction.
    pub(super) fn add(&mut self, eigenvalue: f64, vector: &[Part]) {
        self.missed = self.expected().map(|expected| ((eigenvalue - expected) / eigenvalue).abs());
        self.before = self.last.replace(eigenvalue);
        self.vector.clear();
        self.vector.extend_from_slice(vector);
    }

    /// Sets the eigenvalue that is expected at the next configuration, which replaces the
    /// extrapolated one.
    pub(super) fn expect(&mut self, eigenvalue: f64) {
        (self.last, self.before) = (Some(eigenvalue), None);
    }

    /// Clears the eigenvalues, the eigenvector and the error of the prediction.
    pub(super) fn forget(&mut self) {
        (self.last, self.before, self.missed) = (None, None, None);
        self.vector.clear();
    }

    /// Computes the start vector of the iteration. `sizes` are the numbers of rows used in each
    /// block; the remaining components are zero.
    pub(super) fn start(
        &mut self,
        sizes: impl ExactSizeIterator<Item = usize>,
    ) -> impl Iterator<Item = Part> {
        let Self { vector, general, .. } = self;
        for k in general.len()..sizes.len() {
            let angle = |i: usize| 1.0 + (BLOCK * k + i) as f64 * 0.7548;
            general.push(core::array::from_fn(|i| angle(i).sin()));
        }
        let known = KNOWN * (0.5 * (BLOCK * sizes.len()) as f64).sqrt();
        sizes.zip(&*general).enumerate().map(move |(k, (size, general))| {
            let last = vector.get(k).copied().unwrap_or([0.0; BLOCK]);
            core::array::from_fn(|i| if i < size { general[i] + known * last[i] } else { 0.0 })
        })
    }
}
