//! Conversion of names to the form that a model file allows.

use super::context::Context;
use super::description::Description;
use super::extension;
use crate::diagnostic::quoted;
use std::collections::{HashMap, HashSet};

/// Names that parts cannot have, because they have a meaning in motions, loads and results.
pub(super) const TAKEN: [&str; 10] =
    ["title", "start", "duration", "step", "file", "order", "time", "loads", "dampers", "ground"];
/// Maximum length of a name in characters; longer names are cut off.
const LONGEST: usize = 100;

/// Converts a name to allowed characters: letters, digits, `_` and `-`, with dots between non-empty
/// components of the name.
fn allowed(name: &str) -> String {
    let parts = name.replace("::", ".");
    let parts = parts.split('.').map(|part| {
        let letter = |c: char| if c.is_alphanumeric() || c == '_' || c == '-' { c } else { '_' };
        part.chars().map(letter).collect::<String>()
    });
    let parts: Vec<String> = parts.filter(|part| !part.is_empty()).collect();
    let name: String = parts.join(".").chars().take(LONGEST).collect();
    let name = name.trim_end_matches('.');
    let first = name.split('.').next().unwrap_or_default();
    match first {
        "" => "unnamed".to_owned(),
        _ if TAKEN.contains(&first) => format!("_{name}"),
        _ => name.to_owned(),
    }
}

/// Names already used by one kind of part, such as joints, and the new names of parts that were renamed.
#[derive(Default)]
struct Names {
    used: HashSet<String>,
    renamed: HashMap<String, String>,
}

impl Names {
    /// Replaces a name by its allowed form, and appends a number if this form is already used.
    fn take(&mut self, context: &Context<'_>, name: &mut String, kind: &str) {
        let own = allowed(name);
        let mut unique = own.clone();
        let mut number = 2;
        while !self.used.insert(unique.clone()) {
            unique = format!("{own}_{number}");
            number += 1;
        }
        // Dots in place of the colons of nested models do not count as a change of the name.
        if unique != name.replace("::", ".") {
            let message = format!("{kind} {} is renamed to {unique}", quoted(name));
            context.note(message, None);
        }
        if unique != *name {
            let former = std::mem::replace(name, unique);
            self.renamed.entry(former).or_insert_with(|| name.clone());
        }
    }
}

/// Converts the names of all parts to unique names of the allowed form.
pub(super) fn tidy(context: &Context<'_>, robot: &mut Description) {
    let mut bodies = Names::default();
    for body in robot.bodies.iter_mut().skip(1) {
        bodies.take(context, &mut body.name, "body");
    }
    let mut joints = Names::default();
    for joint in &mut robot.joints {
        joints.take(context, &mut joint.name, "joint");
    }
    extension::rename(robot, &joints.renamed, &bodies.renamed);
    let mut springs = Names::default();
    for spring in &mut robot.springs {
        springs.take(context, &mut spring.name, "spring");
    }
    let mut motors = Names::default();
    for motor in &mut robot.motors {
        motors.take(context, &mut motor.name, "motor");
    }
    for motor in &mut robot.joint_motors {
        motors.take(context, &mut motor.name, "motor");
    }
    let mut gearings = Names::default();
    for gearing in &mut robot.gearings {
        gearings.take(context, &mut gearing.name, "gearing");
    }
    robot.name = robot.name.chars().filter(|c| !c.is_control()).take(LONGEST).collect();
}

/// Renames joints with several degrees of freedom that have the name of a body, because a name such
/// as `ball.x` could be a coordinate of the joint or of the body.
pub(super) fn separate(context: &Context<'_>, robot: &mut Description) {
    let taken: HashSet<String> = (robot.joints.iter().map(|joint| &joint.name))
        .chain(robot.bodies.iter().map(|body| &body.name))
        .cloned()
        .collect();
    let mut renamed = HashMap::new();
    for joint in &mut robot.joints {
        let is_body = robot.bodies.iter().any(|body| body.name == joint.name);
        if !is_body || !joint.kind.has_scalar_coordinates() || joint.kind.dofs().len() < 2 {
            continue;
        }
        let mut own = format!("{}_joint", joint.name);
        let mut number = 2;
        while taken.contains(&own) {
            own = format!("{}_joint{number}", joint.name);
            number += 1;
        }
        let message = format!(
            "joint {} is renamed to {own}, because a body has the same name",
            quoted(&joint.name)
        );
        context.note(message, joint.place.clone());
        renamed.insert(std::mem::replace(&mut joint.name, own.clone()), own);
    }
    extension::rename(robot, &renamed, &HashMap::new());
}
