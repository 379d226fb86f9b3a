//! Scalar degrees of freedom of joints, with the names that result tables use.

use stiction_core::mechanism::{JointId, Mechanism};

/// A scalar degree of freedom of a joint.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Dof {
    /// Name of the joint, followed by the name of the degree of freedom if the joint has several.
    pub(crate) name: String,
    pub(crate) joint: JointId,
    /// Index of the degree of freedom in its joint.
    pub(crate) index: usize,
    /// True for a displacement, m; false for an angle, rad.
    pub(crate) translates: bool,
    /// Index of the actuator that drives this degree of freedom, if any.
    pub(crate) actuator: Option<usize>,
}

/// Lists all scalar degrees of freedom of a mechanism's joints. Joints without scalar coordinates,
/// such as ball joints, are omitted.
pub(crate) fn dofs_of(mechanism: &Mechanism) -> Vec<Dof> {
    let actuators: Vec<_> = mechanism.actuators().collect();
    let joints = mechanism.joints().iter().enumerate();
    let with_coordinates = joints.filter(|(_, joint)| joint.joint_type.has_scalar_coordinates());
    let dofs = with_coordinates.flat_map(|(id, joint)| {
        let own = joint.joint_type.dofs().iter().enumerate();
        own.map(move |(index, dof)| (JointId(id), index, joint.dof_name(index), dof.translates()))
    });
    let dof = |(joint, index, name, translates)| Dof {
        name,
        joint,
        index,
        translates,
        actuator: actuators.iter().position(|a| *a == (joint, index)),
    };
    dofs.map(dof).collect()
}

/// Returns, for each actuator, the index in `dofs` of the degree of freedom that it drives.
pub(crate) fn actuated(dofs: &[Dof]) -> Vec<usize> {
    let places = dofs.iter().enumerate().filter_map(|(k, dof)| Some((dof.actuator?, k)));
    let mut places: Vec<(usize, usize)> = places.collect();
    places.sort_unstable();
    places.into_iter().map(|(_, k)| k).collect()
}

impl Dof {
    /// Returns the SI units of the coordinate, its rate and its acceleration.
    pub(crate) fn units(&self) -> [&'static str; 3] {
        if self.translates { ["m", "m/s", "m/s^2"] } else { ["rad", "rad/s", "rad/s^2"] }
    }

    /// Returns the column names of the coordinate, its rate and its acceleration.
    pub(crate) fn columns(&self) -> [String; 3] {
        let [position, rate, acceleration] = self.units();
        [("position", position), ("rate", rate), ("acceleration", acceleration)]
            .map(|(quantity, unit)| format!("{}.{quantity} [{unit}]", self.name))
    }
}
