//! The coupling of friction and reactions with the loads of the contacts as the only unknowns: for
//! positions that the kernels cannot plan, and as their oracle. Reactions are affine in the friction
//! forces, whatever decides among those that are not unique.

use super::continuation::Lock;
use super::interfaces::Interfaces;
use super::inverse::STAGNATED;
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::spatial::Wrench;
use nalgebra::{DMatrix, DVector};

/// Newton steps at one part of the coefficients.
const STEPS: usize = 40;
/// The loads are found when none changes by more than this part of the largest.
const SETTLED: f64 = 1e-12;
/// The first step of the coefficients, as a part of the given ones, and the smallest.
const FIRST_STEP: f64 = 0.1;
const SMALLEST_STEP: f64 = 1e-6;
/// Loads grown by this factor count as grown without bound.
const UNBOUNDED: f64 = 1e9;

/// How the joints' wrenches depend on the friction forces.
pub(super) struct Reactions<'a> {
    /// Without friction.
    pub(super) base: &'a [Wrench<f64>],
    /// For each contact the change of all joints' wrenches by one newton of its friction.
    pub(super) responses: &'a [Vec<Wrench<f64>>],
}

/// Follows the loads from no Coulomb friction to the given coefficients. `interfaces` have speeds and
/// resistances; their loads are the solution's then.
///
/// # Errors
/// Where the solution is lost: friction locks the mechanism.
pub(super) fn follow(
    interfaces: &mut Interfaces<f64>,
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
    reactions: &Reactions<'_>,
) -> Result<(), Lock> {
    let given: Vec<f64> = interfaces.states.iter().map(|s| s.resistance.coefficient).collect();
    interfaces.press(parameters, bodies, reactions.base);
    let start: Vec<f64> = interfaces.states.iter().map(|state| state.load.value).collect();
    let largest_start = start.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut known = DVector::from_vec(start.clone());
    let (mut part, mut step) = (0.0, FIRST_STEP);
    let mut begun = false;
    while !begun || part < 1.0 {
        // The first time with viscous friction alone.
        let next = if begun { f64::min(part + step, 1.0) } else { 0.0 };
        for (state, coefficient) in interfaces.states.iter_mut().zip(&given) {
            state.resistance.coefficient = coefficient * next;
        }
        let limit = UNBOUNDED * largest_start;
        if let Some(loads) = newton(interfaces, parameters, bodies, reactions, &known, limit) {
            (known, part, begun) = (loads, next, true);
            step *= 1.5;
            continue;
        }
        step *= 0.5;
        if !begun || step < SMALLEST_STEP {
            let growth = |k: &usize| known[*k] / (start[*k] + 1e-12 * largest_start);
            let interface = (0..start.len()).max_by(|a, b| growth(a).total_cmp(&growth(b)));
            return Err(Lock { part, interface: interface.unwrap_or(0) });
        }
    }
    Ok(())
}

/// The loads at the present resistances, near `known` ones; None if they are not found, or lie beyond
/// a point where the determinant vanishes.
fn newton(
    interfaces: &mut Interfaces<f64>,
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
    reactions: &Reactions<'_>,
    known: &DVector<f64>,
    limit: f64,
) -> Option<DVector<f64>> {
    let count = known.len();
    let joint = |interface: usize| parameters.interfaces[interface].joint;
    let mut loads = known.clone();
    for step in 0..STEPS {
        let mut wrenches = reactions.base.to_vec();
        for (state, (load, response)) in
            interfaces.states.iter().zip(loads.iter().zip(reactions.responses))
        {
            let force = state.resistance.force(*load);
            wrenches.iter_mut().zip(response).for_each(|(sum, unit)| *sum += *unit * force);
        }
        interfaces.press(parameters, bodies, &wrenches);
        let states = &interfaces.states;
        let misfit = DVector::from_fn(count, |k, _| loads[k] - states[k].load.value);
        let matrix = DMatrix::from_fn(count, count, |k, l| {
            let change = states[k].load.gradient.power(reactions.responses[l][joint(k)]);
            f64::from(u8::from(k == l)) - change * states[l].resistance.coefficient
        });
        let factored = matrix.lu();
        let change = factored.solve(&misfit)?;
        loads -= &change;
        let largest = loads.amax();
        if largest >= limit || !loads.iter().all(|load| load.is_finite()) {
            return None;
        }
        // At last what does not fall any more is rounding.
        let enough = if step + 1 == STEPS { STAGNATED } else { SETTLED };
        if change.amax() <= enough * largest {
            return (factored.determinant() > 0.0).then_some(loads);
        }
    }
    None
}
