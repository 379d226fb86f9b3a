//! Reads the bodies of an MJCF file with their joints, masses and sites.

use super::super::description::{Body, GROUND};
use super::super::inertia::{Mass, negative_mass, symmetric};
use super::super::xml::Element;
use super::Reader;
use super::settings::{FromGeoms, pose_of_ends};
use crate::diagnostic::quoted;
use nalgebra::{Matrix3, SymmetricEigen};
use stiction_core::mechanism::GROUND_NAME;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Element in a body, with the pose, in the body, of the `frame` elements that enclose it, and the
/// default class that it inherits.
struct Item<'a> {
    element: &'a Element,
    frame: Pose<f64>,
    class: Option<&'a str>,
}

/// Body whose content has not yet been read.
struct Pending<'a> {
    element: &'a Element,
    parent: usize,
    /// Pose, in the parent body, of the `frame` element that encloses the element of this body.
    frame: Pose<f64>,
    class: Option<&'a str>,
}

impl Reader<'_, '_> {
    /// Reads all bodies. The function is not recursive, because chains of nested bodies may be
    /// long.
    pub(super) fn read_bodies(&mut self, root: &Element) {
        let mut open: Vec<Pending<'_>> = Vec::new();
        for world in root.all("worldbody") {
            let items = self.items(world, world.get("childclass"));
            for item in &items {
                match item.element.tag.as_str() {
                    "site" => self.read_site(item, GROUND),
                    "joint" | "freejoint" => {
                        let message = "a joint is directly in <worldbody>".to_owned();
                        let help = "put the joint into the <body> that it moves";
                        self.context.error("mjcf", message, &item.element.place(), help);
                    }
                    _ => {}
                }
            }
            open.extend(bodies_of(items, GROUND));
        }
        open.reverse();
        while let Some(pending) = open.pop() {
            let below = self.read_body(&pending);
            open.extend(below.into_iter().rev());
        }
    }

    /// Lists the elements in a body or in the world; nested `frame` elements are replaced by their
    /// content.
    fn items<'e>(&self, element: &'e Element, class: Option<&'e str>) -> Vec<Item<'e>> {
        let mut items = Vec::new();
        let below = |element: &'e Element, frame: Pose<f64>, class: Option<&'e str>| {
            element.children.iter().rev().map(move |element| Item { element, frame, class })
        };
        let mut open: Vec<Item<'e>> = below(element, Pose::identity(), class).collect();
        while let Some(item) = open.pop() {
            if item.element.tag == "frame" {
                let frame = item.frame * self.settings.pose(self.context, item.element);
                let class = item.element.get("childclass").or(item.class);
                open.extend(below(item.element, frame, class));
            } else {
                items.push(item);
            }
        }
        items
    }

    fn read_site(&mut self, item: &Item<'_>, body: usize) {
        let site = self.defaults.applied(self.context, item.element, item.class);
        let Some(name) = site.get("name") else { return };
        let pose = match site.numbers::<6>(self.context, "fromto") {
            Some([a, b, c, d, e, f]) => pose_of_ends([Vec3::new(a, b, c), Vec3::new(d, e, f)]),
            None => self.settings.pose(self.context, &site),
        };
        self.sites.insert(name.to_owned(), (body, item.frame * pose));
    }

    /// Reads a body and returns its child bodies.
    fn read_body<'e>(&mut self, pending: &Pending<'e>) -> Vec<Pending<'e>> {
        let Pending { element, parent, frame, class } = *pending;
        let class = element.get("childclass").or(class);
        let name = match element.get("name") {
            Some(name) => name.to_owned(),
            None => format!("body{}", self.robot.bodies.len()),
        };
        let in_parent = frame * self.settings.pose(self.context, element);
        let items = self.items(element, class);
        let is_held = element.get("mocap") == Some("true");
        if is_held {
            let message = "a body that a program moves (mocap) is fixed at its initial pose";
            self.context.note(message, Some(element.place()));
        }
        if element.number(self.context, "gravcomp").is_some_and(|part| part != 0.0) {
            let message =
                "gravity compensation (gravcomp) is left out: the actuators carry the whole weight";
            self.context.warn(message, Some(element.place()));
        }
        let joint = |item: &&Item<'_>| matches!(item.element.tag.as_str(), "joint" | "freejoint");
        let joints: Vec<(Element, Pose<f64>)> = items
            .iter()
            .filter(joint)
            .filter(|_| !is_held)
            .map(|item| (self.defaults.applied(self.context, item.element, item.class), item.frame))
            .collect();
        let pose = self.poses[parent] * in_parent;
        // The ground of a model written by this program: a body of the world without joints and mass.
        if name == GROUND_NAME && parent == GROUND && joints.is_empty() && is_bare(&items) {
            self.bodies.insert(name, GROUND);
            for item in items.iter().filter(|item| item.element.tag == "site") {
                self.read_site(&Item { frame: in_parent * item.frame, ..*item }, GROUND);
            }
            let mut below = bodies_of(items, GROUND);
            below.iter_mut().for_each(|body| body.frame = in_parent * body.frame);
            return below;
        }
        // The intermediate bodies between several joints of one body come before the body itself.
        let between = self.read_joints(&joints, (parent, in_parent), &name, element);
        let is_fixed = joints.is_empty() && self.fixed[parent];
        let mass = self.mass_of(element, (&name, is_fixed), &items);
        let mut body = Body::massless(name.clone(), Some(element.place()));
        (body.mass, body.com, body.inertia) = (mass.mass, mass.com, mass.inertia);
        body.visuals = items
            .iter()
            .filter_map(|item| self.visual_of((item.element, item.frame), item.class))
            .collect();
        let index = self.robot.bodies.len();
        self.robot.bodies.push(body);
        self.poses.push(pose);
        self.fixed.resize(index, false);
        self.fixed.push(is_fixed);
        if let Some(last) = between.last() {
            self.robot.joints[*last].to = index;
        }
        // Nothing can refer to a body without a name.
        let is_named = element.attribute("name").is_some();
        if is_named && self.bodies.insert(name.clone(), index).is_some() {
            let message = format!("there are two bodies named {}", quoted(&name));
            self.context.error("name", message, &element.place(), "");
        }
        for item in items.iter().filter(|item| item.element.tag == "site") {
            self.read_site(item, index);
        }
        bodies_of(items, index)
    }

    /// Mass of a body from its `inertial` element or from its geoms.
    fn mass_of(
        &mut self,
        element: &Element,
        (name, is_fixed): (&str, bool),
        items: &[Item<'_>],
    ) -> Mass {
        let inertial = items.iter().find(|item| item.element.tag == "inertial");
        let from_geoms = match self.settings.from_geoms {
            FromGeoms::Always => true,
            FromGeoms::Never => false,
            FromGeoms::Missing => inertial.is_none(),
        };
        let mass = match from_geoms {
            true => {
                let geoms = items.iter().filter(|item| item.element.tag == "geom");
                geoms.fold(Mass::none(), |sum, item| {
                    let geom = self.defaults.applied(self.context, item.element, item.class);
                    sum.with(self.geom_mass(&geom, name, is_fixed).placed(item.frame))
                })
            }
            false => Mass::none(),
        };
        // If no geom has mass, the body keeps its `inertial`.
        let mass = match inertial.filter(|_| mass.mass == 0.0) {
            Some(item) => self.read_inertial(item).placed(item.frame),
            None => mass,
        };
        if mass.mass < 0.0 {
            let message = negative_mass("body", name, mass.mass);
            self.context.error("mass", message, &element.place(), "masses are at least 0 kg");
        }
        self.bounded(mass)
    }

    fn read_inertial(&self, item: &Item<'_>) -> Mass {
        let (context, element) = (self.context, item.element);
        let mass = element.number(context, "mass").unwrap_or(0.0);
        let pose = self.settings.pose(context, element);
        let inertia = match element.numbers::<6>(context, "fullinertia") {
            Some(entries) => symmetric(entries),
            None => {
                let diagonal = element.numbers::<3>(context, "diaginertia");
                Mat3::diagonal(Vec3::from(diagonal.unwrap_or([0.0; 3])))
            }
        };
        Mass { mass, com: Vec3::zero(), inertia }.placed(pose)
    }

    /// Applies the minimum mass and inertia, and balances the inertia, if the compiler settings require it.
    fn bounded(&self, mut mass: Mass) -> Mass {
        let settings = &self.settings;
        mass.mass = mass.mass.max(settings.least_mass);
        if settings.least_inertia <= 0.0 && !settings.balance_inertia {
            return mass;
        }
        let eigen = SymmetricEigen::new(Matrix3::from(mass.inertia));
        let mut moments = eigen.eigenvalues.map(|moment| moment.max(settings.least_inertia));
        let sum: f64 = moments.sum();
        let exceeds = moments.iter().any(|moment| sum - moment < *moment);
        if settings.balance_inertia && exceeds {
            moments.fill(sum / 3.0);
        }
        if moments != eigen.eigenvalues {
            let axes = &eigen.eigenvectors;
            mass.inertia = Mat3::from(axes * Matrix3::from_diagonal(&moments) * axes.transpose());
        }
        mass
    }
}

/// Tests if no element of a body has mass.
fn is_bare(items: &[Item<'_>]) -> bool {
    let mass = |item: &Item<'_>| match item.element.tag.as_str() {
        "inertial" => item.element.get("mass") != Some("0"),
        "geom" => true,
        _ => false,
    };
    !items.iter().any(mass)
}

fn bodies_of(items: Vec<Item<'_>>, parent: usize) -> Vec<Pending<'_>> {
    let bodies = items.into_iter().filter(|item| item.element.tag == "body");
    bodies.map(|Item { element, frame, class }| Pending { element, parent, frame, class }).collect()
}
