//! Free coordinates of the estimation: one for each group of tied parameters, and one for each
//! single parameter that is not held constant.

use super::Problem;
use nalgebra::{DMatrix, DVector};

/// Map from free coordinates `z` to the values of all parameters: `theta = base + T z`. Each
/// parameter depends on at most one coordinate, so one entry of `T` is stored for each parameter.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    /// Values of the parameters that are held constant; zero for all others.
    pub(crate) base: DVector<f64>,
    /// Index of the coordinate on which each parameter depends, and its factor; `None` for a
    /// parameter that is held constant.
    entries: Vec<Option<(usize, f64)>>,
    /// Index of the first parameter that depends on each coordinate.
    pub(crate) firsts: Vec<usize>,
}

/// Number of rows of tall matrices that are multiplied at a time.
const ROWS: usize = 1024;

impl Map {
    /// Returns the number of free coordinates.
    pub(crate) fn size(&self) -> usize {
        self.firsts.len()
    }

    /// Returns the index of the coordinate on which a parameter depends, and the factor of this
    /// coordinate; `None` for a parameter that is held constant.
    pub(crate) fn entry(&self, parameter: usize) -> Option<(usize, f64)> {
        self.entries[parameter]
    }

    /// Returns the factor of a coordinate for the first parameter that depends on it.
    pub(crate) fn factor(&self, column: usize) -> f64 {
        self.entries[self.firsts[column]].map_or(1.0, |(_, factor)| factor)
    }

    /// Returns the values of all parameters for given coordinates.
    pub(crate) fn values(&self, z: &DVector<f64>) -> DVector<f64> {
        &self.base + self.changes(z)
    }

    /// Changes of all parameters for changes of the coordinates.
    pub(crate) fn changes(&self, z: &DVector<f64>) -> DVector<f64> {
        let each = self
            .entries
            .iter()
            .map(|entry| entry.map_or(0.0, |(column, factor)| factor * z[column]));
        DVector::from_iterator(self.entries.len(), each)
    }

    /// Converts the rows `rows` of a matrix with a column for each parameter to a matrix with a
    /// column for each coordinate.
    pub(crate) fn columns(
        &self,
        matrix: &DMatrix<f64>,
        rows: std::ops::Range<usize>,
    ) -> DMatrix<f64> {
        let count = rows.len();
        let mut out = DMatrix::zeros(count, self.size());
        for (k, entry) in self.entries.iter().enumerate() {
            if let Some((column, factor)) = entry {
                let own = matrix.view((rows.start, k), (count, 1));
                out.column_mut(*column).axpy(*factor, &own.column(0), 1.0);
            }
        }
        out
    }

    /// Adds a derivative with respect to a parameter to the gradient with respect to the coordinates.
    pub(crate) fn add_slope(&self, target: &mut DVector<f64>, parameter: usize, slope: f64) {
        if let Some((column, factor)) = self.entries[parameter] {
            target[column] += factor * slope;
        }
    }

    /// Adds a second derivative with respect to two parameters to the Hessian with respect to the coordinates.
    pub(crate) fn add_bend(&self, target: &mut DMatrix<f64>, (i, k): (usize, usize), bend: f64) {
        if let (Some((row, a)), Some((column, b))) = (self.entries[i], self.entries[k]) {
            target[(row, column)] += a * b * bend;
        }
    }

    /// Computes the covariance of all parameters from `free`, the covariance of the coordinates.
    pub(crate) fn spread(&self, free: &DMatrix<f64>) -> DMatrix<f64> {
        let count = self.entries.len();
        DMatrix::from_fn(count, count, |i, k| match (self.entries[i], self.entries[k]) {
            (Some((row, a)), Some((column, b))) => a * b * free[(row, column)],
            _ => 0.0,
        })
    }
}

impl Problem<'_> {
    pub(crate) fn map(&self) -> Map {
        let count = self.parameters.len();
        let mut base = DVector::zeros(count);
        let mut groups: Vec<Vec<usize>> = Vec::new();
        let mut done = self.options.held.clone();
        for k in (0..count).filter(|&k| done[k]) {
            base[k] = self.parameters[k].prior;
        }
        for group in &self.options.tied {
            let group: Vec<usize> = group.iter().copied().filter(|&k| !done[k]).collect();
            group.iter().for_each(|&k| done[k] = true);
            if !group.is_empty() {
                groups.push(group);
            }
        }
        groups.extend((0..count).filter(|&k| !done[k]).map(|k| vec![k]));
        groups.sort();
        let mut entries = vec![None; count];
        for (column, group) in groups.iter().enumerate() {
            // Tied parameters have one common value, with the scale of the first parameter of the
            // group.
            let factor = self.parameters[group[0]].scale.max(1e-300);
            group.iter().for_each(|&k| entries[k] = Some((column, factor)));
        }
        Map { base, entries, firsts: groups.iter().map(|group| group[0]).collect() }
    }
}

/// Computes the product of the transpose of a tall matrix `a` with another matrix `b`.
pub(crate) fn transposed_product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(a.ncols(), b.ncols());
    for from in (0..a.nrows()).step_by(ROWS) {
        let count = ROWS.min(a.nrows() - from);
        // Products of plain matrices are computed in blocks, those with a transposed view are not.
        sum.gemm(1.0, &a.rows(from, count).transpose(), &b.rows(from, count), 1.0);
    }
    sum
}
