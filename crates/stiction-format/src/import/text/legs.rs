//! Writes the tables of groups of equal legs into the text of a model file.

use super::super::context::Context;
use super::super::description::{Body, Description, Joint};
use super::super::legs::placement::{Placement, candidates, unrotated};
use super::super::legs::{Group, Part};
use super::numbers::{angle, axis, lengths};
use super::{comment, joint, key, mass_properties, motor, spring, text, visuals};
use crate::source::Place;
use std::collections::HashSet;
use std::fmt::Write;
use stiction_core::spatial::Vec3;

/// Maximum number of entries in the comment of a table that lists lines of the imported file.
const MOST_LINES: usize = 12;

/// Formats the properties of joints and bodies that must agree in equal legs as text: everything
/// except joint frames, initial coordinates and meshes.
pub(in crate::import) fn properties(
    robot: &Description,
    joints: &[usize],
    bodies: &[usize],
) -> String {
    let mut out = String::new();
    for &body in bodies {
        mass_properties(&mut out, &robot.bodies[body]);
        out.push('\n');
    }
    for &joint in joints {
        out += &of_joint(robot, joint);
        out.push('\n');
        out += &motor::of_leg(robot, joint).unwrap_or_default();
        out.push('\n');
    }
    out
}

/// Formats the lines of a joint's table that are the same in all legs of a group.
fn of_joint(robot: &Description, index: usize) -> String {
    let context = silent();
    let mut out = String::new();
    joint::pitch(&mut out, &robot.joints[index]);
    if !is_marked(robot, index) {
        joint::actuation(&mut out, robot, index);
    }
    joint::ranges(&mut out, &robot.joints[index]);
    joint::friction(&context, &mut out, robot, index);
    if is_marked(robot, index) {
        // This line distinguishes an actuated joint from a joint without a motor. It is not
        // written: in the model file, the chain marks actuated joints.
        out += "# actuated\n";
    }
    out
}

/// Creates a context without files. Its notes are discarded because they repeat notes that were
/// collected when an earlier text was written.
fn silent() -> Context<'static> {
    Context::new(&|_| Err(String::new()), false)
}

/// Tests if the chain of the leg marks the joint with `*` as actuated.
fn is_marked(robot: &Description, index: usize) -> bool {
    let mut out = String::new();
    joint::actuation(&mut out, robot, index);
    robot.joints[index].dofs.len() == 1 && !out.is_empty()
}

/// Returns the indices of the joints whose motors are written in the tables of their legs.
pub(super) fn driven(robot: &Description, groups: &[Group]) -> HashSet<usize> {
    let joints = groups.iter().flat_map(|group| &group.legs).flat_map(|leg| &leg.joints);
    joints.copied().filter(|joint| motor::of_leg(robot, *joint).is_some()).collect()
}

/// Writes the tables of all groups of legs.
pub(super) fn write(out: &mut String, robot: &Description, groups: &[Group], in_loops: &[bool]) {
    let mut count = 0;
    for group in groups {
        let header = if groups.len() == 1 { "[legs]" } else { "[[legs]]" };
        let writer = Writer { robot, group, in_loops, header, count };
        let texts = candidates(robot, group);
        let texts = texts.iter().map(|placement| writer.group(placement));
        // Of all placements, the one with the shortest text is chosen.
        let shortest = texts.min_by_key(|text| (text.lines().count(), text.chars().count()));
        *out += &shortest.unwrap_or_default();
        count += group.legs.len();
    }
}

/// Key of a leg's property and its value, both as written in the model file.
type Entry = (String, String);

struct Writer<'a> {
    robot: &'a Description,
    group: &'a Group,
    in_loops: &'a [bool],
    header: &'static str,
    /// Number of legs in all previous groups.
    count: usize,
}

impl Writer<'_> {
    fn group(&self, placement: &Placement) -> String {
        let Self { robot, group, .. } = self;
        let legs = unrotated(robot, group, placement);
        let entries: Vec<Vec<Entry>> = legs
            .iter()
            .zip(&group.legs)
            .map(|(joints, leg)| self.entries(joints, &leg.bodies))
            .collect();
        let is_shared = |entry: &Entry| entries.iter().all(|leg| leg.contains(entry));
        let shared: Vec<&Entry> = entries[0].iter().filter(|entry| is_shared(entry)).collect();
        let own: Vec<Vec<&Entry>> = entries
            .iter()
            .map(|leg| leg.iter().filter(|entry| !is_shared(entry)).collect())
            .collect();
        let mut out = format!("\n{}\n", self.header);
        let _ = writeln!(out, "chain = {}", text(&self.chain()));
        if group.from != super::GROUND {
            let _ = writeln!(out, "from = {}", text(&robot.bodies[group.from].name));
        }
        let _ = writeln!(out, "to = {}", text(&robot.bodies[group.to].name));
        self.names(&mut out);
        let is_turned = placement.angles.iter().any(|angle| *angle != 0.0);
        if is_turned && placement.axis != Vec3::unit(2) {
            let _ = writeln!(out, "about = {}", axis(placement.axis));
        }
        let name = |index: usize| {
            let name = &group.legs[index].name;
            (*name != format!("leg{}", self.count + index + 1)).then_some(name)
        };
        let is_short = own.iter().all(Vec::is_empty);
        if is_short && (0..legs.len()).all(|leg| name(leg).is_none()) {
            let each = placement.angles.iter().map(|own| match *own {
                0.0 => "\"0 deg\"".to_owned(),
                own => angle(own),
            });
            let angles: Vec<String> = each.collect();
            let _ = writeln!(out, "angles = [{}]", angles.join(", "));
        } else if is_short {
            out += "place = [\n";
            for (index, own) in placement.angles.iter().enumerate() {
                let mut keys = Vec::new();
                keys.extend(name(index).map(|name| format!("name = {}", text(name))));
                if *own != 0.0 {
                    keys.push(format!("angle = {}", angle(*own)));
                }
                let _ = writeln!(out, "    {{ {} }},", keys.join(", "));
            }
            out += "]\n";
        }
        for (key, value) in shared.iter().filter(|(key, _)| !key.contains('.')) {
            let _ = writeln!(out, "{key} = {value}");
        }
        if !is_short {
            for (index, own) in own.iter().enumerate() {
                out += "\n[[legs.place]]\n";
                if let Some(name) = name(index) {
                    let _ = writeln!(out, "name = {}", text(name));
                }
                if placement.angles[index] != 0.0 {
                    let _ = writeln!(out, "angle = {}", angle(placement.angles[index]));
                }
                for (key, value) in own {
                    let _ = writeln!(out, "{key} = {value}");
                }
            }
        }
        self.parts(&mut out, &shared);
        out
    }

    /// Formats the chain of the group's legs, with the names of its bodies, such as
    /// `R cylinder P* rod S`.
    fn chain(&self) -> String {
        let first = &self.group.legs[0];
        let mut words = Vec::new();
        for (index, &joint) in first.joints.iter().enumerate() {
            let mark = if is_marked(self.robot, joint) { "*" } else { "" };
            words.push(format!("{}{mark}", self.robot.joints[joint].kind.symbol()));
            words.extend(self.group.bodies.get(index).map(|body| body.key.clone()));
        }
        words.join(" ")
    }

    /// Writes the name patterns of joints and bodies whose names differ from the default names.
    fn names(&self, out: &mut String) {
        let parts = self.group.joints.iter().chain(&self.group.bodies);
        let names: Vec<String> = parts
            .filter(|part| !part.has_default_names())
            .map(|part| format!("{} = {}", key(&part.key), text(&part.pattern)))
            .collect();
        if !names.is_empty() {
            let _ = writeln!(out, "names = {{ {} }}", names.join(", "));
        }
    }

    /// Returns the keys and values of one leg that may differ between legs: its end points, joint
    /// frames, initial coordinates and meshes.
    fn entries(&self, joints: &[Joint], bodies: &[usize]) -> Vec<Entry> {
        let last = joints.len() - 1;
        let mut entries = vec![
            ("foot".to_owned(), lengths(joints[0].frame_j.position)),
            ("tip".to_owned(), lengths(joints[last].frame_k.position)),
        ];
        for (index, (own, part)) in joints.iter().zip(&self.group.joints).enumerate() {
            let mut own = own.clone();
            if index == 0 {
                own.frame_j.position = Vec3::zero();
            }
            if index == last {
                own.frame_k.position = Vec3::zero();
            }
            let mut lines = String::new();
            joint::frames(&mut lines, &own);
            // A joint is in a loop either in all legs or in none, although the joint that closes
            // the loop may differ.
            joint::start(&mut lines, &own, self.in_loops[self.group.legs[0].joints[index]]);
            entries.extend(lines.lines().filter_map(|line| {
                let (name, value) = line.split_once(" = ")?;
                Some((format!("joints.{}.{name}", key(&part.key)), value.to_owned()))
            }));
        }
        for (body, part) in bodies.iter().zip(&self.group.bodies) {
            if let Some(visuals) = visuals(&self.robot.bodies[*body]) {
                entries.push((format!("bodies.{}.visual", key(&part.key)), visuals));
            }
        }
        entries
    }

    /// Writes the tables of joints, motors, springs and bodies of a group.
    fn parts(&self, out: &mut String, shared: &[&Entry]) {
        let Self { robot, group, .. } = self;
        let first = &group.legs[0];
        for (index, part) in group.joints.iter().enumerate() {
            let joints: Vec<&Joint> =
                group.legs.iter().map(|leg| &robot.joints[leg.joints[index]]).collect();
            let lines = self.shared("joints", part, shared);
            let own = of_joint(robot, first.joints[index]).replace("# actuated\n", "");
            let remarks = self.remarks(joints.iter().map(|joint| joint.comment.as_deref()));
            let places = joints.iter().map(|joint| joint.place.as_ref());
            self.table(out, &remarks, ("joints", part), places);
            *out += &lines;
            *out += &own;
        }
        for (index, part) in group.joints.iter().enumerate() {
            if let Some(own) = motor::of_leg(robot, first.joints[index]) {
                let places = group.legs.iter().map(|leg| motor::place(robot, leg.joints[index]));
                self.table(out, "", ("actuators", part), places);
                *out += &own;
            }
        }
        for (index, part) in group.bodies.iter().enumerate() {
            let bodies: Vec<&Body> =
                group.legs.iter().map(|leg| &robot.bodies[leg.bodies[index]]).collect();
            let remarks = self.remarks(bodies.iter().map(|body| body.comment.as_deref()));
            let places = bodies.iter().map(|body| body.place.as_ref());
            self.table(out, &remarks, ("bodies", part), places);
            mass_properties(out, bodies[0]);
            *out += &self.shared("bodies", part, shared);
        }
        for (name, own) in spring::of_legs(robot, group).0 {
            let _ = writeln!(out, "\n[legs.springs.{}]", key(&name));
            *out += &own;
        }
    }

    /// Formats the lines in the table of a joint or body that are the same in all legs. `kind` is
    /// the name of the table, `joints` or `bodies`.
    fn shared(&self, kind: &str, part: &Part, shared: &[&Entry]) -> String {
        let prefix = format!("{kind}.{}.", key(&part.key));
        let own =
            shared.iter().filter_map(|(key, value)| Some((key.strip_prefix(&prefix)?, value)));
        own.map(|(key, value)| format!("{key} = {value}\n")).collect()
    }

    /// Writes the header of a table, with a comment that lists the line of the part in the imported
    /// file for each leg.
    fn table<'p>(
        &self,
        out: &mut String,
        remarks: &str,
        (kind, part): (&str, &Part),
        places: impl Iterator<Item = Option<&'p Place>>,
    ) {
        let header = format!("[legs.{kind}.{}]", key(&part.key));
        let mut lines: Vec<String> = Vec::new();
        for place in places.flatten() {
            let line = place.line_column().0.to_string();
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
        if lines.len() > MOST_LINES {
            let last = lines.split_off(lines.len() - 1);
            lines.truncate(MOST_LINES - 2);
            lines.push("…".to_owned());
            lines.extend(last);
        }
        let _ = match lines.as_slice() {
            [] => writeln!(out, "\n{remarks}{header}"),
            lines => writeln!(out, "\n{remarks}{header:<35} # {}", lines.join(", ")),
        };
    }

    /// Formats the comments that a joint or body has in the individual legs. Comments that differ
    /// only in the leg's name are written once.
    fn remarks<'c>(&self, all: impl Iterator<Item = Option<&'c str>>) -> String {
        let mut known: Vec<(String, &str, Vec<&str>)> = Vec::new();
        let mut count = 0;
        for (remark, leg) in all.zip(&self.group.legs) {
            count += 1;
            let Some(remark) = remark else { continue };
            let common = remark.replace(leg.name.as_str(), "{}");
            match known.iter_mut().find(|(own, ..)| *own == common) {
                Some((.., legs)) => legs.push(&leg.name),
                None => known.push((common, remark, vec![&leg.name])),
            }
        }
        let mut out = String::new();
        for (_, remark, legs) in &known {
            match legs.len() == count {
                true => comment(&mut out, remark),
                false => comment(&mut out, &format!("{}: {remark}", legs.join(", "))),
            }
        }
        out
    }
}
