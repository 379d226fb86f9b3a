//! Inverse iteration for the smallest eigenvalue of a Gram matrix.

use super::super::prediction::Shift;
use crate::linalg::{BlockCholesky, Lanczos, Part, STEPS, dot};

/// Relative distance of the shift from the smallest eigenvalue at which the bisection ends, and the
/// largest number of bisections.
const CLOSE: f64 = 1e-4;
const BISECTIONS: usize = 30;

/// Computes the eigenvector of the smallest eigenvalue of a matrix by inverse iteration with the
/// given shift. Returns `None` if the shifted matrix is not positive definite, or if the iteration
/// does not converge.
pub(super) fn weakest<'a>(
    matrix: &mut BlockCholesky,
    lanczos: &'a mut Lanczos,
    start: impl Iterator<Item = Part>,
    Shift { by, accuracy }: Shift,
) -> Option<&'a [Part]> {
    matrix.shift(by);
    if !matrix.factor() {
        return None;
    }
    lanczos.greatest(start, (accuracy, STEPS), |vector| matrix.solve(vector))
}

/// Returns a shift slightly below the smallest eigenvalue of a matrix, found by bisection: the
/// Cholesky decomposition of the shifted matrix exists if the shift is below all eigenvalues.
/// Returns `None` if the matrix is not positive definite. The matrix is overwritten.
///
/// If many eigenvalues are close to the smallest one, as with many similar legs, iterations without
/// a shift converge too slowly.
pub(super) fn shift_below(matrix: &mut BlockCholesky) -> Option<Shift> {
    matrix.keep();
    let (mut below, mut above) = (0.0, matrix.least_diagonal());
    for _ in 0..BISECTIONS {
        if above - below <= CLOSE * above {
            break;
        }
        let middle = 0.5 * (below + above);
        matrix.restore();
        matrix.shift(middle);
        match matrix.factor() {
            true => below = middle,
            false => above = middle,
        }
    }
    // If no shift was below all eigenvalues, the matrix is not known to be positive definite.
    if below > 0.0 { Shift::below(above, (above - below) / above) } else { None }
}

pub(super) fn length_squared(vector: &[Part]) -> f64 {
    vector.iter().map(|part| dot(part, part)).sum()
}
