//! Inverse iteration for the smallest eigenvalue of a Gram matrix.

use super::super::prediction::Shift;
use crate::linalg::{BLOCK, BlockCholesky, Lanczos, Part, STEPS, Twofold, dot};

/// Maximum number of refinement passes. For singular values at [`TINY`](super::TINY), each pass divides the
/// error by about a hundred.
const PASSES: usize = 10;
/// Refinement ends when the norm of the correction is at most this fraction of the norm of the
/// solution. The value is of the order of round-off.
const REFINED: f64 = 1e-14;
/// Relative distance of the shift from the smallest eigenvalue at which the bisection ends, and the
/// largest number of bisections.
const CLOSE: f64 = 1e-4;
const BISECTIONS: usize = 30;
/// Relative residual at which the iteration with refined solutions has converged.
const REFINED_ACCURACY: f64 = 1e-12;

/// Computes the eigenvector of the smallest eigenvalue of a matrix by inverse iteration with the
/// given shift. Without a shift, solutions are refined with `product`, which adds the product of
/// the exact matrix and a vector to its output. Returns `None` if the shifted matrix is not
/// positive definite, or if the iteration or the refinement does not converge.
pub(super) fn weakest<'a>(
    matrix: &mut BlockCholesky,
    lanczos: &'a mut Lanczos,
    start: impl Iterator<Item = Part>,
    shift: Option<Shift>,
    product: impl Fn(&[Part], &mut [[Twofold; BLOCK]]),
) -> Option<&'a [Part]> {
    matrix.shift(shift.map_or(0.0, |shift| shift.by));
    if !matrix.factor() {
        return None;
    }
    if let Some(Shift { accuracy, .. }) = shift {
        return lanczos.greatest(start, (accuracy, STEPS), |vector| matrix.solve(vector));
    }
    let mut settled = true;
    let refined = |vector: &mut [Part]| settled &= solve_refined(matrix, vector, &product);
    let found = lanczos.greatest(start, (REFINED_ACCURACY, STEPS), refined);
    found.filter(|_| settled)
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

/// Solves a linear system in place by iterative refinement with an approximate decomposition;
/// `vector` contains the right-hand side and receives the solution. Returns `false` if the
/// refinement does not converge.
fn solve_refined(
    matrix: &mut BlockCholesky,
    vector: &mut [Part],
    product: &impl Fn(&[Part], &mut [[Twofold; BLOCK]]),
) -> bool {
    let wanted = vector.to_vec();
    matrix.solve(vector);
    let mut left = vec![[Twofold::default(); BLOCK]; wanted.len()];
    for _ in 0..PASSES {
        for (left, wanted) in left.iter_mut().flatten().zip(wanted.iter().flatten()) {
            *left = Twofold::default();
            left.add_product(-1.0, *wanted);
        }
        product(vector, &mut left);
        let mut correction: Vec<Part> =
            left.iter().map(|part| part.map(|sum| -sum.value())).collect();
        matrix.solve(&mut correction);
        for (x, more) in vector.iter_mut().flatten().zip(correction.iter().flatten()) {
            *x += more;
        }
        let [size, change] = [&*vector, &correction].map(length_squared);
        if change <= REFINED * REFINED * size {
            return true;
        }
        if !change.is_finite() {
            break;
        }
    }
    false
}

pub(super) fn length_squared(vector: &[Part]) -> f64 {
    vector.iter().map(|part| dot(part, part)).sum()
}
