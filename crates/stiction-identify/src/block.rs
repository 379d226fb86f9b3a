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
    /// Instruments: columns of another motion, such as the commanded one, whose errors are independent of those of
    /// `matrix`; zero in rows in which that motion rests. `None` for least squares.
    pub instruments: Option<DMatrix<f64>>,
    /// Index of each row's instant on the equidistant time grid of the log; some instants may be missing.
    pub steps: Vec<usize>,
}

/// Bounds of the efforts of one actuator while the mechanism stands still, one row for each dwell: efforts that the
/// parameters explain without friction lie within the limits of static friction about the measured ones.
#[derive(Clone, Debug)]
pub struct Dwells {
    /// Effort without friction per unit of each parameter.
    pub matrix: DMatrix<f64>,
    /// Static friction limit per unit of each parameter, not negative.
    pub limits: DMatrix<f64>,
    /// Least and greatest measured effort less that of the model without friction, N or N m; widened by friction that
    /// is not estimated.
    pub bounds: Vec<[f64; 2]>,
}

/// Rows of one log.
#[derive(Clone, Debug)]
pub struct Block {
    /// Rows of each actuator.
    pub channels: Vec<Rows>,
    /// Bounds at rest for each actuator; empty without dwells.
    pub dwells: Vec<Dwells>,
    /// Independent samples per row: rows closer than half a period of the filter repeat each other.
    pub independence: f64,
}

impl Block {
    /// Number of instants in each piece, if the block is divided into `pieces` of equal length.
    pub(crate) fn fold_length(&self, pieces: usize) -> usize {
        let last = self.channels.iter().filter_map(|rows| rows.steps.last()).max();
        last.map_or(1, |last| last + 1).div_ceil(pieces).max(1)
    }
}

impl Dwells {
    /// Keeps the dwells for which `keep` holds, by their index.
    pub fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        let kept: Vec<usize> = (0..self.bounds.len()).filter(|&k| keep(k)).collect();
        self.matrix = self.matrix.select_rows(&kept);
        self.limits = self.limits.select_rows(&kept);
        self.bounds = kept.iter().map(|&k| self.bounds[k]).collect();
    }
}

impl Rows {
    /// Appends a column, which is its own instrument.
    pub fn push_column(&mut self, column: &DVector<f64>) {
        // Rows without instruments do not count, and stay without.
        let has_any = |matrix: &DMatrix<f64>, row| matrix.row(row).iter().any(|x| *x != 0.0);
        let instruments = self.instruments.as_ref().map(|matrix| {
            let each = column.iter().enumerate();
            let each = each.map(|(row, x)| if has_any(matrix, row) { *x } else { 0.0 });
            DVector::from_iterator(column.len(), each)
        });
        let columns = std::iter::once(column).chain(&instruments);
        let matrices = std::iter::once(&mut self.matrix).chain(&mut self.instruments);
        for (matrix, column) in matrices.zip(columns) {
            let count = matrix.ncols();
            *matrix = take(matrix).insert_column(count, 0.0);
            matrix.set_column(count, column);
        }
    }

    /// Removes the last column.
    pub fn pop_column(&mut self) {
        for matrix in std::iter::once(&mut self.matrix).chain(&mut self.instruments) {
            let count = matrix.ncols();
            *matrix = take(matrix).remove_column(count.saturating_sub(1));
        }
    }

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

fn take(matrix: &mut DMatrix<f64>) -> DMatrix<f64> {
    std::mem::replace(matrix, DMatrix::zeros(0, 0))
}
