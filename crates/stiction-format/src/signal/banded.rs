//! Banded linear systems.

/// A square matrix with nonzeros on the main diagonal and on `band` diagonals on either side.
#[derive(Clone, Debug)]
pub(super) struct Banded {
    size: usize,
    band: usize,
    /// Entries row by row, `2 band + 1` per row.
    entries: Vec<f64>,
}

impl Banded {
    /// Creates a zero matrix.
    pub(super) fn new(size: usize, band: usize) -> Self {
        Self { size, band, entries: vec![0.0; size * (2 * band + 1)] }
    }

    fn index(&self, row: usize, column: usize) -> Option<usize> {
        let offset = (column + self.band).checked_sub(row)?;
        (row < self.size && column < self.size && offset <= 2 * self.band)
            .then_some(row * (2 * self.band + 1) + offset)
    }

    /// Returns an entry; zero outside the band.
    pub(super) fn get(&self, row: usize, column: usize) -> f64 {
        self.index(row, column).and_then(|i| self.entries.get(i)).copied().unwrap_or(0.0)
    }

    /// Sets an entry; ignored outside the band.
    pub(super) fn set(&mut self, row: usize, column: usize, value: f64) {
        if let Some(entry) = self.index(row, column).and_then(|i| self.entries.get_mut(i)) {
            *entry = value;
        }
    }

    /// Adds to an entry; ignored outside the band.
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        if let Some(entry) = self.index(row, column).and_then(|i| self.entries.get_mut(i)) {
            *entry += value;
        }
    }

    /// Product of the matrix with a vector.
    pub(super) fn times(&self, x: &[f64]) -> Vec<f64> {
        let row = |row: usize| {
            let columns = row.saturating_sub(self.band)..(row + self.band + 1).min(self.size);
            columns.map(|k| self.get(row, k) * x.get(k).copied().unwrap_or(0.0)).sum()
        };
        (0..self.size).map(row).collect()
    }

    /// Factors the matrix in place without pivoting, which is stable for diagonally dominant and
    /// for totally positive matrices (de Boor, A Practical Guide to Splines, chapter XIII).
    pub(super) fn factor(mut self) -> Factored {
        for pivot in 0..self.size {
            let diagonal = self.get(pivot, pivot);
            let last = (pivot + self.band).min(self.size.saturating_sub(1));
            for row in pivot + 1..=last {
                let factor = self.get(row, pivot) / diagonal;
                self.set(row, pivot, factor);
                if factor != 0.0 {
                    for column in pivot + 1..=last {
                        let entry = self.get(row, column) - factor * self.get(pivot, column);
                        self.set(row, column, entry);
                    }
                }
            }
        }
        Factored(self)
    }
}

/// LU factors of a banded matrix.
pub(super) struct Factored(Banded);

impl Factored {
    /// Returns the entries, within the band, of the inverse of the factored matrix, which must be
    /// symmetric (Takahashi's recursion, from `Z = D^-1 L^-1 + (1 - L^T) Z`).
    pub(super) fn inverse_within_band(&self) -> Banded {
        let Banded { size, band, .. } = self.0;
        let mut inverse = Banded::new(size, band);
        for row in (0..size).rev() {
            let last = (row + band).min(size - 1);
            // The diagonal entry depends on the entries to its right.
            for column in (row..=last).rev() {
                let unit = if row == column { 1.0 / self.0.get(row, row) } else { 0.0 };
                let sum: f64 =
                    (row + 1..=last).map(|k| self.0.get(k, row) * inverse.get(k, column)).sum();
                inverse.set(row, column, unit - sum);
                inverse.set(column, row, unit - sum);
            }
        }
        inverse
    }

    /// Solves the linear system for the right-hand side `b`, which is replaced by the solution.
    pub(super) fn solve(&self, b: &mut [f64]) {
        let Banded { size, band, .. } = self.0;
        let read = |b: &[f64], k: usize| b.get(k).copied().unwrap_or(0.0);
        for row in 0..size {
            let first = row.saturating_sub(band);
            let sum: f64 = (first..row).map(|k| self.0.get(row, k) * read(b, k)).sum();
            if let Some(x) = b.get_mut(row) {
                *x -= sum;
            }
        }
        for row in (0..size).rev() {
            let last = (row + band).min(size.saturating_sub(1));
            let sum: f64 = (row + 1..=last).map(|k| self.0.get(row, k) * read(b, k)).sum();
            if let Some(x) = b.get_mut(row) {
                *x = (*x - sum) / self.0.get(row, row);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_banded_system_is_solved() {
        let n = 20;
        let mut matrix = Banded::new(n, 2);
        for i in 0..n {
            for k in 0..n {
                if i.abs_diff(k) <= 2 {
                    matrix.set(
                        i,
                        k,
                        if i == k { 6.0 } else { 1.0 / (1.0 + i as f64 + 2.0 * k as f64) },
                    );
                }
            }
        }
        let x: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut b: Vec<f64> =
            (0..n).map(|i| (0..n).map(|k| matrix.get(i, k) * x[k]).sum()).collect();
        matrix.factor().solve(&mut b);
        for (found, expected) in b.iter().zip(&x) {
            // The matrix is diagonally dominant, so its condition number is of order one.
            assert!((found - expected).abs() < 1e-14);
        }
    }

    /// Checks the entries of the inverse within the band against columns obtained by solving for
    /// unit vectors.
    #[test]
    fn the_inverse_within_the_band() {
        let n = 12;
        let mut matrix = Banded::new(n, 3);
        for i in 0..n {
            for k in i..n.min(i + 4) {
                let value = if i == k { 9.0 } else { ((i * k) as f64).cos() };
                matrix.set(i, k, value);
                matrix.set(k, i, value);
            }
        }
        let factored = matrix.factor();
        let inverse = factored.inverse_within_band();
        for column in 0..n {
            let mut unit = vec![0.0; n];
            unit[column] = 1.0;
            factored.solve(&mut unit);
            for row in column.saturating_sub(3)..n.min(column + 4) {
                // The matrix is diagonally dominant, so its condition number is of order one.
                assert!((inverse.get(row, column) - unit[row]).abs() < 1e-15);
            }
        }
    }
}
