//! Guaranteed bounds of static friction forces and of the changes of the efforts that they cause.
//!
//! Equations (R2) and (R3) of the book's theory.

use super::map::{Couplings, FrictionMap};
use nalgebra::{DMatrix, DVector};

/// Computes an upper bound of the friction force of each interface, N, for forward and backward
/// sliding (positive and negative friction). The bound is valid for all solutions of the friction
/// laws with all coefficients multiplied by `part`. For a sliding interface, it is a bound of the
/// change of the friction force. `loads` and `couplings` must bound the normal forces `N <= loads +
/// couplings |friction|`.
///
/// Let `mu` be the friction coefficients times `part`, and `M = mu couplings`. If the spectral
/// radius of `M` is below one, `|f| <= mu loads + M |f|` implies `|f| <= (I - M)^-1 mu loads`,
/// because `(I - M)^-1` has no negative entries. Otherwise returns `None`.
pub(super) fn greatest_frictions(
    map: &FrictionMap<'_>,
    loads: &[f64],
    couplings: &Couplings,
    part: f64,
) -> Option<Vec<[f64; 2]>> {
    let count = map.interfaces();
    let coefficient = |interface: usize| {
        let [forward, backward] = map.coefficients(interface);
        part * forward.max(backward)
    };
    let alone = |interface: usize| {
        if map.rests(interface) { coefficient(interface) * loads[interface] } else { 0.0 }
    };
    let constants = DVector::from_fn(count, |interface, _| alone(interface));
    // The spectral radius is proportional to `part`.
    if part * couplings.radius() >= 1.0 {
        return None;
    }
    let greatest = match &couplings.of_limits {
        Some(matrix) => fixed_point(matrix, part, &constants)?,
        None => constants,
    };
    let sound = greatest.iter().all(|x| x.is_finite() && *x >= -1e-12 * greatest.amax());
    let limit = |(interface, greatest): (usize, &f64)| {
        let [forward, backward] = map.coefficients(interface);
        let most = forward.max(backward);
        let part = |coefficient: f64| if most > 0.0 { coefficient / most } else { 0.0 };
        // The friction of a sliding interface may change in either direction.
        let parts = if map.rests(interface) { [part(forward), part(backward)] } else { [1.0; 2] };
        parts.map(|part| part * greatest.max(0.0))
    };
    sound.then(|| greatest.iter().enumerate().map(limit).collect())
}

/// Largest number of fixed-point steps. If more steps are needed, a factorisation is faster.
const STEPS: usize = 16;

/// Solves `x = constants + part matrix x`. The spectral radius of `part matrix` must be below one.
fn fixed_point(matrix: &DMatrix<f64>, part: f64, constants: &DVector<f64>) -> Option<DVector<f64>> {
    let mut solution = constants.clone();
    // Weak couplings converge in a few steps.
    for _ in 0..STEPS {
        let next = constants + matrix * &solution * part;
        let change = (&next - &solution).amax();
        solution = next;
        if change <= f64::EPSILON * solution.amax() {
            return Some(solution);
        }
    }
    (DMatrix::identity(matrix.nrows(), matrix.ncols()) - matrix * part).lu().solve(constants)
}

/// Computes a guaranteed lower and upper bound of the change of each effort due to static friction,
/// N or N m. Returns `None` if the coupling of friction and reactions is too strong.
pub(super) fn outer_changes(map: &FrictionMap<'_>, efforts: usize) -> Option<Vec<(f64, f64)>> {
    let loads: Vec<f64> =
        (0..map.interfaces()).map(|interface| map.load_without(interface)).collect();
    let couplings = map.couplings();
    let greatest = greatest_frictions(map, &loads, &couplings, 1.0)?;
    let owners: Vec<usize> = map.owners().collect();
    let bounds = (0..efforts).map(|actuator| {
        let slopes = map.slopes(actuator);
        let sizes = map.sizes(&slopes);
        let (mut low, mut high) = (0.0, 0.0);
        for (interface, size) in sizes.into_iter().enumerate() {
            let single = owners.iter().filter(|owner| **owner == interface).count() == 1;
            let slope =
                owners.iter().position(|owner| *owner == interface).map_or(0.0, |k| slopes[k]);
            let [mut up, mut down] = greatest[interface];
            // Forward friction is positive; balls and plates have equal limits.
            if single && slope < 0.0 {
                core::mem::swap(&mut up, &mut down);
            }
            high += size * up;
            low -= size * down;
        }
        (low, high)
    });
    Some(bounds.collect())
}
