//! Names of actuators, joints and friction interfaces in columns and messages.

use stiction_core::friction::interfaces_of;
use stiction_core::mechanism::Mechanism;

/// Names of actuators, joints and friction interfaces in columns and messages.
#[derive(Clone, Debug)]
pub(crate) struct Names {
    /// For each actuator its name and the unit of its effort.
    pub(crate) drives: Vec<(String, &'static str)>,
    /// For each joint its name.
    pub(crate) joints: Vec<String>,
    /// For each friction interface its name and the index of its joint.
    pub(crate) interfaces: Vec<(String, usize)>,
    /// Friction interfaces whose law has an internal state; inverse dynamics computes their steady
    /// sliding only.
    pub(crate) steady: Vec<String>,
}

impl Names {
    pub(crate) fn new(mechanism: &Mechanism) -> Self {
        let joints = mechanism.joints();
        let drives = mechanism
            .actuators()
            .map(|(id, dof)| {
                let joint = &joints[id.0];
                (joint.actuator_name(dof), joint.joint_type.dofs()[dof].units().1)
            })
            .collect();
        let mut steady = Vec::new();
        let interfaces = joints
            .iter()
            .enumerate()
            .flat_map(|(index, joint)| joint.friction.iter().map(move |c| (index, joint, c)))
            .map(|(index, joint, interface)| {
                let place = interfaces_of(joint.joint_type)[interface.place].0;
                let name = if place.is_empty() {
                    joint.name.clone()
                } else {
                    format!("{}.{place}", joint.name)
                };
                let laws = [Some(&interface.law), interface.backward.as_ref()];
                if laws.into_iter().flatten().any(|law| law.bristles.is_some()) {
                    steady.push(name.clone());
                }
                (name, index)
            })
            .collect();
        Self { drives, joints: joints.iter().map(|j| j.name.clone()).collect(), interfaces, steady }
    }
}

/// Width of a column of names, not less than `least`.
pub(crate) fn width<'a>(names: impl Iterator<Item = &'a str>, least: usize) -> usize {
    names.map(str::len).fold(least, usize::max)
}
