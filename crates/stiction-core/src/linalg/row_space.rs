//! Row space of a small dense matrix: minimum-norm solutions, null space and dependent rows.

use crate::scalar::Scalar;

/// QR decomposition of the transpose of a matrix `J` with column pivoting: `J^T P = Q R`.
///
/// The rows of `J` are pivoted by their components orthogonal to the rows chosen before. Rows
/// without a significant orthogonal component are dependent. Householder reflections, Businger and
/// Golub 1965.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowSpace {
    rows: usize,
    columns: usize,
    rank: usize,
    /// Transposed factor `R^T` and Householder vectors, row by row in pivot order. A row contains
    /// `R^T` up to the diagonal, and behind it the Householder vector without its first component.
    work: Vec<f64>,
    /// For each Householder vector: its first component and half its squared length.
    heads: Vec<(f64, f64)>,
    /// Index in `J` of each row, in pivot order.
    order: Vec<usize>,
    /// Squared norms of the remaining components of the rows, in pivot order.
    remaining: Vec<Remaining>,
}

/// Squared norm of the component of a row orthogonal to the rows chosen before.
#[derive(Clone, Copy, Debug)]
struct Remaining {
    square: f64,
    /// Value of `square` when it was last computed from the component itself.
    computed: f64,
}

impl Remaining {
    /// An updated squared norm below this fraction of the computed one has lost digits, and is
    /// computed again. Above this fraction, its relative error is about 1e-14 times the number of
    /// columns.
    const KEPT: f64 = 0.01;
    /// Rows whose updated squared norms exceed this fraction of the largest one may be the largest.
    const NEARLY: f64 = 1.0 - 1e-10;

    fn of(component: &[f64]) -> Self {
        let square = dot(component, component);
        Self { square, computed: square }
    }

    /// Removes the first entry of `component`, which has become part of the triangular factor.
    fn shorten(&mut self, component: &[f64]) {
        let Some((first, rest)) = component.split_first() else { return };
        self.square -= first * first;
        if self.square <= Self::KEPT * self.computed {
            *self = Self::of(rest);
        }
    }
}

impl RowSpace {
    /// Decomposes `matrix`, which has `rows` rows and `columns` columns in row-major order. A row
    /// is dependent if the norm of its component orthogonal to the independent rows is at most
    /// `negligible`, or `negligible` times the largest row norm if that norm exceeds one.
    pub(crate) fn decompose(
        &mut self,
        matrix: &[f64],
        rows: usize,
        columns: usize,
        negligible: f64,
    ) {
        (self.rows, self.columns) = (rows, columns);
        self.work.clear();
        self.work.extend_from_slice(matrix);
        self.heads.clear();
        self.order.clear();
        self.order.extend(0..rows);
        self.rank = 0;
        let n = columns;
        self.remaining.clear();
        self.remaining.extend(self.work.chunks_exact(n.max(1)).map(Remaining::of));
        let mut first = 1.0_f64;
        for k in 0..rows.min(columns) {
            let largest =
                self.remaining[k..].iter().fold(0.0_f64, |most, row| most.max(row.square));
            let mut best = (k, 0.0);
            for row in k..rows {
                // The updated squares are accurate enough to exclude rows, but not to choose among
                // nearly equal ones: their squares are computed from the components.
                if self.remaining[row].square >= Remaining::NEARLY * largest {
                    let rest = &self.work[row * n + k..(row + 1) * n];
                    let size = dot(rest, rest);
                    if size > best.1 {
                        best = (row, size);
                    }
                }
            }
            let length = best.1.sqrt();
            if k == 0 {
                first = first.max(length);
            }
            // NaN also ends the decomposition; the NaN values remain visible in the solutions.
            if length.is_nan() || length <= negligible * first {
                break;
            }
            if best.0 != k {
                self.order.swap(k, best.0);
                self.remaining.swap(k, best.0);
                let (before, from) = self.work.split_at_mut(best.0 * n);
                before[k * n..(k + 1) * n].swap_with_slice(&mut from[..n]);
            }
            let diagonal = self.work[k * n + k];
            let new = if diagonal > 0.0 { -length } else { length };
            let head = diagonal - new;
            // Half the squared norm of the reflector.
            let half = -new * head;
            self.heads.push((head, half));
            let (done, rest) = self.work.split_at_mut((k + 1) * n);
            let reflector = &mut done[k * n + k..];
            reflector[0] = head;
            let remaining = self.remaining[k + 1..].iter_mut();
            for (row, remaining) in rest.chunks_exact_mut(n).zip(remaining) {
                reflect(reflector, half, &mut row[k..]);
                remaining.shorten(&row[k..]);
            }
            reflector[0] = new;
            self.rank += 1;
        }
    }

    /// Returns the number of independent rows.
    pub(crate) fn rank(&self) -> usize {
        self.rank
    }

    /// Returns the norm of the component of the last independent row orthogonal to the other
    /// independent rows, divided by the largest row norm. Returns one if no row is independent.
    pub(crate) fn least_part(&self) -> f64 {
        let diagonal = |k: usize| self.work[k * self.columns + k].abs();
        self.rank.checked_sub(1).map_or(1.0, |last| diagonal(last) / diagonal(0))
    }

    fn apply<T: Scalar>(&self, step: usize, vector: &mut [T]) {
        let n = self.columns;
        let (head, half) = self.heads[step];
        let tail = &self.work[step * n + step + 1..(step + 1) * n];
        let Some((first, rest)) = vector[step..].split_first_mut() else { return };
        let mut sum = *first * T::from_f64(head);
        for (t, x) in tail.iter().zip(&*rest) {
            sum += *x * T::from_f64(*t);
        }
        let amount = sum / T::from_f64(half);
        *first -= amount * T::from_f64(head);
        rest.iter_mut().zip(tail).for_each(|(x, t)| *x -= amount * T::from_f64(*t));
    }

    /// Computes the vector of minimum norm whose scalar products with the independent rows equal
    /// the corresponding values in `right`, which has one value for each row of the matrix.
    pub(crate) fn shortest(&self, right: &[f64]) -> Vec<f64> {
        let mut vector = Vec::new();
        self.shortest_into(right, &mut vector);
        vector
    }

    /// Computes the same vector as [`Self::shortest`] and writes it to `vector`.
    pub(crate) fn shortest_into(&self, right: &[f64], vector: &mut Vec<f64>) {
        let n = self.columns;
        vector.clear();
        vector.resize(n, 0.0);
        // Forward substitution: R^T y = right.
        for k in 0..self.rank {
            let mut sum = right[self.order[k]];
            for (i, y) in vector.iter().enumerate().take(k) {
                sum -= self.work[k * n + i] * y;
            }
            vector[k] = sum / self.work[k * n + k];
        }
        for step in (0..self.rank).rev() {
            self.apply(step, vector);
        }
    }

    /// Computes an orthonormal basis of the null space. The vectors are stored one after the other.
    pub(crate) fn null_space(&self) -> Vec<f64> {
        let mut basis = Vec::new();
        self.null_space_into(&mut basis);
        basis
    }

    /// Computes the same basis as [`Self::null_space`] and writes it to `basis`.
    pub(crate) fn null_space_into(&self, basis: &mut Vec<f64>) {
        let n = self.columns;
        basis.clear();
        basis.resize(n * (n - self.rank), 0.0);
        for (k, vector) in basis.chunks_exact_mut(n.max(1)).enumerate() {
            vector[self.rank + k] = 1.0;
            for step in (0..self.rank).rev() {
                self.apply(step, vector);
            }
        }
    }

    /// Computes the coefficients of the linear combination of rows that is the orthogonal
    /// projection of `vector` on the row space. Coefficients of dependent rows are zero. Overwrites
    /// `vector`.
    pub(crate) fn amounts<T: Scalar>(&self, vector: &mut [T], amounts: &mut Vec<T>) {
        for step in 0..self.rank {
            self.apply(step, vector);
        }
        amounts.clear();
        amounts.resize(self.rows, T::zero());
        self.back(vector);
        for k in 0..self.rank {
            amounts[self.order[k]] = vector[k];
        }
    }

    /// Solves `R x = right` by back substitution, writing `x` to the first entries of `right`.
    fn back<T: Scalar>(&self, right: &mut [T]) {
        let n = self.columns;
        for k in (0..self.rank).rev() {
            let mut sum = right[k];
            for (later, x) in right.iter().enumerate().take(self.rank).skip(k + 1) {
                sum -= *x * T::from_f64(self.work[later * n + k]);
            }
            right[k] = sum / T::from_f64(self.work[k * n + k]);
        }
    }

    /// Computes the coefficients of one vanishing linear combination of rows for each dependent
    /// row. The coefficient of the dependent row is one, those of the other dependent rows are
    /// zero.
    pub(crate) fn dependencies(&self) -> Vec<Vec<f64>> {
        let n = self.columns;
        let each = (self.rank..self.rows).map(|dependent| {
            let mut parts: Vec<f64> = self.work[dependent * n..dependent * n + self.rank].to_vec();
            self.back(&mut parts);
            let mut amounts = vec![0.0; self.rows];
            for (k, part) in parts.iter().enumerate() {
                amounts[self.order[k]] = -part;
            }
            amounts[self.order[dependent]] = 1.0;
            amounts
        });
        each.collect()
    }
}

fn reflect(reflector: &[f64], half: f64, vector: &mut [f64]) {
    let amount = dot(reflector, vector) / half;
    vector.iter_mut().zip(reflector).for_each(|(x, r)| *x -= amount * r);
}

/// Computes the scalar product of two vectors of equal length, accumulated in four independent
/// sums.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn times(matrix: &[f64], columns: usize, x: &[f64]) -> Vec<f64> {
        matrix.chunks_exact(columns).map(|r| r.iter().zip(x).map(|(a, b)| a * b).sum()).collect()
    }

    /// Checks that updated norms choose the pivots in the order of the known sizes, for rows that
    /// differ only slightly, so that most digits cancel after the first pivot.
    #[test]
    fn updated_norms_keep_their_digits() {
        let (m, n) = (6, 8);
        let mut random = crate::random::Random::new(11);
        let base: Vec<f64> = (0..n).map(|_| random.number()).collect();
        let size = |row: usize| 10.0_f64.powi(-2 * (row as i32 + 1));
        let matrix: Vec<f64> = (0..m)
            .flat_map(|row| base.iter().map(move |x| (row, *x)).collect::<Vec<_>>())
            .map(|(row, x)| if row == 0 { 2.0 * x } else { x + size(row) * random.number() })
            .collect();
        let mut space = RowSpace::default();
        space.decompose(&matrix, m, n, 1e-14);
        assert_eq!((space.rank(), &space.order[..]), (6, &[0, 1, 2, 3, 4, 5][..]));
    }

    proptest! {
        /// Checks the decomposition of five rows in seven dimensions, the last two of which are
        /// combinations of the first three: number of dependencies, null space, minimum-norm
        /// solution, and projection.
        #[test]
        fn dependent_rows_are_reported(
            numbers in prop::collection::vec(-1.0..1.0_f64, 21),
            mix in prop::collection::vec(-1.0..1.0_f64, 6),
        ) {
            let (m, n) = (5, 7);
            let mut matrix = numbers;
            for part in mix.chunks_exact(3) {
                for column in 0..n {
                    let sum = (0..3).map(|k| part[k] * matrix[k * n + column]).sum();
                    matrix.push(sum);
                }
            }
            let mut space = RowSpace::default();
            space.decompose(&matrix, m, n, 1e-10);
            prop_assume!(space.rank() == 3);
            prop_assert_eq!(space.dependencies().len(), 2);
            let basis = space.null_space();
            for vector in basis.chunks_exact(n) {
                prop_assert!(times(&matrix, n, vector).iter().all(|x| x.abs() < 1e-13));
                prop_assert!((vector.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-13);
            }
            // The minimum-norm solution of consistent equations lies in the row space.
            let wanted = times(&matrix, n, &[0.3, -0.2, 0.9, 0.1, -0.7, 0.4, 0.5]);
            let short = space.shortest(&wanted);
            let found = times(&matrix, n, &short);
            // Nearly dependent rows magnify round-off errors, so the tolerance is wide.
            prop_assert!(found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-8));
            for vector in basis.chunks_exact(n) {
                let along: f64 = vector.iter().zip(&short).map(|(a, b)| a * b).sum();
                prop_assert!(along.abs() < 1e-8);
            }
            let mut amounts = Vec::new();
            space.amounts(&mut short.clone(), &mut amounts);
            for column in 0..n {
                let sum: f64 = (0..m).map(|row| amounts[row] * matrix[row * n + column]).sum();
                prop_assert!((sum - short[column]).abs() < 1e-6 * (1.0 + short[column].abs()));
            }
            for dependency in space.dependencies() {
                for column in 0..n {
                    let sum: f64 = (0..m).map(|row| dependency[row] * matrix[row * n + column]).sum();
                    prop_assert!(sum.abs() < 1e-9);
                }
            }
        }
    }
}
