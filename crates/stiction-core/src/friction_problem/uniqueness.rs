//! Bound on the coupling of friction and normal loads: below one the solution is unique.
//!
//! Equations (F6) and (F7) of the book's theory.

use super::influence::Influence;
use super::normal_load::Configuration;

/// Number of power iterations; any number yields a bound.
const STEPS: usize = 60;

/// Buffers of [`coupling_bound`].
#[derive(Clone, Debug, Default)]
pub(crate) struct BoundWorkspace {
    interfaces: Vec<(usize, f64)>,
    /// Coupling matrix, row by row.
    matrix: Vec<f64>,
    vectors: [Vec<f64>; 2],
}

/// Bound on the spectral radius of the coupling. Entry (i, j) of the coupling matrix bounds the
/// change of the normal load of interface i per newton of change of that of interface j, through
/// the friction at j. Load maps are seminorms of the wrench, and wrenches are affine in frictions.
/// With a radius below one the solution therefore exists and is unique (Banach's fixed-point
/// theorem in the maximum norm weighted by the eigenvector of the matrix).
///
/// `interfaces` lists the interfaces by index, each with its friction coefficient; `influence` is
/// per unit of normal load.
pub(crate) fn coupling_bound(
    at: Configuration<'_>,
    interfaces: impl Iterator<Item = (usize, f64)>,
    influence: &mut impl Influence,
    workspace: &mut BoundWorkspace,
) -> f64 {
    let BoundWorkspace { interfaces: known, matrix, vectors } = workspace;
    known.clear();
    known.extend(interfaces);
    let count = known.len();
    matrix.clear();
    matrix.resize(count * count, 0.0);
    if count > 0 {
        influence.visit(|row, column, wrench| {
            let (interface, own) = known[row];
            matrix[row * count + column] = at.largest_load_change(interface, wrench, own);
        });
    }
    radius_bound(matrix, count, vectors)
}

/// Bound on the spectral radius of a matrix without negative entries: the largest ratio of `(matrix x)_i` to `x_i`, for
/// any positive `x` (Collatz and Wielandt).
pub(crate) fn radius_bound(matrix: &[f64], count: usize, [x, next]: &mut [Vec<f64>; 2]) -> f64 {
    let mut bound = f64::INFINITY;
    if count == 0 {
        return 0.0;
    }
    // Comparisons with NaN are false: check explicitly.
    if matrix.iter().any(|entry| !entry.is_finite()) {
        return f64::INFINITY;
    }
    x.clear();
    x.resize(count, 1.0);
    next.clear();
    next.resize(count, 0.0);
    for _ in 0..STEPS {
        for (next, row) in next.iter_mut().zip(matrix.chunks_exact(count)) {
            *next = row.iter().zip(x.iter()).map(|(entry, x)| entry * x).sum();
        }
        let ratio = next.iter().zip(x.iter()).map(|(next, x)| next / x).fold(0.0, f64::max);
        bound = bound.min(ratio);
        // Damping by half and a positive lower bound keep the vector positive for any matrix.
        let largest = next.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        for (x, next) in x.iter_mut().zip(next.iter()) {
            *x = 0.5 * *x + 0.5 * next / largest + 1e-12;
        }
    }
    bound
}

#[cfg(test)]
mod tests {
    fn radius_bound(matrix: &[f64]) -> f64 {
        super::radius_bound(matrix, matrix.len().isqrt(), &mut Default::default())
    }

    #[test]
    fn bounds_are_near_the_radius_and_never_below() {
        let rotation = [0.0, 0.5, 0.5, 0.0];
        let nilpotent = [0.0, 3.0, 0.0, 0.0];
        let mixed = [0.1, 0.2, 0.3, 0.2];
        assert!((radius_bound(&rotation) - 0.5).abs() < 1e-9);
        assert!(radius_bound(&nilpotent) < 0.1);
        assert!((radius_bound(&mixed) - 0.4).abs() < 1e-6 && radius_bound(&mixed) >= 0.4 - 1e-15);
        assert_eq!(radius_bound(&[]), 0.0);
    }
}
