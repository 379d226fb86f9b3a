//! How strongly friction and reactions are coupled: whether there can be another solution.
//!
//! Equations (F6) and (F7) of the book's theory.

use super::balance::Balance;
use super::interfaces::{InterfaceState, most_change_of_load};
use super::inverse::Inverse;
use super::model::Model;
use crate::friction::Resistance;
use crate::kinematics::Bodies;
use crate::parameters::Parameters;

/// Steps of the power iteration; any number gives a bound.
const STEPS: usize = 60;

/// Room to measure the coupling in; what is there is used again.
#[derive(Clone, Debug, Default)]
pub(super) struct CouplingWorkspace {
    balance: Option<Balance<f64>>,
    efforts: Vec<f64>,
    sliding: Vec<usize>,
    /// Row by row.
    matrix: Vec<f64>,
    vectors: [Vec<f64>; 2],
}

impl CouplingWorkspace {
    /// A bound on the spectral radius of the coupling: entry (i, j) of the matrix is the most by
    /// which the load of contact i changes when the load of contact j changes by one newton, through
    /// the friction at j. Load maps are seminorms of the reaction, and reactions are affine in
    /// frictions, so with a radius below one friction and reactions have one solution and no other
    /// (Banach's fixed-point theorem in the maximum norm weighted by the matrix's own vector).
    pub(super) fn strength(
        &mut self,
        inverse: &Inverse<f64>,
        model: &Model,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
    ) -> f64 {
        let Self { balance, efforts, sliding, matrix, vectors } = self;
        sliding.clear();
        sliding.extend((0..parameters.interfaces.len()).filter(|&interface| {
            let state = &inverse.interfaces()[interface];
            state.sliding > 0.0 && state.resistance.coefficient > 0.0
        }));
        let balance = match balance {
            Some(balance) if balance.fits(inverse.balance()) => balance,
            other => other.insert(inverse.balance().clone()),
        };
        efforts.resize(inverse.efforts().len(), 0.0);
        let count = sliding.len();
        matrix.clear();
        matrix.resize(count * count, 0.0);
        if count == 0 {
            return 0.0;
        }
        // One factorisation serves all contacts.
        balance.factor_frictionless(inverse.balance(), &model.balance, parameters, bodies);
        for (j, &from) in sliding.iter().enumerate() {
            let resistance = Resistance { coefficient: 0.0, constant: 1.0 };
            let unit = InterfaceState { resistance, ..inverse.interfaces()[from] };
            let interface = &parameters.interfaces[from];
            balance.apply_friction_alone(
                &model.balance,
                parameters,
                bodies,
                interface,
                &unit,
                efforts,
            );
            for (i, &to) in sliding.iter().enumerate() {
                let content = &parameters.interfaces[to];
                let pitch = parameters.pitch[content.joint];
                let change = balance.joint_wrenches[content.joint];
                let [own, coefficient] = [to, from]
                    .map(|interface| inverse.interfaces()[interface].resistance.coefficient);
                let most = most_change_of_load(content, pitch, bodies, change, own);
                matrix[i * count + j] = coefficient * most;
            }
        }
        radius_bound(matrix, count, vectors)
    }
}

/// The spectral radius of a matrix without negative entries is at most the largest ratio of
/// `(matrix x)_i` to `x_i`, for any positive `x` (Collatz and Wielandt).
pub(crate) fn radius_bound(matrix: &[f64], count: usize, [x, next]: &mut [Vec<f64>; 2]) -> f64 {
    let mut bound = f64::INFINITY;
    if count == 0 {
        return 0.0;
    }
    // Comparisons would pass over NaN.
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
        // Half a step, and not to zero: the vector stays positive whatever the matrix.
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
