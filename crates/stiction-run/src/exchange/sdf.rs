//! Export to SDF: the links in the home position and all joints, including those that close loops.

use super::dynamics;
use super::extension::{self, Entry, six, tensor};
use super::mimic::{self, Mimic};
use super::names::Names;
use super::xml::{Xml, numbers};
use super::{Home, Unfit};
use std::f64::consts::TAU;
use stiction_core::joint::JointType;
use stiction_core::mechanism::{BodyId, Joint};
use stiction_format::NAMESPACE;

/// SDF model as text, with notes on properties that SDF cannot express.
#[derive(Clone, Debug, PartialEq)]
pub struct Sdf {
    /// Text of the SDF file.
    pub text: String,
    /// Notes on properties that the file omits or changes, one per entry.
    pub notes: Vec<String>,
}

/// Returns the name of a joint type in SDF; `None` if SDF has no such joint.
fn word(joint_type: JointType) -> Option<&'static str> {
    match joint_type {
        JointType::Revolute => Some("revolute"),
        JointType::Prismatic => Some("prismatic"),
        JointType::Helical => Some("screw"),
        JointType::Universal => Some("universal"),
        JointType::Spherical => Some("ball"),
        JointType::Fixed => Some("fixed"),
        JointType::Cylindrical | JointType::Planar | JointType::Free => None,
    }
}

/// Converts an assembled mechanism to SDF.
///
/// # Errors
/// Returns [`Unfit::NoSuchJoint`] if SDF has no joint of a required type.
pub fn sdf(home: &Home<'_>) -> Result<Sdf, Unfit> {
    let mechanism = &home.model.mechanism;
    let lacks =
        |joint: &&Joint| joint.joint_type != JointType::Free && word(joint.joint_type).is_none();
    if let Some(joint) = mechanism.joints().iter().find(lacks) {
        let kind = joint.joint_type.symbol().to_owned();
        return Err(Unfit::NoSuchJoint { joint: joint.name.clone(), kind, format: "SDF" });
    }
    let mut notes = extension::notes(mechanism);
    let massless: Vec<&str> = mechanism.bodies()[1..]
        .iter()
        .filter(|body| body.mass == 0.0)
        .map(|body| body.name.as_str())
        .collect();
    if !massless.is_empty() {
        let names = massless.join(", ");
        notes.push(format!("Gazebo rejects links without mass, here {names}"));
    }
    let mut xml = Xml::default();
    xml.open("sdf", &[("version", "1.11".into()), ("xmlns:stiction", NAMESPACE.into())]);
    let made = format!("Written by stiction {}. SI units.", env!("CARGO_PKG_VERSION"));
    xml.comment(&[&home.model.title, &made]);
    for note in &notes {
        xml.comment(&[&format!("Note: {note}.")]);
    }
    xml.open("world", &[("name", "default".into())]);
    xml.text("gravity", &[], &numbers(&mechanism.gravity().to_array()));
    xml.open("model", &[("name", home.model.name.clone())]);
    let mut names = Names::default();
    names.reserve("world");
    let bodies: Vec<String> =
        mechanism.bodies().iter().map(|body| names.take(&body.name)).collect();
    // The ground is a link, because its frame need not be that of the world.
    for (index, body) in mechanism.bodies().iter().enumerate() {
        xml.open("link", &[("name", bodies[index].clone())]);
        xml.text("pose", &[], &numbers(&six(home.poses[index])));
        if index > 0 {
            xml.open("inertial", &[]);
            let com = stiction_core::spatial::Pose::at(body.com);
            xml.text("pose", &[], &numbers(&six(com)));
            xml.text("mass", &[], &numbers(&[body.mass]));
            xml.open("inertia", &[]);
            for (key, value) in tensor(body) {
                xml.text(key, &[], &numbers(&[value]));
            }
            xml.close();
            xml.close();
        } else {
            xml.open("inertial", &[]);
            xml.text("mass", &[], "0");
            xml.open("inertia", &[]);
            for key in ["ixx", "iyy", "izz"] {
                xml.text(key, &[], "0");
            }
            xml.close();
            xml.close();
        }
        xml.close();
    }
    let hold = names.take("ground_hold");
    xml.open("joint", &[("name", hold), ("type", "fixed".into())]);
    xml.text("parent", &[], "world");
    xml.text("child", &[], &bodies[BodyId::GROUND.0]);
    xml.close();
    let mimics = mimic::all(mechanism);
    for index in 0..mechanism.joints().len() {
        write_joint(&mut xml, home, index, &bodies, &mimics);
    }
    let mut entries = extension::frictions(mechanism);
    entries.extend(extension::default_friction(home.model));
    entries.extend(extension::springs(mechanism));
    entries.extend(extension::others(mechanism));
    entries.extend(extension::coordinates(home));
    for Entry { kind, name, text } in entries {
        xml.text(extension::tag(kind), &[("name", name)], &text);
    }
    Ok(Sdf { text: xml.finish(), notes })
}

fn write_joint(xml: &mut Xml, home: &Home<'_>, index: usize, bodies: &[String], mimics: &[Mimic]) {
    let mechanism = &home.model.mechanism;
    let joint = &mechanism.joints()[index];
    let Some(word) = word(joint.joint_type) else { return };
    let [from, to] = [joint.predecessor, joint.successor].map(|body| bodies[body.0].clone());
    xml.open("joint", &[("name", joint.name.clone()), ("type", word.into())]);
    let relative = ("relative_to", from.clone());
    xml.text("pose", &[relative], &numbers(&six(joint.frame_j)));
    xml.text("parent", &[], &from);
    xml.text("child", &[], &to);
    if joint.joint_type == JointType::Helical {
        xml.text("screw_thread_pitch", &[], &numbers(&[joint.pitch * TAU]));
    }
    let angle = home.coordinates[index].first().copied().flatten().unwrap_or(0.0);
    let axes: &[(&str, [f64; 3])] = match joint.joint_type {
        JointType::Spherical | JointType::Fixed => &[],
        // The second axis of a universal joint is the one in the home position.
        JointType::Universal => {
            &[("axis", [0.0, 0.0, 1.0]), ("axis2", [angle.cos(), angle.sin(), 0.0])]
        }
        _ => &[("axis", [0.0, 0.0, 1.0])],
    };
    for (dof, (tag, axis)) in axes.iter().enumerate() {
        let tag: &'static str = if *tag == "axis" { "axis" } else { "axis2" };
        xml.open(tag, &[]);
        xml.text("xyz", &[], &numbers(axis));
        // An effort limit of zero marks a degree of freedom without actuator.
        let (range, effort, rate) = match joint.joint_type {
            JointType::Revolute | JointType::Prismatic => mimic::limits(mechanism, index),
            _ => (None, None, None),
        };
        let effort = if joint.actuated[dof] { effort.unwrap_or(1e9) } else { 0.0 };
        xml.open("limit", &[]);
        // The limits are relative to the home position, where the coordinates of the file are zero.
        if let Some((lower, upper)) = range {
            xml.text("lower", &[], &numbers(&[lower - angle]));
            xml.text("upper", &[], &numbers(&[upper - angle]));
        }
        xml.text("effort", &[], &numbers(&[effort]));
        if let Some(rate) = rate {
            xml.text("velocity", &[], &numbers(&[rate]));
        }
        xml.close();
        let dynamics = dynamics::attributes(mechanism, index);
        if !dynamics.is_empty() {
            xml.open("dynamics", &[]);
            for (key, value) in dynamics {
                xml.text(key, &[], &numbers(&[value]));
            }
            xml.close();
        }
        if let Some(mimic) = mimics.iter().find(|mimic| mimic.follower == index) {
            let leader = mechanism.joints()[mimic.leader].name.clone();
            xml.open("mimic", &[("joint", leader), ("axis", "axis".into())]);
            xml.text("multiplier", &[], &numbers(&[mimic.multiplier]));
            // Both coordinates are zero in the home position, where the gearing is satisfied.
            xml.text("offset", &[], "0");
            xml.text("reference", &[], "0");
            xml.close();
        }
        xml.close();
    }
    xml.close();
}
