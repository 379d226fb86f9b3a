//! Computes the smallest singular value of a matrix, faster than by a complete decomposition.

use super::Svd;
use nalgebra::{DMatrix, DVector};

/// Number of vectors that are iterated together. With fewer vectors, clusters of small singular
/// values slow down the iteration.
const BLOCK: usize = 3;
/// Maximum number of iteration steps. If they do not converge, a singular value decomposition
/// follows.
const STEPS: usize = 60;
/// Relative change of the squared singular value in one step at which the iteration stops.
const ACCURACY: f64 = 1e-13;
/// Smallest singular value that is accepted from the iteration, as a fraction of the largest matrix
/// entry. For smaller values, squaring the matrix loses too many digits.
const SQUARABLE: f64 = 1e-3;

/// Computes the smallest of the `min(rows, columns)` singular values of a matrix.
///
/// Uses block inverse iteration with the Gram matrix of the shorter side. For values so small that
/// squaring the matrix loses digits, uses the singular value decomposition.
pub fn smallest_singular_value(matrix: &DMatrix<f64>) -> f64 {
    let (rows, columns) = matrix.shape();
    let size = rows.min(columns);
    if size == 0 {
        return 0.0;
    }
    let by_iteration = || {
        let gram =
            if rows <= columns { matrix * matrix.transpose() } else { matrix.tr_mul(matrix) };
        let factor = gram.cholesky()?;
        let block = BLOCK.min(size);
        // Any start vectors that are not orthogonal to the singular vector are suitable.
        let mut vectors = DMatrix::from_fn(size, block, |i, j| {
            (1.0 + i as f64 * (0.7548 + 0.5698 * j as f64)).sin()
        });
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            factor.solve_mut(&mut vectors);
            // The lengths before orthogonalisation tend to the inverse of the smallest eigenvalue
            // of the Gram matrix.
            let largest = orthonormalise(&mut vectors)?;
            let now = largest.recip();
            if (now - last).abs() <= ACCURACY * now {
                return Some(now.sqrt());
            }
            last = now;
        }
        None
    };
    match by_iteration() {
        Some(value) if value > SQUARABLE * matrix.amax() => value,
        _ => {
            let shorter = if rows < columns { matrix.transpose() } else { matrix.clone() };
            Svd::new(&shorter).singular_values[size - 1]
        }
    }
}

/// Replaces the columns by an orthonormal basis of their span. Returns the largest singular value
/// of the original columns, or `None` if it is zero or not finite.
fn orthonormalise(vectors: &mut DMatrix<f64>) -> Option<f64> {
    let svd = Svd::new(vectors);
    let largest = svd.largest();
    if !(largest.is_finite() && largest > 0.0) {
        return None;
    }
    for (k, mut column) in vectors.column_iter_mut().enumerate() {
        let direction: DVector<f64> = svd.u.column(k).into_owned();
        column.copy_from(&direction);
    }
    Some(largest)
}
