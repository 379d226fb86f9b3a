//! Names of actuators, joints, bodies and friction interfaces, and look-up by name.

use crate::error::Error;
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_format::did_you_mean;

/// Names of the parts of a mechanism. Each list has the order of the corresponding results.
#[derive(Debug)]
pub(crate) struct Names {
    /// Short name (`leg1.P`) and full name of each actuator; the full name ends in the name of the
    /// degree of freedom if the joint has several.
    pub(crate) actuators: Vec<(String, String)>,
    /// Name of each drive train.
    pub(crate) motors: Vec<String>,
    /// Name of each rigid gearing.
    pub(crate) gearings: Vec<String>,
    pub(crate) joints: Vec<String>,
    pub(crate) bodies: Vec<String>,
    /// Scalar joint coordinates: name, joint, index of the degree of freedom.
    pub(crate) coordinates: Vec<(String, JointId, usize)>,
    /// Name of each friction interface: the name of the joint, followed by that of the interface if
    /// the joint has several.
    pub(crate) interfaces: Vec<String>,
    /// Name of each friction interface in a simulation: the friction interfaces of the joints,
    /// followed by the motor shafts with friction.
    pub(crate) with_shafts: Vec<String>,
}

impl Names {
    pub(crate) fn new(mechanism: &Mechanism) -> Self {
        let joints = mechanism.joints();
        let actuators = mechanism
            .actuators()
            .map(|(id, dof)| (joints[id.0].actuator_name(dof), joints[id.0].dof_name(dof)))
            .collect();
        let mut coordinates = Vec::new();
        let mut interfaces = Vec::new();
        for (index, joint) in joints.iter().enumerate() {
            if joint.joint_type.has_scalar_coordinates() {
                let dofs = 0..joint.joint_type.dofs().len();
                coordinates.extend(dofs.map(|dof| (joint.dof_name(dof), JointId(index), dof)));
            }
            interfaces.extend(joint.interface_names());
        }
        let shafts = mechanism.shafts_with_friction();
        let shafts = shafts.into_iter().map(|shaft| format!("{}.motor", shaft.name));
        let with_shafts = interfaces.iter().cloned().chain(shafts).collect();
        Self {
            actuators,
            motors: mechanism.drive_trains().iter().map(|train| train.name.clone()).collect(),
            gearings: mechanism.gearings().iter().map(|gearing| gearing.name.clone()).collect(),
            joints: joints.iter().map(|joint| joint.name.clone()).collect(),
            bodies: mechanism.bodies().iter().map(|body| body.name.clone()).collect(),
            coordinates,
            interfaces,
            with_shafts,
        }
    }

    /// Index of an actuator.
    pub(crate) fn actuator(&self, name: &str) -> Result<usize, Error> {
        match self.actuators.iter().position(|(_, full)| full == name) {
            Some(index) => Ok(index),
            None => find("actuator", name, self.actuators.iter().map(|(short, _)| short)),
        }
    }

    /// Index of a drive train.
    pub(crate) fn motor(&self, name: &str) -> Result<usize, Error> {
        if self.motors.is_empty() {
            return Err(Error::input("the model has no drive trains")
                .with_help("add a table such as [actuators.motor]"));
        }
        find("drive train", name, &self.motors)
    }

    /// Index of a gearing.
    pub(crate) fn gearing(&self, name: &str) -> Result<usize, Error> {
        find("gearing", name, &self.gearings)
    }

    /// Index of a joint.
    pub(crate) fn joint(&self, name: &str) -> Result<usize, Error> {
        find("joint", name, &self.joints)
    }

    /// Index of a body; the ground is body 0.
    pub(crate) fn body(&self, name: &str) -> Result<usize, Error> {
        find("body", name, &self.bodies)
    }

    /// Index of a scalar joint coordinate.
    pub(crate) fn coordinate(&self, name: &str) -> Result<usize, Error> {
        find("joint coordinate", name, self.coordinates.iter().map(|(name, ..)| name))
    }

    /// Index of a friction interface of a joint, by its name.
    pub(crate) fn interface(&self, name: &str) -> Result<usize, Error> {
        find_interface(name, &self.interfaces)
    }

    /// Index of a friction interface in a simulation, where motor shafts with friction are
    /// included.
    pub(crate) fn interface_or_shaft(&self, name: &str) -> Result<usize, Error> {
        find_interface(name, &self.with_shafts)
    }
}

fn find_interface(name: &str, interfaces: &[String]) -> Result<usize, Error> {
    if interfaces.is_empty() {
        return Err(Error::input("the model declares no friction in any joint")
            .with_help("add `friction = { mu = 0.1, radius = \"8 mm\" }` to a joint"));
    }
    find("friction interface", name, interfaces)
}

/// Index of `name` in the list `known`. The error for an unknown name suggests the nearest known
/// names; `what` is the kind of object in this message, such as `joint`.
pub(crate) fn find<'a>(
    what: &str,
    name: &str,
    known: impl IntoIterator<Item = &'a String>,
) -> Result<usize, Error> {
    let known: Vec<&str> = known.into_iter().map(String::as_str).collect();
    known.iter().position(|other| *other == name).ok_or_else(|| {
        let help = did_you_mean(name, "known names", known)
            .unwrap_or_else(|| format!("the model has no {what}"));
        Error::input(format!("there is no {what} `{name}`")).with_help(help)
    })
}
