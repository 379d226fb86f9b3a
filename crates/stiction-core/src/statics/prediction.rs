//! Prediction of the smallest eigenvalue of a matrix and of its eigenvector along a motion, from
//! those at the preceding configurations.

use crate::linalg::{BLOCK, Part, VectorHistory};

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
/// Smallest relative distance of the shift from the predicted eigenvalue. It exceeds the round-off
/// of the smallest eigenvalues for which the matrix is used.
const NEAREST: f64 = 1e-5;
/// Largest relative distance of the shift from the predicted eigenvalue.
const FARTHEST: f64 = 0.5;
/// Relative distance of the shift from the predicted eigenvalue while the error of no prediction is
/// known.
const UNCHECKED: f64 = 0.1;
/// Error of the preceding predictions up to which the extrapolated eigenvector may be so accurate
/// that an eigenvalue is found by [`Prediction::bracket`].
const SMOOTH: f64 = 1e-5;
/// Smallest number of eigenvectors from which another one is extrapolated.
const FEWEST: usize = 3;
/// Weight of the preceding configuration's eigenvector in the start vector, relative to the weight
/// of a general vector. Because of the general vector, the iteration finds the smallest eigenvalue
/// even if its eigenvector is orthogonal to the preceding one.
const KNOWN: f64 = 4.0;

/// Smallest eigenvalues at the three most recent configurations, and their eigenvectors.
#[derive(Clone, Debug, Default)]
pub(super) struct Prediction {
    /// Smallest eigenvalues at the most recent configuration and at the ones before it, in this
    /// order.
    last: [Option<f64>; 3],
    /// Relative errors of the predictions for the most recent configuration and for the one before
    /// it; `None` if there was no prediction.
    missed: [Option<f64>; 2],
    /// Unit eigenvectors at the most recent configurations, with equal senses.
    vectors: VectorHistory,
    /// Buffer for a unit eigenvector.
    unit: Vec<f64>,
    /// Rayleigh quotient of the vector that was last extrapolated.
    quotient: Option<f64>,
    /// Differences between these quotients and the eigenvalues, relative to the eigenvalues, for the
    /// most recent configuration and for the one before it.
    excess: [Option<f64>; 2],
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
        // The error of a single prediction may be small by chance.
        let missed = self.missed.into_iter().flatten().reduce(f64::max);
        let missed = missed.map_or(UNCHECKED, |missed| SAFETY * missed);
        Shift::below(self.expected()?, missed)
    }

    /// Returns true if the square root of the expected eigenvalue is below half of `limit`.
    pub(super) fn is_below(&self, limit: f64) -> bool {
        self.expected().is_some_and(|expected| expected < 0.25 * limit * limit)
    }

    fn expected(&self) -> Option<f64> {
        match self.last {
            [Some(a), Some(b), Some(c)] => Some(3.0 * (a - b) + c),
            [Some(a), Some(b), None] => Some(2.0 * a - b),
            [last, ..] => last,
        }
    }

    /// Writes the eigenvector that is expected at the next configuration to `vector`, extrapolated
    /// from the preceding ones. Returns `false` if too few are known, if the motion is not smooth, or
    /// if the round-off of eigenvalues, `rounded`, does not permit a certain result.
    pub(super) fn extrapolate(&self, rounded: f64, vector: &mut Vec<f64>) -> bool {
        let is_smooth = |missed: &Option<f64>| missed.is_some_and(|missed| missed <= SMOOTH);
        let is_large = |last: f64| rounded <= 0.5 * CERTAIN * last;
        let length = self.vectors.last().map_or(0, <[f64]>::len);
        self.missed.iter().all(is_smooth)
            && self.last[0].is_some_and(is_large)
            && self.vectors.count() >= FEWEST
            && self.vectors.predict(length, vector)
    }

    /// Returns a shift that is expected to lie below the smallest eigenvalue, from the Rayleigh
    /// quotient `quotient` of the extrapolated vector, which lies above it. `None` if the preceding
    /// quotients exceeded the eigenvalues by too much for a certain result. `rounded` is the
    /// round-off of eigenvalues.
    pub(super) fn bracket(&mut self, quotient: f64, rounded: f64) -> Option<f64> {
        self.quotient = Some(quotient);
        let [Some(last), Some(before)] = self.excess else { return None };
        let margin = (SAFETY * last.max(before) * quotient).max(rounded);
        // Half of the permitted error is for round-off of the lower bound.
        (margin <= 0.5 * CERTAIN * quotient).then_some(quotient - margin)
    }

    /// Adds the smallest eigenvalue and its eigenvector at the next configuration, and computes the
    /// errors of the predictions.
    pub(super) fn add(&mut self, eigenvalue: f64, vector: &[Part]) {
        let relative_error = |value: f64| ((value - eigenvalue) / eigenvalue).abs();
        self.excess = [self.quotient.take().map(relative_error), self.excess[0]];
        let missed = self.expected().map(relative_error);
        self.missed = [missed, self.missed[0]];
        self.last = [Some(eigenvalue), self.last[0], self.last[1]];
        let flat = vector.as_flattened();
        let product = |a: &[f64]| a.iter().zip(flat).map(|(a, b)| a * b).sum::<f64>();
        let over = 1.0 / product(flat).sqrt();
        let is_opposite = self.vectors.last().is_some_and(|last| product(last) < 0.0);
        let over = if is_opposite { -over } else { over };
        self.unit.clear();
        self.unit.extend(flat.iter().map(|x| over * x));
        self.vectors.add(&self.unit);
    }

    /// Sets the eigenvalue that is expected at the next configuration, which replaces the
    /// extrapolated one.
    pub(super) fn expect(&mut self, eigenvalue: f64) {
        self.last = [Some(eigenvalue), None, None];
        self.vectors.keep_last();
        (self.quotient, self.excess) = (None, [None; 2]);
    }

    /// Clears the eigenvalues, the eigenvectors and the errors of the predictions.
    pub(super) fn forget(&mut self) {
        (self.last, self.missed) = ([None; 3], [None; 2]);
        (self.quotient, self.excess) = (None, [None; 2]);
        self.vectors.forget();
    }

    /// Computes the start vector of the iteration. `sizes` are the numbers of rows used in each
    /// block; the remaining components are zero.
    pub(super) fn start(
        &mut self,
        sizes: impl ExactSizeIterator<Item = usize>,
    ) -> impl Iterator<Item = Part> {
        let Self { vectors, general, .. } = self;
        for k in general.len()..sizes.len() {
            let angle = |i: usize| 1.0 + (BLOCK * k + i) as f64 * 0.7548;
            general.push(core::array::from_fn(|i| angle(i).sin()));
        }
        let last: &[Part] = vectors.last().unwrap_or(&[]).as_chunks().0;
        let known = KNOWN * (0.5 * (BLOCK * sizes.len()) as f64).sqrt();
        sizes.zip(&*general).enumerate().map(move |(k, (size, general))| {
            let last = last.get(k).copied().unwrap_or([0.0; BLOCK]);
            core::array::from_fn(|i| if i < size { general[i] + known * last[i] } else { 0.0 })
        })
    }
}
