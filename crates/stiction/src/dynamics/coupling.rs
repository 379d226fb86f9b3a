//! How strongly friction and reactions are coupled: whether there can be another solution.

use super::inverse::{Inverse, Setup};
use crate::friction::Resistance;
use crate::kinematics::Bodies;
use crate::parameters::Parameters;

/// Steps of the power iteration; any number gives a bound.
const STEPS: usize = 60;

/// A bound on the spectral radius of the coupling: entry (i, j) of the matrix is the most by which
/// the load of contact i changes when the load of contact j changes by one newton, through the
/// friction at j. Load maps are seminorms of the reaction, and reactions are affine in frictions,
/// so with a radius below one friction and reactions have one solution and no other
/// (Banach's fixed-point theorem in the maximum norm weighted by the matrix's own vector).
pub(super) fn strength(
    inverse: &Inverse<f64>,
    setup: &Setup<'_>,
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
) -> f64 {
    let sliding: Vec<usize> = (0..parameters.contacts.len())
        .filter(|&contact| {
            let state = &inverse.contacts()[contact];
            state.sliding > 0.0 && state.resistance.coefficient > 0.0
        })
        .collect();
    let mut probe = inverse.clone();
    let none = Resistance { coefficient: 0.0, viscous: 0.0 };
    let one = Resistance { coefficient: 0.0, viscous: 1.0 };
    probe.set_resistances(none);
    let without = probe.frozen_wrenches(setup, parameters, bodies).to_vec();
    let mut matrix = vec![vec![0.0; sliding.len()]; sliding.len()];
    for (j, &from) in sliding.iter().enumerate() {
        probe.set_resistance(from, one);
        let with = probe.frozen_wrenches(setup, parameters, bodies).to_vec();
        probe.set_resistance(from, none);
        for (i, &to) in sliding.iter().enumerate() {
            let joint = parameters.contacts[to].joint;
            let change = with[joint] - without[joint];
            let [own, coefficient] =
                [to, from].map(|contact| inverse.contacts()[contact].resistance.coefficient);
            let most = inverse.most_change_of_load(to, parameters, bodies, change, own);
            matrix[i][j] = coefficient * most;
        }
    }
    radius_bound(&matrix)
}

/// The spectral radius of a matrix without negative entries is at most the largest ratio of
/// `(matrix x)_i` to `x_i`, for any positive `x` (Collatz and Wielandt).
pub(super) fn radius_bound(matrix: &[Vec<f64>]) -> f64 {
    let mut x = vec![1.0; matrix.len()];
    let mut bound = f64::INFINITY;
    if matrix.is_empty() {
        return 0.0;
    }
    // Comparisons would pass over NaN.
    if matrix.iter().flatten().any(|entry| !entry.is_finite()) {
        return f64::INFINITY;
    }
    for _ in 0..STEPS {
        let next: Vec<f64> = matrix
            .iter()
            .map(|row| row.iter().zip(&x).map(|(entry, x)| entry * x).sum::<f64>())
            .collect();
        let ratio = next.iter().zip(&x).map(|(next, x)| next / x).fold(0.0, f64::max);
        bound = bound.min(ratio);
        // Half a step, and not to zero: the vector stays positive whatever the matrix.
        let largest = next.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        for (x, next) in x.iter_mut().zip(&next) {
            *x = 0.5 * *x + 0.5 * next / largest + 1e-12;
        }
    }
    bound
}

#[cfg(test)]
mod tests {
    use super::radius_bound;

    #[test]
    fn bounds_are_near_the_radius_and_never_below() {
        let rotation = vec![vec![0.0, 0.5], vec![0.5, 0.0]];
        let nilpotent = vec![vec![0.0, 3.0], vec![0.0, 0.0]];
        let mixed = vec![vec![0.1, 0.2], vec![0.3, 0.2]];
        assert!((radius_bound(&rotation) - 0.5).abs() < 1e-9);
        assert!(radius_bound(&nilpotent) < 0.1);
        assert!((radius_bound(&mixed) - 0.4).abs() < 1e-6 && radius_bound(&mixed) >= 0.4 - 1e-15);
        assert_eq!(radius_bound(&[]), 0.0);
    }
}
