//! Self-locking: configurations that static friction holds without actuator efforts.
//!
//! Equation (R5) of the book's theory.

use super::couplings::Couplings;
use super::demand::{Demand, Equation, NOTHING, of_sign, ratio};
use super::map::FrictionMap;
use super::outer::greatest_frictions;
use crate::linalg::Svd;
use nalgebra::DVector;
use std::collections::BTreeSet;

/// Result of the self-locking test, which decides whether static friction holds a configuration
/// while some actuators exert no effort.
#[derive(Clone, Debug, PartialEq)]
pub struct Holding {
    /// Verdict of the test. [`Verdict::Holds`] and [`Verdict::Slips`] are proven.
    pub verdict: Verdict,
    /// Guaranteed lower and upper bounds of the common factor on all static friction coefficients
    /// that is needed to hold the configuration. The upper bound is infinite if no sufficient
    /// factor was found.
    pub needed: (f64, f64),
    /// Friction forces that hold the configuration, N: for each interface, the components along its
    /// DOFs, with the sign of the sliding that they oppose. Empty if the verdict is not
    /// [`Verdict::Holds`], or if it follows from an effort interval that contains zero.
    pub frictions: Vec<Vec<f64>>,
}

/// Verdict of the self-locking test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Friction forces within all limits hold the configuration.
    Holds,
    /// For some motion the load supplies more power than friction can dissipate.
    Slips,
    /// Neither holding nor slipping is proven.
    Undecided,
}

/// Largest number of iterations that alternate between normal forces and friction distribution.
const ROUNDS: usize = 60;
/// Number of bisections in the search for the largest insufficient factor on the friction
/// coefficients.
const HALVINGS: usize = 40;
/// Largest factor on the friction coefficients that is tried. A larger sufficient factor counts as
/// infinite.
const MOST: f64 = 1e6;
/// Bounds count as equal if they differ by less than this fraction.
const SAME: f64 = 1e-9;

/// Computes the friction limits of each interface, N, for forward and backward sliding under the
/// normal forces `loads`, N.
fn limits(map: &FrictionMap<'_>, loads: &[f64]) -> Vec<[f64; 2]> {
    let limit = |(interface, load): (usize, &f64)| map.coefficients(interface).map(|mu| mu * load);
    loads.iter().enumerate().map(limit).collect()
}

/// Decides whether friction forces within their limits satisfy `equations`. `map` must contain all
/// interfaces, with the influence `couplings` on their normal forces.
pub(super) fn hold(
    map: &FrictionMap<'_>,
    couplings: &Couplings,
    equations: &[&Equation],
) -> Holding {
    let mut frictions = vec![0.0; map.len()];
    let (mut not_enough, mut enough) = (0.0_f64, 0.0_f64);
    let size = equations.iter().map(|equation| equation.missing.powi(2)).sum::<f64>().sqrt();
    let strength = |group: &[&Equation]| group.iter().map(|own| own.strength()).fold(0.0, f64::max);
    let negligible = NOTHING * strength(equations);
    for group in independent_groups(map, equations) {
        if group.iter().all(|equation| equation.missing == 0.0) {
            continue;
        }
        let reach: BTreeSet<usize> =
            group.iter().flat_map(|own| own.reach.iter().copied()).collect();
        if reach.is_empty() || strength(&group) <= negligible {
            // No friction influences these equations, except for round-off.
            let is_met = |own: &&Equation| own.missing.abs() <= NOTHING * size;
            let lost = !group.iter().all(is_met);
            not_enough = if lost { f64::INFINITY } else { not_enough };
            continue;
        }
        let reach: Vec<usize> = reach.into_iter().collect();
        let own_couplings;
        let (own, couplings) = if reach.len() == map.interfaces() {
            (map.clone(), couplings)
        } else {
            let own = map.restricted(reach.clone());
            own_couplings = couplings.restricted(&own, &reach);
            (own, &own_couplings)
        };
        let found = needed_factor(&own, couplings, Demand::new(&own, &group));
        not_enough = not_enough.max(found.not_enough);
        enough = enough.max(found.enough);
        for (k, friction) in found.frictions.into_iter().enumerate() {
            frictions[own.global(k)] = friction;
        }
    }
    let enough = enough.max(not_enough);
    let (verdict, frictions) = match (not_enough, enough) {
        (_, enough) if enough <= 1.0 + 1e-12 => (Verdict::Holds, split(map, &frictions)),
        (not_enough, _) if not_enough > 1.0 => (Verdict::Slips, Vec::new()),
        _ => (Verdict::Undecided, Vec::new()),
    };
    // Extremely large factors are due to normal forces that are round-off.
    let enough = if enough > MOST { f64::INFINITY } else { enough };
    let is_same = enough.is_finite() && enough - not_enough <= SAME * enough;
    let not_enough = if is_same { enough } else { not_enough };
    Holding { verdict, needed: (not_enough, enough), frictions }
}

/// Groups equations such that no friction force influences equations of two groups.
fn independent_groups<'a>(
    map: &FrictionMap<'_>,
    equations: &[&'a Equation],
) -> Vec<Vec<&'a Equation>> {
    let mut groups: Vec<Vec<&Equation>> = Vec::new();
    // Group of each interface.
    let mut group_of = vec![None; map.interfaces()];
    for &equation in equations {
        let known: BTreeSet<usize> =
            equation.reach.iter().filter_map(|interface| group_of[*interface]).collect();
        let first = known.first().copied().unwrap_or(groups.len());
        groups.resize_with(groups.len().max(first + 1), Vec::new);
        for &other in known.iter().skip(1) {
            for moved in core::mem::take(&mut groups[other]) {
                moved.reach.iter().for_each(|interface| group_of[*interface] = Some(first));
                groups[first].push(moved);
            }
        }
        equation.reach.iter().for_each(|interface| group_of[*interface] = Some(first));
        groups[first].push(equation);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

/// Factor on the friction coefficients that some equations need.
struct Needed {
    /// Largest factor that is proven to be insufficient; infinite if no friction satisfies the
    /// equations.
    not_enough: f64,
    /// Smallest sufficient factor that was found, and the friction that needs it.
    enough: f64,
    frictions: Vec<f64>,
}

/// Finds the factor on the friction coefficients that the equations in `demand` need.
fn needed_factor(map: &FrictionMap<'_>, couplings: &Couplings, demand: Demand) -> Needed {
    let Some(demand) = demand.independent() else {
        let (not_enough, enough) = (f64::INFINITY, f64::INFINITY);
        return Needed { not_enough, enough, frictions: Vec::new() };
    };
    let unique = demand.unique();
    let (enough, frictions) = match &unique {
        Some(frictions) => {
            let own = limits(map, &map.loads(frictions));
            let part = ratio(&map.sizes(frictions), &of_sign(map, frictions, &own));
            (part, frictions.clone())
        }
        None => follow_loads(map, &demand),
    };
    let known = (enough, frictions.as_slice());
    let not_enough =
        greatest_insufficient(map, couplings, &demand, known, unique.is_some()).min(enough);
    Needed { not_enough, enough, frictions }
}

/// Iterates between friction distributions and the normal forces that they cause. Returns the
/// factor on the friction coefficients that the best distribution needs, and this distribution.
/// Each distribution is checked with its own normal forces, so the factor is attained.
fn follow_loads(map: &FrictionMap<'_>, demand: &Demand) -> (f64, Vec<f64>) {
    let mut frictions = vec![0.0; map.len()];
    let mut best = (f64::INFINITY, frictions.clone());
    let mut weights = limits(map, &map.loads(&frictions));
    for _ in 0..ROUNDS {
        let borne = demand.borne_by(map, &weights);
        let Some(share) = borne.and_then(|borne| borne.share(map, &weights)) else { break };
        frictions = share.frictions;
        let own = limits(map, &map.loads(&frictions));
        let part = ratio(&map.sizes(&frictions), &of_sign(map, &frictions, &own));
        let settled = (part - best.0).abs() <= 1e-13 * part;
        if part < best.0 {
            best = (part, frictions.clone());
        }
        if settled {
            break;
        }
        // Halves each change, so that alternating normal forces converge as well.
        for (weight, own) in weights.iter_mut().zip(own) {
            *weight = [0, 1].map(|way| 0.5 * (weight[way] + own[way]));
        }
    }
    best
}

/// Returns the largest factor on the friction coefficients, at most `most`, that is guaranteed to
/// be insufficient.
///
/// Every solution equals one solution, `known`, plus friction without effect on the equations.
/// Normal forces can therefore be bounded relative to their values for `known` as well as for zero
/// friction. Relative to `known`, only friction without effect on the equations changes them.
///
/// `is_unique` is true if `known` is the only solution.
fn greatest_insufficient(
    map: &FrictionMap<'_>,
    plain: &Couplings,
    demand: &Demand,
    (most, known): (f64, &[f64]),
    is_unique: bool,
) -> f64 {
    // The transpose has few columns, and therefore few singular vectors.
    let svd = Svd::new(&demand.slopes.transpose());
    let rank = svd.rank(NOTHING);
    let reach = svd.u.columns(0, rank);
    let without_effect = |vector: &[f64]| {
        let vector = DVector::from_column_slice(vector);
        let rest = &vector - reach * reach.tr_mul(&vector);
        rest.iter().copied().collect::<Vec<f64>>()
    };
    let plain_loads: Vec<f64> = (0..map.interfaces()).map(|c| map.load_without(c)).collect();
    let least: Vec<f64> = match known.iter().any(|x| *x != 0.0) {
        true => known.iter().zip(without_effect(known)).map(|(a, b)| a - b).collect(),
        false => {
            let amounts = svd.v.columns(0, rank).tr_mul(&demand.missing);
            let amounts = amounts.component_div(&svd.singular_values.rows(0, rank));
            (reach * amounts).iter().copied().collect()
        }
    };
    let bound_loads = map.loads(&least);
    let reached: Vec<&[f64]> = svd.u.as_slice().chunks_exact(map.len()).take(rank).collect();
    let bound = &map.couplings_without(plain, &reached);
    let falls_short = |part: f64| {
        let frictions = [(&plain_loads, plain), (&bound_loads, bound)]
            .map(|(loads, couplings)| greatest_frictions(map, loads, couplings, part));
        let greatest = match frictions {
            [Some(a), Some(b)] => {
                let least = |(a, b): (&[f64; 2], &[f64; 2])| [a[0].min(b[0]), a[1].min(b[1])];
                a.iter().zip(&b).map(least).collect()
            }
            [Some(one), None] | [None, Some(one)] => one,
            [None, None] => return false,
        };
        if is_unique {
            return ratio(&map.sizes(known), &of_sign(map, known, &greatest)) > 1.0;
        }
        match demand.borne_by(map, &greatest) {
            None => true,
            Some(borne) => borne.exceeds(map, &greatest),
        }
    };
    let (mut low, mut high) = (0.0, most.min(MOST));
    if falls_short(high) {
        return if most > MOST { f64::INFINITY } else { most };
    }
    for _ in 0..HALVINGS {
        // Geometric mean, because fractions span many orders of magnitude.
        let middle =
            if low > 0.0 && high > 4.0 * low { (low * high).sqrt() } else { 0.5 * (low + high) };
        if falls_short(middle) { low = middle } else { high = middle }
    }
    low
}

/// Splits a vector of friction components into one vector per interface.
fn split(map: &FrictionMap<'_>, frictions: &[f64]) -> Vec<Vec<f64>> {
    let mut each = vec![Vec::new(); map.interfaces()];
    for (owner, friction) in map.owners().zip(frictions) {
        each[owner].push(*friction);
    }
    each
}
