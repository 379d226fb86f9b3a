//! What contacts at rest leave open: the interval of each driving force.

use super::forces::Forces;
use super::inverse::{Inverse, Settings, Setup};
use super::load::AppliedLoad;
use crate::kinematics::{Bodies, Kinematics};
use crate::parameters::Parameters;

/// The part of the greatest static friction by which the change of drives is probed: so small that
/// loads hardly change, so large that rounding does not matter.
const PROBE: f64 = 1e-3;

/// A contact at rest that can hold.
fn holds(inverse: &Inverse<f64>, contact: usize) -> bool {
    let state = &inverse.contacts()[contact];
    state.sliding == 0.0 && state.friction() > 0.0
}

/// Bounds each driving force over the static friction of contacts at rest, and leaves `inverse`
/// and `forces.drives` as they were.
///
/// Static friction is any force up to the limit that its own load allows, in any direction. For
/// each drive the friction of every resting contact is put at its limit in the direction that
/// raises (lowers) that drive, and the coupled problem is solved again: the bounds are attained.
/// They are exact where the direction that raises a drive does not change with the loads.
///
/// Returns false if some of these problems did not settle.
pub(super) fn bound_drives(
    forces: &mut Forces,
    inverse: &mut Inverse<f64>,
    setup: &Setup<'_>,
    parameters: &Parameters<f64>,
    kinematics: &mut Kinematics<f64>,
    loads: &[AppliedLoad<f64>],
    settings: &Settings,
) -> bool {
    forces.unbounded();
    let contacts = parameters.contacts.len();
    if !inverse.has_friction() || !(0..contacts).any(|contact| holds(inverse, contact)) {
        return true;
    }
    let mut settled = true;
    for actuator in 0..forces.drives.len() {
        for raise in [true, false] {
            point_held(inverse, setup, parameters, &kinematics.bodies, settings, actuator, raise);
            inverse.solve(setup, parameters, kinematics, loads, settings);
            settled &= inverse.friction_settled(settings);
            let drive = inverse.drives()[actuator];
            let (low, high) = &mut forces.drive_bounds[actuator];
            (*low, *high) = (low.min(drive), high.max(drive));
            release(inverse, contacts);
            // Back to the undisturbed loads.
            inverse.solve(setup, parameters, kinematics, loads, settings);
        }
    }
    settled
}

fn release(inverse: &mut Inverse<f64>, contacts: usize) {
    (0..contacts).for_each(|contact| inverse.set_held(contact, [0.0; 3]));
}

/// Points the static friction of all resting contacts to where it raises (or lowers) one drive, by
/// the drive's change for each component alone.
fn point_held(
    inverse: &mut Inverse<f64>,
    setup: &Setup<'_>,
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
    settings: &Settings,
    actuator: usize,
    raise: bool,
) {
    let resting: Vec<usize> =
        (0..parameters.contacts.len()).filter(|&contact| holds(inverse, contact)).collect();
    let mut directions = Vec::with_capacity(resting.len());
    for &contact in &resting {
        let mut direction = [0.0; 3];
        let freedoms = parameters.contacts[contact].shape.freedoms().len();
        for component in 0..freedoms {
            let [ahead, back] = [PROBE, -PROBE].map(|part| {
                let mut held = [0.0; 3];
                held[component] = part;
                inverse.set_held(contact, held);
                inverse.hold_again(setup, parameters, bodies, settings);
                inverse.drives()[actuator]
            });
            direction[component] = ahead - back;
        }
        inverse.set_held(contact, [0.0; 3]);
        let size = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
        let scale = if raise { 1.0 } else { -1.0 } / if size > 0.0 { size } else { 1.0 };
        directions.push(direction.map(|d| d * scale));
    }
    for (&contact, direction) in resting.iter().zip(directions) {
        inverse.set_held(contact, direction);
    }
}
