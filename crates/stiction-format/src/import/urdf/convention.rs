//! Reads loop closures and motors from a YAML file beside the URDF file, according to the
//! convention of the robot collection *example-parallel-robots*.
//!
//! `closed_loop` lists pairs of joints or links whose frames coincide; `type` specifies if the
//! whole frames (`6d`) or only their origins (`3d`) coincide. `name_mot` lists the actuated joints.
//! `joint_name` lists joints of the URDF file whose types are replaced by those in `joint_type`.

use super::super::context::Context;
use super::super::description::{Coordinate, Description, Joint};
use super::super::yaml::{self, Value, Word};
use super::Tree;
use super::joint::retype;
use crate::diagnostic::{did_you_mean, quoted};
use crate::source::Source;
use std::sync::Arc;
use stiction_core::joint::JointType;

/// Information from the YAML file that affects how motors of the URDF file are read.
pub(super) struct Convention {
    /// True if the YAML file lists the actuated joints (`name_mot`).
    pub(super) names_motors: bool,
}

/// Reads the YAML file with this name (without extension), or else `robot.yaml`, if it exists and
/// follows the convention.
pub(super) fn read(
    context: &Context<'_>,
    tree: &Tree,
    name: &str,
    robot: &mut Description,
) -> Convention {
    let found = [format!("{name}.yaml"), format!("{name}.yml"), SHARED.to_owned()];
    let Some(source) = found.iter().find_map(|name| context.text(name).ok()) else {
        return Convention { names_motors: false };
    };
    let before = context.out.take();
    let convention = read_file(context, tree, &source, robot);
    let mut own = context.out.replace(before);
    if source.name == SHARED && name != "robot" {
        own.explain(&format!(
            "{SHARED} is read because it is in the folder of this URDF file and there is no {name}.yaml; if it \
             belongs to another robot, move it, or write an empty file {name}.yaml"
        ));
    }
    context.append(own);
    convention
}

/// Name of the YAML file that is read for every URDF file of its folder without a YAML file of its own.
const SHARED: &str = "robot.yaml";

/// Keys of the convention.
const KEYS: [&str; 5] = ["closed_loop", "type", "name_mot", "joint_name", "joint_type"];

fn read_file(
    context: &Context<'_>,
    tree: &Tree,
    source: &Arc<Source>,
    robot: &mut Description,
) -> Convention {
    let mut convention = Convention { names_motors: false };
    let not_read = || {
        let keys = KEYS.map(quoted).join(", ");
        let message = format!(
            "the YAML file {} is not read: it has none of the keys {keys}",
            quoted(&source.name)
        );
        context.note(message, None);
    };
    let entries = match yaml::parse(source) {
        Ok(entries) => entries,
        // A file with the same name may serve another purpose.
        Err(_) if !source.text.contains("closed_loop") => {
            not_read();
            return convention;
        }
        Err(error) => {
            context.append(error);
            return convention;
        }
    };
    let get = |key: &str| entries.iter().find(|(known, _)| known.text == key);
    if KEYS.iter().all(|key| get(key).is_none()) {
        if !entries.is_empty() {
            not_read();
        }
        return convention;
    }
    for (key, _) in &entries {
        if !KEYS.contains(&key.text.as_str()) {
            let help = did_you_mean(&key.text, "keys", KEYS).unwrap_or_default();
            let help = if help.is_empty() { help } else { format!("; {help}") };
            let message = format!("the unknown key {} is left out{help}", quoted(&key.text));
            context.note(message, Some(key.place.clone()));
        }
    }
    if let (Some((_, names)), Some((key, types))) = (get("joint_name"), get("joint_type")) {
        let (names, types) = (names.words(), types.words());
        if names.len() != types.len() {
            let message = yaml::lengths("joint_type", "joint_name", (types.len(), names.len()));
            context.error("yaml", message, &key.place, "");
        }
        for (name, kind) in names.into_iter().zip(types) {
            replace(context, tree, robot, (name, kind));
        }
    }
    if let Some((key, pairs)) = get("closed_loop") {
        let types = get("type").map(|(_, types)| types.words()).unwrap_or_default();
        // A single pair may be written without the enclosing list.
        let single = pairs.items().iter().all(|item| matches!(item, Value::Word(_)));
        let pairs = if single { std::slice::from_ref(pairs) } else { pairs.items() };
        let pairs: Vec<&Value> = pairs.iter().filter(|pair| !pair.words().is_empty()).collect();
        if !types.is_empty() && types.len() != pairs.len() {
            let message = yaml::lengths("type", "closed_loop", (types.len(), pairs.len()));
            context.error("yaml", message, &key.place, "");
        }
        for (index, pair) in pairs.into_iter().enumerate() {
            let kind = types.get(index).copied();
            let joint = closure(context, tree, robot, (key, pair, kind));
            robot.joints.extend(joint);
        }
    }
    if let Some((_, names)) = get("name_mot") {
        convention.names_motors = true;
        for name in names.words() {
            actuate(context, tree, robot, name);
        }
    }
    convention
}

fn joint_of(context: &Context<'_>, tree: &Tree, name: &Word) -> Option<usize> {
    let found = tree.joints.get(&name.text).copied();
    if found.is_none() {
        let mut known: Vec<&str> = tree.joints.keys().map(String::as_str).collect();
        known.sort_unstable();
        let help = did_you_mean(&name.text, "joints", known).unwrap_or_default();
        let message = format!("there is no joint {}", quoted(&name.text));
        context.error("name", message, &name.place, &help);
    }
    found
}

fn replace(
    context: &Context<'_>,
    tree: &Tree,
    robot: &mut Description,
    (name, kind): (&Word, &Word),
) -> Option<()> {
    let joint = joint_of(context, tree, name)?;
    let joint = robot.joints.get_mut(joint)?;
    let (kind, word) = match kind.text.to_ascii_uppercase().as_str() {
        "SPHERICAL" => (JointType::Spherical, "a ball joint"),
        "CARDAN" => (JointType::Universal, "a universal joint"),
        "FIXED" => (JointType::Fixed, "fixed"),
        _ => {
            let message = format!("{} is not a type of joint", quoted(&kind.text));
            context.error("type", message, &kind.place, "use SPHERICAL, CARDAN or FIXED");
            return None;
        }
    };
    retype(joint, kind);
    joint.comment = Some(format!("The YAML file makes it {word}."));
    Some(())
}

/// Creates the joint that closes a loop: a fixed joint if two frames coincide (`6d`, the default),
/// or a spherical joint if only their origins coincide (`3d`).
fn closure(
    context: &Context<'_>,
    tree: &Tree,
    robot: &Description,
    (key, pair, kind): (&Word, &Value, Option<&Word>),
) -> Option<Joint> {
    let names = pair.words();
    let [first, second] = names.as_slice() else {
        let place = names.first().map_or(&key.place, |name| &name.place);
        let message = format!("a closed loop has two frames, but this one has {}", names.len());
        context.error("yaml", message, place, "write ['frame_A', 'frame_B']");
        return None;
    };
    let joint_type = match kind.map(|kind| kind.text.to_ascii_lowercase()).as_deref() {
        None | Some("6d") => JointType::Fixed,
        Some("3d") => JointType::Spherical,
        Some(other) => {
            let place = kind.map_or(&key.place, |kind| &kind.place);
            let message = format!("{} is not a type of closure", quoted(other));
            context.error("type", message, place, "use '6d' or '3d'");
            return None;
        }
    };
    // The frame of a joint is the frame of its child link.
    let frame = |name: &Word| {
        let of_joint = tree.joints.get(&name.text).map(|&joint| robot.joints[joint].to);
        let found = of_joint.or_else(|| tree.links.get(&name.text).copied());
        if found.is_none() {
            let known = tree.joints.keys().chain(tree.links.keys()).map(String::as_str);
            let mut known: Vec<&str> = known.collect();
            known.sort_unstable();
            let help = did_you_mean(&name.text, "joints and links", known).unwrap_or_default();
            let message = format!("there is no joint or link {}", quoted(&name.text));
            context.error("name", message, &name.place, &help);
        }
        found
    };
    let ends = (frame(first)?, frame(second)?);
    let mut joint = Joint::new(closure_name(first, second), joint_type, ends);
    joint.closes = true;
    joint.place = Some(first.place.clone());
    let what = match joint_type {
        JointType::Fixed => "the frames",
        _ => "the origins of the frames",
    };
    joint.comment = Some(format!(
        "Closes a loop, from the YAML file: {what} of {} and {} coincide.",
        quoted(&first.text),
        quoted(&second.text)
    ));
    Some(joint)
}

/// Returns the name of a loop closure: the common beginning of the names of both frames if it has
/// at least three characters, else the first name with the suffix `_closure`.
fn closure_name(first: &Word, second: &Word) -> String {
    // When this program exports a robot, links with these suffixes mark the two frames of a joint.
    let marked = [".from", ".frame"].iter().find_map(|ending| first.text.strip_suffix(ending));
    if let (Some(own), Some(other)) = (marked, second.text.strip_suffix(".to"))
        && own == other
    {
        return own.to_owned();
    }
    let shared: usize = first
        .text
        .chars()
        .zip(second.text.chars())
        .take_while(|(a, b)| a == b)
        .map(|(a, _)| a.len_utf8())
        .sum();
    let stem = first.text.get(..shared).unwrap_or_default();
    let stem = stem.trim_end_matches(['_', '-', '.', ' ']);
    if stem.chars().count() >= 3 { stem.to_owned() } else { format!("{}_closure", first.text) }
}

fn actuate(context: &Context<'_>, tree: &Tree, robot: &mut Description, name: &Word) -> Option<()> {
    let joint = joint_of(context, tree, name)?;
    match robot.joints.get_mut(joint)?.dofs.as_mut_slice() {
        [dof] => *dof = Coordinate { actuated: true, ..*dof },
        _ => {
            let message = format!(
                "{} does not have exactly one coordinate, so it gets no motor",
                quoted(&name.text)
            );
            context.note(message, Some(name.place.clone()));
        }
    }
    Some(())
}
