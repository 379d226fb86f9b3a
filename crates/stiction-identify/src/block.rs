//! Rows of the regression, grouped by log and by actuator.

use crate::period::Period;
use nalgebra::{DMatrix, DVector};

/// Rows of the regression for one actuator in one log, in the order of time.
#[derive(Clone, Debug)]
pub struct Rows {
    /// Effort per unit of each parameter (columns), at each instant (rows).
    pub matrix: DMatrix<f64>,
    /// Measured effort minus the effort of the model without friction, N or N m.
    pub right: DVector<f64>,
    /// Measured effort, N or N m.
    pub measured: DVector<f64>,
    /// Instruments, with the shape of `matrix`: columns computed from another motion, such as the
    /// commanded motion, whose errors are independent of the errors of `matrix`. A row is zero if
    /// the other motion is at rest. `None` for least squares.
    pub instruments: Option<DMatrix<f64>>,
    /// Index of each row's instant on the equidistant time grid of the log; some instants may be missing.
    pub steps: Vec<usize>,
}

/// Bounds on the efforts of one actuator during dwells (periods of standstill), one row for each
/// dwell. The effort that the parameters explain without friction differs from the measured efforts
/// by at most the limit of static friction.
#[derive(Clone, Debug)]
pub struct Dwells {
    /// Effort without friction (rows: dwells) per unit of each parameter (columns).
    pub matrix: DMatrix<f64>,
    /// Static friction limit (rows: dwells) per unit of each parameter (columns), not negative.
    pub limits: DMatrix<f64>,
    /// Least and greatest measured effort minus the effort of the model without friction, N or N m.
    /// Friction that is not estimated raises the least and lowers the greatest value, which relaxes
    /// both inequalities.
    pub bounds: Vec<[f64; 2]>,
}

/// Rows of the regression, and bounds at rest, of one log.
#[derive(Clone, Debug)]
pub struct Block {
    /// Rows of each actuator.
    pub channels: Vec<Rows>,
    /// Bounds at rest for each actuator; empty without dwells.
    pub dwells: Vec<Dwells>,
    /// Number of independent samples per row. It is below one if rows are closer than half a period
    /// of the filter, because such rows partly repeat each other, and one for rows without order in
    /// time.
    pub independence: f64,
    /// Period of the motion if it is repeated.
    period: Option<Period>,
}

impl Block {
    /// Creates the block of a log without bounds at rest, and finds the period of its motion. For
    /// `independence` see [`Self::independence`].
    pub fn new(channels: Vec<Rows>, independence: f64) -> Self {
        // Rows of steady motions are independent and have no order in time.
        let period = if independence < 1.0 { Period::of(&channels) } else { None };
        Self { channels, dwells: Vec::new(), independence, period }
    }

    /// Period of the motion; `None` for a motion that is not repeated.
    pub(crate) fn period(&self) -> Option<Period> {
        self.period
    }
}

impl Dwells {
    /// Keeps the dwells for whose index `keep` returns true.
    pub fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        let kept: Vec<usize> = (0..self.bounds.len()).filter(|&k| keep(k)).collect();
        self.matrix = self.matrix.select_rows(&kept);
        self.limits = self.limits.select_rows(&kept);
        self.bounds = kept.iter().map(|&k| self.bounds[k]).collect();
    }

    /// Appends the column of a parameter whose effort per unit is `value` in each dwell, and which
    /// has no static friction.
    pub fn push_column(&mut self, value: f64) {
        push(&mut self.matrix, |_| value);
        push(&mut self.limits, |_| 0.0);
    }

    /// Removes the last column of the dwells' matrices.
    pub fn pop_column(&mut self) {
        [&mut self.matrix, &mut self.limits].into_iter().for_each(pop);
    }
}

impl Rows {
    /// Appends a column to the matrix and, if there are instruments, to the instruments.
    pub fn push_column(&mut self, column: &DVector<f64>) {
        let without = self.rows_without_instruments();
        push(&mut self.matrix, |row| column[row]);
        if let Some(instruments) = &mut self.instruments {
            push(instruments, |row| column[row]);
            // Rows without instruments do not count, so their instruments stay zero.
            without.into_iter().for_each(|row| instruments.row_mut(row).fill(0.0));
        }
    }

    /// Removes the last column of the matrix and of the instruments.
    pub fn pop_column(&mut self) {
        std::iter::once(&mut self.matrix).chain(&mut self.instruments).for_each(pop);
    }

    /// Returns the indices of the rows whose instruments are zero, because the motion from which
    /// the instruments are computed is at rest there; empty for least squares.
    pub(crate) fn rows_without_instruments(&self) -> Vec<usize> {
        let rows = self.instruments.iter().flat_map(|all| all.row_iter().enumerate());
        rows.filter(|(_, row)| row.iter().all(|x| *x == 0.0)).map(|(index, _)| index).collect()
    }

    /// Returns the number of rows, one per instant.
    pub fn len(&self) -> usize {
        self.right.len()
    }

    /// Returns `true` if there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the efforts that the parameter values `values` predict, N or N m. For inertial
    /// parameters in `values`, see [`Self::residuals`].
    pub fn predicted(&self, values: &DVector<f64>) -> DVector<f64> {
        &self.measured - self.residuals(values)
    }

    /// Returns the residuals for the parameter values `values`, N or N m. Inertial parameters in
    /// `values` are differences from their prior values, because `right` does not contain the
    /// efforts of the model without friction.
    pub fn residuals(&self, values: &DVector<f64>) -> DVector<f64> {
        &self.right - &self.matrix * values
    }
}

/// Appends a column to a matrix; `value` returns the entry of each row.
fn push(matrix: &mut DMatrix<f64>, value: impl Fn(usize) -> f64) {
    let count = matrix.ncols();
    *matrix = take(matrix).insert_column(count, 0.0);
    matrix.column_mut(count).iter_mut().enumerate().for_each(|(row, x)| *x = value(row));
}

/// Removes the last column of a matrix.
fn pop(matrix: &mut DMatrix<f64>) {
    let last = matrix.ncols().saturating_sub(1);
    *matrix = take(matrix).remove_column(last);
}

fn take(matrix: &mut DMatrix<f64>) -> DMatrix<f64> {
    std::mem::replace(matrix, DMatrix::zeros(0, 0))
}
