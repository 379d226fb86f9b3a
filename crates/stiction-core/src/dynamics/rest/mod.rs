//! Static friction at rest: effort intervals, breakaway efforts, and self-locking.
//!
//! Joint wrenches and efforts are affine in the friction forces ([`FrictionMap`]), but the limit of
//! each friction force grows with a normal force. Each result therefore has inner bounds, which are
//! attained by friction forces that satisfy all friction laws simultaneously, and guaranteed outer
//! bounds, which follow from upper bounds of the normal forces.

pub(super) mod bounds;
mod breakaway;
mod couplings;
mod demand;
mod holding;
mod map;
mod outer;
mod search;
mod sparse_search;

pub use breakaway::Breakaway;
pub use holding::{Holding, Verdict};

use super::coupling::FrictionCoupling;
use super::forces::{Bounds, Forces};
use super::inverse::Inverse;
use super::responses::Influences;
use crate::joint::Motion;
use bounds::{Position, StaticFriction, resolve, set_static_frictions};
use demand::Equation;
use map::FrictionMap;

/// Results of the analysis of static friction at a configuration under given loads.
#[derive(Clone, Debug, PartialEq)]
pub struct Rest {
    /// Breakaway efforts of each actuator while the other actuators are locked. `None` if actuators
    /// are redundant, or if there are fewer actuators than DOFs.
    pub breakaway: Vec<Option<Breakaway>>,
    /// Self-locking test of each actuator: this actuator exerts no effort while the other actuators
    /// are locked.
    pub alone: Vec<Holding>,
    /// Self-locking test of the whole mechanism: no actuator exerts an effort.
    pub unpowered: Holding,
}

impl Rest {
    /// Extends effort intervals without guaranteed outer bounds ([`Bounds::Attained`]) to include
    /// the breakaway efforts, at which all friction forces are within their limits. With strong
    /// coupling the computed interval may not contain the breakaway efforts, since the search does
    /// not try all combinations of static friction.
    pub(super) fn extend_intervals(&self, forces: &mut Forces) {
        if forces.bounds != Bounds::Attained {
            return;
        }
        for (breakaway, bounds) in self.breakaway.iter().zip(&mut forces.effort_bounds) {
            let Some(Breakaway { forward, backward }) = breakaway else { continue };
            for effort in [forward.0, forward.1, backward.0, backward.1] {
                if effort.is_finite() {
                    *bounds = (bounds.0.min(effort), bounds.1.max(effort));
                }
            }
        }
    }

    /// Changes the verdict from undecided to [`Verdict::Holds`] where the effort interval of an
    /// actuator contains zero. Applies only if the solution is unique for every static friction:
    /// the effort then depends continuously on the static friction, so some static friction makes
    /// it zero.
    pub(super) fn take_intervals(&mut self, forces: &Forces) {
        if !matches!(forces.bounds, Bounds::Exact | Bounds::Certified) {
            return;
        }
        for (holding, &(low, high)) in self.alone.iter_mut().zip(&forces.effort_bounds) {
            let contains_zero = low <= 0.0 && 0.0 <= high;
            if holding.verdict == Verdict::Undecided && contains_zero {
                holding.verdict = Verdict::Holds;
                holding.needed.1 = holding.needed.1.min(1.0);
            }
        }
    }
}

/// Analyses static friction at the configuration in `inverse`, with the mechanism at rest.
pub(super) fn examine(
    inverse: &mut Inverse<f64>,
    mut position: Position<'_>,
    coupling: &mut FrictionCoupling,
) -> Rest {
    let released: Vec<StaticFriction> = (0..position.parameters.interfaces.len())
        .map(|interface| StaticFriction { interface, direction: [0.0; 3], fixed: false })
        .collect();
    let Position { model, parameters, settings, .. } = position;
    let bodies = &position.kinematics.bodies;
    let responses = coupling.responses(inverse, model, parameters, bodies, true);
    let influences = Influences::new(responses, parameters);
    let (couplings, reaches) = {
        let known = (responses, &influences);
        let map = FrictionMap::new(inverse, known, parameters, bodies, settings);
        let couplings = map.couplings();
        let reach = |actuator| map.reach(&map.slopes(actuator), couplings.influencing());
        let reaches: Vec<Vec<usize>> = (0..inverse.efforts().len()).map(reach).collect();
        (couplings, reaches)
    };
    let velocities = breakaway::impending(&mut position);
    let breakaway = velocities
        .iter()
        .zip(&reaches)
        .enumerate()
        .map(|(actuator, (velocities, reach))| {
            let goal = (actuator, &**reach);
            Some(breakaway::break_away(inverse, &mut position, goal, velocities.as_ref()?))
        })
        .collect();
    set_static_frictions(inverse, &released);
    resolve(inverse, &mut position);

    let bodies = &position.kinematics.bodies;
    let map = FrictionMap::new(inverse, (responses, &influences), parameters, bodies, settings);
    let efforts: Vec<(usize, f64, f64)> = inverse
        .efforts()
        .iter()
        .zip(&model.topology().actuators)
        .enumerate()
        .map(|(index, (&drive, actuator))| {
            let joint_type = model.topology().joint_types[actuator.joint];
            // Torques are divided by the characteristic length for comparison with forces.
            let scale = match joint_type.dofs()[actuator.dof].motion {
                Motion::Translation => 1.0,
                Motion::Rotation | Motion::Screw => 1.0 / parameters.length,
            };
            (index, drive, scale)
        })
        .collect();
    let spins = model.constraints().spins().len();
    let wrenches = inverse.joint_wrenches().iter();
    let forces = wrenches.map(|wrench| wrench.force.norm());
    let largest = forces.chain(efforts.iter().map(|(_, drive, scale)| (drive * scale).abs()));
    let largest = largest.fold(0.0, f64::max);
    let spins: Vec<Equation> =
        (0..spins).filter_map(|spin| Equation::of_spin(&map, &couplings, spin)).collect();
    let efforts: Vec<Equation> = efforts
        .into_iter()
        .map(|effort| Equation::of_effort(&map, &couplings, effort, largest))
        .collect();
    let hold = |efforts: &[Equation]| {
        holding::hold(&map, &couplings, &efforts.iter().chain(&spins).collect::<Vec<_>>())
    };
    Rest { breakaway, alone: efforts.chunks(1).map(hold).collect(), unpowered: hold(&efforts) }
}
