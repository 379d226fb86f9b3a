//! Reads the joints of a URDF file.

use super::super::context::Context;
use super::super::description::{Coordinate, Description, Gearing, Joint};
use super::super::rotation::z_to;
use super::super::xml::Element;
use super::{Tree, origin};
use crate::diagnostic::{did_you_mean, quoted};
use stiction_core::joint::JointType;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Limits of this magnitude and above count as absent. Files contain such limits because URDF
/// requires limits for some joint types.
pub(super) const UNLIMITED: f64 = 1e9;

/// Names of the joint types in URDF, and the corresponding joint types of the model.
const TYPES: [(&str, JointType); 7] = [
    ("revolute", JointType::Revolute),
    ("continuous", JointType::Revolute),
    ("prismatic", JointType::Prismatic),
    ("fixed", JointType::Fixed),
    ("floating", JointType::Free),
    ("planar", JointType::Planar),
    // Extension of URDF by Isaac Sim and other programs.
    ("spherical", JointType::Spherical),
];

pub(super) fn read(context: &Context<'_>, tree: &Tree, element: &Element) -> Option<Joint> {
    let name = element.required(context, "name")?;
    let kind = kind_of(context, element)?;
    let from = link(context, tree, element, "parent", "link")?;
    let to = link(context, tree, element, "child", "link")?;
    let mut joint = Joint::new(name, kind, (from, to));
    joint.place = Some(element.place());
    let place = origin(context, element);
    let frame = axis_frame(context, element, kind)?;
    joint.frame_j = place * frame;
    joint.frame_k = frame;
    if kind == JointType::Free {
        joint.start = Some(Pose::identity());
    }
    properties(context, element, &mut joint);
    Some(joint)
}

/// Returns the type of a joint; reports an unknown type.
pub(super) fn kind_of(context: &Context<'_>, element: &Element) -> Option<JointType> {
    let word = element.required(context, "type")?;
    let found = TYPES.iter().find(|(known, _)| *known == word).map(|(_, kind)| *kind);
    if found.is_none() {
        let place =
            element.attribute("type").map_or_else(|| element.place(), |type_| type_.place());
        let known = TYPES.iter().map(|(known, _)| *known);
        let help = did_you_mean(word, "types", known).unwrap_or_default();
        let message = format!("{} has the unknown type {}", element.title(), quoted(word));
        context.error("type", message, &place, &help);
    }
    found
}

/// Returns the index of the body of a link, whose name is in the attribute `key` of the child
/// element `tag`; reports a missing or unknown link.
pub(super) fn link(
    context: &Context<'_>,
    tree: &Tree,
    element: &Element,
    tag: &str,
    key: &str,
) -> Option<usize> {
    let Some(end) = element.child(tag) else {
        let message = format!("{} has no <{tag}>", element.title());
        context.error("missing", message, &element.place(), "");
        return None;
    };
    let name = end.required(context, key)?;
    let found = tree.links.get(name).copied();
    if found.is_none() {
        let mut known: Vec<&str> = tree.links.keys().map(String::as_str).collect();
        known.sort_unstable();
        let help = did_you_mean(name, "links", known).unwrap_or_default();
        let place = end.attribute(key).map_or_else(|| end.place(), |key| key.place());
        context.error("name", format!("there is no link {}", quoted(name)), &place, &help);
    }
    found
}

/// Creates a frame with z along the joint axis. An element without `axis` has the joint axis x;
/// joint types without an axis have the identity as frame.
pub(super) fn axis_frame(
    context: &Context<'_>,
    element: &Element,
    kind: JointType,
) -> Option<Pose<f64>> {
    if matches!(kind, JointType::Fixed | JointType::Free | JointType::Spherical) {
        return Some(Pose::identity());
    }
    let Some(axis) = element.child("axis") else {
        return Some(Pose { rotation: z_to(Vec3::unit(0)), position: Vec3::zero() });
    };
    let direction = Vec3::from(axis.numbers::<3>(context, "xyz").unwrap_or([1.0, 0.0, 0.0]));
    let Some(direction) = direction.direction() else {
        let message = format!("the axis of {} is zero", element.title());
        context.error("axis", message, &axis.place(), "give a direction such as \"0 0 1\"");
        return None;
    };
    Some(Pose { rotation: z_to(direction), position: Vec3::zero() })
}

/// Reads the limits, damping and friction of a joint from its element.
fn properties(context: &Context<'_>, element: &Element, joint: &mut Joint) {
    let is_continuous = element.get("type") == Some("continuous");
    let place = || Some(element.place());
    let mut shared = Coordinate::default();
    // Exporters of CAD programs once wrote `joint_properties` for `dynamics`.
    for dynamics in ["dynamics", "joint_properties"].iter().filter_map(|tag| element.child(tag)) {
        let value = |key| dynamics.number(context, key).unwrap_or(0.0);
        shared.damping = value("damping").max(0.0);
        shared.friction = value("friction").max(0.0);
    }
    if let Some(limit) = element.child("limit") {
        let bound = |key| limit.number(context, key).filter(|value| value.abs() < UNLIMITED);
        shared.range = match (bound("lower"), bound("upper")) {
            _ if is_continuous => None,
            (None, None) => None,
            (lower, upper) => Some([lower.unwrap_or(0.0), upper.unwrap_or(0.0)]),
        };
    }
    if shared.range.is_some_and(|[lower, upper]| lower >= upper) {
        context.note("limits with an empty range are left out", place());
        shared.range = None;
    }
    let own = (joint.kind, joint.dofs.as_mut_slice());
    match own {
        (JointType::Revolute | JointType::Prismatic, [dof]) => *dof = shared,
        (JointType::Spherical, _) => joint.damping = shared.damping,
        _ if shared.damping != 0.0 || shared.friction != 0.0 => {
            let message = "damping and friction of floating and planar joints are left out";
            context.warn(message, place());
        }
        _ => {}
    }
}

/// Reads the element `mimic`, which couples a joint to another joint: the coordinate of the joint
/// is `multiplier` times the coordinate of the other joint, plus `offset`.
pub(super) fn read_mimic(
    context: &Context<'_>,
    tree: &Tree,
    element: &Element,
    robot: &mut Description,
) -> Option<()> {
    let mimic = element.child("mimic")?;
    let own = *tree.joints.get(element.get("name")?)?;
    let name = mimic.required(context, "joint")?;
    let Some(&other) = tree.joints.get(name) else {
        let mut known: Vec<&str> = tree.joints.keys().map(String::as_str).collect();
        known.sort_unstable();
        let help = did_you_mean(name, "joints", known).unwrap_or_default();
        context.error("name", format!("there is no joint {}", quoted(name)), &mimic.place(), &help);
        return None;
    };
    if own == other {
        let help = "name the joint that it follows, or remove <mimic>";
        context.error("mimic", format!("{} mimics itself", element.title()), &mimic.place(), help);
        return None;
    }
    if robot.joints[own].kind == JointType::Fixed {
        let message = "a fixed joint cannot follow another one: its <mimic> is left out";
        context.note(message, Some(mimic.place()));
        return None;
    }
    let has_one = |joint: usize| robot.joints[joint].dofs.len() == 1;
    if !has_one(own) || !has_one(other) {
        let message = format!(
            "{} mimics {}, but only joints of one degree of freedom can be coupled",
            element.title(),
            quoted(name)
        );
        let help = "remove <mimic>, or make both joints revolute, continuous or prismatic";
        context.error("mimic", message, &mimic.place(), help);
        return None;
    }
    let multiplier = mimic.number(context, "multiplier").unwrap_or(1.0);
    let constant = mimic.number(context, "offset").unwrap_or(0.0);
    robot.gearings.push(Gearing {
        name: robot.joints[own].name.clone(),
        terms: vec![(own, 0, 1.0), (other, 0, -multiplier)],
        constant,
        place: Some(mimic.place()),
    });
    Some(())
}

/// Changes the type of a joint and places both of its frames at the child's frame; a universal
/// joint rotates about x, then about y.
pub(super) fn retype(joint: &mut Joint, kind: JointType) {
    // Pose of the child's frame in the parent's frame at zero coordinates.
    let frame = joint.frame_j * joint.frame_k.inverse();
    let axes = match kind {
        // The first axis is x and the second axis is y.
        JointType::Universal => Mat3::from_columns(Vec3::unit(1), Vec3::unit(2), Vec3::unit(0)),
        _ => Mat3::identity(),
    };
    let axes = Pose { rotation: axes, position: Vec3::zero() };
    let old = joint.clone();
    *joint = Joint {
        place: old.place,
        comment: old.comment,
        friction: old.friction,
        range: old.range,
        frame_j: frame * axes,
        frame_k: axes,
        ..Joint::new(old.name, kind, (old.from, old.to))
    };
}
