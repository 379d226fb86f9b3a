//! Reads the tendons of an MJCF file: springs between two points, and linear combinations of joint
//! coordinates that motors drive.

use super::super::description::Spring;
use super::super::xml::Element;
use super::Reader;
use super::joint::part_of;
use crate::source::Place;
use std::collections::HashMap;
use stiction_core::spatial::Pose;

/// Fixed tendon: a linear combination of joint coordinates.
#[derive(Clone, Debug)]
pub(super) struct Fixed {
    /// Joints with one degree of freedom, each with its coefficient in the combination.
    pub(super) joints: Vec<(usize, f64)>,
    /// Inertia in the tendon's coordinate, SI units. Like the friction and damping of the tendon,
    /// it is assigned to the motor that drives the tendon.
    pub(super) armature: f64,
    /// Constant friction in the tendon's coordinate, SI units.
    pub(super) friction: f64,
    /// Damping in the tendon's coordinate, SI units.
    pub(super) damping: f64,
    pub(super) is_driven: bool,
    place: Place,
}

/// All fixed tendons by name.
pub(super) type Tendons = HashMap<String, Fixed>;

impl Reader<'_, '_> {
    pub(super) fn read_tendons(&mut self, root: &Element) -> Tendons {
        let mut tendons = Tendons::new();
        for element in root.all("tendon").flat_map(|tendon| tendon.children.iter()) {
            let element = self.defaults.applied(self.context, element, None);
            match element.tag.as_str() {
                "fixed" => {
                    let fixed = self.read_fixed(&element);
                    if let (Some(name), Some(fixed)) = (element.get("name"), fixed) {
                        tendons.insert(name.to_owned(), fixed);
                    }
                }
                "spatial" => self.read_spatial(&element),
                _ => {}
            }
        }
        tendons
    }

    /// Reports the inertia, friction and damping of fixed tendons that no motor drives.
    pub(super) fn note_tendons(&self, tendons: &Tendons) {
        let mut left: Vec<&Fixed> = tendons.values().filter(|fixed| !fixed.is_driven).collect();
        left.sort_by_key(|fixed| fixed.place.line_column());
        for fixed in left {
            let values = [fixed.armature, fixed.friction, fixed.damping];
            for (key, value) in ["armature", "frictionloss", "damping"].into_iter().zip(values) {
                if value != 0.0 {
                    let message =
                        format!("`{key}` of a <fixed> tendon that no motor drives is left out");
                    self.context.warn(message, Some(fixed.place.clone()));
                }
            }
        }
    }

    /// Narrows the range of a joint by the range of a tendon that contains only this joint. Returns
    /// `false` if the tendon contains several joints, or if no range remains.
    fn limit_joint(&mut self, joints: &[(usize, f64)], range: [f64; 2]) -> bool {
        let &[(joint, coefficient)] = joints else { return false };
        let [dof] = self.robot.joints[joint].dofs.as_mut_slice() else { return false };
        let [a, b] = range.map(|length| length / coefficient);
        let own = [a.min(b), a.max(b)];
        let [lower, upper] = dof.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let both = [lower.max(own[0]), upper.min(own[1])];
        let is_range = coefficient != 0.0 && both[0] < both[1];
        if is_range {
            dof.range = Some(both);
        }
        is_range
    }

    fn read_fixed(&mut self, element: &Element) -> Option<Fixed> {
        let context = self.context;
        let list = |key: &str| match self.settings.has(part_of(key)) {
            true => element.list(context, key).unwrap_or_default(),
            false => Vec::new(),
        };
        let left = |key: &str| {
            let message = format!("`{key}` of a tendon that couples joints is left out");
            context.note(message, Some(element.place()));
        };
        if list("stiffness").iter().any(|value| *value != 0.0) {
            let message = "`stiffness` of a tendon that couples joints is left out";
            context.warn(message, Some(element.place()));
        }
        let value = |key: &str| list(key).first().copied().unwrap_or(0.0).max(0.0);
        let [armature, friction, damping] = ["armature", "frictionloss", "damping"].map(value);
        let term = |joint: &Element| {
            let name = joint.required(context, "joint")?;
            let index = self.joints.get(name).copied();
            if index.is_none() {
                let message = format!("there is no joint `{name}`");
                context.error("name", message, &joint.place(), "");
            }
            Some((index?, joint.number(context, "coef").unwrap_or(1.0)))
        };
        let joints: Option<Vec<(usize, f64)>> = element.all("joint").map(term).collect();
        let joints = joints?;
        let range = element.numbers::<2>(context, "range").filter(|range| *range != [0.0; 2]);
        let is_limited = element.get("limited") != Some("false") && self.settings.has("limit");
        if let Some(range) = range.filter(|_| is_limited)
            && !self.limit_joint(&joints, range)
        {
            match joints.len() {
                1 => {
                    let message =
                        "`range` of a tendon contradicts the range of its joint: it is left out";
                    context.note(message, Some(element.place()));
                }
                _ => left("range"),
            }
        }
        Some(Fixed {
            joints,
            armature,
            friction,
            damping,
            is_driven: false,
            place: element.place(),
        })
    }

    fn read_spatial(&mut self, element: &Element) {
        let context = self.context;
        let value = |key: &str| {
            let list = element.list(context, key).unwrap_or_default();
            let has = self.settings.has(part_of(key));
            list.first().copied().filter(|_| has).unwrap_or(0.0)
        };
        let (stiffness, damping) = (value("stiffness"), value("damping"));
        let place = || Some(element.place());
        if value("frictionloss") > 0.0 {
            context.warn("friction of a tendon is left out", place());
        }
        let sites: Vec<(usize, _)> = element
            .all("site")
            .filter_map(|site| self.sites.get(site.get("site")?).copied())
            .collect();
        let ([(first, one), (second, two)], 2) = (sites.as_slice(), element.children.len()) else {
            let message = "a tendon that is not a straight line between two sites is left out";
            match stiffness > 0.0 || damping > 0.0 {
                true => context.warn(message, place()),
                false => context.note(message, place()),
            }
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
                    context.warn("the range of `springlength` is replaced by its mean", place());
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
