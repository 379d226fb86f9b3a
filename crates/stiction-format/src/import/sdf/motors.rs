//! Guesses which joints of an SDF file have motors: the joints that a plugin names, or else joints
//! that may have an effort according to their limits.

use super::super::description::Motor;
use super::Reader;
use super::models::Model;

/// Effort limits of this size and above, N or N m, count as absent.
const UNLIMITED: f64 = 1e9;

/// Marks joints as actuated: the joints that plugins name, if any. Otherwise, in an open chain, all
/// joints whose effort limit is not 0, including joints without a limit; in a mechanism with loops,
/// the joints with a positive effort limit.
pub(super) fn guess(reader: &mut Reader<'_, '_>, models: &[Model]) {
    let mut named: Vec<usize> = Vec::new();
    for model in models {
        for plugin in model.element.all("plugin") {
            for tag in ["joint_name", "joint"] {
                let joints = plugin.all(tag).map(|joint| model.full(&joint.text));
                named.extend(joints.filter_map(|joint| reader.joints.get(&joint).copied()));
            }
        }
    }
    let has_names = !named.is_empty();
    let joints = &reader.robot.joints;
    let is_open = joints.len() + 1 == reader.robot.bodies.len();
    let is_chosen = |joint: usize, dof: usize| {
        let effort = reader.efforts.get(&(joint, dof));
        match joints[joint].dofs.len() {
            1 if has_names => named.contains(&joint),
            // An open chain: all joints that may have an effort, also those without a limit.
            1 if is_open => effort != Some(&0.0),
            // A plugin names a joint, not an axis of it. Joints with several axes are often passive and without limits.
            _ => !has_names && effort.is_some_and(|effort| *effort > 0.0),
        }
    };
    let follows =
        |joint: usize| reader.robot.gearings.iter().any(|gearing| gearing.terms[0].0 == joint);
    let chosen: Vec<(usize, usize)> = (0..joints.len())
        .flat_map(|joint| (0..joints[joint].dofs.len()).map(move |dof| (joint, dof)))
        .filter(|&(joint, dof)| is_chosen(joint, dof) && !follows(joint))
        .collect();
    let any = !chosen.is_empty();
    for (joint, dof) in chosen {
        let effort = reader.efforts.get(&(joint, dof)).copied();
        let effort = effort.filter(|effort| *effort > 0.0 && *effort < UNLIMITED);
        let rate = reader.rates.get(&(joint, dof)).copied();
        let content = &mut reader.robot.joints[joint];
        content.dofs[dof].actuated = true;
        if effort.is_some() || rate.is_some() {
            reader.robot.motors.push(Motor {
                name: content.dof_name(dof),
                joint,
                dof,
                gear: 1.0,
                effort,
                rate,
                place: content.place.clone(),
            });
        }
    }
    let message = match any {
        true if has_names => {
            "SDF does not say which joints have motors: those named in plugins are actuated"
        }
        true if is_open => {
            "SDF does not say which joints have motors: those whose effort limit is not 0 are actuated"
        }
        true => {
            "SDF does not say which joints have motors: those with an effort limit above 0 are actuated"
        }
        false => "the file does not say which joints have motors: add `actuated = true` to them",
    };
    reader.context.note(message, None);
}
