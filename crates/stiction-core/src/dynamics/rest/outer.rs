//! Guaranteed bounds of static friction forces and of the changes of the efforts that they cause.
//!
//! Equations (R2) and (R3) of the book's theory.

use super::couplings::Couplings;
use super::map::FrictionMap;
use crate::linalg::largest;

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
    let constants: Vec<f64> = (0..count).map(alone).collect();
    // The spectral radius is proportional to `part`.
    if part * couplings.radius() >= 1.0 {
        return None;
    }
    let greatest = couplings.fixed_point(part, &constants)?;
    let least = -1e-12 * largest(&greatest);
    let sound = greatest.iter().all(|x| x.is_finite() && *x >= least);
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

/// Computes a guaranteed lower and upper bound of the change of each effort due to static friction,
/// N or N m. Returns `None` if the coupling of friction and reactions is too strong.
pub(super) fn outer_changes(
    map: &FrictionMap<'_>,
    couplings: &Couplings,
    efforts: usize,
) -> Option<Vec<(f64, f64)>> {
    let loads: Vec<f64> =
        (0..map.interfaces()).map(|interface| map.load_without(interface)).collect();
    let greatest = greatest_frictions(map, &loads, couplings, 1.0)?;
    let bounds = (0..efforts).map(|actuator| {
        let slopes = map.slopes(actuator);
        let (mut low, mut high) = (0.0, 0.0);
        let sizes = map.sizes(&slopes);
        for (interface, (size, &[mut up, mut down])) in sizes.into_iter().zip(&greatest).enumerate()
        {
            // Forward friction is positive; balls and plates have equal limits.
            if matches!(slopes[map.components(interface)], [slope] if slope < 0.0) {
                core::mem::swap(&mut up, &mut down);
            }
            high += size * up;
            low -= size * down;
        }
        (low, high)
    });
    Some(bounds.collect())
}
