//! Reader of MJCF, the format of MuJoCo: nested bodies, and equality constraints that close loops.

mod actuator;
mod body;
mod defaults;
mod equality;
mod geom;
mod joint;
mod keyframe;
mod known;
mod mesh;
mod settings;
mod tendon;

use super::context::Context;
use super::description::Description;
use super::extension;
use super::joint_motors;
use super::locks;
use super::unread;
use super::xml::Element;
use defaults::Defaults;
use settings::Settings;
use std::collections::HashMap;
use stiction_core::spatial::Pose;

/// State of reading an MJCF file.
pub(super) struct Reader<'a, 'c> {
    context: &'a Context<'c>,
    settings: Settings,
    defaults: Defaults,
    robot: Description,
    /// Pose of each body in the world in the file's configuration.
    poses: Vec<Pose<f64>>,
    /// Flag for each body, true if it is fixed to the world.
    fixed: Vec<bool>,
    /// Indices of the bodies by their names in the file.
    bodies: HashMap<String, usize>,
    /// Indices of the joints by their names in the file.
    joints: HashMap<String, usize>,
    /// Indices of the joints in the order in which a keyframe lists their coordinates.
    order: Vec<usize>,
    /// Sites by name: index of the body, and pose of the site in this body.
    sites: HashMap<String, (usize, Pose<f64>)>,
    meshes: mesh::Meshes,
}

/// Elements that generate bodies; the import does not support them.
const GENERATORS: [&str; 5] = ["replicate", "composite", "flexcomp", "flex", "attach"];

/// Reads a robot from the root element of an MJCF file; `None` after an error.
pub(super) fn read(context: &Context<'_>, root: &Element) -> Option<Description> {
    let mut root = root.clone();
    defaults::include(context, &mut root)?;
    super::limit_size(context, &root)?;
    refuse_generators(context, &root)?;
    let settings = Settings::read(context, &root);
    let defaults = Defaults::read(context, &root);
    let name = root.get("model").unwrap_or("robot");
    let robot = Description::new("MJCF", name, settings.gravity);
    let mut reader = Reader {
        context,
        settings,
        defaults,
        robot,
        poses: vec![Pose::identity()],
        fixed: vec![true],
        bodies: HashMap::from([("world".to_owned(), 0)]),
        joints: HashMap::new(),
        order: Vec::new(),
        sites: HashMap::new(),
        meshes: mesh::Meshes::default(),
    };
    reader.read_meshes(&root);
    if context.has_errors() {
        return None;
    }
    reader.read_bodies(&root);
    if context.has_errors() {
        return None;
    }
    reader.scale_mass();
    let mut tendons = reader.read_tendons(&root);
    reader.read_equalities(&root, &tendons);
    reader.read_actuators(&root, &mut tendons);
    reader.note_tendons(&tendons);
    locks::fix(context, &mut reader.robot);
    joint_motors::settle(context, &mut reader.robot);
    reader.read_keyframe(&root);
    reader.robot.extensions = extension::custom_texts(&root);
    unread::note(context, &root, known::KNOWN);
    Some(reader.robot)
}

fn refuse_generators(context: &Context<'_>, root: &Element) -> Option<()> {
    let mut open = vec![root];
    while let Some(element) = open.pop() {
        if GENERATORS.contains(&element.tag.as_str()) {
            let message = format!("<{}>, which generates bodies, is not read", element.tag);
            let help = "save the model with MuJoCo (mj_saveLastXML), which writes each of these \
                bodies, and convert the saved file";
            context.error("mjcf", message, &element.place(), help);
            return None;
        }
        open.extend(element.children.iter().filter(|child| child.tag != "asset"));
    }
    Some(())
}

impl Reader<'_, '_> {
    /// Scales all masses so that their sum is the total mass in the settings.
    fn scale_mass(&mut self) {
        let Some(total) = self.settings.total_mass else { return };
        let sum: f64 = self.robot.bodies.iter().map(|body| body.mass).sum();
        if sum > 0.0 {
            for body in &mut self.robot.bodies {
                body.mass *= total / sum;
                body.inertia = body.inertia * (total / sum);
            }
        }
    }
}
