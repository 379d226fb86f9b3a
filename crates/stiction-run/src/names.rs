//! Names of the elements of a mechanism in columns and messages.

use stiction_core::mechanism::{Gearing, Mechanism};
use stiction_draw::drawing::legs_of_joints;
use stiction_format::ModelFile;

/// Names of actuators, bodies, joints, friction interfaces and gearings in columns and messages.
#[derive(Clone, Debug, Default)]
pub(crate) struct Names {
    /// Name and unit of the effort of each actuator.
    pub(crate) drives: Vec<(String, &'static str)>,
    /// Name of each body.
    pub(crate) bodies: Vec<String>,
    /// Name of each joint.
    pub(crate) joints: Vec<String>,
    /// Name of each friction interface, and index of its joint.
    pub(crate) interfaces: Vec<(String, usize)>,
    /// For each friction interface, true if its friction is a moment and its sliding velocity an
    /// angular velocity, as those of motors that rotate.
    pub(crate) rotates: Vec<bool>,
    /// Name of each gearing, and unit of its effort.
    pub(crate) gearings: Vec<(String, &'static str)>,
    /// Names of the friction interfaces whose law has an internal state. Inverse dynamics computes
    /// only steady sliding for these interfaces.
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
        let (mut interfaces, mut steady) = (Vec::new(), Vec::new());
        for (index, joint) in joints.iter().enumerate() {
            for (friction, name) in joint.friction.iter().zip(joint.interface_names()) {
                let laws = [Some(&friction.law), friction.backward.as_ref()];
                if laws.into_iter().flatten().any(|law| law.bristles.is_some()) {
                    steady.push(name.clone());
                }
                interfaces.push((name, index));
            }
        }
        let gearing = |gearing: &Gearing| {
            (gearing.name.clone(), if gearing.is_length() { "N" } else { "N m" })
        };
        Self {
            drives,
            bodies: mechanism.bodies().iter().map(|body| body.name.clone()).collect(),
            joints: joints.iter().map(|joint| joint.name.clone()).collect(),
            rotates: vec![false; interfaces.len()],
            interfaces,
            gearings: mechanism.gearings().iter().map(gearing).collect(),
            steady,
        }
    }
}

impl Names {
    /// Creates the names like [`Self::new`], with the friction interfaces of motors and gears after
    /// those of the joints. Simulations use this order.
    pub(crate) fn with_shafts(mechanism: &Mechanism) -> Self {
        let mut names = Self::new(mechanism);
        for shaft in mechanism.shafts_with_friction() {
            names.interfaces.push((format!("{}.motor", shaft.name), shaft.joint.0));
            names.rotates.push(shaft.rotates);
        }
        names
    }

    /// Returns the unit of the friction of an interface.
    pub(crate) fn friction_unit(&self, interface: usize) -> &'static str {
        if self.rotates[interface] { "N m" } else { "N" }
    }

    /// Returns the names of columns for each friction interface. `quantities` are those of an
    /// interface at which something slides, with units.
    pub(crate) fn friction_columns(&self, quantities: &[&str]) -> Vec<String> {
        let each = self.interfaces.iter().zip(&self.rotates);
        let columns = each.flat_map(|((name, _), rotates)| {
            quantities.iter().map(move |quantity| match rotates {
                true => {
                    let quantity = quantity.replace("[N]", "[N m]").replace("[m/s]", "[rad/s]");
                    format!("{name}.{quantity}")
                }
                false => format!("{name}.{quantity}"),
            })
        });
        columns.collect()
    }
}

/// Returns the index of the leg of each actuator, which determines the colour of its curves; `None`
/// for actuators outside the legs.
pub(crate) fn legs_of_actuators(mechanism: &Mechanism) -> Vec<Option<usize>> {
    let legs = legs_of_joints(mechanism);
    mechanism.actuators().map(|(joint, _)| legs[joint.0]).collect()
}

/// Returns the index of the leg of each friction interface; `None` for interfaces outside the legs.
pub(crate) fn legs_of_interfaces(mechanism: &Mechanism, names: &Names) -> Vec<Option<usize>> {
    let legs = legs_of_joints(mechanism);
    names.interfaces.iter().map(|(_, joint)| legs[*joint]).collect()
}

/// Returns the width, in characters, of a column that contains `names`; at least `least`.
pub(crate) fn width<'a>(names: impl Iterator<Item = &'a str>, least: usize) -> usize {
    names.map(str::len).fold(least, usize::max)
}

/// Returns the name of a model and its title, which may be empty, on one line.
pub fn heading(name: &str, title: &str) -> String {
    match title {
        "" => name.to_owned(),
        title => format!("{name}: {title}"),
    }
}

/// Returns the name and the title of a model on one line.
pub(crate) fn heading_of(model: &ModelFile) -> String {
    heading(&model.name, &model.title)
}

/// Joins words by commas; an ellipsis replaces the words after the first `most`.
pub(crate) fn listed(words: impl IntoIterator<Item = impl AsRef<str>>, most: usize) -> String {
    let mut text = String::new();
    for (k, word) in words.into_iter().enumerate() {
        text += if k > 0 { ", " } else { "" };
        if k == most {
            return text + "...";
        }
        text += word.as_ref();
    }
    text
}
