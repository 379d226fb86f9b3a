//! Frames of SDF: the pose of each frame is given relative to another frame.

use super::super::context::Context;
use super::super::rotation;
use super::super::xml::{Element, numbers_in};
use super::Reader;
use super::models::Model;
use crate::diagnostic::{did_you_mean, quoted};
use crate::source::Place;
use std::cell::RefCell;
use std::collections::HashMap;
use stiction_core::spatial::{Mat3, Pose, Vec3};

#[derive(Clone, Debug)]
struct Frame {
    /// Full name of the frame to which `pose` is relative; `None` for the world.
    base: Option<String>,
    pose: Pose<f64>,
    /// For a model, the name of the frame in the model to which the model's pose applies; `None` if
    /// the pose applies to the model's own frame.
    placement: Option<String>,
    /// Full name of the frame or link to which the frame is attached.
    carrier: Option<String>,
    place: Place,
}

/// All frames by full name, such as `arm::wrist`.
#[derive(Debug, Default)]
pub(super) struct Frames {
    frames: HashMap<String, Frame>,
    resolved: HashMap<String, Pose<f64>>,
    /// Poses of placement frames in their models, by the names of the models' own frames. Without them, the time to resolve
    /// placement frames of nested models would double with each level.
    placements: RefCell<HashMap<String, Pose<f64>>>,
}

/// Reads the child element `pose`; returns the identity if it is absent.
pub(super) fn pose(context: &Context<'_>, element: &Element) -> Pose<f64> {
    let Some(pose) = element.child("pose").filter(|pose| !pose.text.is_empty()) else {
        return Pose::identity();
    };
    let place = pose.place();
    let Some(numbers) = numbers_in(context, &pose.text, &place) else { return Pose::identity() };
    let degrees = matches!(pose.get("degrees"), Some("true" | "1"));
    match numbers.as_slice() {
        &[x, y, z, roll, pitch, yaw] => {
            let angles = [roll, pitch, yaw];
            let angles = if degrees { angles.map(f64::to_radians) } else { angles };
            rotation::pose([x, y, z], angles)
        }
        &[x, y, z, qx, qy, qz, qw] if pose.get("rotation_format") == Some("quat_xyzw") => {
            let rotation = rotation::quaternion([qw, qx, qy, qz]).unwrap_or(Mat3::identity());
            Pose { position: Vec3::new(x, y, z), rotation }
        }
        other => {
            let message = format!("a pose has {} numbers instead of 6", other.len());
            context.error("pose", message, &place, "write x y z roll pitch yaw");
            Pose::identity()
        }
    }
}

/// Name of the frame to which a pose is relative, as written.
fn relative_to(element: &Element) -> Option<&str> {
    let pose = element.child("pose")?;
    pose.get("relative_to").or_else(|| pose.get("frame")).filter(|name| !name.is_empty())
}

impl Frames {
    pub(super) fn contains(&self, name: &str) -> bool {
        name == "world" || self.frames.contains_key(name)
    }

    fn add(&mut self, name: String, frame: Frame) {
        self.frames.entry(name).or_insert(frame);
    }

    /// Computes the poses of all frames in the world.
    ///
    /// Returns `None` after a message if a frame is unknown, or relative to itself.
    pub(super) fn resolve(&mut self, context: &Context<'_>) -> Option<()> {
        let mut names: Vec<String> = self.frames.keys().cloned().collect();
        names.sort_unstable();
        for name in &names {
            let pose = self.chain(context, name, None)?;
            self.resolved.insert(name.clone(), pose);
        }
        Some(())
    }

    /// Pose of the frame `name` relative to the frame `above`, which must be a frame to which
    /// `name` is relative, directly or through other frames. If `above` is `None`, the pose is
    /// relative to the world.
    fn chain(&self, context: &Context<'_>, name: &str, above: Option<&str>) -> Option<Pose<f64>> {
        let mut total = Pose::identity();
        let mut at = name.to_owned();
        for _ in 0..=self.frames.len() {
            if Some(at.as_str()) == above {
                return Some(total);
            }
            if above.is_none() {
                if at == "world" {
                    return Some(total);
                }
                if let Some(known) = self.resolved.get(&at) {
                    return Some(*known * total);
                }
            }
            let Some(frame) = self.frames.get(&at) else {
                // The names of all other frames are known.
                if let Some(model) = above.and_then(|above| self.frames.get(above)) {
                    let message =
                        format!("the placement frame {} is not a frame of its model", quoted(name));
                    let help = "name a link, joint or frame of the model";
                    context.error("frame", message, &model.place, help);
                }
                return None;
            };
            let mut own = frame.pose;
            if let Some(placement) = &frame.placement
                && above != Some(at.as_str())
            {
                // The pose applies to the placement frame of the model.
                let known = self.placements.borrow().get(&at).copied();
                let placed = match known {
                    Some(placed) => placed,
                    None => self.chain(context, placement, Some(&at))?,
                };
                self.placements.borrow_mut().insert(at.clone(), placed);
                own = own * placed.inverse();
            }
            total = own * total;
            let base = frame.base.clone().unwrap_or_else(|| "world".to_owned());
            if !self.contains(&base) {
                let known = self.frames.keys().map(String::as_str);
                let help = did_you_mean(&base, "frames", known).unwrap_or_default();
                let message = format!("there is no frame {}", quoted(&base));
                context.error("frame", message, &frame.place, &help);
                return None;
            }
            at = base;
        }
        let place = &self.frames.get(name)?.place;
        let message = format!("the frame {} is relative to itself", quoted(name));
        context.error("frame", message, place, "remove the cycle of `relative_to`");
        None
    }

    /// Pose of a frame in the world.
    pub(super) fn pose(&self, name: &str) -> Pose<f64> {
        self.resolved.get(name).copied().unwrap_or(Pose::identity())
    }

    /// Index of the body to which a frame is attached, directly or through other frames. `links`
    /// contains the indices of all links and of the world by name.
    pub(super) fn body<'a>(
        &'a self,
        name: &'a str,
        links: &HashMap<String, usize>,
    ) -> Option<usize> {
        let mut at = name;
        for _ in 0..=self.frames.len() {
            if let Some(body) = links.get(at) {
                return Some(*body);
            }
            at = self.frames.get(at)?.carrier.as_deref()?;
        }
        None
    }
}

impl Reader<'_, '_> {
    /// Adds the frames of a model: the model's own frame, and the frames of its links, joints and
    /// `frame` elements.
    pub(super) fn add_frames(&mut self, model: &Model) {
        let context = self.context;
        let element = &model.element;
        let own = model.own_frame();
        let base = match relative_to(element) {
            Some(name) => model.outer_frame(name),
            None => model.around.clone(),
        };
        let first = element.child("link").and_then(|link| link.get("name"));
        let carrier = element.get("canonical_link").or(first).map(|link| model.full(link));
        let placement = element.get("placement_frame").map(str::to_owned);
        let placement = placement
            .or_else(|| element.child("placement_frame").map(|frame| frame.text.clone()))
            .filter(|name| !name.is_empty())
            .map(|name| model.full(&name));
        let frame = Frame {
            base,
            pose: pose(context, element),
            placement,
            carrier,
            place: element.place(),
        };
        if !model.prefix.is_empty() && !model.merged {
            let alias = model.prefix.trim_end_matches("::").to_owned();
            let same = Frame {
                base: Some(own.clone()),
                pose: Pose::identity(),
                placement: None,
                carrier: Some(own.clone()),
                place: element.place(),
            };
            self.frames.add(alias, same);
        }
        if !model.is_world {
            self.frames.add(own.clone(), frame);
        }
        for child in &element.children {
            let Some(name) = child.get("name") else { continue };
            let attached = child.get("attached_to").filter(|name| !name.is_empty());
            let attached = attached.map(|name| model.frame(name));
            let default = match child.tag.as_str() {
                "link" => own.clone(),
                "joint" => match child.child("child") {
                    Some(link) => model.frame(&link.text),
                    None => own.clone(),
                },
                "frame" => attached.clone().unwrap_or_else(|| own.clone()),
                _ => continue,
            };
            let carrier = match child.tag.as_str() {
                "link" => None,
                _ => Some(default.clone()),
            };
            let base = match relative_to(child) {
                Some(name) => model.frame(name),
                None => default,
            };
            let frame = Frame {
                base: Some(base),
                pose: pose(context, child),
                placement: None,
                carrier,
                place: child.place(),
            };
            self.frames.add(model.full(name), frame);
        }
    }
}
