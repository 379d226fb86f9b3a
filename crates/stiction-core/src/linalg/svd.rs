//! Singular value decomposition.

use super::basis::Basis;
use nalgebra::{DMatrix, DVector};

/// Singular value decomposition `matrix = u * diag(singular_values) * transpose(v)`.
///
/// Uses one-sided Jacobi rotations (Hestenes 1958; de Rijk 1989 for the order of columns), which
/// determine small singular values to high relative accuracy. Rank decisions rely on this accuracy:
/// the decomposition of a general-purpose library loses up to eleven digits for matrices of
/// mechanisms (`tests/suite/svd.rs` checks the properties that this library violated). The right
/// singular vectors of the library are orthogonal, however, and Jacobi rotations that start from
/// these vectors converge fast.
#[derive(Clone, Debug)]
pub struct Svd {
    /// Left singular vectors, one for each column of the matrix. A vector is zero if its singular
    /// value is zero within rounding.
    pub u: DMatrix<f64>,
    /// Singular values, one for each column of the matrix, largest first.
    pub singular_values: DVector<f64>,
    /// Right singular vectors, one for each column of the matrix; they form an orthonormal basis.
    pub v: DMatrix<f64>,
}

/// Matrices with at least this many columns begin the Jacobi rotations with the right singular
/// vectors of another decomposition, because this is faster.
const LARGE: usize = 24;

/// Maximum number of sweeps over all pairs of columns; six to ten are usually sufficient.
const SWEEPS: usize = 60;

impl Svd {
    /// Decomposes a matrix of any shape.
    pub fn new(matrix: &DMatrix<f64>) -> Self {
        let columns = matrix.ncols();
        let mut v = if columns < LARGE { None } else { nearly_right_vectors(matrix) }
            .unwrap_or_else(|| DMatrix::identity(columns, columns));
        let mut work = matrix * &v;
        let scale = matrix.amax();
        // Columns below this squared norm consist of round-off and have no meaningful direction.
        let nothing = (f64::EPSILON * scale).powi(2) * matrix.nrows().max(1) as f64;
        let mut squares: Vec<f64> = work.column_iter().map(|c| c.norm_squared()).collect();
        for _ in 0..SWEEPS {
            let mut rotated = false;
            for i in 0..columns {
                // De Rijk's order: the largest of the remaining columns first.
                let largest =
                    (i..columns).max_by(|&a, &b| squares[a].total_cmp(&squares[b])).unwrap_or(i);
                work.swap_columns(i, largest);
                v.swap_columns(i, largest);
                squares.swap(i, largest);
                for j in i + 1..columns {
                    rotated |= orthogonalise(&mut work, &mut v, &mut squares, (i, j), nothing);
                }
            }
            if !rotated {
                break;
            }
        }
        let mut order: Vec<usize> = (0..columns).collect();
        let norms: Vec<f64> = work.column_iter().map(|c| c.norm()).collect();
        order.sort_by(|&a, &b| norms[b].total_cmp(&norms[a]));
        let mut u = DMatrix::zeros(matrix.nrows(), columns);
        for (k, &from) in order.iter().enumerate() {
            if norms[from] * norms[from] > nothing {
                u.set_column(k, &(work.column(from) / norms[from]));
            }
        }
        let v = DMatrix::from_fn(columns, columns, |i, k| v[(i, order[k])]);
        let singular_values = DVector::from_iterator(columns, order.iter().map(|&k| norms[k]));
        Self { u, singular_values, v }
    }

    /// Returns the largest singular value; zero for an empty matrix.
    pub fn largest(&self) -> f64 {
        self.singular_values.iter().copied().next().unwrap_or(0.0)
    }

    /// Returns the number of singular values above `negligible` times the largest one.
    pub fn rank(&self, negligible: f64) -> usize {
        let limit = negligible * self.largest();
        self.singular_values.iter().filter(|&&s| s > limit).count()
    }

    /// Returns the rank of a matrix whose entries are either of order one or round-off: the number
    /// of singular values above `negligible` times the largest one (or times 1, if that is
    /// greater). A matrix that consists of round-off only has rank zero.
    pub fn rank_of_order_one(&self, negligible: f64) -> usize {
        let limit = negligible * self.largest().max(1.0);
        self.singular_values.iter().filter(|&&s| s > limit).count()
    }

    /// Computes an orthonormal basis of the null space, for a matrix of the given rank.
    pub fn null_space(&self, rank: usize) -> Vec<DVector<f64>> {
        self.v.column_iter().skip(rank).map(|c| c.into_owned()).collect()
    }

    /// Computes the minimum-norm least-squares solution for the right-hand side `right`, for a
    /// matrix of the given rank.
    pub fn solve(&self, right: &DVector<f64>, rank: usize) -> DVector<f64> {
        let mut solution = DVector::zeros(self.v.nrows());
        for k in 0..rank {
            let amount = self.u.column(k).dot(right) / self.singular_values[k];
            solution.axpy(amount, &self.v.column(k), 1.0);
        }
        solution
    }
}

/// Computes an orthonormal basis that nearly diagonalises the Gram matrix of the columns, with the
/// singular value decomposition of nalgebra. Returns `None` if this decomposition fails.
fn nearly_right_vectors(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (rows, columns) = matrix.shape();
    // Padded with rows of zeros, the matrix has one right singular vector for each column.
    let square = matrix.clone().resize_vertically(rows.max(columns), 0.0);
    let found = nalgebra::SVD::try_new(square, false, true, f64::EPSILON, 100 * columns)?;
    let v = found.v_t?.transpose();
    let skew = v.tr_mul(&v) - DMatrix::identity(columns, columns);
    // Also rejects NaN, because comparisons with NaN are false.
    (skew.amax() <= 1e-15 * columns as f64).then_some(v)
}

/// Rotates columns `i` and `j` such that they become orthogonal. Returns `false` if they are
/// already orthogonal or if one of them is negligible.
fn orthogonalise(
    work: &mut DMatrix<f64>,
    v: &mut DMatrix<f64>,
    squares: &mut [f64],
    (i, j): (usize, usize),
    nothing: f64,
) -> bool {
    let (alpha, beta) = (squares[i], squares[j]);
    if alpha <= nothing || beta <= nothing {
        return false;
    }
    let gamma = work.column(i).dot(&work.column(j));
    if gamma.abs() <= 4.0 * f64::EPSILON * (alpha * beta).sqrt() {
        return false;
    }
    let zeta = (beta - alpha) / (2.0 * gamma);
    let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
    let c = 1.0 / (1.0 + t * t).sqrt();
    let s = c * t;
    for matrix in [&mut *work, v] {
        // `i < j`, and columns are stored one after the other.
        let rows = matrix.nrows();
        let (before, from) = matrix.as_mut_slice().split_at_mut(j * rows);
        let (first, second) = (&mut before[i * rows..][..rows], &mut from[..rows]);
        for (a, b) in first.iter_mut().zip(second.iter_mut()) {
            (*a, *b) = (c * *a - s * *b, s * *a + c * *b);
        }
    }
    for k in [i, j] {
        squares[k] = work.column(k).norm_squared();
    }
    true
}

/// Computes an orthonormal basis of the directions in the span of `all` that are orthogonal to
/// `known`.
pub(crate) fn complement(all: &Basis, known: &Basis) -> Vec<DVector<f64>> {
    if known.len() >= all.len() {
        return Vec::new();
    }
    let basis = DMatrix::from_columns(&all.dense());
    let mut rows = DMatrix::zeros(known.len().max(1), all.len());
    for (k, vector) in known.dense().iter().enumerate() {
        rows.set_row(k, &basis.tr_mul(vector).transpose());
    }
    Svd::new(&rows).null_space(known.len()).iter().map(|amounts| &basis * amounts).collect()
}
