//! What contacts at rest leave open: the interval of each driving force.
//!
//! Equation (R1) of the book's theory.

use super::map::FrictionMap;
use super::outer::outer_changes;
use crate::dynamics::continuation;
use crate::dynamics::forces::Forces;
use crate::dynamics::inverse::Inverse;
use crate::dynamics::model::Model;
use crate::dynamics::settings::Settings;
use crate::kinematics::Kinematics;
use crate::parameters::Parameters;
use crate::statics::AppliedLoad;

/// The part of the greatest static friction by which the change of efforts is probed: so small that
/// loads hardly change, so large that rounding does not matter.
const PROBE: f64 = 1e-3;
/// How often the directions of static friction are looked for again where they were put last.
const ROUNDS: usize = 4;
/// Directions that differ by less are the same.
const SAME: f64 = 1e-6;

/// A position with everything that is needed to solve it again.
pub(in crate::dynamics) struct Position<'a> {
    pub(in crate::dynamics) model: &'a Model,
    pub(in crate::dynamics) parameters: &'a Parameters<f64>,
    pub(in crate::dynamics) kinematics: &'a mut Kinematics<f64>,
    pub(in crate::dynamics) loads: &'a [AppliedLoad<f64>],
    pub(in crate::dynamics) settings: &'a Settings,
}

/// Static friction of one contact at rest: its direction, of length one or zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Held {
    pub(super) interface: usize,
    pub(super) direction: [f64; 3],
    /// Whether the direction is given.
    pub(super) fixed: bool,
}

impl Held {
    fn is_near(&self, other: &Self) -> bool {
        let pairs = self.direction.iter().zip(&other.direction);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < SAME
    }
}

/// Bounds each driving force over the static friction of contacts at rest, and leaves
/// `forces.efforts` as they were.
///
/// Static friction is any force up to the limit that its own load allows, in any direction. For
/// each drive the friction of every resting contact is put at its limit in the direction that
/// raises (lowers) that drive most, there the coupled problem is solved again, and the directions
/// are looked for again until they stay. So the bounds are attained; that nothing lies beyond them
/// is certain where a drive changes with each friction alike whatever the others are, as it does
/// but for strong coupling. Where the forces grow without bound on the way, as in a mechanism that
/// friction can lock, the bound is infinite.
pub(in crate::dynamics) fn bound_efforts(
    forces: &mut Forces,
    inverse: &mut Inverse<f64>,
    mut position: Position<'_>,
) {
    forces.close_bounds();
    let resting: Vec<usize> = (0..position.parameters.interfaces.len())
        .filter(|&interface| {
            let state = &inverse.interfaces()[interface];
            // Its load may be zero only while nothing else has friction.
            state.sliding == 0.0 && state.resistance.coefficient > 0.0
        })
        .collect();
    if !inverse.has_friction() || resting.is_empty() {
        return;
    }
    let released: Vec<Held> = resting
        .iter()
        .map(|&interface| Held { interface, direction: [0.0; 3], fixed: false })
        .collect();
    let slopes = probe(inverse, &position, &released);
    let Position { model, parameters, settings, .. } = position;
    let map = FrictionMap::new(inverse, model, parameters, &position.kinematics.bodies, settings);
    let changes = outer_changes(&map, forces.efforts.len());
    for actuator in 0..forces.efforts.len() {
        for sense in [1.0, -1.0] {
            let before = forces.efforts[actuator];
            let way = Way { actuator, sense, before };
            let found = extreme(inverse, &mut position, &released, &slopes, way);
            let (low, high) = &mut forces.effort_bounds[actuator];
            (*low, *high) = (low.min(found.least), high.max(found.greatest));
        }
    }
    hold(inverse, &released);
    resolve(inverse, &mut position);
    forces.certify_bounds(changes);
}

/// What was found on the way to an extreme of a drive.
pub(super) struct Extreme {
    pub(super) least: f64,
    pub(super) greatest: f64,
}

/// What is to be raised (sense 1) or lowered (-1), and from where.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub(super) actuator: usize,
    pub(super) sense: f64,
    pub(super) before: f64,
}

/// Raises (lowers) a drive as far as static friction can, from `start`, where the efforts change with
/// it by `slopes`. Fixed directions stay.
pub(super) fn extreme(
    inverse: &mut Inverse<f64>,
    position: &mut Position<'_>,
    start: &[Held],
    slopes: &[Vec<Vec<f64>>],
    way: Way,
) -> Extreme {
    let Way { actuator, sense, before } = way;
    let mut found = Extreme { least: f64::INFINITY, greatest: f64::NEG_INFINITY };
    let mut held = start.to_vec();
    for round in 0..ROUNDS {
        let next = if round == 0 {
            steepest(&held, slopes, actuator, sense)
        } else {
            steepest(&held, &probe(inverse, position, &held), actuator, sense)
        };
        if next.iter().zip(&held).all(|(next, held)| next.is_near(held)) {
            break;
        }
        held = next;
        hold(inverse, &held);
        let settled = resolve(inverse, position);
        let mut drive = inverse.efforts()[actuator];
        if !settled {
            drive = if drive < before { f64::NEG_INFINITY } else { f64::INFINITY };
        }
        found = Extreme { least: found.least.min(drive), greatest: found.greatest.max(drive) };
        if !settled {
            break;
        }
    }
    found
}

pub(super) fn hold(inverse: &mut Inverse<f64>, held: &[Held]) {
    for &Held { interface, direction, .. } in held {
        inverse.set_held(interface, direction);
    }
}

/// Solves with the present static friction; false where friction grows without bound, the forces
/// then are those on the way there.
pub(super) fn resolve(inverse: &mut Inverse<f64>, position: &mut Position<'_>) -> bool {
    let Position { model, parameters, kinematics, loads, settings } = position;
    inverse.solve(model, parameters, kinematics, loads, settings);
    if inverse.friction_settled(settings) && inverse.is_balanced(model, parameters) {
        return true;
    }
    let outcome =
        continuation::follow_friction(inverse, model, parameters, kinematics, loads, settings, 1.0);
    if outcome.is_err() {
        inverse.finish_friction(model.topology(), parameters, &kinematics.bodies);
    }
    outcome.is_ok()
}

/// The change of each drive with each component of each contact's static friction, about where they
/// are, as `slopes[held][component][actuator]`.
pub(super) fn probe(
    inverse: &mut Inverse<f64>,
    position: &Position<'_>,
    held: &[Held],
) -> Vec<Vec<Vec<f64>>> {
    let Position { model, parameters, kinematics, settings, .. } = position;
    let mut slopes = Vec::with_capacity(held.len());
    for &Held { interface, direction, .. } in held {
        let dofs = parameters.interfaces[interface].shape.dofs().len();
        let of_component = |component: usize| {
            let [ahead, back] = [PROBE, -PROBE].map(|part| {
                let mut moved = direction;
                moved[component] += part;
                inverse.set_held(interface, moved);
                inverse.hold_again(model, parameters, &kinematics.bodies, settings);
                inverse.efforts().to_vec()
            });
            ahead.iter().zip(&back).map(|(ahead, back)| ahead - back).collect()
        };
        slopes.push((0..dofs).map(of_component).collect());
        inverse.set_held(interface, direction);
    }
    inverse.hold_again(model, parameters, &kinematics.bodies, settings);
    slopes
}

/// The directions of static friction in which one drive rises (falls) most.
fn steepest(held: &[Held], slopes: &[Vec<Vec<f64>>], actuator: usize, sense: f64) -> Vec<Held> {
    let direction_of = |(held, slopes): (&Held, &Vec<Vec<f64>>)| {
        if held.fixed {
            return *held;
        }
        let mut direction = [0.0; 3];
        for (component, slope) in direction.iter_mut().zip(slopes) {
            *component = sense * slope[actuator];
        }
        // One freedom has but two directions, whatever the size.
        let size = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
        let over = if size > 0.0 { 1.0 / size } else { 0.0 };
        Held { direction: direction.map(|d| d * over), ..*held }
    };
    held.iter().zip(slopes).map(direction_of).collect()
}
