//! Reads the initial configuration from a keyframe of an MJCF file.

use super::super::rotation;
use super::super::xml::Element;
use super::Reader;
use crate::diagnostic::quoted;
use stiction_core::joint::JointType;
use stiction_core::spatial::{Mat3, Pose, Vec3};

impl Reader<'_, '_> {
    /// Sets the initial coordinates to those of the keyframe `home`, or else of the first keyframe
    /// with coordinates.
    pub(super) fn read_keyframe(&mut self, root: &Element) -> Option<()> {
        let keys = || root.all("keyframe").flat_map(|all| all.all("key"));
        let has_position = |key: &&Element| key.attribute("qpos").is_some();
        let home = keys().filter(has_position).find(|key| key.get("name") == Some("home"));
        let key = home.or_else(|| keys().find(has_position))?;
        let values = key.list(self.context, "qpos")?;
        let size = |index: &usize| match self.robot.joints[*index].kind {
            JointType::Free => 7,
            JointType::Spherical => 4,
            _ => 1,
        };
        let expected: usize = self.order.iter().map(size).sum();
        if values.len() != expected {
            let message =
                format!("the keyframe has {} coordinates instead of {expected}", values.len());
            let help = "give one for each hinge and slide, 4 for a ball, 7 for a free joint";
            self.context.error("keyframe", message, &key.place(), help);
            return None;
        }
        let mut rest = values.as_slice();
        let mut take = |count: usize| {
            let (taken, left) = rest.split_at(count.min(rest.len()));
            rest = left;
            taken
        };
        for index in self.order.clone() {
            let joint = &mut self.robot.joints[index];
            let turn = |q: &[f64]| {
                let q: Option<[f64; 4]> = q.try_into().ok();
                q.and_then(rotation::quaternion).unwrap_or(Mat3::identity())
            };
            match joint.kind {
                JointType::Free => {
                    let q = take(7);
                    let position = Vec3::new(q[0], q[1], q[2]);
                    joint.start = Some(Pose { position, rotation: turn(&q[3..]) });
                }
                JointType::Spherical => {
                    let rotation = turn(take(4));
                    joint.start = Some(Pose { position: Vec3::zero(), rotation });
                }
                _ => {
                    if let ([dof], [value]) = (joint.dofs.as_mut_slice(), take(1)) {
                        dof.position = *value;
                    }
                }
            }
        }
        self.robot.position = "the keyframe";
        if let Some(name) = key.get("name") {
            let message = format!("the robot starts at the keyframe {}", quoted(name));
            self.context.note(message, Some(key.place()));
        }
        Some(())
    }
}
