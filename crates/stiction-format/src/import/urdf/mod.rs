//! Imports URDF files, which contain a tree of links, with additional loop closures.

mod closures;
mod convention;
mod joint;
mod known;
mod motors;

use super::context::Context;
use super::description::{Body, Description, GROUND, Joint, VisualMesh};
use super::extension;
use super::inertia::{negative_mass, symmetric, turned};
use super::rotation;
use super::unread;
use super::xml::{EXPAND_XACRO, Element, XACRO};
use crate::diagnostic::quoted;
use std::collections::HashMap;
use stiction_core::spatial::{Pose, Vec3};

/// Gravitational acceleration along z, m/s², assumed because URDF files do not contain it.
const GRAVITY: f64 = -9.81;

/// Indices of links and joints by their names in the file.
pub(super) struct Tree {
    /// Index of the body of each link, by the name of the link in the file.
    pub(super) links: HashMap<String, usize>,
    /// Index of each joint by its name in the file.
    pub(super) joints: HashMap<String, usize>,
}

/// Reads a robot from the root element of a URDF file and from the YAML file `companion`, if it
/// exists; `None` after an error.
pub(super) fn read(context: &Context<'_>, root: &Element, companion: &str) -> Option<Description> {
    refuse_xacro(context, root)?;
    let name = root.get("name").unwrap_or("robot");
    let mut robot = Description::new("URDF", name, Vec3::new(0.0, 0.0, GRAVITY));
    let mut tree = Tree { links: HashMap::new(), joints: HashMap::new() };
    let base = base_of(context, root)?;
    for link in root.all("link") {
        let name = link.required(context, "name")?.to_owned();
        let index = if name == base { GROUND } else { robot.bodies.len() };
        if tree.links.insert(name.clone(), index).is_some() {
            let message = format!("there are two links named {}", quoted(&name));
            context.error("name", message, &link.place(), "");
            return None;
        }
        let body = link_body(context, link, name, index == GROUND);
        match index {
            GROUND => ground(context, &mut robot, &body),
            _ => robot.bodies.push(body),
        }
    }
    for element in root.all("joint") {
        let joint = joint::read(context, &tree, element)?;
        let name = element.get("name").unwrap_or_default().to_owned();
        if tree.joints.insert(name, robot.joints.len()).is_some() {
            let message = format!("there are two joints named {}", quoted(&joint.name));
            context.error("name", message, &element.place(), "");
            return None;
        }
        robot.joints.push(joint);
    }
    check_tree(context, &robot)?;
    for element in root.all("joint") {
        joint::read_mimic(context, &tree, element, &mut robot);
    }
    robot.place_followers();
    closures::read(context, &tree, root, &mut robot);
    let convention = convention::read(context, &tree, companion, &mut robot);
    motors::read(context, &tree, root, convention, &mut robot);
    robot.extensions = extension::entries(root);
    note_unused(context, root, &robot);
    Some(robot)
}

/// Rejects Xacro, a macro language from which URDF is generated.
fn refuse_xacro(context: &Context<'_>, root: &Element) -> Option<()> {
    let is_macro = |element: &Element| {
        element.namespace.contains("xacro")
            || element.attributes.iter().any(|attribute| attribute.value.contains("${"))
    };
    let mut stack = vec![root];
    while let Some(element) = stack.pop() {
        if is_macro(element) {
            context.error("xacro", XACRO.to_owned(), &element.place(), EXPAND_XACRO);
            return None;
        }
        stack.extend(&element.children);
    }
    Some(())
}

/// Returns the name of the root link, which is not the child of any joint; reports an error unless
/// exactly one link is a root.
fn base_of(context: &Context<'_>, root: &Element) -> Option<String> {
    let carried: Vec<&str> = root
        .all("joint")
        .filter_map(|joint| joint.child("child").and_then(|child| child.get("link")))
        .collect();
    let links: Vec<&Element> = root.all("link").collect();
    if links.is_empty() {
        let message = "the robot has no links".to_owned();
        context.error("missing", message, &root.place(), "a URDF has <link> and <joint> elements");
        return None;
    }
    let is_free = |link: &&&Element| link.get("name").is_some_and(|name| !carried.contains(&name));
    let free: Vec<&&Element> = links.iter().filter(is_free).collect();
    match free.as_slice() {
        [] => {
            let message = "every link is the child of a joint, so the robot has no root".to_owned();
            let help = "close loops with a <loop_joint> or a YAML file instead of a joint";
            context.error("tree", message, &root.place(), help);
            None
        }
        [base] => base.get("name").map(str::to_owned),
        [_, other, ..] => {
            let names: Vec<String> =
                free.iter().filter_map(|link| link.get("name")).map(quoted).collect();
            let shown = names.iter().take(4).cloned().collect::<Vec<_>>().join(", ");
            let message = format!("{} links have no parent: {shown}", names.len());
            let help = "connect them by joints; exactly one link is the root";
            context.error("tree", message, &other.place(), help);
            None
        }
    }
}

/// Reads the mass and the meshes of a link. The mass of the link that `is_ground` has no effect.
fn link_body(context: &Context<'_>, link: &Element, name: String, is_ground: bool) -> Body {
    let mut body = Body::massless(name, Some(link.place()));
    body.visuals = link.all("visual").filter_map(|visual| mesh_of(context, visual)).collect();
    let shapes = link.all("collision").filter_map(|shape| shape.child("geometry")?.child("mesh"));
    for mesh in shapes {
        mesh.get("filename").map(|file| context.is_mesh_file(file, &mesh.place()));
    }
    let Some(inertial) = link.child("inertial") else { return body };
    let origin = origin(context, inertial);
    let mass = inertial.child("mass").and_then(|mass| mass.number(context, "value"));
    body.mass = mass.unwrap_or(0.0);
    body.com = origin.position;
    if let Some(inertia) = inertial.child("inertia") {
        let entries = INERTIA.map(|key| inertia.number(context, key).unwrap_or(0.0));
        body.inertia = turned(symmetric(entries), origin.rotation);
    }
    if !is_ground {
        note_missing(context, inertial, &body.name);
    }
    if body.mass < 0.0 {
        let message = negative_mass("link", &body.name, body.mass);
        let place = inertial.child("mass").map_or_else(|| inertial.place(), Element::place);
        context.error("mass", message, &place, "masses are at least 0 kg");
    }
    body
}

/// Attributes of `<inertia>`, which URDF requires.
const INERTIA: [&str; 6] = ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"];

/// Warns of parts of an `inertial` element that URDF requires and the file lacks; they count as 0.
fn note_missing(context: &Context<'_>, inertial: &Element, link: &str) {
    let link = quoted(link);
    if inertial.child("mass").is_none_or(|mass| mass.attribute("value").is_none()) {
        let message = format!(
            "the mass of link {link} is missing and counts as 0 kg: write <mass value=\"...\"/>"
        );
        context.warn(message, Some(inertial.place()));
    }
    let Some(inertia) = inertial.child("inertia") else {
        let message = format!(
            "the inertia of link {link} is missing and counts as 0 kg m^2: write <inertia> with {}",
            INERTIA.join(", ")
        );
        context.warn(message, Some(inertial.place()));
        return;
    };
    let missing = INERTIA.into_iter().filter(|key| inertia.attribute(key).is_none());
    let missing: Vec<String> = missing.map(|key| format!("`{key}`")).collect();
    if !missing.is_empty() {
        let counts =
            if missing.len() == 1 { "is missing and counts" } else { "are missing and count" };
        let message = format!(
            "{} of the inertia of link {link} {counts} as 0 kg m^2: write all of {}",
            missing.join(", "),
            INERTIA.join(", ")
        );
        context.warn(message, Some(inertia.place()));
    }
}

/// Returns the mesh of a `visual` element; `None` if the element has no mesh or the mesh cannot be
/// shown.
fn mesh_of(context: &Context<'_>, visual: &Element) -> Option<VisualMesh> {
    let mesh = visual.child("geometry")?.child("mesh")?;
    let file = mesh.get("filename").filter(|file| context.has_mesh(file, mesh.place()))?.to_owned();
    let scale = mesh.numbers::<3>(context, "scale").unwrap_or([1.0; 3]);
    Some(VisualMesh { file, scale, pose: origin(context, visual) })
}

/// Notes that the root link is the ground, and writes this into the ground's comment.
fn ground(context: &Context<'_>, robot: &mut Description, link: &Body) {
    let mut comment = format!("The root link of the file, {}, is the ground.", quoted(&link.name));
    if link.mass > 0.0 {
        comment += &format!(" Its mass, {} kg, does not matter.", link.mass);
    }
    context.note(comment.trim_end_matches('.'), link.place.clone());
    robot.bodies[GROUND].comment = Some(comment);
}

/// Reads the pose of an element from its child `origin`; the pose is the identity without this
/// child.
pub(super) fn origin(context: &Context<'_>, element: &Element) -> Pose<f64> {
    match element.child("origin") {
        Some(origin) => placed(context, origin),
        None => Pose::identity(),
    }
}

/// Reads a pose from the attributes `xyz`, m, and `rpy`, rad, or `quat_xyzw`, a quaternion.
pub(super) fn placed(context: &Context<'_>, element: &Element) -> Pose<f64> {
    let position = element.numbers::<3>(context, "xyz").unwrap_or([0.0; 3]);
    let mut pose = rotation::pose(position, [0.0; 3]);
    if let Some(angles) = element.numbers::<3>(context, "rpy") {
        pose.rotation = rotation::roll_pitch_yaw(angles);
    } else if let Some([x, y, z, w]) = element.numbers::<4>(context, "quat_xyzw") {
        pose.rotation = rotation::quaternion([w, x, y, z]).unwrap_or(pose.rotation);
    }
    pose
}

/// Checks that each link has one parent, and that the parents lead to the root.
fn check_tree(context: &Context<'_>, robot: &Description) -> Option<()> {
    let mut parent: Vec<Option<&Joint>> = vec![None; robot.bodies.len()];
    for joint in &robot.joints {
        if let Some(other) = parent[joint.to].replace(joint) {
            let (body, place) = (&robot.bodies[joint.to].name, joint.place.as_ref()?);
            let message = format!(
                "link {} is the child of two joints, {} and {}",
                quoted(body),
                quoted(&other.name),
                quoted(&joint.name)
            );
            let help = "close the loop with a <loop_joint>, or with `closed_loop` in a YAML file";
            context.error("tree", message, place, help);
            return None;
        }
    }
    let reached = robot.poses();
    let lost = (0..robot.bodies.len()).find(|&body| reached[body].is_none());
    if let Some(body) = lost {
        let message =
            format!("the joints of link {} form a closed ring", quoted(&robot.bodies[body].name));
        let help = "close loops with a <loop_joint> or a YAML file instead of a joint";
        context.error("tree", message, robot.bodies[body].place.as_ref()?, help);
        return None;
    }
    Some(())
}

fn note_unused(context: &Context<'_>, root: &Element, robot: &Description) {
    let has = |tag: &str| root.all("link").any(|link| link.child(tag).is_some());
    if has("visual") || has("collision") {
        let is_shown = robot.bodies.iter().any(|body| !body.visuals.is_empty());
        context.note(super::left_out_shapes(is_shown), None);
    }
    unread::note(context, root, known::KNOWN);
}
