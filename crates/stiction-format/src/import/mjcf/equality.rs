//! Reads the equality constraints of an MJCF file: closures of loops, and couplings of joints.

use super::super::description::{Gearing, Joint};
use super::super::rotation;
use super::super::xml::Element;
use super::Reader;
use super::tendon::Tendons;
use crate::diagnostic::{did_you_mean, quoted};
use stiction_core::joint::JointType;
use stiction_core::spatial::{Pose, Vec3};

impl Reader<'_, '_> {
    pub(super) fn read_equalities(&mut self, root: &Element, tendons: &Tendons) {
        if !self.settings.has("equality") {
            return;
        }
        for equality in root.all("equality") {
            for (number, element) in equality.children.iter().enumerate() {
                let element = self.defaults.equality(self.context, element);
                if element.get("active") == Some("false") {
                    let message = "an equality that is not active is left out";
                    self.context.note(message, Some(element.place()));
                    continue;
                }
                let name = match element.get("name") {
                    Some(name) => name.to_owned(),
                    None => format!("{}{}", element.tag, number + 1),
                };
                let joint = match element.tag.as_str() {
                    "connect" => self.connect(&element, &name),
                    "weld" => self.weld(&element, &name),
                    "joint" => {
                        self.couple(&element, &name);
                        None
                    }
                    "tendon" => {
                        self.couple_tendons(&element, &name, tendons);
                        None
                    }
                    other => {
                        let message = format!("an equality of type {other} is left out");
                        self.context.warn(message, Some(element.place()));
                        None
                    }
                };
                self.robot.joints.extend(joint);
            }
        }
    }

    /// Looks up the name in the attribute `key` of an element; reports a name that is not in
    /// `known`. `what` is the kind of the named part in the message.
    fn named<T: Clone>(
        &self,
        element: &Element,
        (key, what): (&str, &str),
        known: &std::collections::HashMap<String, T>,
    ) -> Option<T> {
        let attribute = element.attribute(key)?;
        let name = attribute.value.trim();
        let found = known.get(name).cloned();
        if found.is_none() {
            let mut names: Vec<&str> = known.keys().map(String::as_str).collect();
            names.sort_unstable();
            let help = did_you_mean(name, &format!("{what}s"), names).unwrap_or_default();
            let message = format!("there is no {what} {}", quoted(name));
            self.context.error("name", message, &attribute.place(), &help);
        }
        found
    }

    /// Returns the two bodies that an element connects, and, if the element names sites, the poses
    /// of the two sites in these bodies.
    #[expect(clippy::type_complexity, reason = "two bodies and, for sites, two poses")]
    fn ends(&self, element: &Element) -> Option<([usize; 2], Option<[Pose<f64>; 2]>)> {
        if element.attribute("site1").is_some() {
            let (first, one) = self.named(element, ("site1", "site"), &self.sites)?;
            element.required(self.context, "site2")?;
            let (second, two) = self.named(element, ("site2", "site"), &self.sites)?;
            return Some(([first, second], Some([one, two])));
        }
        element.required(self.context, "body1")?;
        let first = self.named(element, ("body1", "body"), &self.bodies)?;
        let second = match element.attribute("body2") {
            Some(_) => self.named(element, ("body2", "body"), &self.bodies)?,
            None => 0,
        };
        Some(([first, second], None))
    }

    /// Pose of the second body in the first, in the file's configuration.
    fn between(&self, [first, second]: [usize; 2]) -> Pose<f64> {
        self.poses[first].inverse() * self.poses[second]
    }

    /// Reads a `connect` constraint, the coincidence of two points, as a ball joint.
    fn connect(&self, element: &Element, name: &str) -> Option<Joint> {
        let (ends, sites) = self.ends(element)?;
        let [one, two] = match sites {
            Some(sites) => sites.map(|site| site.position),
            None => {
                element.required(self.context, "anchor")?;
                let anchor = Vec3::from(element.numbers::<3>(self.context, "anchor")?);
                [anchor, self.between(ends).inverse().apply(anchor)]
            }
        };
        let mut joint = Joint::new(name, JointType::Spherical, (ends[0], ends[1]));
        joint.frame_j = Pose::at(one);
        // Both frames have the same axes in the file's configuration.
        joint.frame_k = Pose { position: two, rotation: self.between(ends).rotation.transpose() };
        joint.closes = true;
        joint.place = Some(element.place());
        joint.comment = Some(format!("Closes a loop: <connect> {}.", quoted(name)));
        Some(joint)
    }

    /// Reads a `weld` constraint, the coincidence of two frames, as a fixed joint.
    fn weld(&self, element: &Element, name: &str) -> Option<Joint> {
        let (ends, sites) = self.ends(element)?;
        let [one, two] = match sites {
            Some(sites) => sites,
            None => {
                let given = element.numbers::<7>(self.context, "relpose");
                let given = given.and_then(|[x, y, z, a, b, c, d]| {
                    let rotation = rotation::quaternion([a, b, c, d])?;
                    Some(Pose { position: Vec3::new(x, y, z), rotation })
                });
                // A given pose is that of the weld point of the second body.
                let anchor = element.numbers::<3>(self.context, "anchor").unwrap_or([0.0; 3]);
                match given {
                    Some(given) => [given, Pose::at(Vec3::from(anchor))],
                    None => [self.between(ends), Pose::identity()],
                }
            }
        };
        let mut joint = Joint::new(name, JointType::Fixed, (ends[0], ends[1]));
        (joint.frame_j, joint.frame_k) = (one, two);
        joint.closes = true;
        joint.place = Some(element.place());
        joint.comment = Some(format!("Closes a loop: <weld> {}.", quoted(name)));
        Some(joint)
    }

    /// Constant and linear coefficient of the polynomial of a coupling. `None` for a nonlinear
    /// coupling, which is reported. `has_second` is false if the coupling contains only one
    /// coordinate.
    fn linear(&self, element: &Element, has_second: bool) -> Option<[f64; 2]> {
        let mut coefficients = [0.0, 1.0, 0.0, 0.0, 0.0];
        let given = element.list(self.context, "polycoef").unwrap_or_default();
        coefficients.iter_mut().zip(given).for_each(|(known, value)| *known = value);
        if has_second && coefficients[2..].iter().any(|value| *value != 0.0) {
            let message = "a coupling with a nonlinear `polycoef` is left out";
            self.context.warn(message, Some(element.place()));
            return None;
        }
        Some([coefficients[0], coefficients[1]])
    }

    /// Coordinate of a joint in the file's configuration; `None` unless the joint has exactly one
    /// coordinate.
    fn reference(&self, joint: usize) -> Option<f64> {
        match self.robot.joints[joint].dofs.as_slice() {
            [dof] => Some(dof.position),
            _ => None,
        }
    }

    /// Reads a coupling between the lengths of two fixed tendons. Only linear polynomials can be
    /// converted.
    fn couple_tendons(&mut self, element: &Element, name: &str, tendons: &Tendons) -> Option<()> {
        element.required(self.context, "tendon1")?;
        let place = Some(element.place());
        let find = |key: &str| tendons.get(element.get(key)?.trim());
        let second = element.attribute("tendon2").is_some();
        let (Some(first), true) = (find("tendon1"), !second || find("tendon2").is_some()) else {
            self.context.warn(
                "a coupling of tendons that are not sums of joint coordinates is left out",
                place,
            );
            return None;
        };
        let [constant, factor] = self.linear(element, second)?;
        let mut terms = first.joints.clone();
        if let Some(second) = find("tendon2") {
            terms.extend(second.joints.iter().map(|&(joint, part)| (joint, -factor * part)));
        }
        // The equation couples deviations from the file's configuration.
        let mut sum = constant;
        for &(joint, part) in &terms {
            sum += part * self.reference(joint)?;
        }
        let terms = terms.into_iter().map(|(joint, part)| (joint, 0, part)).collect();
        self.robot.gearings.push(Gearing { name: name.to_owned(), terms, constant: sum, place });
        Some(())
    }

    /// Reads a coupling between the coordinates of two joints. Only linear polynomials can be
    /// converted.
    fn couple(&mut self, element: &Element, name: &str) -> Option<()> {
        element.required(self.context, "joint1")?;
        let first = self.named(element, ("joint1", "joint"), &self.joints)?;
        let second = match element.attribute("joint2") {
            Some(_) => Some(self.named(element, ("joint2", "joint"), &self.joints)?),
            None => None,
        };
        let [constant, factor] = self.linear(element, second.is_some())?;
        // The equation couples deviations from the file's configuration.
        let mut terms = vec![(first, 0, 1.0)];
        let mut constant = constant + self.reference(first)?;
        if let Some(second) = second {
            terms.push((second, 0, -factor));
            constant -= factor * self.reference(second)?;
        }
        let place = Some(element.place());
        self.robot.gearings.push(Gearing { name: name.to_owned(), terms, constant, place });
        Some(())
    }
}
