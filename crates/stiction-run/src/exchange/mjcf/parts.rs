//! Bodies of an MJCF file and their joints, with unique names.

use super::steps::{Step, steps};
use super::tree::Tree;
use crate::exchange::Home;
use crate::exchange::names::Names;

/// MJCF joint with its unique name.
pub(super) struct NamedStep {
    pub(super) step: Step,
    pub(super) name: String,
}

/// Unique names of an MJCF body and of the MJCF joints that connect it to its parent.
pub(super) struct NamedPart {
    pub(super) name: String,
    /// Name of the free joint, if the body moves freely in the world with six coordinates.
    pub(super) free: Option<String>,
    /// MJCF joints that connect the body to its parent; empty for a free body.
    pub(super) steps: Vec<NamedStep>,
}

/// Chooses unique names for all MJCF bodies and their joints. If a body of the mechanism is split,
/// each part except the first is named after the body and the joint that connects the part.
pub(super) fn named(home: &Home<'_>, tree: &Tree) -> Vec<NamedPart> {
    let mechanism = &home.model.mechanism;
    let (mut bodies, mut joints) = (Names::default(), Names::default());
    bodies.reserve("world");
    let own: Vec<String> = mechanism.bodies().iter().map(|b| bodies.take(&b.name)).collect();
    let parts = tree.parts.iter().map(|part| {
        let joint = &mechanism.joints()[part.joint];
        let name = match part.is_further {
            false => own[part.body].clone(),
            true => bodies.take(&format!("{}@{}", own[part.body], joint.name)),
        };
        if part.is_free {
            let free = Some(joints.take(&joint.name));
            return NamedPart { name, free, steps: Vec::new() };
        }
        let steps = steps(home, part.joint, part.reversed).into_iter().map(|step| {
            let name = joints.take(&format!("{}{}", joint.name, step.suffix));
            NamedStep { step, name }
        });
        NamedPart { name, free: None, steps: steps.collect() }
    });
    parts.collect()
}
