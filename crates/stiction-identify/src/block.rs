//! Rows of the regression: the efforts of one actuator in one log.

use nalgebra::{DMatrix, DVector};

/// Rows of one actuator in one log, in the order of time.
#[derive(Clone, Debug)]
pub struct Rows {
    /// Effort per unit of each parameter (columns), at each instant (rows).
    pub matrix: DMatrix<f64>,
    /// Measured effort minus the effort of the model without friction, N or N m.
    pub right: DVector<f64>,
    /// Measured effort, N or N m.
    pub measured: DVector<f64>,
    /// Index of each row's instant on the equidistant time grid of the log; some instants may be missing.
    pub steps: Vec<usize>,
}

/// Rows of one log.
#[derive(Clone, Debug)]
pub struct Block {
    /// Rows of each actuator.
    pub channels: Vec<Rows>,
    /// Number of independent samples per row, at most one: rows closer than half a period of the filter are correlated.
    pub independence: f64,
}

impl Block {
    /// Number of instants in each piece, if the block is divided into `pieces` of equal length.
    pub(crate) fn fold_length(&self, pieces: usize) -> usize {
        let last = self.channels.iter().filter_map(|rows| rows.steps.last()).max();
        last.map_or(1, |last| last + 1).div_ceil(pieces).max(1)
    }
}

impl Rows {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.right.len()
    }

    /// Returns whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Efforts that these values predict, N or N m; the meaning of the values is that of [`Self::residuals`].
    pub fn predicted(&self, values: &DVector<f64>) -> DVector<f64> {
        &self.measured - self.residuals(values)
    }

    /// Residuals for these values, N or N m. Values of inertial parameters are differences from the prior, because
    /// `right` does not contain the efforts of the model without friction.
    pub fn residuals(&self, values: &DVector<f64>) -> DVector<f64> {
        &self.right - &self.matrix * values
    }
}
