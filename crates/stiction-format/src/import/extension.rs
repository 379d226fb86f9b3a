//! Extension elements of this program in files of other formats, for properties that these formats
//! cannot express.
//!
//! In URDF and SDF, extension elements are elements in a separate namespace, in MJCF custom texts.
//! Each names the joint or other part to which it belongs:
//!
//! | kind | content |
//! | --- | --- |
//! | `friction` | the content of the joint's `friction` table in a model file |
//! | `spring` | the content of the spring's table |
//! | `bushing`, `actuator`, `gearing` | the content of the table of the bushing, motor or gearing |
//! | `range` | the content of the joint's `range` |
//! | `axes` | orientation of frame J in its body and of frame K in its body, of a ball joint: two quaternions |
//! | `from` | the predecessor of a joint whose bodies are exchanged in the file |
//! | `start` | coordinates of the joint at which the robot starts |
//! | `coordinates` | the joint's coordinates in the file's configuration, where the file has zero |
//! | `joint` | type of a joint that the file describes by several joints, and the names of these joints in the order in which they act from frame J to frame K |
//! | `body` | the joint of the file that carries the body of this name, which is between two joints of one MJCF body |
//! | `default` | a value of the table `default`; the only possible name is `friction` |
//! | `gravity` | the acceleration of gravity, three numbers in m/s²; this element has no name |

use super::context::Context;
use super::description::{Description, Joint};
use super::xml::{Element, numbers_in};
use crate::diagnostic::quoted;
use crate::fields::tables::FRICTION_MODES;
use crate::source::Place;
use std::collections::{HashMap, HashSet};
use stiction_core::joint::JointType;
use stiction_core::spatial::{Mat3, Pose, Quaternion, Vec3};
use toml::Table;

/// Greatest sine of the angle between two directions that are the same in a file of nine digits.
const SAME_AXIS: f64 = 1e-8;

/// Greatest relative difference between the same friction in two elements of a file.
const SAME_FRICTION: f64 = 1e-6;

/// XML namespace of the extension elements.
pub const NAMESPACE: &str = "urn:stiction:1";

/// An extension element: its kind, the name of the joint or other part to which it belongs, and its
/// text.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) kind: String,
    pub(super) name: String,
    pub(super) text: String,
    pub(super) place: Place,
}

/// Returns the extension elements of this program among the children of `parent`.
pub(super) fn entries(parent: &Element) -> Vec<Entry> {
    let own = parent.children.iter().filter(|child| child.namespace == NAMESPACE);
    let entry = |child: &Element| Entry {
        kind: child.tag.clone(),
        name: child.get("name").unwrap_or_default().to_owned(),
        text: child.text.clone(),
        place: child.place(),
    };
    own.map(entry).collect()
}

/// Returns the extension elements that an MJCF file contains as custom texts.
pub(super) fn custom_texts(root: &Element) -> Vec<Entry> {
    let prefix = format!("{NAMESPACE}/");
    let texts = root.all("custom").flat_map(|custom| custom.all("text"));
    let entry = |text: &Element| {
        let (kind, name) = text.get("name")?.strip_prefix(&prefix)?.split_once('/')?;
        let data = text.attribute("data")?;
        Some(Entry {
            kind: kind.to_owned(),
            name: name.to_owned(),
            text: data.value.replace(";;", "\n"),
            place: data.place(),
        })
    };
    texts.filter_map(entry).collect()
}

/// Applies extension elements to the robot. Returns the elements that cannot be applied: those
/// whose joint does not exist, and `from` elements with a body that the joint does not connect.
pub(super) fn apply(
    context: &Context<'_>,
    robot: &mut Description,
    entries: Vec<Entry>,
) -> Vec<Entry> {
    let mut left = Vec::new();
    let with_axes: HashSet<String> = entries
        .iter()
        .filter(|entry| entry.kind == "axes")
        .map(|entry| entry.name.clone())
        .collect();
    // A ball of MJCF has no axes of its own.
    let lacks_axes = |joint: &Joint, format: &str| {
        joint.kind == JointType::Spherical && format == "MJCF" && !with_axes.contains(&joint.name)
    };
    for entry in entries {
        match entry.kind.as_str() {
            "gravity" => {
                let numbers = numbers_in(context, &entry.text, &entry.place).unwrap_or_default();
                if let &[x, y, z] = numbers.as_slice() {
                    robot.gravity = Vec3::new(x, y, z);
                }
            }
            "default" if entry.name == "friction" => {
                if FRICTION_MODES.contains(&entry.text.as_str()) {
                    robot.friction = Some(entry.text);
                } else {
                    let message = format!("{} is not a friction mode", quoted(&entry.text));
                    let help = "write on, one-pass or off";
                    context.error("extension", message, &entry.place, help);
                }
            }
            "spring" => {
                let table = table(context, &entry);
                robot.spring_tables.extend(table.map(|table| (entry.name.clone(), table)));
            }
            "bushing" | "actuator" | "gearing" => {
                let Some(table) = table(context, &entry) else { continue };
                let tables = match entry.kind.as_str() {
                    "bushing" => &mut robot.bushing_tables,
                    "actuator" => &mut robot.motor_tables,
                    _ => &mut robot.gearing_tables,
                };
                tables.push((entry.name.clone(), table));
            }
            _ => match robot.joints.iter().position(|joint| {
                joint.name == entry.name && (joint.kind != JointType::Fixed || !joint.closes)
            }) {
                // The bodies of a joint may be known only after merging.
                Some(index) if entry.kind == "from" && !is_end(robot, index, &entry.text) => {
                    left.push(entry);
                }
                Some(index)
                    if entry.kind == "range" && lacks_axes(&robot.joints[index], robot.format) =>
                {
                    let message = format!(
                        "the range of the tilt of joint {} is left out: the file does not contain \
                         the axes from which it is measured",
                        quoted(&entry.name)
                    );
                    context.note(message, Some(entry.place));
                }
                Some(index) => joint(context, robot, index, &entry),
                None => left.push(entry),
            },
        }
    }
    left
}

/// Tests if a joint connects the body of this name with another one.
fn is_end(robot: &Description, joint: usize, body: &str) -> bool {
    let joint = &robot.joints[joint];
    [joint.from, joint.to].iter().any(|end| robot.bodies[*end].name == body)
}

/// Names of the joint coordinates to which a table of the model file refers by its key `joint` or
/// `joints`.
pub(super) fn joint_names(table: &Table) -> Vec<String> {
    let joints = table.get("joints").and_then(toml::Value::as_table);
    let several = joints.into_iter().flat_map(|joints| joints.keys().cloned());
    let one = table.get("joint").and_then(toml::Value::as_str).map(str::to_owned);
    one.into_iter().chain(several).collect()
}

/// Renames joints and bodies in the tables of extension elements. The maps lead from old to new
/// names; all names change at once, so that two names can be exchanged.
pub(super) fn rename(
    robot: &mut Description,
    joints: &HashMap<String, String>,
    bodies: &HashMap<String, String>,
) {
    let springs = robot.spring_tables.iter_mut().chain(&mut robot.bushing_tables);
    let all = springs.chain(&mut robot.motor_tables).chain(&mut robot.gearing_tables);
    for (_, table) in all {
        if let Some(toml::Value::Table(factors)) = table.get_mut("joints") {
            *factors = std::mem::take(factors)
                .into_iter()
                .map(|(name, factor)| (renamed_coordinate(&name, joints).unwrap_or(name), factor))
                .collect();
        }
        if let Some(toml::Value::String(name)) = table.get_mut("joint")
            && let Some(new) = renamed_coordinate(name, joints)
        {
            *name = new;
        }
        for end in ["from", "to"] {
            if let Some(toml::Value::String(name)) = table.get_mut(end)
                && let Some(new) = bodies.get(name.as_str())
            {
                name.clone_from(new);
            }
        }
    }
}

/// New name of the coordinate `joint` or `joint.dof`; `None` if the joint is not renamed.
fn renamed_coordinate(name: &str, joints: &HashMap<String, String>) -> Option<String> {
    if let Some(new) = joints.get(name) {
        return Some(new.clone());
    }
    let (joint, dof) = name.rsplit_once('.')?;
    Some(format!("{}.{dof}", joints.get(joint)?))
}

/// Removes motors, springs, gearings and coordinate properties that the file contains for other
/// programs if extension elements describe them completely.
pub(super) fn supersede(robot: &mut Description) {
    let places = |robot: &Description, tables: &[(String, Table)]| -> Vec<(usize, usize)> {
        let names: Vec<String> = tables.iter().flat_map(|(_, table)| joint_names(table)).collect();
        let dofs = |joint: usize| (0..robot.joints[joint].dofs.len()).map(move |dof| (joint, dof));
        let all = (0..robot.joints.len()).flat_map(dofs);
        all.filter(|&(joint, dof)| names.contains(&robot.joints[joint].dof_name(dof))).collect()
    };
    for (joint, dof) in places(robot, &robot.motor_tables) {
        robot.motors.retain(|motor| (motor.joint, motor.dof) != (joint, dof));
        let other = |term: &(usize, f64)| dof > 0 || term.0 != joint;
        robot.joint_motors.retain(|motor| motor.terms.iter().all(other));
        let own = &mut robot.joints[joint].dofs[dof];
        (own.armature, own.friction, own.damping, own.actuated) = (0.0, 0.0, 0.0, true);
    }
    let tables = &robot.spring_tables;
    robot.springs.retain(|spring| tables.iter().all(|(name, _)| *name != spring.name));
    for (joint, dof) in places(robot, &robot.spring_tables) {
        let own = &mut robot.joints[joint].dofs[dof];
        (own.spring, own.damping) = (None, 0.0);
    }
    for joint in &mut robot.joints {
        // The table describes the friction of the joint; the file contains it again for other programs.
        let constant = joint.friction.as_ref().map_or(0.0, constant_friction);
        if let [dof] = joint.dofs.as_mut_slice()
            && (dof.friction - constant).abs() <= SAME_FRICTION * constant
        {
            dof.friction = 0.0;
        }
    }
    for (_, table) in robot.gearing_tables.clone() {
        let mut names = joint_names(&table);
        names.sort_unstable();
        let joints = &robot.joints;
        robot.gearings.retain(|gearing| {
            let mut own: Vec<String> =
                gearing.terms.iter().map(|term| joints[term.0].dof_name(term.1)).collect();
            own.sort_unstable();
            own != names
        });
    }
}

/// Friction of a joint due to its preload alone, N or N m, according to a friction table in SI units.
fn constant_friction(table: &Table) -> f64 {
    let number = |key: &str| table.get(key).and_then(toml::Value::as_float);
    let force = number("mu").unwrap_or(0.0) * number("preload").unwrap_or(0.0);
    force * number("radius").unwrap_or(1.0)
}

/// Reports extension elements whose joint does not exist, and `from` elements that name a body that
/// the joint does not connect.
pub(super) fn note_left(context: &Context<'_>, robot: &Description, entries: Vec<Entry>) {
    for entry in entries {
        let name = quoted(&entry.name);
        let is_joint = robot.joints.iter().any(|joint| joint.name == entry.name);
        let message = match is_joint && entry.kind == "from" {
            true => format!("joint {name} does not connect the body {}", quoted(&entry.text)),
            false => format!("there is no joint {name} for <{}>", entry.kind),
        };
        let acts = ["friction", "coordinates", "start", "from"].contains(&entry.kind.as_str());
        match acts {
            true => context.warn(message, Some(entry.place)),
            false => context.note(message, Some(entry.place)),
        }
    }
}

fn joint(context: &Context<'_>, robot: &mut Description, index: usize, entry: &Entry) {
    let from = robot.bodies.iter().position(|body| body.name == entry.text);
    let joint = &mut robot.joints[index];
    match entry.kind.as_str() {
        "friction" => joint.friction = table(context, entry),
        "range" => joint.range = table(context, entry),
        "axes" => axes(context, joint, entry),
        "from" if from == Some(joint.to) => turn_round(joint),
        "start" | "coordinates" => {
            let numbers = numbers_in(context, &entry.text, &entry.place).unwrap_or_default();
            if !is_position(joint.kind, &numbers) {
                let message = format!("these are not coordinates of joint {}", quoted(&joint.name));
                context.error("coordinates", message, &entry.place, "");
                return;
            }
            let across = joint.kind.pose(&numbers, joint.pitch);
            if entry.kind == "coordinates" {
                shift(joint, &numbers, across);
                // Ranges and springs in the file refer to the zero position of the file.
                for (dof, value) in joint.dofs.iter_mut().zip(&numbers) {
                    dof.range = dof.range.map(|range| range.map(|bound| bound + value));
                    dof.spring = dof.spring.map(|[stiffness, rest]| [stiffness, rest + value]);
                }
            }
            if joint.dofs.is_empty() {
                joint.start = Some(across);
            } else {
                joint.dofs.iter_mut().zip(numbers).for_each(|(dof, value)| dof.position = value);
            }
        }
        _ => {}
    }
}

/// Gives the frames of a ball joint these orientations; the position of the file remains.
fn axes(context: &Context<'_>, joint: &mut Joint, entry: &Entry) {
    let numbers = numbers_in(context, &entry.text, &entry.place).unwrap_or_default();
    let (j, k) = numbers.split_at(numbers.len().min(4));
    if joint.kind != JointType::Spherical || !is_unit(j) || !is_unit(k) {
        let message = format!("these are not axes of a ball joint {}", quoted(&joint.name));
        let help = "write two quaternions of length 1, w x y z, in the bodies of frames J and K";
        context.error("axes", message, &entry.place, help);
        return;
    }
    let relative = joint.relative();
    joint.frame_j.rotation = Quaternion::from_coordinates(j).rotation();
    joint.frame_k.rotation = Quaternion::from_coordinates(k).rotation();
    joint.start = Some(joint.frame_j.inverse() * relative * joint.frame_k);
}

/// Leaves out ranges of the tilt of ball joints that a model file cannot express, each with a note.
pub(super) fn check_tilts(context: &Context<'_>, robot: &mut Description) {
    let has_tilt = |joint: &Joint| {
        joint.kind == JointType::Spherical
            && joint.range.as_ref().is_some_and(|table| table.contains_key("tilt"))
    };
    for joint in robot.joints.iter_mut().filter(|joint| has_tilt(joint)) {
        let z = joint.frame_j.rotation.columns[2];
        // The model file measures the tilt from the z axis of the predecessor.
        if z.cross(Vec3::unit(2)).norm() > SAME_AXIS || z.dot(Vec3::unit(2)) < 0.0 {
            let message = format!(
                "the range of the tilt of joint {} is left out: it is measured from an axis of \
                 the first body other than z, which a model file cannot express",
                quoted(&joint.name)
            );
            context.note(message, joint.place.clone());
            joint.range = None;
        }
    }
}

fn is_unit(quaternion: &[f64]) -> bool {
    quaternion.len() == 4 && (quaternion.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-6
}

/// Tests if `numbers` are coordinates of a joint of this kind: one number for each coordinate, and
/// a quaternion of length 1.
fn is_position(kind: JointType, numbers: &[f64]) -> bool {
    numbers.len() == kind.coordinates()
        && match kind {
            JointType::Spherical => is_unit(numbers),
            JointType::Free => is_unit(&numbers[3..]),
            _ => true,
        }
}

/// Moves the frames of a joint so that the file's configuration, in which frames J and K coincide,
/// gets the coordinates `numbers`. `across` is the pose of frame K in frame J at these coordinates.
fn shift(joint: &mut Joint, numbers: &[f64], across: Pose<f64>) {
    match joint.kind {
        JointType::Universal => {
            let turn = |axis: usize, angle: f64| Pose {
                rotation: Mat3::about_axis(axis, angle.sin_cos()),
                position: Vec3::zero(),
            };
            joint.frame_j = joint.frame_j * turn(2, -numbers[0]);
            joint.frame_k = joint.frame_k * turn(0, numbers[1]);
        }
        // The pose of a floating body remains that of the file.
        JointType::Free => {}
        _ => joint.frame_k = joint.frame_k * across,
    }
}

/// Exchanges predecessor and successor of a joint; the values of its scalar coordinates do not
/// change.
fn turn_round(joint: &mut Joint) {
    let [x, y, z] = [0, 1, 2].map(Vec3::unit);
    let axes = match joint.kind {
        JointType::Universal => Mat3::from_columns(-z, -y, -x),
        JointType::Spherical | JointType::Fixed | JointType::Free => Mat3::identity(),
        JointType::Planar => return,
        _ => Mat3::from_columns(x, -y, -z),
    };
    let axes = Pose { rotation: axes, position: Vec3::zero() };
    (joint.from, joint.to) = (joint.to, joint.from);
    (joint.frame_j, joint.frame_k) = (joint.frame_k * axes, joint.frame_j * axes);
    joint.start = joint.start.map(Pose::inverse);
    joint.dofs.reverse();
}

/// Parses the text of an extension element as a TOML table; reports errors.
pub(super) fn table(context: &Context<'_>, entry: &Entry) -> Option<Table> {
    match entry.text.parse::<Table>() {
        Ok(table) => Some(table),
        Err(error) => {
            let message = format!("the {} cannot be read: {}", entry.kind, error.message());
            let help = "write the keys of a table of the model file, one per line: mu = 0.1";
            context.error("extension", message, &entry.place, help);
            None
        }
    }
}
