//! Notes on properties that a file for MuJoCo does not express.

use super::tree::Tree;
use super::{friction, inertia};
use stiction_core::mechanism::{DriveTrain, Mechanism};

/// Omitted or changed properties, one per line.
pub(super) fn notes(mechanism: &Mechanism, tree: &Tree) -> Vec<String> {
    let mut notes = Vec::new();
    let (mut all, mut left_out) = (0, 0);
    for (index, joint) in mechanism.joints().iter().enumerate() {
        let has_steps = tree.parts.iter().any(|part| part.joint == index);
        all += joint.friction.len();
        let carried = |interface: &&_| friction::is_damping_alone(interface, has_steps);
        left_out += joint.friction.len() - joint.friction.iter().filter(carried).count();
    }
    if left_out > 0 {
        notes.push(format!(
            "friction is omitted at {left_out} of {all} friction interfaces: MJCF has no \
             friction that depends on the load or the direction, and none in a ball that closes \
             a loop; other viscous friction becomes damping"
        ));
    }
    let length = mechanism.characteristic_length();
    let raised: Vec<&str> = (1..mechanism.bodies().len())
        .filter(|&body| {
            let content = &mechanism.bodies()[body];
            content.mass > 0.0 && inertia::accepted(content, length, tree.count[body]).1
        })
        .map(|body| mechanism.bodies()[body].name.as_str())
        .collect();
    if !raised.is_empty() {
        notes.push(format!(
            "the smallest moments of inertia of {} are increased, because MuJoCo rejects those \
             that no mass distribution has; this has no effect as long as the bodies turn about \
             their other axes only",
            raised.join(", ")
        ));
    }
    if mechanism.joints().iter().any(|joint| joint.compliance.is_some()) {
        notes.push("compliances of joints are omitted".to_owned());
    }
    let trains = mechanism.drive_trains();
    let has_steps = |train: &&DriveTrain| tree.parts.iter().any(|p| p.joint == train.joint.0);
    if trains.iter().filter(has_steps).any(|train| train.gear.efficiencies() != (1.0, 1.0)) {
        notes
            .push("losses of gears are left out: MJCF has none that grow with the load".to_owned());
    }
    let lost: Vec<_> =
        trains.iter().filter(|train| !has_steps(train)).map(|t| t.name.as_str()).collect();
    if !lost.is_empty() {
        notes.push(format!(
            "motors of joints that close a loop are left out, with their rotors: {}",
            lost.join(", ")
        ));
    }
    notes
}
