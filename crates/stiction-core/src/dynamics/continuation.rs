//! Friction that locks: the solution followed from no friction to the given coefficients.
//!
//! Equation (F8) of the book's theory.

use super::coupling::CouplingWorkspace;
use super::inverse::Inverse;
use super::model::Model;
use super::settings::Settings;
use crate::kinematics::Kinematics;
use crate::parameters::Parameters;
use crate::statics::AppliedLoad;

/// Where the solution was lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lock {
    /// The part of the given coefficients.
    pub(super) part: f64,
    /// The contact whose load has grown most.
    pub(super) interface: usize,
}

/// A bound on the coupling below which a step may go at once: there is one solution and no other.
const CERTAIN: f64 = 0.99;
/// Beyond that steps are this part of what the coefficients are: a longer one might pass over a piece
/// in which there is no solution, or reach another one.
const LONGEST_STEP: f64 = 0.02;
/// Where they begin if no bound is known, and the smallest step, as parts of the given coefficients.
const FIRST_STEP: f64 = 0.01;
const SMALLEST_STEP: f64 = 1e-5;
/// Loads grown by this factor count as grown without bound.
const UNBOUNDED: f64 = 1e9;

/// Follows the solution from frictionless joints, growing all coefficients together, to `until` times
/// the given ones; `inverse` holds it then. It is lost where the determinant of the coupled balance vanishes:
/// the driving forces grow without bound as the coefficients come near.
pub(super) fn follow_friction(
    inverse: &mut Inverse<f64>,
    model: &Model,
    parameters: &Parameters<f64>,
    kinematics: &mut Kinematics<f64>,
    loads: &[AppliedLoad<f64>],
    settings: &Settings,
    until: f64,
) -> Result<(), Lock> {
    inverse.begin(model, parameters, kinematics, loads, settings);
    let bodies = &kinematics.bodies;
    let start: Vec<f64> = inverse.interfaces().iter().map(|c| c.load()).collect();
    let largest_start = start.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut good = inverse.clone();
    let strength = CouplingWorkspace::default().strength(inverse, model, parameters, bodies);
    let certain = if strength > 0.0 { CERTAIN / strength } else { f64::INFINITY };
    let (mut part, mut step) = (0.0, f64::min(certain, until).max(FIRST_STEP));
    while part < until {
        if part > 0.0 {
            step = step.min(LONGEST_STEP * part);
        }
        let next = f64::min(part + step, until);
        inverse.apply_friction_at(model.topology(), parameters, bodies, settings, next);
        let mut found = false;
        for _ in 0..settings.friction_steps {
            let (change, largest) = inverse.step(model, parameters, bodies);
            if largest.is_nan() || largest > UNBOUNDED * largest_start {
                break;
            }
            if settings.is_settled(change, largest) {
                found = inverse.orientation() > 0.0;
                break;
            }
        }
        found |= inverse.friction_stagnated() && inverse.is_balanced(model, parameters);
        if found {
            good.clone_from(inverse);
            part = next;
            step *= 2.0;
        } else {
            inverse.clone_from(&good);
            step *= 0.5;
            if step < SMALLEST_STEP * part.max(1.0) {
                let growth = |interface: usize| {
                    inverse.interfaces()[interface].load()
                        / (start[interface] + 1e-12 * largest_start)
                };
                let interfaces = 0..start.len();
                let interface =
                    interfaces.max_by(|&a, &b| growth(a).total_cmp(&growth(b))).unwrap_or(0);
                return Err(Lock { part, interface });
            }
        }
    }
    inverse.finish_friction(model.topology(), parameters, bodies);
    inverse.spin_up(model, kinematics);
    Ok(())
}
