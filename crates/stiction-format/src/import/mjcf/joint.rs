//! Reads the joints of one MJCF body. The joints form a chain from the parent body to this body,
//! with massless bodies between them.

use super::super::description::{Body, Coordinate, GROUND, Joint};
use super::super::rotation::z_to;
use super::super::xml::Element;
use super::Reader;
use crate::diagnostic::quoted;
use stiction_core::joint::JointType;
use stiction_core::spatial::{Pose, Vec3};

impl Reader<'_, '_> {
    /// Reads the joints of a body and returns their indices; the last joint does not yet have a
    /// successor.
    ///
    /// The joints of one body act in series; their positions and axes refer to the body in the
    /// file's configuration.
    pub(super) fn read_joints(
        &mut self,
        joints: &[(Element, Pose<f64>)],
        (parent, in_parent): (usize, Pose<f64>),
        body: &str,
        element: &Element,
    ) -> Vec<usize> {
        if joints.is_empty() {
            let mut joint = Joint::new(format!("{body}_fixed"), JointType::Fixed, (parent, parent));
            joint.frame_j = in_parent;
            joint.place = Some(element.place());
            return vec![self.push(joint)];
        }
        let mut indices = Vec::new();
        let (mut from, mut start) = (parent, in_parent);
        for (number, (element, frame)) in joints.iter().enumerate() {
            let name = self.joint_name(element, body, (number, joints.len()));
            let Some(joint) = self.read_joint(element, *frame, (from, start), &name) else {
                continue;
            };
            if number + 1 < joints.len() {
                // The file has no name for this intermediate body; the name only has to be unique.
                let between =
                    Body::massless(format!("{body}_{}", number + 1), Some(element.place()));
                self.poses.push(self.poses[from] * start);
                self.robot.bodies.push(between);
            }
            let index = self.push(joint);
            self.robot.joints[index].to = self.robot.bodies.len() - 1;
            let is_named = element.attribute("name").is_some();
            if is_named && self.joints.insert(name.clone(), index).is_some() {
                let message = format!("there are two joints named {}", quoted(&name));
                self.context.error("name", message, &element.place(), "");
            }
            self.order.push(index);
            indices.push(index);
            (from, start) = (self.robot.bodies.len() - 1, Pose::identity());
        }
        indices
    }

    pub(super) fn push(&mut self, joint: Joint) -> usize {
        self.robot.joints.push(joint);
        self.robot.joints.len() - 1
    }

    fn joint_name(&self, element: &Element, body: &str, (number, count): (usize, usize)) -> String {
        match element.get("name") {
            Some(name) => name.to_owned(),
            None if count == 1 => format!("{body}_joint"),
            None => format!("{body}_joint{}", number + 1),
        }
    }

    fn read_joint(
        &self,
        element: &Element,
        frame: Pose<f64>,
        (from, start): (usize, Pose<f64>),
        name: &str,
    ) -> Option<Joint> {
        let context = self.context;
        let word = match element.tag.as_str() {
            "freejoint" => "free",
            _ => element.get("type").unwrap_or("hinge"),
        };
        let kind = match word {
            "hinge" => JointType::Revolute,
            "slide" => JointType::Prismatic,
            "ball" => JointType::Spherical,
            "free" => JointType::Free,
            other => {
                let message = format!("{} has the unknown type {}", element.title(), quoted(other));
                context.error("type", message, &element.place(), "use hinge, slide, ball or free");
                return None;
            }
        };
        let mut joint = Joint::new(name, kind, (from, from));
        joint.place = Some(element.place());
        if kind == JointType::Free {
            if from != GROUND {
                let message = "a free joint is not at the top of the tree".to_owned();
                let help = "MuJoCo allows free joints only for bodies in the world";
                context.error("mjcf", message, &element.place(), help);
            }
            joint.start = Some(start);
            self.note_left(element, "free", &["damping", "stiffness", "armature", "frictionloss"]);
            return Some(joint);
        }
        let position = element.numbers::<3>(context, "pos").unwrap_or([0.0; 3]);
        let mut own = frame * Pose::at(Vec3::from(position));
        if kind == JointType::Spherical {
            own.rotation = Pose::identity().rotation;
            joint.damping = self.first(element, "damping");
            let has_spring = self.first(element, "stiffness") > 0.0;
            let message = "range and stiffness of ball joints are left out";
            match element.attribute("range") {
                _ if has_spring => context.warn(message, Some(element.place())),
                Some(_) => context.note(message, Some(element.place())),
                None => {}
            }
            self.note_left(element, "ball", &["armature", "frictionloss"]);
        } else {
            let axis = element.numbers::<3>(context, "axis").unwrap_or([0.0, 0.0, 1.0]);
            let Some(axis) = Vec3::from(axis).direction() else {
                let message = format!("the axis of joint {} is zero", quoted(name));
                context.error("axis", message, &element.place(), "give a direction");
                return None;
            };
            own.rotation = z_to(frame.rotation * axis);
        }
        joint.frame_j = start * own;
        joint.frame_k = own;
        if let [dof] = joint.dofs.as_mut_slice() {
            *dof = self.coordinate(element, kind);
            let reference = kind.pose(&[dof.position], 0.0);
            joint.frame_k = own * reference;
        }
        Some(joint)
    }

    /// Adds a remark on properties of a joint of this kind that the model does not express.
    fn note_left(&self, element: &Element, kind: &str, keys: &[&str]) {
        for key in keys.iter().filter(|key| self.first(element, key) != 0.0) {
            let message = format!("`{key}` of a {kind} joint is left out");
            self.context.warn(message, Some(element.place()));
        }
    }

    /// Reads the first number of an attribute, which newer files may extend to the coefficients of
    /// a polynomial. Returns zero if the file disables the part of the mechanics to which the
    /// attribute belongs.
    fn first(&self, element: &Element, key: &str) -> f64 {
        if !self.settings.has(part_of(key)) {
            return 0.0;
        }
        let numbers = element.list(self.context, key).unwrap_or_default();
        if numbers.iter().skip(1).any(|number| *number != 0.0) {
            let message = format!("only the linear part of `{key}` is kept");
            self.context.warn(message, Some(element.place()));
        }
        numbers.first().copied().unwrap_or(0.0)
    }

    fn coordinate(&self, element: &Element, kind: JointType) -> Coordinate {
        let context = self.context;
        let turns = kind == JointType::Revolute;
        let measure = |value: f64| if turns { self.settings.angle(value) } else { value };
        let number = |key: &str| element.number(context, key);
        let limited = match element.get("limited") {
            Some("true") => true,
            Some("false") => false,
            _ => self.settings.autolimits,
        };
        let range = element.numbers::<2>(context, "range").map(|range| range.map(measure));
        let stiffness = self.first(element, "stiffness");
        let damper = element.list(context, "springdamper").unwrap_or_default();
        if damper.iter().any(|number| *number > 0.0) {
            let message = "springdamper (time constant and damping ratio) is left out: give `stiffness` \
                and `damping` instead";
            context.warn(message, Some(element.place()));
        }
        if element.attribute("actuatorfrcrange").is_some() {
            let message =
                "actuatorfrcrange is left out: give the limit as `forcerange` of the motor";
            context.note(message, Some(element.place()));
        }
        let rest = number("springref").map_or(0.0, measure);
        let positive = |value: f64| value.max(0.0);
        Coordinate {
            position: number("ref").map_or(0.0, measure),
            range: range.filter(|[least, greatest]| {
                limited && least < greatest && self.settings.has("limit")
            }),
            damping: positive(self.first(element, "damping")),
            friction: positive(self.first(element, "frictionloss")),
            armature: positive(number("armature").unwrap_or(0.0)),
            spring: (stiffness > 0.0).then_some([stiffness, rest]),
            actuated: false,
        }
    }
}

/// Converts the name of a property of a joint or tendon to the name of the flag that disables it.
pub(super) fn part_of(key: &str) -> &str {
    match key {
        "stiffness" => "spring",
        "damping" => "damper",
        other => other,
    }
}
