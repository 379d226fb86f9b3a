//! Reader of SDF: links and joints between them, including closed loops.

mod frames;
mod gearbox;
mod joint;
mod known;
mod link;
mod models;
mod motors;

use super::context::Context;
use super::description::{Description, GROUND, Joint};
use super::extension;
use super::unread;
use super::xml::Element;
use crate::diagnostic::quoted;
use frames::Frames;
use models::Model;
use std::collections::HashMap;
use stiction_core::disjoint_sets::DisjointSets;
use stiction_core::joint::JointType;
use stiction_core::spatial::{Pose, Vec3};

/// Default z component of the gravity of a world, m/s².
const GRAVITY: f64 = -9.8;

/// State of reading an SDF file.
pub(super) struct Reader<'a, 'c> {
    context: &'a Context<'c>,
    robot: Description,
    frames: Frames,
    /// Pose of each body in the world.
    poses: Vec<Pose<f64>>,
    /// Indices of the bodies by their full names in the file.
    bodies: HashMap<String, usize>,
    /// Indices of the joints by their full names in the file.
    joints: HashMap<String, usize>,
    /// Effort limits by indices of the joint and its degree of freedom, N or N m; without a limit
    /// there is no entry.
    efforts: HashMap<(usize, usize), f64>,
    /// Rate limits by indices of the joint and its degree of freedom, m/s or rad/s; without a limit
    /// there is no entry.
    rates: HashMap<(usize, usize), f64>,
}

/// Reads a robot from the root element of an SDF file; `None` after an error.
pub(super) fn read(context: &Context<'_>, root: &Element) -> Option<Description> {
    let found = models::read(context, root)?;
    let gravity = root.child("world").and_then(|world| world.child("gravity"));
    let gravity = gravity.and_then(|gravity| gravity.text_numbers::<3>(context));
    let gravity = gravity.map_or(Vec3::new(0.0, 0.0, GRAVITY), Vec3::from);
    let robot = Description::new("SDF", found.name.clone(), gravity);
    let mut reader = Reader {
        context,
        robot,
        frames: Frames::default(),
        poses: vec![Pose::identity()],
        bodies: HashMap::from([("world".to_owned(), GROUND)]),
        joints: HashMap::new(),
        efforts: HashMap::new(),
        rates: HashMap::new(),
    };
    for model in &found.models {
        reader.add_frames(model);
    }
    reader.frames.resolve(context)?;
    for model in &found.models {
        for link in model.element.all("link") {
            reader.read_link(model, link)?;
        }
    }
    for model in &found.models {
        for joint in model.element.all("joint") {
            reader.read_joint(model, joint)?;
        }
    }
    for model in &found.models {
        for joint in model.element.all("joint") {
            reader.read_mimic(model, joint);
            reader.read_gearbox(model, joint);
        }
        reader.hold(model);
    }
    reader.robot.place_followers();
    reader.float(&found.models);
    motors::guess(&mut reader, &found.models);
    reader.robot.extensions =
        found.models.iter().flat_map(|model| extension::entries(&model.element)).collect();
    unread::note(context, root, known::ROOT);
    reader.note_unused(&found.models);
    Some(reader.robot)
}

impl Reader<'_, '_> {
    /// Fixes the links of a static model to the ground.
    fn hold(&mut self, model: &Model) {
        if !model.is_static {
            return;
        }
        for link in model.element.all("link") {
            let Some(name) = link.get("name") else { continue };
            let Some(&body) = self.bodies.get(&model.full(name)) else { continue };
            let mut joint = Joint::new(
                format!("{}_static", model.full(name)),
                JointType::Fixed,
                (GROUND, body),
            );
            joint.frame_j = self.poses[body];
            joint.place = Some(link.place());
            joint.comment = Some("The model is static.".to_owned());
            self.robot.joints.push(joint);
        }
    }

    /// Adds a free joint between the world and each group of links that no chain of joints connects
    /// with the world.
    fn float(&mut self, models: &[Model]) {
        let count = self.robot.bodies.len();
        let mut groups = DisjointSets::new(count);
        for joint in &self.robot.joints {
            groups.unite(joint.from, joint.to);
        }
        let mut canonical: Vec<usize> = models
            .iter()
            .filter_map(|model| self.bodies.get(&model.full(model.element.get("canonical_link")?)))
            .copied()
            .collect();
        canonical.extend(1..count);
        for body in canonical {
            if !groups.unite(body, GROUND) {
                continue;
            }
            let name = self.robot.bodies[body].name.clone();
            let mut joint = Joint::new(format!("{name}_free"), JointType::Free, (GROUND, body));
            joint.start = Some(self.poses[body]);
            joint.comment = Some("No joint connects it with the world: it floats.".to_owned());
            let message = format!(
                "no joint connects {} with the world: it floats; to attach it, change joint {} to type `fixed`",
                quoted(&name),
                quoted(&joint.name)
            );
            self.context.note(message, self.robot.bodies[body].place.clone());
            self.robot.joints.push(joint);
        }
    }

    fn note_unused(&self, models: &[Model]) {
        let mut shapes = false;
        for model in models {
            for link in model.element.all("link") {
                shapes |= link.child("visual").is_some() || link.child("collision").is_some();
                let disabled = |child: &&Element| matches!(child.text.as_str(), "false" | "0");
                if let Some(gravity) = link.child("gravity").filter(disabled) {
                    let message = "a link without gravity has no counterpart in the model";
                    self.context.warn(message, Some(gravity.place()));
                }
            }
            unread::note(self.context, &model.element, known::MODEL);
        }
        if shapes {
            let is_shown = self.robot.bodies.iter().any(|body| !body.visuals.is_empty());
            let message = super::left_out_shapes(is_shown);
            self.context.note(message, None);
        }
    }
}
