//! Rows of the regression for one actuator.

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

impl Rows {
    /// Rows of successive instants with two columns, the motion and its square, and without efforts.
    #[cfg(test)]
    pub(crate) fn of_motion(length: usize, motion: impl Fn(f64) -> f64) -> Self {
        let matrix = DMatrix::from_fn(length, 2, |row, k| motion(row as f64).powi(k as i32 + 1));
        let (right, measured) = (DVector::zeros(length), DVector::zeros(length));
        Self { matrix, right, measured, instruments: None, steps: (0..length).collect() }
    }

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
pub(crate) fn push(matrix: &mut DMatrix<f64>, value: impl Fn(usize) -> f64) {
    let count = matrix.ncols();
    *matrix = take(matrix).insert_column(count, 0.0);
    matrix.column_mut(count).iter_mut().enumerate().for_each(|(row, x)| *x = value(row));
}

/// Removes the last column of a matrix.
pub(crate) fn pop(matrix: &mut DMatrix<f64>) {
    let last = matrix.ncols().saturating_sub(1);
    *matrix = take(matrix).remove_column(last);
}

fn take(matrix: &mut DMatrix<f64>) -> DMatrix<f64> {
    std::mem::replace(matrix, DMatrix::zeros(0, 0))
}
