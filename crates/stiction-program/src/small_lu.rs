//! Solution of small dense linear systems without branches. The order of pivots is chosen once,
//! from representative numbers.

use stiction_core::scalar::Scalar;

/// LU factors of a square matrix.
#[derive(Clone, Debug)]
pub(crate) struct Factors<T> {
    /// Row and column of each pivot.
    order: Vec<(usize, usize)>,
    /// Entries in the order of the pivots: multipliers below the diagonal, reciprocal pivots on it,
    /// and the upper factor above it.
    matrix: Vec<Vec<T>>,
    /// Pivots in their order.
    pivots: Vec<T>,
}

/// Returns the order of pivots along the diagonal.
pub(crate) fn diagonal(size: usize) -> Vec<(usize, usize)> {
    (0..size).map(|k| (k, k)).collect()
}

/// Chooses an order of pivots in which each pivot is the largest remaining entry of the matrix.
/// Rows and columns are first scaled by their largest entries, because their units differ. Returns
/// `None` for a singular matrix.
pub(crate) fn largest_pivots(mut matrix: Vec<Vec<f64>>) -> Option<Vec<(usize, usize)>> {
    let size = matrix.len();
    for row in &mut matrix {
        let largest = row.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        row.iter_mut().for_each(|x| *x /= largest);
    }
    for column in 0..size {
        let largest = matrix.iter().fold(0.0_f64, |max, row| max.max(row[column].abs()));
        matrix.iter_mut().for_each(|row| row[column] /= largest);
    }
    let mut order: Vec<(usize, usize)> = Vec::with_capacity(size);
    for _ in 0..size {
        let is_left =
            |r: usize, c: usize| !order.iter().any(|&(row, column)| row == r || column == c);
        let all = (0..size).flat_map(|r| (0..size).map(move |c| (r, c)));
        let best = all
            .filter(|&(r, c)| is_left(r, c))
            .max_by(|&(a, b), &(c, d)| matrix[a][b].abs().total_cmp(&matrix[c][d].abs()))?;
        let (row, column) = best;
        let pivot = matrix[row][column];
        // Such a pivot is a rounding error, or not finite.
        if !pivot.is_finite() || pivot.abs() < 1e-12 {
            return None;
        }
        for r in (0..size).filter(|&r| r != row && is_left(r, column)) {
            let factor = matrix[r][column] / pivot;
            for c in 0..size {
                matrix[r][c] -= factor * matrix[row][c];
            }
        }
        order.push(best);
    }
    Some(order)
}

impl<T: Scalar> Factors<T> {
    /// Factorises a matrix with pivots in the given order.
    pub(crate) fn new(matrix: &[Vec<T>], order: Vec<(usize, usize)>) -> Self {
        let row = |&(row, _): &(usize, usize)| {
            order.iter().map(|&(_, column)| matrix[row][column]).collect()
        };
        let mut matrix: Vec<Vec<T>> = order.iter().map(row).collect();
        let mut pivots = Vec::with_capacity(order.len());
        for pivot in 0..order.len() {
            pivots.push(matrix[pivot][pivot]);
            let over = matrix[pivot][pivot].recip();
            matrix[pivot][pivot] = over;
            let (above, below) = matrix.split_at_mut(pivot + 1);
            for row in below {
                row[pivot] *= over;
                let factor = row[pivot];
                for (x, y) in row.iter_mut().zip(&above[pivot]).skip(pivot + 1) {
                    *x -= factor * *y;
                }
            }
        }
        Self { order, matrix, pivots }
    }

    /// Reciprocal pivots in their order.
    pub(crate) fn reciprocal_pivots(&self) -> impl Iterator<Item = T> {
        self.matrix.iter().enumerate().map(|(pivot, row)| row[pivot])
    }

    /// Determinant relative to that of another matrix, of which `reciprocals` are the reciprocal
    /// pivots. It has the same units as this matrix has in its last rows. Products of all pivots
    /// may leave the range of numbers, so each pivot is divided by that of the other matrix.
    pub(crate) fn determinant_relative_to(&self, reciprocals: &[T]) -> T {
        let (first, last) = self.pivots.split_at(self.pivots.len() - reciprocals.len());
        let ratios = last.iter().zip(reciprocals).map(|(pivot, over)| *pivot * *over);
        let all = first.iter().copied().chain(ratios);
        all.reduce(|product, pivot| product * pivot).unwrap_or_else(T::one)
    }

    /// Solves the linear system for one right-hand side.
    pub(crate) fn solve(&self, right: &[T]) -> Vec<T> {
        let mut own: Vec<T> = self.order.iter().map(|&(row, _)| right[row]).collect();
        for row in 1..own.len() {
            for column in 0..row {
                let change = self.matrix[row][column] * own[column];
                own[row] -= change;
            }
        }
        for row in (0..own.len()).rev() {
            for column in row + 1..own.len() {
                let change = self.matrix[row][column] * own[column];
                own[row] -= change;
            }
            own[row] *= self.matrix[row][row];
        }
        let mut solution = own.clone();
        for (value, &(_, column)) in own.iter().zip(&self.order) {
            solution[column] = *value;
        }
        solution
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_core::random::Random;

    #[test]
    fn systems_are_solved_for_any_pivot() {
        let mut random = Random::new(3);
        for size in 1..7 {
            let mut matrix: Vec<Vec<f64>> =
                (0..size).map(|_| (0..size).map(|_| random.number()).collect()).collect();
            // The order along the diagonal would have a zero pivot.
            matrix[0][0] = if size > 1 { 0.0 } else { 2.0 };
            let wanted: Vec<f64> = (0..size).map(|_| random.number()).collect();
            let right: Vec<f64> = matrix
                .iter()
                .map(|row| row.iter().zip(&wanted).map(|(a, b)| a * b).sum())
                .collect();
            let order = largest_pivots(matrix.clone()).unwrap();
            let found = Factors::new(&matrix, order).solve(&right);
            for (found, wanted) in found.iter().zip(&wanted) {
                // The tolerance allows for rounding errors magnified by condition numbers of some
                // hundred.
                assert!((found - wanted).abs() < 1e-12, "{size}: {found} {wanted}");
            }
        }
        assert_eq!(largest_pivots(vec![vec![1.0, 2.0], vec![2.0, 4.0]]), None);
    }

    #[test]
    fn determinants_of_small_numbers_have_a_ratio() {
        let tiny = |scale: f64, size: usize| -> Vec<Vec<f64>> {
            (0..size)
                .map(|r| (0..size).map(|c| if r == c { scale } else { 0.0 }).collect())
                .collect()
        };
        let small = Factors::new(&tiny(1e-30, 20), diagonal(20));
        let reciprocals: Vec<f64> = small.reciprocal_pivots().collect();
        let mut bordered = tiny(2e-30, 21);
        bordered[0][0] = -3.0;
        let ratio = Factors::new(&bordered, diagonal(21)).determinant_relative_to(&reciprocals);
        let wanted = -3.0 * 2.0_f64.powi(20);
        assert!((ratio / wanted - 1.0).abs() < 1e-13, "{ratio}");
    }
}
