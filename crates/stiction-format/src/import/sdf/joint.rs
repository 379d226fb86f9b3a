//! Reads the joints of an SDF file.

use super::super::description::{Body, Coordinate, Gearing, Joint};
use super::super::rotation::{z_and_x, z_to};
use super::super::xml::Element;
use super::Reader;
use super::models::Model;
use crate::diagnostic::{did_you_mean, quoted};
use std::f64::consts::TAU;
use stiction_core::joint::JointType;
use stiction_core::spatial::{Pose, Vec3};

/// Range limits of this magnitude or more, rad or m, count as absent.
const UNLIMITED: f64 = 1e15;
/// Rate limits of this magnitude or more, m/s or rad/s, count as absent.
const UNLIMITED_RATE: f64 = 1e9;
/// Greatest sine of the deviation from a right angle at which axes count as perpendicular.
const PERPENDICULAR: f64 = 1e-9;

impl Reader<'_, '_> {
    pub(super) fn read_joint(&mut self, model: &Model, element: &Element) -> Option<()> {
        let context = self.context;
        let name = model.full(element.required(context, "name")?);
        let word = element.required(context, "type")?;
        if word == "gearbox" {
            // A gearbox couples two other joints.
            return Some(());
        }
        let (from, to) = (self.end(model, element, "parent")?, self.end(model, element, "child")?);
        let place = self.frames.pose(&name);
        let add = |reader: &mut Self, name: String, kind, ends, rotation, key: Option<&str>| {
            reader.add_joint((model, element), (name, kind, ends), Pose { rotation, ..place }, key)
        };
        let kind = match word {
            "revolute" | "continuous" => JointType::Revolute,
            "prismatic" => JointType::Prismatic,
            "screw" => JointType::Helical,
            "ball" => JointType::Spherical,
            "fixed" => JointType::Fixed,
            "universal" | "revolute2" => JointType::Universal,
            other => {
                let known = [
                    "revolute",
                    "continuous",
                    "prismatic",
                    "screw",
                    "ball",
                    "fixed",
                    "universal",
                    "revolute2",
                ];
                let help = did_you_mean(other, "types", known).unwrap_or_default();
                let message = format!("{} has the unknown type {}", element.title(), quoted(other));
                context.error("type", message, &element.place(), &help);
                return None;
            }
        };
        let rotation = match kind {
            JointType::Spherical | JointType::Fixed => place.rotation,
            JointType::Universal => {
                let first = self.axis(model, element, "axis")?;
                let second = self.axis(model, element, "axis2")?;
                if first.dot(second).abs() > PERPENDICULAR {
                    // A universal joint whose axes are not perpendicular becomes two hinges with a
                    // massless body between them.
                    let between = self.robot.bodies.len();
                    let body = Body::massless(format!("{name}_between"), Some(element.place()));
                    self.robot.bodies.push(body);
                    self.poses.push(self.poses[from]);
                    let hinge = JointType::Revolute;
                    let names = ["first", "second"].map(|which| format!("{name}_{which}"));
                    let [one, two] = names;
                    add(self, one, hinge, (from, between), z_to(first), Some("axis"));
                    add(self, two, hinge, (between, to), z_to(second), Some("axis2"));
                    return Some(());
                }
                z_and_x(first, second)?
            }
            _ => z_to(self.axis(model, element, "axis")?),
        };
        let index = add(self, name.clone(), kind, (from, to), rotation, Some("axis"));
        if kind == JointType::Helical {
            let per_turn = match element.child_number(context, "screw_thread_pitch") {
                Some(pitch) => pitch,
                // The older key is an angle per length of a left-handed thread.
                None => match element.child_number(context, "thread_pitch") {
                    Some(pitch) if pitch != 0.0 => -TAU / pitch,
                    _ => 1.0,
                },
            };
            self.robot.joints[index].pitch = per_turn / TAU;
        }
        if self.joints.insert(name.clone(), index).is_some() {
            let message = format!("there are two joints named {}", quoted(&name));
            context.error("name", message, &element.place(), "");
        }
        Some(())
    }

    /// Adds a joint between two bodies; both of its frames coincide with `frame`, given in the
    /// world.
    fn add_joint(
        &mut self,
        (_, element): (&Model, &Element),
        (name, kind, (from, to)): (String, JointType, (usize, usize)),
        frame: Pose<f64>,
        key: Option<&str>,
    ) -> usize {
        let index = self.robot.joints.len();
        let mut joint = Joint::new(name, kind, (from, to));
        joint.frame_j = self.poses[from].inverse() * frame;
        joint.frame_k = self.poses[to].inverse() * frame;
        joint.place = Some(element.place());
        let keys: &[&str] = match (kind, key) {
            (JointType::Universal, _) => &["axis", "axis2"],
            (_, Some("axis2")) => &["axis2"],
            _ => &["axis"],
        };
        for (dof, (own, key)) in joint.dofs.iter_mut().zip(keys).enumerate() {
            if let Some(axis) = element.child(key) {
                let (coordinate, [effort, rate]) = self.coordinate(axis);
                *own = coordinate;
                self.efforts.extend(effort.map(|effort| ((index, dof), effort)));
                self.rates.extend(rate.map(|rate| ((index, dof), rate)));
            }
        }
        self.robot.joints.push(joint);
        index
    }

    /// Index of the body at one end of a joint: the link that the child element `tag` names, or the
    /// link to which the named frame is attached.
    pub(super) fn end(&self, model: &Model, element: &Element, tag: &str) -> Option<usize> {
        let context = self.context;
        let Some(end) = element.child(tag).filter(|end| !end.text.is_empty()) else {
            let message = format!("{} has no <{tag}>", element.title());
            context.error("missing", message, &element.place(), "");
            return None;
        };
        let full = model.frame(&end.text);
        let found = self.frames.body(&full, &self.bodies);
        if found.is_none() {
            let mut known: Vec<&str> = self.bodies.keys().map(String::as_str).collect();
            known.sort_unstable();
            let help = did_you_mean(&full, "links", known).unwrap_or_default();
            let message = format!("there is no link {}", quoted(&full));
            context.error("name", message, &end.place(), &help);
        }
        found
    }

    /// Direction, in the world, of the axis that the child element `key` of a joint describes.
    pub(super) fn axis(&self, model: &Model, element: &Element, key: &str) -> Option<Vec3<f64>> {
        let context = self.context;
        let joint = model.full(element.get("name")?);
        let Some(axis) = element.child(key) else {
            // Default of the format.
            return Some(self.frames.pose(&joint).rotation.columns[2]);
        };
        let xyz = axis.child("xyz");
        let numbers =
            xyz.filter(|xyz| !xyz.text.is_empty()).and_then(|xyz| xyz.text_numbers::<3>(context));
        let direction = Vec3::from(numbers.unwrap_or([0.0, 0.0, 1.0]));
        let Some(direction) = direction.direction() else {
            let message = format!("the axis of {} is zero", element.title());
            context.error("axis", message, &axis.place(), "give a direction such as 0 0 1");
            return None;
        };
        let is_true = |child: &Element| matches!(child.text.as_str(), "true" | "1");
        let in_model = match axis.child("use_parent_model_frame") {
            Some(child) => is_true(child),
            // Until version 1.4, axes were expressed in the frame of the model.
            None => model.version < (1, 5),
        };
        let expressed = xyz.and_then(|xyz| xyz.get("expressed_in")).filter(|name| !name.is_empty());
        let frame = match expressed {
            Some(name) => model.frame(name),
            None if in_model => model.own_frame(),
            None => joint,
        };
        if !self.frames.contains(&frame) {
            let message = format!("there is no frame {}", quoted(&frame));
            context.error("frame", message, &axis.place(), "");
            return None;
        }
        Some(self.frames.pose(&frame).rotation * direction)
    }

    /// Reads the range, damping, friction and spring of an axis. Also returns the limits of its
    /// effort, N or N m, and rate, m/s or rad/s.
    fn coordinate(&self, axis: &Element) -> (Coordinate, [Option<f64>; 2]) {
        let context = self.context;
        let mut coordinate = Coordinate {
            position: axis.child_number(context, "initial_position").unwrap_or(0.0),
            ..Coordinate::default()
        };
        let mut greatest = [None; 2];
        if let Some(limit) = axis.child("limit") {
            let number = |key: &str| {
                let child = limit.child(key).filter(|child| !child.text.is_empty())?;
                // Files may contain `inf`.
                match child.text.trim_start_matches(['-', '+']).to_ascii_lowercase().as_str() {
                    "inf" | "infinity" => None,
                    _ => child.text_numbers::<1>(context).map(|[value]| value),
                }
            };
            let bound = |key: &str| number(key).filter(|value| value.abs() < UNLIMITED);
            coordinate.range = match (bound("lower"), bound("upper")) {
                (Some(lower), Some(upper)) if lower < upper => Some([lower, upper]),
                (None, None) => None,
                _ => {
                    let message = "one-sided limits and limits with an empty range are left out";
                    context.note(message, Some(limit.place()));
                    None
                }
            };
            greatest = [
                number("effort").filter(|effort| *effort >= 0.0),
                number("velocity").filter(|rate| *rate > 0.0 && *rate < UNLIMITED_RATE),
            ];
        }
        if let Some(dynamics) = axis.child("dynamics") {
            let number = |key: &str| dynamics.child_number(context, key).unwrap_or(0.0);
            coordinate.damping = number("damping").max(0.0);
            coordinate.friction = number("friction").max(0.0);
            let stiffness = number("spring_stiffness");
            let rest = number("spring_reference");
            coordinate.spring = (stiffness > 0.0).then_some([stiffness, rest]);
        }
        (coordinate, greatest)
    }

    /// Reads a coupling with another joint, the leader: coordinate = multiplier (leader -
    /// reference) + offset.
    pub(super) fn read_mimic(&mut self, model: &Model, element: &Element) -> Option<()> {
        let context = self.context;
        let mimic = element.child("axis")?.child("mimic")?;
        let own = *self.joints.get(&model.full(element.get("name")?))?;
        let leader = mimic.required(context, "joint")?;
        let Some(&other) = self.joints.get(&model.full(leader)) else {
            let message = format!("there is no joint {}", quoted(leader));
            context.error("name", message, &mimic.place(), "");
            return None;
        };
        let number = |key: &str, default: f64| mimic.child_number(context, key).unwrap_or(default);
        let (multiplier, offset) = (number("multiplier", 1.0), number("offset", 0.0));
        let has_one = |joint: usize| self.robot.joints[joint].dofs.len() == 1;
        if !has_one(own) || !has_one(other) || own == other {
            let message = "a coupling of joints with several coordinates is left out";
            context.warn(message, Some(mimic.place()));
            return None;
        }
        self.robot.gearings.push(Gearing {
            name: self.robot.joints[own].name.clone(),
            terms: vec![(own, 0, 1.0), (other, 0, -multiplier)],
            constant: offset - multiplier * number("reference", 0.0),
            place: Some(mimic.place()),
        });
        Some(())
    }
}
