//! Singularity indices from the triangular factor of the balance matrix, for small singular values.
//!
//! A Gram matrix has the square of the condition number of the balance matrix. The triangular
//! factor of the balance matrix yields small singular values with an error of the order of
//! round-off.

use super::{Content, SingularityDistances, SingularityIndex};
use crate::linalg::{BLOCK, ColumnOrder, SparseMatrix, SparseQr, greatest};

/// Relative residual at which inverse iteration has converged. Round-off in the solutions, relative
/// to the singular value, may exceed a smaller residual.
const ACCURACY: f64 = 1e-9;

impl SingularityIndex {
    /// Number of unknowns of a joint in the matrix whose smallest singular value is the index.
    fn unknowns(self, joint: &Content) -> usize {
        match self {
            Self::Actuation => joint.unknowns,
            Self::Constraint => joint.constraints,
        }
    }
}

impl SingularityDistances {
    /// Computes an index at the configuration set by [`Self::place`] by inverse iteration with the
    /// triangular factor of the balance matrix. Returns `None` if the matrix is singular or the
    /// iteration does not converge.
    pub(super) fn smallest_by_factor(&mut self, index: SingularityIndex) -> Option<f64> {
        let mut groups = Vec::new();
        let mut entries = Vec::new();
        for (number, (joint, on)) in self.joints.iter().zip(&self.on).enumerate() {
            for unknown in 0..index.unknowns(joint) {
                let column = groups.len();
                groups.push(number);
                for (end, on) in joint.ends.iter().zip(on) {
                    let Some(body) = end.checked_sub(1) else { continue };
                    let parts = on[unknown].iter().enumerate();
                    entries.extend(parts.map(|(i, part)| (BLOCK * body + i, column, *part)));
                }
            }
        }
        let columns = groups.len();
        let matrix = SparseMatrix::new((BLOCK * self.bodies, columns), entries.into_iter());
        let order = match index {
            SingularityIndex::Actuation => &mut self.orders[0],
            SingularityIndex::Constraint => &mut self.orders[1],
        };
        // Any order is correct; that of a matrix with more zeros may be slower.
        let order = order.get_or_insert_with(|| ColumnOrder::new(&matrix, &groups));
        let factor = SparseQr::new(&matrix, order, 0.0);
        if factor.rank() < columns {
            return None;
        }
        let inverse = |x: &[f64]| factor.solve(&factor.solve_transposed(x.to_vec()));
        let (_, found) = greatest(columns, ACCURACY, inverse)?;
        // Use the balance matrix itself, because its factor has rounded entries.
        let norm = |vector: &[f64]| vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        let value = norm(&matrix.times(&found)) / norm(&found);
        value.is_finite().then_some(value)
    }
}
