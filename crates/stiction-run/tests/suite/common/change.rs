//! Changes of the description of a mechanism that must not affect results.

use stiction_core::joint::JointType;
use stiction_core::mechanism::{BodySpec, JointSpec, Mechanism, MechanismBuilder};
use stiction_core::spatial::Pose;

/// Change of the description of a mechanism: lengths multiplied by `scale`, another base, other
/// names.
pub(crate) struct Change {
    pub(crate) scale: f64,
    pub(crate) base: Option<Pose<f64>>,
    pub(crate) rename: bool,
}

pub(crate) const NONE: Change = Change { scale: 1.0, base: None, rename: false };

impl Change {
    pub(crate) fn name(&self, kind: char, index: usize, name: &str) -> String {
        // The new names also have another alphabetical order.
        if self.rename { format!("{kind}{}", 99 - index) } else { name.to_owned() }
    }

    pub(crate) fn mechanism(&self, old: &Mechanism) -> Mechanism {
        let s = self.scale;
        let scaled = |pose: Pose<f64>| Pose { position: pose.position * s, ..pose };
        let base = self.base.map_or(old.base(), |base| base * old.base());
        let mut builder =
            MechanismBuilder::new(old.name()).gravity(old.gravity() * s).base(scaled(base));
        let name = |index: usize| match index {
            0 => "ground".to_owned(),
            _ => self.name('b', index, &old.bodies()[index].name),
        };
        for (index, body) in old.bodies().iter().enumerate().skip(1) {
            let spec = BodySpec::new(name(index)).mass(body.mass).com(body.com * s);
            builder = builder.body(spec.inertia(body.inertia * (s * s)));
        }
        for (index, joint) in old.joints().iter().enumerate() {
            let (from, to) = (name(joint.predecessor.0), name(joint.successor.0));
            let spec =
                JointSpec::new(self.name('j', index, &joint.name), joint.joint_type, from, to)
                    .frames(scaled(joint.frame_j), scaled(joint.frame_k))
                    .pitch(joint.pitch * s)
                    .actuated_dofs(joint.actuated_dofs().collect::<Vec<_>>());
            let lengths = match joint.joint_type {
                JointType::Prismatic => 0..1,
                JointType::Cylindrical => 1..2,
                JointType::Planar => 0..2,
                JointType::Free => 0..3,
                _ => 0..0,
            };
            builder = builder.joint(match joint.start.clone() {
                None => spec,
                Some(mut start) => {
                    start[lengths].iter_mut().for_each(|length| *length *= s);
                    spec.start(start)
                }
            });
        }
        builder.build().unwrap()
    }
}
