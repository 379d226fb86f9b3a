//! Import of robot files of other programs: URDF, MJCF and SDF become the text of a model file.
//!
//! A reader for each format fills one [description](description::Description) of bodies and joints; [`meaning`]
//! replaces joints that the format can only express indirectly, such as a closure by three equations in a chain that
//! moves in a plane; [`text`] writes the model file. Content without a counterpart is reported with its places, never
//! omitted silently.

mod context;
mod description;
mod extension;
mod hull;
mod inertia;
mod joint_motors;
mod legs;
mod locks;
mod masses;
mod meaning;
mod mesh;
mod mjcf;
mod names;
mod position;
mod relocate;
mod rotation;
mod sdf;
mod shell;
mod solid;
mod text;
mod unread;
mod urdf;
mod xml;
mod yaml;

pub use context::{FileLoader, Note};
pub use extension::NAMESPACE;

use crate::diagnostic::{Diagnostic, Diagnostics, quoted};
use crate::model_file::ModelFile;
use crate::source::Source;
use context::Context;
use description::Description;
use std::sync::Arc;
use xml::Element;

/// Result of an import.
#[derive(Clone, Debug)]
pub struct Imported {
    /// Text of the model file.
    pub text: String,
    /// Remarks on content that the model does not express, or expresses differently from the file.
    pub notes: Vec<Note>,
}

/// Options of an import.
#[derive(Clone, Copy, Debug, Default)]
pub struct ImportOptions {
    /// Imports every joint as it is in the file, without merging chains of joints into hinges, ball
    /// joints and others.
    pub literal: bool,
}

/// Tests if a text looks like a robot file in XML rather than a model file.
pub fn is_robot_file(text: &str) -> bool {
    let text = text.trim_start_matches('\u{feff}').trim_start();
    // No model file in TOML begins with an angle bracket.
    text.starts_with('<')
}

/// Converts a URDF, MJCF or SDF file to a model file. `files` reads meshes and included files, by
/// names relative to the folder of the robot file.
///
/// # Errors
/// All errors of the file, each with its place.
pub fn import(
    source: &Source,
    options: ImportOptions,
    files: &FileLoader<'_>,
) -> Result<Imported, Diagnostics> {
    let source = Arc::new(source.clone());
    let context = Context::new(files, options.literal);
    let robot = xml::parse(&source)
        .map_err(|error| context.append(error))
        .ok()
        .and_then(|root| describe(&context, &root, stem(&source.name)))
        .filter(|_| !context.has_errors());
    context.note_missing_meshes();
    let text = robot.and_then(|robot| write(&context, &source, robot));
    let mut out = context.out.take();
    out.sort();
    match text {
        Some(text) if !out.has_errors() => Ok(Imported { text, notes: context.take_notes() }),
        _ => Err(out),
    }
}

/// Remark that shapes of the file are omitted, because a model has no shapes. `is_shown` is true if
/// meshes of some bodies are kept.
fn left_out_shapes(is_shown: bool) -> &'static str {
    match is_shown {
        true => {
            "only the visual meshes of moving bodies are kept; all other visual and collision shapes are left out"
        }
        false => "visual and collision shapes are not needed and are left out",
    }
}

/// Name of a file without its folder and ending.
fn stem(name: &str) -> &str {
    let name = file_name(name);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

fn file_name(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

/// Maximum number of bodies; analysing larger mechanisms would take hours.
const MOST_BODIES: usize = 2000;

/// Rejects files with too many bodies.
fn limit_size(context: &Context<'_>, root: &Element) -> Option<()> {
    let mut count = 0;
    let mut open = vec![root];
    while let Some(element) = open.pop() {
        count += usize::from(matches!(element.tag.as_str(), "link" | "body" | "joint"));
        if count > 3 * MOST_BODIES {
            let message = format!(
                "the file is too large: the limit is {MOST_BODIES} bodies with their joints"
            );
            let help = "import a part of the robot; mechanisms of this size cannot be computed";
            context.error("size", message, &element.place(), help);
            return None;
        }
        open.extend(&element.children);
    }
    Some(())
}

/// Reads the robot from the root element of a file; the tag of this element determines the format.
fn describe(context: &Context<'_>, root: &Element, stem: &str) -> Option<Description> {
    limit_size(context, root)?;
    match root.tag.as_str() {
        "robot" => urdf::read(context, root, stem),
        "mujoco" => mjcf::read(context, root),
        "sdf" => sdf::read(context, root),
        "mujocoinclude" => {
            let message = "this is a part of an MJCF model, not a whole robot".to_owned();
            let help = "convert the file whose <include> names this one";
            context.error("xml", message, &root.place(), help);
            None
        }
        other => {
            let message = format!("the root element {} is not that of a robot file", quoted(other));
            let help = "a URDF begins with <robot>, an MJCF with <mujoco>, an SDF with <sdf>";
            context.push(Diagnostic::error("xml", message).at(root.place(), "").help(help));
            None
        }
    }
}

/// Writes the model file with repeating legs as groups; `long` is the text without groups. `None`
/// if the robot has no repeating legs, or if no grouped text is shorter and describes the same
/// mechanism with the same names.
fn with_legs(
    context: &Context<'_>,
    robot: &Description,
    draft: &text::Draft<'_>,
    long: &str,
    read: &dyn Fn(&str) -> Result<ModelFile, Diagnostics>,
) -> Option<String> {
    /// Maximum number of groups; limits the time for writing and reading texts.
    const MOST: usize = 20;
    let found = if context.literal { Vec::new() } else { legs::find(robot) };
    if found.is_empty() {
        return None;
    }
    let model = read(long).ok()?;
    let (mut groups, mut shortest, mut shorter) = (Vec::new(), long.lines().count(), None);
    for group in found.into_iter().take(MOST) {
        groups.push(group);
        let text = text::write(context, robot, &text::Draft { legs: &groups, ..draft.clone() });
        let lines = text.lines().count();
        if lines < shortest && read(&text).is_ok_and(|own| legs::is_same(&own, &model)) {
            (shortest, shorter) = (lines, Some(text));
        } else {
            groups.pop();
        }
    }
    shorter
}

/// Writes the model file twice: first without a motion, to find a configuration in which all loops
/// close, then with a motion that keeps the robot in this configuration.
fn write(context: &Context<'_>, source: &Source, mut robot: Description) -> Option<String> {
    // Extension elements name the bodies that a joint connects, not links that mark its frames.
    meaning::fold(&mut robot);
    meaning::restore(context, &mut robot);
    let entries = std::mem::take(&mut robot.extensions);
    let left = extension::apply(context, &mut robot, entries);
    if robot.bodies.len() == 1 {
        let message = "the file has no moving body";
        let help = match robot.format {
            "URDF" => {
                "its only link is the root, which becomes the ground: for a floating robot, \
                 connect it to a link `world` by a joint of type floating"
            }
            _ => "if another file includes this one, convert the other file",
        };
        context.push(Diagnostic::error("missing", message).help(help));
        return None;
    }
    names::tidy(context, &mut robot);
    if !context.literal {
        meaning::simplify(context, &mut robot);
    }
    // Joints that the file describes by several joints get their names only by merging.
    let left = extension::apply(context, &mut robot, left);
    extension::supersede(&mut robot);
    extension::note_left(context, &robot, left);
    extension::check_tilts(context, &mut robot);
    // Extension elements contain the names of joints in the file or after merging. Joints can
    // therefore be renamed only now.
    names::separate(context, &mut robot);
    masses::check(context, &mut robot);
    if context.has_errors() {
        return None;
    }
    let draft = text::Draft { file: file_name(&source.name), notes: &[], motion: None, legs: &[] };
    let name = format!("{} as a model file", source.name);
    let read = |text: &str| {
        crate::read(&Source::new(name.clone(), text), &|_| Err("no files here".to_owned()))
    };
    let text = text::write(context, &robot, &draft);
    let model = match read(&text) {
        Ok(model) => model,
        Err(errors) => {
            context.append(relocate::to_robot_file(&robot, &text, errors));
            return None;
        }
    };
    let motion = position::assemble(context, &mut robot, &model);
    // The second text would repeat the notes of the first, which are the same.
    let notes = context.take_notes();
    let draft = text::Draft { notes: &notes, motion, ..draft };
    let again = Context::new(context.files, context.literal);
    let text = text::write(&again, &robot, &draft);
    let text = with_legs(&again, &robot, &draft, &text, &read).unwrap_or(text);
    context.put_notes(notes);
    Some(text)
}
