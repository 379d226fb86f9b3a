//! Writes the tables of rigid gearings into the text of a model file.

use super::super::context::Context;
use super::super::description::{Description, Gearing};
use super::joint::is_angle;
use super::numbers::{angle, length, quantity};
use super::{entries, key, line};
use crate::diagnostic::quoted;
use std::collections::HashSet;
use std::fmt::Write;

/// Returns the terms of a gearing as written to the model file: (joint index, coordinate index,
/// factor). Terms of the same coordinate are added, and terms with factor 0 removed. Returns `None`
/// if fewer than two terms remain, a factor is not finite, or a joint lacks the coordinate.
pub(in crate::import) fn terms(
    robot: &Description,
    gearing: &Gearing,
) -> Option<Vec<(usize, usize, f64)>> {
    let mut terms: Vec<(usize, usize, f64)> = Vec::new();
    for &(joint, dof, factor) in &gearing.terms {
        robot.joints[joint].dofs.get(dof)?;
        match terms.iter_mut().find(|known| (known.0, known.1) == (joint, dof)) {
            Some(known) => known.2 += factor,
            None => terms.push((joint, dof, factor)),
        }
    }
    terms.retain(|term| term.2 != 0.0);
    (terms.len() > 1 && terms.iter().all(|term| term.2.is_finite())).then_some(terms)
}

/// Writes the tables of all gearings; reports and omits gearings that do not couple two
/// coordinates.
pub(super) fn write(context: &Context<'_>, out: &mut String, robot: &Description) {
    let mut names: HashSet<String> = HashSet::new();
    for (name, table) in &robot.gearing_tables {
        names.insert(name.clone());
        let _ = writeln!(out, "\n[gearings.{}]", key(name));
        entries(out, table);
    }
    for gearing in &robot.gearings {
        let Some(terms) = terms(robot, gearing) else {
            let message = format!(
                "the coupling {} does not connect two movable joints: it is left out",
                quoted(&gearing.name)
            );
            context.note(message, gearing.place.clone());
            continue;
        };
        let mut name = gearing.name.clone();
        while !names.insert(name.clone()) {
            name += "_gearing";
        }
        one(out, robot, (&name, gearing), &terms);
    }
}

fn one(
    out: &mut String,
    robot: &Description,
    (name, gearing): (&str, &Gearing),
    terms: &[(usize, usize, f64)],
) {
    let turns = |&(joint, dof, _): &(usize, usize, f64)| is_angle(robot.joints[joint].kind, dof);
    let is_length = !terms.iter().all(turns);
    let each: Vec<String> = terms
        .iter()
        .map(|term| {
            let &(joint, dof, factor) = term;
            let factor = match is_length && turns(term) {
                true => quantity(factor, "m/rad"),
                false => factor.to_string(),
            };
            format!("{} = {factor}", key(&robot.joints[joint].dof_name(dof)))
        })
        .collect();
    let _ =
        writeln!(out, "\n{}", line(gearing.place.as_ref(), &format!("[gearings.{}]", key(name))));
    let _ = writeln!(out, "joints = {{ {} }}", each.join(", "));
    let offset = if is_length { length(gearing.constant) } else { angle(gearing.constant) };
    if offset != "0" {
        let _ = writeln!(out, "offset = {offset}");
    }
}
