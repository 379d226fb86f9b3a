//! Notes on properties that an MJCF file cannot express.

use super::inertia;
use super::tree::Tree;
use crate::exchange::damping;
use stiction_core::mechanism::{DriveTrain, GearedDof, Gearing, Mechanism};

/// Returns notes on properties that the MJCF file omits or changes, one per entry.
pub(super) fn notes(mechanism: &Mechanism, tree: &Tree) -> Vec<String> {
    let mut notes = Vec::new();
    let (mut all, mut left_out) = (0, 0);
    for (index, joint) in mechanism.joints().iter().enumerate() {
        let has_steps = tree.parts.iter().any(|part| part.joint == index);
        all += joint.friction.len();
        let carried = |interface: &&_| damping::is_damping_alone(interface, has_steps);
        left_out += joint.friction.len() - joint.friction.iter().filter(carried).count();
    }
    if left_out > 0 {
        notes.push(format!(
            "friction at {left_out} of {all} friction interfaces is in <text> elements that only \
             stiction reads: MJCF has no friction that depends on the load or the direction, and \
             none in a ball joint that closes a loop; other viscous friction becomes damping"
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
             that no mass distribution has; this has no effect as long as the bodies turn only \
             about their other axes",
            raised.join(", ")
        ));
    }
    if mechanism.joints().iter().any(|joint| joint.compliance.is_some()) {
        notes.push("compliances of joints are omitted".to_owned());
    }
    if mechanism.joints().iter().any(|joint| !joint.ranges.is_empty()) {
        notes.push(
            "ranges of joints are in <text> elements that only stiction reads, because a range is \
             a mechanical stop in MJCF"
                .to_owned(),
        );
    }
    let mut joint_springs: Vec<(usize, usize)> = Vec::new();
    let on_joints = mechanism.joint_springs().iter().filter(|spring| {
        let in_tree = tree.parts.iter().any(|part| part.joint == spring.joint.0);
        let key = (spring.joint.0, spring.dof);
        let is_second = joint_springs.contains(&key);
        joint_springs.push(key);
        !in_tree || is_second || (spring.preload != 0.0 && spring.stiffness == 0.0)
    });
    let on_joints: Vec<&str> = on_joints.map(|spring| spring.name.as_str()).collect();
    let bushings = mechanism.bushings().iter().map(|bushing| bushing.name.as_str());
    let pushing = mechanism.springs().iter().filter(|s| s.preload != 0.0 && s.stiffness == 0.0);
    let left: Vec<&str> = on_joints
        .into_iter()
        .chain(bushings)
        .chain(pushing.map(|spring| spring.name.as_str()))
        .collect();
    if !left.is_empty() {
        notes.push(format!(
            "springs on joints outside of the tree, bushings, and constant-force springs are in \
             <text> elements that only stiction reads: {}",
            left.join(", ")
        ));
    }
    let (trains, of_several): (Vec<&DriveTrain>, Vec<&DriveTrain>) =
        mechanism.drive_trains().iter().partition(|train| train.only_dof().is_some());
    let has_steps = |train: &&&DriveTrain| {
        let in_tree = |driven: &GearedDof| tree.parts.iter().any(|p| p.joint == driven.joint.0);
        train.dofs.iter().all(in_tree)
    };
    if trains.iter().filter(has_steps).any(|train| train.gear.efficiencies() != (1.0, 1.0)) {
        notes.push(
            "gear losses are in <text> elements that only stiction reads: MJCF has no losses \
                that grow with the load"
                .to_owned(),
        );
    }
    if trains.iter().any(|train| train.rotor_axis.is_some()) {
        notes.push(
            "axes of rotors are in <text> elements that only stiction reads: the armature of MJCF \
             has no gyroscopic torque"
                .to_owned(),
        );
    }
    let lost: Vec<_> =
        trains.iter().filter(|train| !has_steps(train)).map(|t| t.name.as_str()).collect();
    if !lost.is_empty() {
        notes.push(format!(
            "motors of joints that close a loop are in <text> elements that only stiction reads: {}",
            lost.join(", ")
        ));
    }
    let is_lost = |train: &&&DriveTrain| !has_steps(train);
    let names: Vec<_> =
        of_several.iter().filter(is_lost).map(|train| train.name.as_str()).collect();
    if !names.is_empty() {
        notes.push(format!(
            "motors in <text> elements that only stiction reads: {}",
            names.join(", ")
        ));
    }
    let is_lost = |gearing: &&Gearing| {
        let in_tree = |dof: &GearedDof| tree.parts.iter().any(|p| p.joint == dof.joint.0);
        !gearing.dofs.iter().all(in_tree)
    };
    let lost: Vec<&str> = (mechanism.gearings().iter())
        .filter(is_lost)
        .map(|gearing| gearing.name.as_str())
        .collect();
    if !lost.is_empty() {
        notes.push(format!(
            "gearings of joints that close a loop are in <text> elements that only stiction reads: \
             {}",
            lost.join(", ")
        ));
    }
    notes
}
