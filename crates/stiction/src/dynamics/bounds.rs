//! What contacts at rest leave open: the interval of each driving force.

use super::forces::Forces;
use super::inverse::{Inverse, Settings, Setup};
use super::load::AppliedLoad;
use super::wedge;
use crate::kinematics::Kinematics;
use crate::parameters::Parameters;

/// The part of the greatest static friction by which the change of drives is probed: so small that
/// loads hardly change, so large that rounding does not matter.
const PROBE: f64 = 1e-3;
/// How often the directions of static friction are looked for again where they were put last.
const ROUNDS: usize = 8;

/// A position with everything that is needed to solve it again.
pub(super) struct Position<'a> {
    pub(super) setup: Setup<'a>,
    pub(super) parameters: &'a Parameters<f64>,
    pub(super) kinematics: &'a mut Kinematics<f64>,
    pub(super) loads: &'a [AppliedLoad<f64>],
    pub(super) settings: &'a Settings,
}

/// Static friction of one contact at rest: its direction, of length one or zero.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Held {
    contact: usize,
    direction: [f64; 3],
}

/// Bounds each driving force over the static friction of contacts at rest, and leaves
/// `forces.drives` as they were.
///
/// Static friction is any force up to the limit that its own load allows, in any direction. For
/// each drive the friction of every resting contact is put at its limit in the direction that
/// raises (lowers) that drive most, there the coupled problem is solved again, and the directions
/// are looked for again until they stay. So the bounds are attained; that nothing lies beyond them
/// is certain where a drive changes with each friction alike whatever the others are, as it does
/// but for strong coupling. Where the forces grow without bound on the way, as in a mechanism that
/// friction can lock, the bound is infinite.
pub(super) fn bound_drives(
    forces: &mut Forces,
    inverse: &mut Inverse<f64>,
    mut position: Position<'_>,
) {
    forces.unbounded();
    let resting: Vec<usize> = (0..position.parameters.contacts.len())
        .filter(|&contact| {
            let state = &inverse.contacts()[contact];
            state.sliding == 0.0 && state.friction() > 0.0
        })
        .collect();
    if !inverse.has_friction() || resting.is_empty() {
        return;
    }
    for actuator in 0..forces.drives.len() {
        for sense in [1.0, -1.0] {
            let released = resting.iter().map(|&contact| Held { contact, direction: [0.0; 3] });
            let mut held: Vec<Held> = released.collect();
            hold(inverse, &held);
            resolve(inverse, &mut position);
            for _ in 0..ROUNDS {
                let next = steepest(inverse, &position, &held, actuator, sense);
                if next == held {
                    break;
                }
                held = next;
                hold(inverse, &held);
                let settled = resolve(inverse, &mut position);
                let mut drive = inverse.drives()[actuator];
                if !settled {
                    let away = drive - forces.drives[actuator];
                    drive = if away < 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
                }
                let (low, high) = &mut forces.drive_bounds[actuator];
                (*low, *high) = (low.min(drive), high.max(drive));
                if !settled {
                    break;
                }
            }
        }
    }
    let released = resting.iter().map(|&contact| Held { contact, direction: [0.0; 3] });
    hold(inverse, &released.collect::<Vec<_>>());
    resolve(inverse, &mut position);
}

fn hold(inverse: &mut Inverse<f64>, held: &[Held]) {
    for &Held { contact, direction } in held {
        inverse.set_held(contact, direction);
    }
}

/// Solves with the present static friction; false where friction grows without bound, the forces
/// then are those on the way there.
fn resolve(inverse: &mut Inverse<f64>, position: &mut Position<'_>) -> bool {
    let Position { setup, parameters, kinematics, loads, settings } = position;
    inverse.solve(setup, parameters, kinematics, loads, settings);
    if inverse.friction_settled(settings) && inverse.is_balanced(setup, parameters) {
        return true;
    }
    let outcome = wedge::follow_friction(inverse, setup, parameters, kinematics, loads, settings);
    if outcome.is_err() {
        inverse.finish_friction(setup.topology, parameters, &kinematics.bodies);
    }
    outcome.is_ok()
}

/// The directions of static friction in which one drive rises (falls) most, by its change for small
/// changes of each component about where they are.
fn steepest(
    inverse: &mut Inverse<f64>,
    position: &Position<'_>,
    held: &[Held],
    actuator: usize,
    sense: f64,
) -> Vec<Held> {
    let Position { setup, parameters, kinematics, settings, .. } = position;
    let found = held.iter().map(|&Held { contact, direction }| {
        let mut slope = [0.0; 3];
        let freedoms = parameters.contacts[contact].shape.freedoms().len();
        for component in 0..freedoms {
            let [ahead, back] = [PROBE, -PROBE].map(|part| {
                let mut moved = direction;
                moved[component] += part;
                inverse.set_held(contact, moved);
                inverse.hold_again(setup, parameters, &kinematics.bodies, settings);
                inverse.drives()[actuator]
            });
            slope[component] = sense * (ahead - back);
        }
        inverse.set_held(contact, direction);
        let size = slope.iter().map(|d| d * d).sum::<f64>().sqrt();
        // One freedom has but two directions, whatever the size.
        let over = if size > 0.0 { 1.0 / size } else { 0.0 };
        Held { contact, direction: slope.map(|d| d * over) }
    });
    let found: Vec<Held> = found.collect();
    inverse.hold_again(setup, parameters, &kinematics.bodies, settings);
    found
}
