//! Writes the description of an imported robot as the text of a model file.

pub(super) mod gearing;
mod joint;
pub(super) mod legs;
mod motor;
pub(super) mod numbers;
mod spring;

pub(super) use joint::has_axes;

use super::context::{Context, Note};
use super::description::{Body, Description, GROUND, Joint, VisualMesh};
use super::extension::joint_names;
use super::legs::Group;
use crate::document::key;
use crate::source::Place;
use numbers::{guess, inertia, lengths, quantity};
use std::collections::HashSet;
use std::fmt::Write;
use stiction_core::spatial::Vec3;

/// Maximum length of a comment line, characters.
const WIDTH: usize = 100;

/// Coordinate with its value, rad or m, in the motion that fixes the robot's configuration.
#[derive(Clone, Debug)]
pub(super) struct Held {
    /// Name of the coordinate as a key of a motion.
    pub(super) name: String,
    pub(super) value: f64,
    pub(super) is_angle: bool,
}

/// Content of the model file besides the robot's description: file name, notes, motion and groups
/// of equal legs.
#[derive(Clone)]
pub(super) struct Draft<'a> {
    /// Name of the file from which the robot was imported.
    pub(super) file: &'a str,
    /// Differences from the imported file, listed at the top of the model file.
    pub(super) notes: &'a [Note],
    /// Coordinates that fix the robot's configuration, written as a motion; `None` for a model file
    /// without a motion, from which only the mechanism is read.
    pub(super) motion: Option<Vec<Held>>,
    /// Groups of joints and bodies that are written as equal legs.
    pub(super) legs: &'a [Group],
}

/// Formats the text of the model file; `context` collects notes on properties that are left out.
pub(super) fn write(context: &Context<'_>, robot: &Description, draft: &Draft<'_>) -> String {
    let mut out = String::new();
    let title = format!("{}, from the {} {}", robot.name, robot.format, draft.file);
    let each =
        if draft.legs.is_empty() { "" } else { "; each part of a leg has one number per leg" };
    comment(
        &mut out,
        &format!(
            "From {} ({}). Numbers after # are line numbers of that file{each}.",
            draft.file, robot.format
        ),
    );
    if !draft.notes.is_empty() {
        out += "#\n";
        comment(&mut out, "Differences from the file:");
        for note in draft.notes {
            item(&mut out, &note.line_with(super::file_name));
        }
    }
    let _ = writeln!(out, "\nname = {}", text(&robot.name));
    let _ = writeln!(out, "title = {}", text(&title));
    let gravity = robot.gravity.to_array().map(|g| quantity(g, "m/s^2"));
    let _ = writeln!(out, "gravity = [{}]", gravity.join(", "));
    if let Some(remark) = &robot.bodies[GROUND].comment {
        out += "\n";
        comment(&mut out, remark);
    }
    let legs = || draft.legs.iter().flat_map(|group| &group.legs);
    let bodies: HashSet<usize> = legs().flat_map(|leg| &leg.bodies).copied().collect();
    let joints: HashSet<usize> = legs().flat_map(|leg| &leg.joints).copied().collect();
    for (index, body) in robot.bodies.iter().enumerate().skip(1) {
        if !bodies.contains(&index) {
            write_body(&mut out, body);
        }
    }
    let in_loops = robot.in_loops();
    legs::write(&mut out, robot, draft.legs, &in_loops);
    for index in (0..robot.joints.len()).filter(|index| !joints.contains(index)) {
        joint::write(context, &mut out, robot, index, in_loops[index]);
    }
    motor::write(context, &mut out, robot, &legs::driven(robot, draft.legs));
    gearing::write(context, &mut out, robot);
    spring::write(&mut out, robot, draft.legs);
    let motion = draft.motion.as_ref().filter(|motion| !motion.is_empty());
    if let Some(motion) = motion {
        out += "\n";
        comment(
            &mut out,
            &format!("At rest, at the position with closed loops nearest to {}.", robot.position),
        );
        out += "[motions.hold]\nduration = 0\n";
        for Held { name, value, is_angle } in motion {
            let _ = writeln!(out, "{} = {}", coordinate(name), guess(*value, *is_angle));
        }
    }
    if motion.is_some() || robot.friction.is_some() {
        out += "\n[default]\n";
    }
    if motion.is_some() {
        out += "motion = \"hold\"\n";
    }
    if let Some(mode) = &robot.friction {
        let _ = writeln!(out, "friction = {}", text(mode));
    }
    out
}

/// Header of the table of a part: `[joints.A]`.
pub(super) fn header(kind: &str, name: &str) -> String {
    format!("[{kind}.{}]", key(name))
}

/// Formats the header of a table, followed by a comment with the line number of the described part
/// in the imported file.
fn line(place: Option<&Place>, header: &str) -> String {
    match place {
        Some(place) => format!("{header:<35} # {}", place.line_column().0),
        None => header.to_owned(),
    }
}

fn write_body(out: &mut String, body: &Body) {
    out.push('\n');
    if let Some(remark) = &body.comment {
        comment(out, remark);
    }
    let _ = writeln!(out, "{}", line(body.place.as_ref(), &header("bodies", &body.name)));
    mass_properties(out, body);
    if let Some(visuals) = visuals(body) {
        let _ = writeln!(out, "visual = {visuals}");
    }
}

fn mass_properties(out: &mut String, body: &Body) {
    if !body.is_massless() {
        let _ = writeln!(out, "mass = {}", quantity(body.mass, "kg"));
        let _ = writeln!(out, "com = {}", lengths(body.com));
        let _ = writeln!(out, "inertia = {}", inertia(body.inertia));
    }
}

/// Formats the list of a body's meshes; `None` for a body without meshes.
fn visuals(body: &Body) -> Option<String> {
    let meshes = body.visuals.iter().map(|visual| format!("    {},\n", mesh(visual)));
    (!body.visuals.is_empty()).then(|| format!("[\n{}]", meshes.collect::<String>()))
}

/// Formats the table of a mesh on one line.
fn mesh(visual: &VisualMesh) -> String {
    let VisualMesh { file, scale, pose } = visual;
    let mut table = format!("{{ mesh = {}", text(file));
    if *scale != [1.0; 3] {
        let _ = write!(table, ", scale = [{}]", scale.map(|x| format!("{x:?}")).join(", "));
    }
    if pose.position != Vec3::zero() {
        let _ = write!(table, ", position = {}", lengths(pose.position));
    }
    let turn = pose.rotation.rotation_vector();
    if turn != Vec3::zero() {
        let angle = turn.norm();
        let axis = (turn * angle.recip()).to_array().map(|x| format!("{x:?}")).join(", ");
        let _ = write!(table, ", rotation = {{ axis = [{axis}], angle = {angle:?} }}");
    }
    table + " }"
}

/// Writes the entries of a table, nested tables on one line each.
fn entries(out: &mut String, table: &toml::Table) {
    for (name, value) in table {
        let _ = writeln!(out, "{} = {value}", key(name));
    }
}

/// Formats a key of a motion; a name with dots is quoted as a whole.
fn coordinate(name: &str) -> String {
    key(name)
}

/// Puts a text in quotes, as a TOML string.
fn text(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// Writes a text as a comment, wrapped at [`WIDTH`] characters.
fn comment(out: &mut String, text: &str) {
    wrapped(out, text, ["# ", "# "]);
}

/// Writes a text as an item of a bulleted list in a comment, wrapped at [`WIDTH`] characters.
fn item(out: &mut String, text: &str) {
    wrapped(out, text, ["# - ", "#   "]);
}

fn wrapped(out: &mut String, text: &str, [first, next]: [&str; 2]) {
    let mut line = first.to_owned();
    let mut is_empty = true;
    for word in text.split_whitespace() {
        // Control characters would end the comment.
        let word: String = word.chars().filter(|c| !c.is_control()).collect();
        if !is_empty && line.chars().count() + word.chars().count() > WIDTH {
            let _ = writeln!(out, "{}", line.trim_end());
            line = next.to_owned();
        }
        line += &word;
        line.push(' ');
        is_empty = false;
    }
    let _ = writeln!(out, "{}", line.trim_end());
}

impl Description {
    /// Tests for each joint if it is part of a closed loop, or if a gearing couples its coordinates
    /// to those of another joint.
    pub(super) fn in_loops(&self) -> Vec<bool> {
        let mut found = self.in_loops_of_bodies();
        for (joint, ..) in
            self.gearings.iter().filter_map(|own| gearing::terms(self, own)).flatten()
        {
            found[joint] = true;
        }
        let in_tables: Vec<String> =
            self.gearing_tables.iter().flat_map(|(_, table)| joint_names(table)).collect();
        for (found, joint) in found.iter_mut().zip(&self.joints) {
            *found |= (0..joint.dofs.len()).any(|dof| in_tables.contains(&joint.dof_name(dof)));
        }
        found
    }

    fn in_loops_of_bodies(&self) -> Vec<bool> {
        // Open chains, with one joint for each body except the ground, contain no loops; no search
        // is necessary.
        if self.joints.len() + 1 == self.bodies.len() {
            return vec![false; self.joints.len()];
        }
        let is_bridged = |joint: usize| {
            let Joint { from, to, .. } = self.joints[joint];
            self.reached_without(joint, from)[to]
        };
        (0..self.joints.len()).map(is_bridged).collect()
    }

    /// Tests for each body if joints other than `without` connect it to the body `start`.
    pub(super) fn reached_without(&self, without: usize, start: usize) -> Vec<bool> {
        let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); self.bodies.len()];
        for (index, joint) in self.joints.iter().enumerate() {
            if index != without {
                neighbours[joint.from].push(joint.to);
                neighbours[joint.to].push(joint.from);
            }
        }
        let mut reached = vec![false; self.bodies.len()];
        reached[start] = true;
        let mut open = vec![start];
        while let Some(body) = open.pop() {
            for &next in &neighbours[body] {
                if !std::mem::replace(&mut reached[next], true) {
                    open.push(next);
                }
            }
        }
        reached
    }
}
