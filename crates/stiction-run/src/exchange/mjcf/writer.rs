//! Writer of an MJCF file, with the functions for the beginning of the file and for its bodies.

use super::inertia;
use super::parts::{NamedPart, NamedStep, named};
use super::sites::Sites;
use super::steps::Kind;
use super::tree::Tree;
use crate::exchange::xml::{Xml, numbers};
use crate::exchange::{Home, damping};
use stiction_core::mechanism::{BodyId, GROUND_NAME, Joint};
use stiction_core::spatial::{Pose, Quaternion};

/// Time step, s, that the file sets for simulations in MuJoCo: half the time constant of the
/// equality constraints, as MuJoCo requires.
const TIMESTEP: f64 = 0.001;

/// Writer of an MJCF file, with the XML text written so far and the names of the exported elements.
pub(super) struct Writer<'a> {
    pub(super) home: &'a Home<'a>,
    pub(super) tree: &'a Tree,
    pub(super) xml: Xml,
    pub(super) parts: Vec<NamedPart>,
    pub(super) sites: Sites,
}

impl<'a> Writer<'a> {
    pub(super) fn new(home: &'a Home<'a>, tree: &'a Tree) -> Self {
        let sites = Sites::new(&home.model.mechanism, tree);
        Self { home, tree, xml: Xml::default(), parts: named(home, tree), sites }
    }

    pub(super) fn joint(&self, index: usize) -> &'a Joint {
        &self.home.model.mechanism.joints()[index]
    }

    /// Returns the text of the whole file, which contains `notes` as comments.
    pub(super) fn write(mut self, notes: &[String]) -> String {
        let mechanism = &self.home.model.mechanism;
        self.xml.open("mujoco", &[("model", self.home.model.name.clone())]);
        let title = &*self.home.model.title;
        let made = format!("Written by stiction {}. SI units.", env!("CARGO_PKG_VERSION"));
        let lines: Vec<&str> = [title, &made].into_iter().filter(|l| !l.is_empty()).collect();
        self.xml.comment(&lines);
        self.xml.comment(&[
            "Body frames and joint coordinates (qpos) are those of the model. A ball's qpos is",
            "the rotation of its body since the home position, in the body's axes. The file's own",
            "position (qpos0) is the home position, in which the mechanism is assembled at the start of a motion.",
        ]);
        for note in notes {
            self.xml.comment(&[&format!("Note: {note}.")]);
        }
        self.xml.empty(
            "compiler",
            &[
                ("angle", "radian".into()),
                ("autolimits", "false".into()),
                ("inertiafromgeom", "false".into()),
            ],
        );
        let gravity = numbers(&mechanism.gravity().to_array());
        self.xml.empty("option", &[("gravity", gravity), ("timestep", numbers(&[TIMESTEP]))]);
        self.write_bodies();
        self.write_equalities();
        self.write_tendons();
        self.write_drives();
        self.write_keyframe();
        self.write_extensions();
        self.xml.finish()
    }

    fn write_bodies(&mut self) {
        self.xml.open("worldbody", &[]);
        let base = self.xml.depth();
        // The ground is a separate body, because some programs read only the first body of the
        // world.
        let mut attributes = vec![("name", GROUND_NAME.to_owned())];
        attributes.extend(placed(self.home.model.mechanism.base()));
        self.xml.open("body", &attributes);
        self.xml.empty("inertial", &massless());
        self.write_sites(BodyId::GROUND.0, None);
        for index in (0..self.tree.parts.len()).filter(|part| !self.tree.parts[*part].is_between) {
            while self.xml.depth() > base + self.tree.parts[index].depth {
                self.xml.close();
            }
            self.write_part(index);
        }
        while self.xml.depth() >= base {
            self.xml.close();
        }
    }

    fn write_part(&mut self, index: usize) {
        let (home, part) = (self.home, &self.tree.parts[index]);
        let mechanism = &home.model.mechanism;
        let body = &mechanism.bodies()[part.body];
        let in_parent = match part.is_free {
            true => home.poses[part.body],
            false => home.poses[part.parent].inverse() * home.poses[part.body],
        };
        let mut attributes = vec![("name", self.parts[index].name.clone())];
        attributes.extend(placed(in_parent));
        self.xml.open("body", &attributes);
        if body.mass > 0.0 {
            let (length, count) = (mechanism.characteristic_length(), self.tree.count[part.body]);
            let share = 1.0 / count as f64;
            let (inertia, _) = inertia::accepted(body, length, count);
            let entry = |(i, j)| inertia.at(i, j) * share;
            let entries = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(entry);
            self.xml.empty(
                "inertial",
                &[
                    ("pos", numbers(&body.com.to_array())),
                    ("mass", numbers(&[body.mass * share])),
                    ("fullinertia", numbers(&entries)),
                ],
            );
        } else {
            self.xml.empty("inertial", &massless());
        }
        for &before in &part.before {
            // The joints of the massless body before this one move it too; they are seen from it in the home position.
            let between = home.poses[self.tree.parts[before].body];
            self.write_steps(before, home.poses[part.body].inverse() * between);
        }
        self.write_steps(index, Pose::identity());
        self.write_sites(part.body, part.is_further.then_some(part.joint));
    }

    /// Writes the MJCF joints of a part. `seen` is the pose of the part's frame in the MJCF body that has these joints.
    fn write_steps(&mut self, index: usize, seen: Pose<f64>) {
        let part = &self.tree.parts[index];
        let joint = self.joint(part.joint);
        let NamedPart { free, steps, .. } = &self.parts[index];
        if let Some(name) = free {
            self.xml.empty("freejoint", &[("name", name.clone())]);
        }
        let damping = damping::damping(joint);
        for NamedStep { step, name } in steps {
            let kind = match step.kind {
                Kind::Hinge => "hinge",
                Kind::Slide => "slide",
                Kind::Ball => "ball",
            };
            let mut attributes = vec![("name", name.clone()), ("type", kind.into())];
            attributes.push(("pos", numbers(&seen.apply(step.position).to_array())));
            if step.kind != Kind::Ball {
                attributes.push(("axis", numbers(&(seen.rotation * step.axis).to_array())));
                attributes.push(("ref", numbers(&[step.home])));
            }
            let damping = step.dof.map_or(0.0, |dof| damping[dof]);
            let trains = self.home.model.mechanism.drive_trains().iter();
            let own = trains.filter(|train| {
                train.only_dof().is_some_and(|(j, dof)| j.0 == part.joint && Some(dof) == step.dof)
            });
            let (mut armature, mut constant, mut damping) = (0.0, 0.0, damping);
            for train in own {
                let (n, friction) = (train.transmission().abs(), train.motor_friction);
                armature += train.reflected_inertia();
                constant += n * friction.constant;
                damping += n * n * friction.viscous;
            }
            let of_motors = [("armature", armature), ("frictionloss", constant)];
            for (key, value) in of_motors.into_iter().filter(|(_, value)| *value > 0.0) {
                attributes.push((key, numbers(&[value])));
            }
            let mut springs = self.home.model.mechanism.joint_springs().iter();
            let spring = springs
                .find(|spring| spring.joint.0 == part.joint && Some(spring.dof) == step.dof)
                .filter(|_| step.kind != Kind::Ball);
            if let Some(spring) = spring {
                damping += spring.damping;
                if spring.stiffness > 0.0 {
                    let rest = spring.rest + spring.preload / spring.stiffness;
                    attributes.push(("stiffness", numbers(&[spring.stiffness])));
                    attributes.push(("springref", numbers(&[rest])));
                }
            }
            if damping > 0.0 {
                attributes.push(("damping", numbers(&[damping])));
            }
            self.xml.empty("joint", &attributes);
        }
    }

    /// Writes the sites of a body. If the body is split, `part` is the joint that carries the part
    /// whose sites are written; `None` selects the first part.
    fn write_sites(&mut self, body: usize, part: Option<usize>) {
        for site in self.sites.of_body[body].iter().filter(|site| site.part == part) {
            let mut attributes = vec![("name", site.name.clone())];
            attributes.extend(placed(site.pose));
            self.xml.empty("site", &attributes);
        }
    }
}

/// Returns the attributes of a zero inertia. The file contains them because some programs require
/// an inertia for every body.
fn massless() -> [(&'static str, String); 3] {
    let zeros = numbers(&[0.0; 3]);
    [("pos", zeros.clone()), ("mass", numbers(&[0.0])), ("diaginertia", zeros)]
}

fn placed(pose: Pose<f64>) -> [(&'static str, String); 2] {
    let Pose { position, .. } = pose;
    [("pos", numbers(&position.to_array())), ("quat", numbers(&quaternion(pose)))]
}

pub(super) fn quaternion(pose: Pose<f64>) -> [f64; 4] {
    let mut quaternion = [0.0; 4];
    Quaternion::from_rotation(pose.rotation).write(&mut quaternion);
    quaternion
}
