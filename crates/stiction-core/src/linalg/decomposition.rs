//! Ranks, null spaces and extreme singular values of sparse matrices.
//!
//! Small matrices are decomposed densely. Large matrices are decomposed into sparse triangular
//! factors. If the sparse factors do not clearly decide the rank, a dense decomposition replaces
//! them.

use super::basis::Basis;
use super::block::{BLOCK, Part};
use super::sparse::SparseMatrix;
use super::sparse_qr::{ColumnOrder, SparseQr};
use super::{Lanczos, MANY_STEPS, Svd};
use nalgebra::DVector;
use std::sync::OnceLock;

/// Number of columns from which sparse factors replace dense decompositions. Sparse factors are
/// faster from about 60 columns, but solutions by seminormal equations are less accurate for nearly
/// singular matrices.
pub(crate) const LARGE: usize = 120;
/// Safety factor for rank decisions by sparse factors. The smallest non-zero singular value must
/// exceed the limit below which values count as zero by this factor, and the limit must exceed the
/// remainders of dependent columns by this factor.
const CLEAR: f64 = 10.0;
/// Safety factor that replaces [`CLEAR`] if all columns are independent and the smallest singular
/// value exceeds the fraction [`ACCURATE`] of the largest one. No column is dropped then, and the
/// smallest singular value has at least eight correct digits.
const CERTAIN: f64 = 1.01;
const ACCURATE: f64 = 1e-7;
/// Largest number of singular values below the limit that are computed one by one, if all columns
/// are independent.
const FEW: usize = 12;
/// Relative residual at which the iteration for the largest squared singular value stops. The
/// relative error of the value is of the order of the square of this residual.
const ACCURACY_OF_LARGEST: f64 = 1e-3;
/// Relative residual at which the iteration for the smallest non-zero squared singular value stops.
/// The relative error of the value is of the order of the square of this residual.
const ACCURACY_OF_SMALLEST: f64 = 1e-11;
/// Components of null vectors below this value are round-off.
const ROUND_OFF: f64 = 1e-14;

/// Nonzero components of a vector, as pairs of index and value.
pub type SparseVector = Vec<(usize, f64)>;

/// Matrix with its complete or partial singular value decomposition.
#[derive(Clone, Debug)]
pub struct Decomposition {
    matrix: SparseMatrix,
    sparse: Option<SparseRank>,
    dense: OnceLock<Svd>,
    rank: usize,
}

/// Sparse factors of a matrix, if they clearly decide the rank of the matrix.
#[derive(Clone, Debug)]
struct SparseRank {
    /// Triangular factor `R` of `A P = Q R`.
    upper: SparseQr,
    /// `R^T`, and the triangular factor `T` of `R^T P' = Q' T`. `T` is square and has the non-zero
    /// singular values of `A`. `None` if all columns are independent.
    square: Option<(SparseMatrix, SparseQr)>,
    largest: f64,
    /// Singular values that count as zero although all columns are independent, ascending, with
    /// their right singular vectors of unit norm.
    negligible: Vec<(f64, Vec<f64>)>,
    /// Smallest non-zero singular value.
    smallest: f64,
    /// Right singular vector of the singular value `smallest`, with unit norm.
    weakest: Vec<f64>,
}

/// Limit below which singular values count as zero.
#[derive(Clone, Copy, Debug)]
pub enum Limit {
    /// The limit is this fraction of the largest singular value.
    OfLargest(f64),
    /// The limit is this fraction of the largest singular value or of one, whichever is greater.
    /// Intended for matrices whose entries are either of order one or round-off.
    OfOrderOne(f64),
}

impl Limit {
    /// Returns the limit for a matrix with the largest singular value `largest`.
    pub(crate) fn value(self, largest: f64) -> f64 {
        match self {
            Self::OfLargest(part) => part * largest,
            Self::OfOrderOne(part) => part * largest.max(1.0),
        }
    }
}

impl Decomposition {
    /// Decomposes a matrix. `groups` contains a group index for each column; columns of one group,
    /// such as the unknowns of one joint, are eliminated together. Singular values below `limit`
    /// count as zero.
    pub(crate) fn new(matrix: SparseMatrix, groups: &[usize], limit: Limit) -> Self {
        match matrix.ncols() < LARGE {
            true => Self::dense(matrix, limit),
            false => Self::sparse(matrix, groups, limit),
        }
    }

    /// Decomposes a matrix densely.
    pub(crate) fn dense(matrix: SparseMatrix, limit: Limit) -> Self {
        let svd = Svd::new(&matrix.to_dense());
        let negligible = limit.value(svd.largest());
        let rank = svd.singular_values.iter().filter(|&&s| s > negligible).count();
        Self { matrix, sparse: None, dense: OnceLock::from(svd), rank }
    }

    /// Decomposes a matrix into sparse factors, or densely if sparse factors do not clearly decide
    /// the rank.
    pub fn sparse(matrix: SparseMatrix, groups: &[usize], limit: Limit) -> Self {
        match SparseRank::new(&matrix, groups, limit) {
            Some(sparse) => {
                let rank = sparse.rank();
                Self { matrix, sparse: Some(sparse), dense: OnceLock::new(), rank }
            }
            None => Self::dense(matrix, limit),
        }
    }

    /// Returns `true` if sparse factors decided the rank.
    pub fn is_sparse(&self) -> bool {
        self.sparse.is_some()
    }

    pub(crate) fn matrix(&self) -> &SparseMatrix {
        &self.matrix
    }

    /// Returns the dense singular value decomposition, which is computed at the first call.
    pub(crate) fn svd(&self) -> &Svd {
        self.dense.get_or_init(|| Svd::new(&self.matrix.to_dense()))
    }

    /// Returns the number of singular values above the limit.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Returns the largest singular value.
    pub fn largest(&self) -> f64 {
        self.sparse.as_ref().map_or_else(|| self.svd().largest(), |sparse| sparse.largest)
    }

    /// Returns the singular value with the given index in descending order; there is one value for
    /// each column. If the value counts as zero, returns an upper bound of it.
    pub fn value(&self, index: usize) -> f64 {
        match &self.sparse {
            Some(sparse) if index + 1 == self.rank => sparse.smallest,
            Some(sparse) if index == 0 && self.rank > 0 => sparse.largest,
            Some(sparse) if index >= self.rank => sparse.dropped(),
            _ => self.svd().singular_values[index],
        }
    }

    /// Returns the singular values in descending order, one for each column. Sparse factors
    /// determine only three values: the largest one, the smallest non-zero one, and an upper bound
    /// of those that count as zero. With sparse factors, the smallest non-zero value replaces all
    /// non-zero values except the largest, and the bound replaces the values that count as zero.
    pub(crate) fn values(&self) -> Vec<f64> {
        match &self.sparse {
            None => self.svd().singular_values.as_slice().to_vec(),
            Some(sparse) => {
                let value = |k| match k {
                    0 if self.rank > 0 => sparse.largest,
                    k if k < self.rank => sparse.smallest,
                    _ => sparse.dropped(),
                };
                (0..self.matrix.ncols()).map(value).collect()
            }
        }
    }

    /// Returns the right singular vector of the smallest non-zero singular value; `None` if the
    /// matrix was decomposed densely.
    pub fn weakest(&self) -> Option<&[f64]> {
        self.sparse.as_ref().map(|sparse| sparse.weakest.as_slice())
    }

    /// Computes a basis of unit vectors of the null space, for the given rank. The basis from a
    /// dense decomposition is orthonormal. With sparse factors, each basis vector belongs to one
    /// dependent column and has only the components that this column requires, or it is a singular
    /// vector of a matrix of independent columns.
    pub fn null_space(&self, rank: usize) -> Vec<SparseVector> {
        let Some(sparse) = self.sparse.as_ref().filter(|_| rank == self.rank) else {
            let dense = |vector: &DVector<f64>| vector.iter().copied().enumerate().collect();
            return self.svd().null_space(rank).iter().map(dense).collect();
        };
        let mut vectors = sparse.upper.null_vectors(ROUND_OFF);
        let negligible = sparse.negligible.iter().rev();
        vectors.extend(negligible.map(|(_, v)| v.iter().copied().enumerate().collect::<Vec<_>>()));
        for vector in &mut vectors {
            let norm = vector.iter().map(|(_, x)| x * x).sum::<f64>().sqrt();
            vector.iter_mut().for_each(|(_, x)| *x /= norm);
        }
        vectors
    }

    /// Computes an orthonormal basis of the null space for the given rank.
    pub fn orthonormal_null_space(&self, rank: usize) -> Basis {
        let length = self.matrix.ncols();
        if self.sparse.is_none() || rank != self.rank {
            return Basis::of_dense(&self.svd().null_space(rank), length);
        }
        Basis::orthonormalised(self.null_space(rank), length, ROUND_OFF)
    }

    /// Computes the minimum-norm least-squares solution of `A x = right` for the decomposed matrix
    /// `A`.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let Some(sparse) = &self.sparse else {
            let right = DVector::from_column_slice(right);
            return self.svd().solve(&right, self.rank).as_slice().to_vec();
        };
        let once = |right: &[f64]| sparse.solve(&self.matrix.transposed_times(right));
        let mut solution = once(right);
        // Seminormal equations square the condition number; refinement compensates for this (Bjorck
        // 1987).
        for _ in 0..2 {
            let image = self.matrix.times(&solution);
            let rest: Vec<f64> = right.iter().zip(&image).map(|(r, i)| r - i).collect();
            solution.iter_mut().zip(once(&rest)).for_each(|(x, more)| *x += more);
        }
        solution
    }
}

/// Converts a sparse vector to a dense vector of the given length.
pub(crate) fn to_dense(vector: &[(usize, f64)], length: usize) -> DVector<f64> {
    let mut dense = DVector::zeros(length);
    vector.iter().for_each(|&(k, x)| dense[k] = x);
    dense
}

/// Computes the sum of vectors with `length` components, multiplied by the given amounts.
pub(crate) fn sum_of(
    vectors: &[SparseVector],
    amounts: impl IntoIterator<Item = f64>,
    length: usize,
) -> DVector<f64> {
    let mut sum = DVector::zeros(length);
    for (vector, amount) in vectors.iter().zip(amounts) {
        vector.iter().for_each(|&(k, x)| sum[k] += amount * x);
    }
    sum
}

impl SparseRank {
    /// Factors a matrix; returns `None` if the factors do not clearly decide the rank.
    fn new(matrix: &SparseMatrix, groups: &[usize], limit: Limit) -> Option<Self> {
        let columns = matrix.ncols();
        let square = |x: &[f64]| matrix.transposed_times(&matrix.times(x));
        let largest = match matrix.entries().next() {
            None => 0.0,
            Some(_) => match greatest(columns, ACCURACY_OF_LARGEST, square) {
                Some((value, _)) => value.sqrt(),
                None => bound_of_largest(matrix),
            },
        };
        let negligible = limit.value(largest);
        let upper = SparseQr::new(matrix, &ColumnOrder::new(matrix, groups), negligible);
        let rank = upper.rank();
        let square = match upper.dependent() {
            [] => None,
            _ => {
                let transposed = upper.transposed();
                let square = SparseQr::new(&transposed, &ColumnOrder::one_by_one(&transposed), 0.0);
                (square.rank() == rank).then_some(Some((transposed, square)))?
            }
        };
        let (smallest, weakest) = (largest, vec![0.0; columns]);
        let mut made = Self { upper, square, largest, negligible: Vec::new(), smallest, weakest };
        let is_full = rank == columns;
        while made.rank() > 0 {
            let inverse = |x: &[f64]| {
                let mut y = made.core().solve(&made.core().solve_transposed(x.to_vec()));
                made.remove_negligible(&mut y);
                y
            };
            let (value, vector) = greatest(rank, ACCURACY_OF_SMALLEST, inverse)?;
            made.smallest = value.sqrt().recip();
            made.weakest = match &made.square {
                Some((transposed, _)) => transposed.times(&vector),
                None => vector,
            };
            let norm = made.weakest.iter().map(|x| x * x).sum::<f64>().sqrt();
            made.weakest.iter_mut().for_each(|x| *x /= norm);
            let is_negligible = is_full
                && made.smallest > ACCURATE * largest
                && CERTAIN * made.smallest < negligible;
            if !is_negligible || made.negligible.len() == FEW {
                break;
            }
            made.negligible.push((made.smallest, core::mem::take(&mut made.weakest)));
        }
        let is_accurate = is_full && made.smallest > ACCURATE * largest;
        let clear = if is_accurate { CERTAIN } else { CLEAR };
        let is_kept = rank == 0 || made.smallest > clear * negligible;
        (is_kept && CLEAR * made.upper.dropped() <= negligible).then_some(made)
    }

    /// Returns the number of singular values that do not count as zero.
    fn rank(&self) -> usize {
        self.upper.rank() - self.negligible.len()
    }

    /// Returns an upper bound of the singular values that count as zero.
    fn dropped(&self) -> f64 {
        self.negligible.last().map_or_else(|| self.upper.dropped(), |(value, _)| *value)
    }

    /// Removes the components of a vector along the singular vectors of [`Self::negligible`].
    fn remove_negligible(&self, x: &mut [f64]) {
        for (_, vector) in &self.negligible {
            let amount: f64 = x.iter().zip(vector).map(|(x, v)| x * v).sum();
            x.iter_mut().zip(vector).for_each(|(x, v)| *x -= amount * v);
        }
    }

    /// Returns the triangular factor whose singular values are the non-zero singular values of the
    /// matrix.
    fn core(&self) -> &SparseQr {
        self.square.as_ref().map_or(&self.upper, |(_, square)| square)
    }

    /// Computes the minimum-norm solution of `A^T A x = right` for a right-hand side in the row
    /// space of `A`.
    fn solve(&self, right: &[f64]) -> Vec<f64> {
        let amounts = self.upper.solve_transposed(right.to_vec());
        match &self.square {
            None => {
                let mut solution = self.upper.solve(&amounts);
                self.remove_negligible(&mut solution);
                solution
            }
            Some((transposed, square)) => {
                transposed.times(&square.solve(&square.solve_transposed(amounts)))
            }
        }
    }
}

/// Computes an upper bound on the largest singular value: the geometric mean of the largest row sum
/// and the largest column sum of the magnitudes of the entries.
fn bound_of_largest(matrix: &SparseMatrix) -> f64 {
    let (mut rows, mut columns) = (vec![0.0; matrix.nrows()], vec![0.0; matrix.ncols()]);
    for (row, column, value) in matrix.entries() {
        rows[row] += value.abs();
        columns[column] += value.abs();
    }
    let most = |sums: Vec<f64>| sums.into_iter().fold(0.0, f64::max);
    (most(rows) * most(columns)).sqrt()
}

/// Computes the largest eigenvalue of a symmetric positive semidefinite operator on vectors of
/// length `length`, and its eigenvector; `None` if the iteration does not converge.
pub(crate) fn greatest(
    length: usize,
    accuracy: f64,
    apply: impl Fn(&[f64]) -> Vec<f64>,
) -> Option<(f64, Vec<f64>)> {
    // Any start vector that is not orthogonal to the eigenvector is suitable.
    let start = (0..length.div_ceil(BLOCK)).map(|part| -> Part {
        core::array::from_fn(|i| match BLOCK * part + i {
            k if k < length => (1.0 + 0.7548 * k as f64).sin(),
            _ => 0.0,
        })
    });
    let mut lanczos = Lanczos::default();
    let vector = lanczos.greatest(start, (accuracy, MANY_STEPS), |parts| {
        let image = apply(&parts.as_flattened()[..length]);
        parts.as_flattened_mut()[..length].copy_from_slice(&image);
    })?;
    let vector = vector.as_flattened()[..length].to_vec();
    let image = apply(&vector);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    Some((dot(&vector, &image) / dot(&vector, &vector), vector))
}
