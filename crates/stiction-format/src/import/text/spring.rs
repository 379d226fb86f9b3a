//! Writes tables of springs.

use super::super::description::Description;
use super::joint::is_angle;
use super::numbers::{angle, length, lengths, quantity};
use super::{entries, key, line, text};
use std::collections::HashSet;
use std::fmt::Write;

pub(super) fn write(out: &mut String, robot: &Description) {
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
    for joint in &robot.joints {
        for (dof, own) in joint.dofs.iter().enumerate() {
            let Some([stiffness, rest]) = own.spring else { continue };
            let (unit, rest) = match is_angle(joint.kind, dof) {
                true => ("N m/rad", angle(rest)),
                false => ("N/m", length(rest)),
            };
            let name = joint.dof_name(dof);
            let header = format!("[springs.{}]", key(&unique(&name)));
            let _ = writeln!(out, "\n{}", line(joint.place.as_ref(), &header));
            let _ = writeln!(out, "joint = {}", text(&name));
            let _ = writeln!(out, "stiffness = {}", quantity(stiffness, unit));
            let _ = writeln!(out, "rest = {rest}");
        }
    }
}
