//! Smallest singular value, computed faster than by a complete decomposition.

use super::Svd;
use nalgebra::{DMatrix, DVector};

/// Number of vectors iterated together: with fewer vectors, clusters of small singular values slow the
/// iteration down.
const BLOCK: usize = 3;
/// Number of steps before the singular value decomposition takes over.
const STEPS: usize = 60;
/// Relative accuracy at which the iteration stops.
const ACCURACY: f64 = 1e-13;
/// Squaring the matrix loses digits if the singular value is below this fraction of the largest
/// entry.
const SQUARABLE: f64 = 1e-3;

/// Smallest of the `min(rows, columns)` singular values of a matrix.
///
/// Uses inverse iteration of a block with the Gram matrix of the shorter side, or the singular
/// value decomposition for values so small that squaring the matrix loses digits.
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
        // Any initial vectors that are not orthogonal to the solution are suitable.
        let mut vectors = DMatrix::from_fn(size, block, |i, j| {
            (1.0 + i as f64 * (0.7548 + 0.5698 * j as f64)).sin()
        });
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            factor.solve_mut(&mut vectors);
            // The lengths after orthogonalisation grow like the inverse of the smallest value.
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

/// Makes the columns orthonormal; returns the largest singular value of the given columns, or
/// `None` if they are not finite.
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
