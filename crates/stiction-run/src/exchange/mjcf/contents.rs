//! Elements after the bodies: springs, motors and the home pose.

use super::names::Names;
use super::parts::{NamedPart, NamedStep};
use super::steps::Kind;
use super::writer::{Writer, quaternion};
use super::xml::numbers;

impl Writer<'_> {
    /// Writes springs as tendons between sites.
    pub(super) fn write_springs(&mut self) {
        let springs = self.home.model.mechanism.springs();
        if springs.is_empty() {
            return;
        }
        self.xml.open("tendon", &[]);
        for (spring, sites) in springs.iter().zip(&self.sites.of_spring) {
            self.xml.open(
                "spatial",
                &[
                    ("name", spring.name.clone()),
                    ("stiffness", numbers(&[spring.stiffness])),
                    ("springlength", numbers(&[spring.free_length])),
                    ("damping", numbers(&[spring.damping])),
                ],
            );
            for site in sites {
                self.xml.empty("site", &[("site", site.clone())]);
            }
            self.xml.close();
        }
        self.xml.close();
    }

    /// Writes motors, in the order of the actuators.
    pub(super) fn write_drives(&mut self) {
        let mechanism = &self.home.model.mechanism;
        let mut drives = Vec::new();
        let names = crate::names::Names::new(mechanism).drives;
        let mut taken = Names::default();
        for ((joint, dof), (name, _)) in mechanism.actuators().zip(names) {
            let trains = mechanism.drive_trains().iter();
            let trains = trains.filter(|train| (train.joint, train.dof) == (joint, dof));
            let mut motors: Vec<(&str, f64)> =
                trains.map(|train| (train.name.as_str(), train.transmission())).collect();
            if motors.is_empty() {
                motors.push((&name, 1.0));
            }
            let steps = self.tree.parts.iter().zip(&self.parts);
            let own =
                steps.filter(|(part, _)| part.joint == joint.0).flat_map(|(_, own)| &own.steps);
            let named = own.into_iter().find(|named| named.step.dof == Some(dof));
            for (name, gear) in motors {
                drives.extend(named.map(|named| (taken.take(name), named.name.clone(), gear)));
            }
        }
        if drives.is_empty() {
            return;
        }
        self.xml.open("actuator", &[]);
        for (name, joint, gear) in drives {
            let gear = numbers(&[gear]);
            self.xml.empty("motor", &[("name", name), ("joint", joint), ("gear", gear)]);
        }
        self.xml.close();
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
