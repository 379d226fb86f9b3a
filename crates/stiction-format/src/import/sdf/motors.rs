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
    let limited: Vec<usize> = {
        let positive = reader.efforts.iter().filter(|(_, effort)| **effort > 0.0);
        positive.map(|(joint, _)| *joint).collect()
    };
    let has_names = !named.is_empty();
    let chosen = if has_names { named } else { limited };
    let count = reader.robot.bodies.len();
    let joints = &reader.robot.joints;
    let is_open = joints.len() + 1 == count;
    let chosen = match is_open && !has_names {
        // An open chain: all joints that may have an effort, also those without a limit.
        true => {
            let may = |joint: &usize| reader.efforts.get(joint) != Some(&0.0);
            (0..joints.len()).filter(may).collect()
        }
        false => chosen,
    };
    let follows: Vec<usize> =
        reader.robot.gearings.iter().map(|gearing| gearing.terms[0].0).collect();
    let mut any = false;
    let mut sorted = chosen;
    sorted.sort_unstable();
    sorted.dedup();
    for joint in sorted {
        if follows.contains(&joint) {
            continue;
        }
        let effort = reader.efforts.get(&joint).copied();
        let effort = effort.filter(|effort| *effort > 0.0 && *effort < UNLIMITED);
        let content = &mut reader.robot.joints[joint];
        if let [dof] = content.dofs.as_mut_slice() {
            dof.actuated = true;
            any = true;
            let rate = reader.rates.get(&joint).copied();
            if effort.is_some() || rate.is_some() {
                reader.robot.motors.push(Motor {
                    name: content.name.clone(),
                    joint,
                    dof: 0,
                    gear: 1.0,
                    effort,
                    rate,
                    place: content.place.clone(),
                });
            }
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
