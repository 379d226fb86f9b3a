//! Tendons: springs between two points, and sums of joint coordinates that motors drive.

use super::super::description::Spring;
use super::super::xml::Element;
use super::Reader;
use std::collections::HashMap;
use stiction_core::spatial::Pose;

/// Joints with their factors, by the name of the tendon.
pub(super) type Tendons = HashMap<String, Vec<(usize, f64)>>;

impl Reader<'_, '_> {
    pub(super) fn read_tendons(&mut self, root: &Element) -> Tendons {
        let mut tendons = Tendons::new();
        for element in root.all("tendon").flat_map(|tendon| tendon.children.iter()) {
            let element = self.defaults.applied(self.context, element, None);
            match element.tag.as_str() {
                "fixed" => {
                    let joints = self.read_fixed(&element);
                    if let (Some(name), Some(joints)) = (element.get("name"), joints) {
                        tendons.insert(name.to_owned(), joints);
                    }
                }
                "spatial" => self.read_spatial(&element),
                _ => {}
            }
        }
        tendons
    }

    fn read_fixed(&self, element: &Element) -> Option<Vec<(usize, f64)>> {
        let context = self.context;
        for key in ["stiffness", "damping", "frictionloss", "armature"] {
            let value = element.list(context, key).unwrap_or_default();
            if value.iter().any(|value| *value != 0.0) {
                let message = format!("`{key}` of a tendon that couples joints is left out");
                context.note(message, Some(element.place()));
            }
        }
        let term = |joint: &Element| {
            let name = joint.required(context, "joint")?;
            let index = self.joints.get(name).copied();
            if index.is_none() {
                let message = format!("there is no joint `{name}`");
                context.error("name", message, &joint.place(), "");
            }
            Some((index?, joint.number(context, "coef").unwrap_or(1.0)))
        };
        element.all("joint").map(term).collect()
    }

    fn read_spatial(&mut self, element: &Element) {
        let context = self.context;
        let value = |key: &str| {
            let list = element.list(context, key).unwrap_or_default();
            list.first().copied().unwrap_or(0.0)
        };
        let (stiffness, damping) = (value("stiffness"), value("damping"));
        let place = || Some(element.place());
        if value("frictionloss") > 0.0 {
            context.note("friction of a tendon is left out", place());
        }
        let sites: Vec<(usize, _)> = element
            .all("site")
            .filter_map(|site| self.sites.get(site.get("site")?).copied())
            .collect();
        let ([(first, one), (second, two)], 2) = (sites.as_slice(), element.children.len()) else {
            context.note("a tendon that is no line between two sites is left out", place());
            return;
        };
        if !(stiffness > 0.0 || damping > 0.0) {
            context.note("a tendon without stiffness and damping is left out", place());
            return;
        }
        let point = |body: &usize, site: &Pose<f64>| self.poses[*body].apply(site.position);
        let own = (point(second, two) + -point(first, one)).norm();
        let lengths = element.list(context, "springlength").unwrap_or_default();
        let free_length = match lengths.as_slice() {
            [] => own,
            [length] if *length < 0.0 => own,
            [length] => *length,
            [least, greatest, ..] => {
                if least != greatest {
                    context.note(
                        "the range of `springlength` is left out: its mean is taken",
                        place(),
                    );
                }
                0.5 * (least + greatest)
            }
        };
        let number = self.robot.springs.len() + 1;
        self.robot.springs.push(Spring {
            name: element.get("name").map_or_else(|| format!("spring{number}"), str::to_owned),
            ends: [*first, *second],
            points: [one.position, two.position],
            stiffness: stiffness.max(0.0),
            free_length,
            damping: damping.max(0.0),
        });
    }
}
