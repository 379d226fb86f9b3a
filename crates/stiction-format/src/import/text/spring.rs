//! Writes tables of springs.

use super::super::description::{Description, Joint};
use super::super::legs::{Group, Leg};
use super::joint::is_angle;
use super::numbers::{angle, length, lengths, quantity};
use super::{entries, key, line, text};
use std::collections::HashSet;
use std::fmt::Write;

/// Springs on joints of equal legs, by their names in the chain; `None` unless every leg has the same ones, with the names
/// of springs of legs.
pub(super) fn of_legs(robot: &Description, group: &Group) -> Option<Vec<(String, String)>> {
    let of_leg = |leg: &Leg| -> Option<Vec<(String, String)>> {
        let mut springs = Vec::new();
        for (&index, part) in leg.joints.iter().zip(&group.joints) {
            let joint = &robot.joints[index];
            for dof in 0..joint.dofs.len() {
                let Some(own) = on_joint(joint, dof) else { continue };
                if !part.has_default_names() || is_used(robot, &joint.dof_name(dof)) {
                    return None;
                }
                let name = joint.dof_name(dof).strip_prefix(&format!("{}.", leg.name))?.to_owned();
                let own = format!("joint = {}\n{own}", text(&name));
                springs.push((name, own));
            }
        }
        Some(springs)
    };
    let mut all = group.legs.iter().map(of_leg);
    let first = all.next()??;
    all.all(|own| own.as_ref() == Some(&first)).then_some(first)
}

/// Tests if another spring than that on the joint has its name.
fn is_used(robot: &Description, name: &str) -> bool {
    robot.spring_tables.iter().any(|(known, _)| known == name)
        || robot.springs.iter().any(|spring| spring.name == name)
}

/// Keys of the spring on a coordinate besides its joint.
fn on_joint(joint: &Joint, dof: usize) -> Option<String> {
    let [stiffness, rest] = joint.dofs[dof].spring?;
    let (unit, rest) = match is_angle(joint.kind, dof) {
        true => ("N m/rad", angle(rest)),
        false => ("N/m", length(rest)),
    };
    Some(format!("stiffness = {}\nrest = {rest}\n", quantity(stiffness, unit)))
}

/// Writes all springs but those of equal legs.
pub(super) fn write(out: &mut String, robot: &Description, groups: &[Group]) {
    let in_legs: HashSet<usize> = groups
        .iter()
        .filter(|group| of_legs(robot, group).is_some())
        .flat_map(|group| &group.legs)
        .flat_map(|leg| &leg.joints)
        .copied()
        .collect();
    let mut names: HashSet<String> = HashSet::new();
    let mut unique = |name: &str| {
        let mut own = name.to_owned();
        while !names.insert(own.clone()) {
            own += "_spring";
        }
        own
    };
    for (name, table) in &robot.spring_tables {
        let _ = writeln!(out, "\n[springs.{}]", key(&unique(name)));
        entries(out, table);
    }
    for (name, table) in &robot.bushing_tables {
        let _ = writeln!(out, "\n[bushings.{}]", key(name));
        entries(out, table);
    }
    for spring in &robot.springs {
        let [from, to] = spring.ends.map(|end| text(&robot.bodies[end].name));
        let [at, to_at] = spring.points.map(lengths);
        let _ = writeln!(out, "\n[springs.{}]", key(&unique(&spring.name)));
        let _ = writeln!(out, "from = {from}\nat = {at}\nto = {to}\nto_at = {to_at}");
        if spring.stiffness > 0.0 {
            let _ = writeln!(out, "stiffness = {}", quantity(spring.stiffness, "N/m"));
            let _ = writeln!(out, "free_length = {}", length(spring.free_length));
        }
        if spring.damping > 0.0 {
            let _ = writeln!(out, "damping = {}", quantity(spring.damping, "N s/m"));
        }
    }
    for (index, joint) in robot.joints.iter().enumerate() {
        if in_legs.contains(&index) {
            continue;
        }
        for dof in 0..joint.dofs.len() {
            let Some(own) = on_joint(joint, dof) else { continue };
            let name = joint.dof_name(dof);
            let header = format!("[springs.{}]", key(&unique(&name)));
            let _ = writeln!(out, "\n{}", line(joint.place.as_ref(), &header));
            let _ = writeln!(out, "joint = {}", text(&name));
            *out += &own;
        }
    }
}
