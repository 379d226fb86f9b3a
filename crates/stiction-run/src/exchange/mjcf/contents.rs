//! Elements of an MJCF file that follow the bodies: springs, motors, extension elements and the
//! home pose.

use super::parts::{NamedPart, NamedStep};
use super::steps::Kind;
use super::tree::Part;
use super::writer::{Writer, quaternion};
use crate::exchange::extension::{self, Entry};
use crate::exchange::names::Names;
use crate::exchange::xml::numbers;
use stiction_core::mechanism::{DriveTrain, GearedDof, Gearing, JointId};
use stiction_format::NAMESPACE;
use toml::Value;

impl<'a> Writer<'a> {
    /// Writes the MJCF tendons. They represent springs between sites, and sums of joint coordinates
    /// for gearings of more than two joints and for motors that act on several joints.
    pub(super) fn write_tendons(&mut self) {
        let mechanism = &self.home.model.mechanism;
        let springs = mechanism.springs();
        let (summed, driven) = (self.summed_gearings(), self.motors_of_several());
        if springs.is_empty() && summed.is_empty() && driven.is_empty() {
            return;
        }
        self.xml.open("tendon", &[]);
        for (spring, sites) in springs.iter().zip(&self.sites.of_spring) {
            // A preload is written as a change of the length at zero force. The file omits the
            // preload of a spring without stiffness; a note says so.
            let shift =
                if spring.stiffness > 0.0 { spring.preload / spring.stiffness } else { 0.0 };
            self.xml.open(
                "spatial",
                &[
                    ("name", spring.name.clone()),
                    ("stiffness", numbers(&[spring.stiffness])),
                    ("springlength", numbers(&[spring.free_length + shift])),
                    ("damping", numbers(&[spring.damping])),
                ],
            );
            for site in sites {
                self.xml.empty("site", &[("site", site.clone())]);
            }
            self.xml.close();
        }
        for (name, terms) in &summed {
            self.write_sum(&[("name", format!("{name}.sum"))], terms);
        }
        for (train, terms) in &driven {
            let (n, friction) = (train.transmission().abs(), train.motor_friction);
            let own = [
                ("armature", train.reflected_inertia()),
                ("frictionloss", n * friction.constant),
                ("damping", n * n * friction.viscous),
            ];
            let own = own.into_iter().filter(|(_, value)| *value > 0.0);
            let mut attributes = vec![("name", format!("{}.sum", train.name))];
            attributes.extend(own.map(|(key, value)| (key, numbers(&[value]))));
            self.write_sum(&attributes, terms);
        }
        self.xml.close();
    }

    fn write_sum(&mut self, attributes: &[(&'static str, String)], terms: &[(String, f64)]) {
        self.xml.open("fixed", attributes);
        for (joint, part) in terms {
            let coef = ("coef", numbers(&[*part]));
            self.xml.empty("joint", &[("joint", joint.clone()), coef]);
        }
        self.xml.close();
    }

    /// Lists the gearings of more than two joints. Each entry contains the name of the gearing, and
    /// the names of its MJCF joints with their coefficients.
    pub(super) fn summed_gearings(&self) -> Vec<(String, Vec<(String, f64)>)> {
        let gearings = self.home.model.mechanism.gearings().iter();
        let terms = |gearing: &Gearing| {
            let term = |dof: &GearedDof| {
                Some((self.step_of(dof.joint, dof.dof)?.name.clone(), dof.coefficient))
            };
            let terms: Option<Vec<_>> = gearing.dofs.iter().map(term).collect();
            Some((gearing.name.clone(), terms?))
        };
        gearings.filter(|gearing| gearing.dofs.len() > 2).filter_map(terms).collect()
    }

    /// Lists the motors that act on several joints, each with the names of its MJCF joints and
    /// their coefficients.
    fn motors_of_several(&self) -> Vec<(&'a DriveTrain, Vec<(String, f64)>)> {
        let trains = self.home.model.mechanism.drive_trains().iter();
        let terms = |train: &'a DriveTrain| {
            let parts = train.output_parts();
            let term = |(joint, dof, part)| Some((self.step_of(joint, dof)?.name.clone(), part));
            parts.map(term).collect::<Option<Vec<_>>>()
        };
        trains
            .filter(|train| train.only_dof().is_none())
            .filter_map(|train| Some((train, terms(train)?)))
            .collect()
    }

    /// Finds the MJCF joint that represents a degree of freedom. `None` if the file has no such
    /// MJCF joint, as for a spherical joint that closes a loop.
    pub(super) fn step_of(&self, joint: JointId, dof: usize) -> Option<&NamedStep> {
        let steps = self.tree.parts.iter().zip(&self.parts);
        let own = steps.filter(|(part, _)| part.joint == joint.0).flat_map(|(_, own)| &own.steps);
        own.into_iter().find(|named| named.step.dof == Some(dof))
    }

    /// Writes the motors: first those that act on one degree of freedom, in the order of the
    /// actuators, then those that act on several joints.
    pub(super) fn write_drives(&mut self) {
        let mechanism = &self.home.model.mechanism;
        let mut drives = Vec::new();
        let names = crate::names::Names::new(mechanism).drives;
        let mut taken = Names::default();
        for ((joint, dof), (name, _)) in mechanism.actuators().zip(names) {
            let trains = mechanism.drive_trains().iter();
            let trains = trains.filter(|train| train.only_dof() == Some((joint, dof)));
            let of_several =
                |train: &DriveTrain| train.only_dof().is_none() && train.moves(joint, dof);
            if mechanism.drive_trains().iter().any(of_several) {
                continue;
            }
            let mut motors: Vec<(&str, f64)> =
                trains.map(|train| (train.name.as_str(), train.transmission())).collect();
            if motors.is_empty() {
                motors.push((&name, 1.0));
            }
            let named = self.step_of(joint, dof);
            for (name, gear) in motors {
                drives.extend(named.map(|named| (taken.take(name), named.name.clone(), gear)));
            }
        }
        let several: Vec<_> = self
            .motors_of_several()
            .into_iter()
            .map(|(train, _)| (train.name.clone(), train.transmission()))
            .collect();
        if drives.is_empty() && several.is_empty() {
            return;
        }
        self.xml.open("actuator", &[]);
        for (name, joint, gear) in drives {
            let gear = numbers(&[gear]);
            self.xml.empty("motor", &[("name", name), ("joint", joint), ("gear", gear)]);
        }
        for (name, gear) in several {
            let tendon = format!("{name}.sum");
            let gear = numbers(&[gear]);
            self.xml
                .empty("motor", &[("name", taken.take(&name)), ("tendon", tendon), ("gear", gear)]);
        }
        self.xml.close();
    }

    /// Writes the extension elements, which only this program reads, as custom text elements.
    pub(super) fn write_extensions(&mut self) {
        let mechanism = &self.home.model.mechanism;
        let reversed: Vec<usize> = (self.tree.parts.iter())
            .filter_map(|part| part.reversed.then_some(part.joint))
            .collect();
        let mut entries = self.bodies_between();
        entries.extend(self.divided_joints());
        entries.extend(extension::frictions(mechanism));
        entries.extend(extension::default_friction(self.home.model));
        entries.extend(extension::own_springs(mechanism));
        entries.extend(extension::others(mechanism));
        entries.extend(extension::ball_axes(mechanism, &reversed));
        entries.extend(extension::reversed(mechanism, reversed.into_iter()));
        if entries.is_empty() {
            return;
        }
        self.xml.open("custom", &[]);
        for Entry { kind, name, text } in entries {
            let name = format!("{NAMESPACE}/{kind}/{name}");
            // XML does not preserve line breaks in attribute values.
            self.xml.empty("text", &[("name", name), ("data", text.replace('\n', ";;"))]);
        }
        self.xml.close();
    }

    /// Lists the bodies between several joints of an MJCF body, each with the last MJCF joint that carries it.
    fn bodies_between(&self) -> Vec<Entry> {
        let parts = self.tree.parts.iter().zip(&self.parts).filter(|(part, _)| part.is_between);
        let entry = |(part, own): (&Part, &NamedPart)| {
            let name = self.home.model.mechanism.bodies()[part.body].name.clone();
            Some(Entry { kind: "body", name, text: own.steps.last()?.name.clone() })
        };
        parts.filter_map(entry).collect()
    }

    /// Lists the joints that the file describes by several MJCF joints: the type of each, and the names of its MJCF joints
    /// in the order in which they act from frame J to frame K.
    fn divided_joints(&self) -> Vec<Entry> {
        let parts = self.tree.parts.iter().zip(&self.parts);
        let entry = |(part, own): (&Part, &NamedPart)| {
            let joint = self.joint(part.joint);
            let mut names: Vec<&str> = own.steps.iter().map(|step| &*step.name).collect();
            if part.reversed {
                names.reverse();
            }
            let kind = joint.joint_type.symbol();
            let text = format!("type = {}\njoints = {}", Value::from(kind), Value::from(names));
            Entry { kind: "joint", name: joint.name.clone(), text }
        };
        parts.filter(|(_, own)| own.steps.len() > 1).map(entry).collect()
    }

    /// Writes the home pose as a keyframe.
    pub(super) fn write_keyframe(&mut self) {
        let mut qpos = Vec::new();
        for (part, NamedPart { free, steps, .. }) in self.tree.parts.iter().zip(&self.parts) {
            if free.is_some() {
                let pose = self.home.poses[part.body];
                qpos.extend(pose.position.to_array());
                qpos.extend(quaternion(pose));
            }
            for NamedStep { step, .. } in steps {
                match step.kind {
                    Kind::Ball => qpos.extend([1.0, 0.0, 0.0, 0.0]),
                    _ => qpos.push(step.home),
                }
            }
        }
        self.xml.open("keyframe", &[]);
        self.xml.empty("key", &[("name", "home".into()), ("qpos", numbers(&qpos))]);
        self.xml.close();
    }
}
