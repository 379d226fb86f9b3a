//! Writes the tables of springs into the text of a model file.

use super::super::description::{Description, Joint, Spring};
use super::super::legs::{Group, Leg};
use super::joint::is_angle;
use super::numbers::{angle, length, lengths, quantity};
use super::{entries, key, line, text};
use std::collections::HashSet;
use std::fmt::Write;

/// Finds the springs that occur in every leg of a group and have default names. Returns the name of
/// each spring within the leg with the lines of its table, and the names of all these springs in
/// the model.
pub(super) fn of_legs(
    robot: &Description,
    group: &Group,
) -> (Vec<(String, String)>, HashSet<String>) {
    let of_leg: Vec<Vec<(String, String)>> = group
        .legs
        .iter()
        .map(|leg| {
            let mut springs = on_joints_of(robot, group, leg);
            springs.extend(tables_of(robot, group, leg));
            springs.extend(between_bodies_of(robot, group, leg));
            springs
        })
        .collect();
    let (first, others) = of_leg.split_first().unwrap_or((&NONE, &[]));
    let is_common = |spring: &&(String, String)| others.iter().all(|leg| leg.contains(spring));
    let common: Vec<(String, String)> = first.iter().filter(is_common).cloned().collect();
    let full = |(key, _): &(String, String)| {
        let key = key.clone();
        group.legs.iter().map(move |leg| format!("{}.{key}", leg.name))
    };
    let names = common.iter().flat_map(full).collect();
    (common, names)
}

static NONE: Vec<(String, String)> = Vec::new();

/// Finds the springs on joint coordinates of a leg, for joints with default names. Returns the name
/// of each spring within the leg and the lines of its table.
fn on_joints_of(robot: &Description, group: &Group, leg: &Leg) -> Vec<(String, String)> {
    let mut springs = Vec::new();
    for (&index, part) in leg.joints.iter().zip(&group.joints) {
        let joint = &robot.joints[index];
        for dof in (0..joint.dofs.len()).filter(|_| part.has_default_names()) {
            let (Some(own), name) = (on_joint(joint, dof), joint.dof_name(dof)) else { continue };
            if let Some(key) = name.strip_prefix(&format!("{}.", leg.name))
                && !is_used(robot, &name)
            {
                springs.push((key.to_owned(), format!("joint = {}\n{own}", text(key))));
            }
        }
    }
    springs
}

/// Formats the table of a spring between points of two bodies with these names.
fn between(spring: &Spring, bodies: [&str; 2]) -> String {
    let [from, to] = bodies.map(text);
    let [at, to_at] = spring.points.map(lengths);
    let mut out = format!("from = {from}\nat = {at}\nto = {to}\nto_at = {to_at}\n");
    if spring.stiffness > 0.0 {
        let _ = writeln!(out, "stiffness = {}", quantity(spring.stiffness, "N/m"));
        let _ = writeln!(out, "free_length = {}", length(spring.free_length));
    }
    if spring.damping > 0.0 {
        let _ = writeln!(out, "damping = {}", quantity(spring.damping, "N s/m"));
    }
    out
}

/// Finds the springs that connect points of two bodies of a leg. Returns the name of each spring
/// within the leg and the lines of its table.
fn between_bodies_of(robot: &Description, group: &Group, leg: &Leg) -> Vec<(String, String)> {
    let body = |end: usize| {
        let index = leg.bodies.iter().position(|body| *body == end)?;
        Some(group.bodies[index].key.as_str())
    };
    let spring = |spring: &Spring| {
        let key = spring.name.strip_prefix(&format!("{}.", leg.name))?;
        let [from, to] = spring.ends.map(body);
        Some((key.to_owned(), between(spring, [from?, to?])))
    };
    robot.springs.iter().filter_map(spring).collect()
}

/// Finds the springs from extension elements that connect bodies of a leg or act on one of its
/// joints. Returns the name of each spring within the leg and the lines of its table.
fn tables_of(robot: &Description, group: &Group, leg: &Leg) -> Vec<(String, String)> {
    let bodies = leg.bodies.iter().zip(&group.bodies);
    let bodies: Vec<(&str, &str)> =
        bodies.map(|(body, part)| (robot.bodies[*body].name.as_str(), part.key.as_str())).collect();
    let dofs = leg.joints.iter().zip(&group.joints).flat_map(|(&joint, part)| {
        let joint = &robot.joints[joint];
        (0..joint.dofs.len()).map(move |dof| {
            let name = joint.dof_name(dof);
            let key = format!("{}{}", part.key, &name[joint.name.len()..]);
            (name, key)
        })
    });
    let dofs: Vec<(String, String)> = dofs.collect();
    let spring = |(name, table): &(String, toml::Table)| {
        let key = name.strip_prefix(&format!("{}.", leg.name))?;
        let mut own = table.clone();
        for (end, value) in &mut own {
            let known = match end.as_str() {
                "from" | "to" => bodies.iter().find(|known| value.as_str() == Some(known.0))?.1,
                "joint" => &dofs.iter().find(|known| value.as_str() == Some(&known.0))?.1,
                _ => continue,
            };
            *value = known.into();
        }
        let mut out = String::new();
        entries(&mut out, &own);
        Some((key.to_owned(), out))
    };
    robot.spring_tables.iter().filter_map(spring).collect()
}

/// Tests if a spring between bodies or from an extension element has this name, which is also the
/// default name of a spring on a joint.
fn is_used(robot: &Description, name: &str) -> bool {
    robot.spring_tables.iter().any(|(known, _)| known == name)
        || robot.springs.iter().any(|spring| spring.name == name)
}

/// Formats the table of the spring on a coordinate, without the key `joint`; returns `None` if the
/// coordinate has no spring.
fn on_joint(joint: &Joint, dof: usize) -> Option<String> {
    let [stiffness, rest] = joint.dofs[dof].spring?;
    let (unit, rest) = match is_angle(joint.kind, dof) {
        true => ("N m/rad", angle(rest)),
        false => ("N/m", length(rest)),
    };
    Some(format!("stiffness = {}\nrest = {rest}\n", quantity(stiffness, unit)))
}

/// Writes the tables of all springs except those of equal legs.
pub(super) fn write(out: &mut String, robot: &Description, groups: &[Group]) {
    let in_legs: HashSet<String> =
        groups.iter().flat_map(|group| of_legs(robot, group).1).collect();
    let mut names: HashSet<String> = HashSet::new();
    let mut unique = |name: &str| {
        let mut own = name.to_owned();
        while !names.insert(own.clone()) {
            own += "_spring";
        }
        own
    };
    for (name, table) in robot.spring_tables.iter().filter(|(name, _)| !in_legs.contains(name)) {
        let _ = writeln!(out, "\n[springs.{}]", key(&unique(name)));
        entries(out, table);
    }
    for (name, table) in &robot.bushing_tables {
        let _ = writeln!(out, "\n[bushings.{}]", key(name));
        entries(out, table);
    }
    for spring in robot.springs.iter().filter(|spring| !in_legs.contains(&spring.name)) {
        let _ = writeln!(out, "\n[springs.{}]", key(&unique(&spring.name)));
        *out += &between(spring, spring.ends.map(|end| robot.bodies[end].name.as_str()));
    }
    for joint in &robot.joints {
        for dof in 0..joint.dofs.len() {
            let Some(own) = on_joint(joint, dof) else { continue };
            let name = joint.dof_name(dof);
            if in_legs.contains(&name) {
                continue;
            }
            let header = format!("[springs.{}]", key(&unique(&name)));
            let _ = writeln!(out, "\n{}", line(joint.place.as_ref(), &header));
            let _ = writeln!(out, "joint = {}", text(&name));
            *out += &own;
        }
    }
}
