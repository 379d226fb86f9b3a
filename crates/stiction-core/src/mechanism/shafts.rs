//! Separate shafts of motors that share the efforts of joints. Simulations add these shafts to the
//! mechanism to model the friction of the motors.
//!
//! Equation (G13) of the book's theory.

use super::drive_train::Group;
use super::gearing::closing_joint;
use super::{Body, BodyId, GearedDof, Gearing, Joint, JointId, Mechanism, MotorMap};
use crate::joint::JointType;
use crate::spatial::{Mat3, Pose, Vec3};

/// Motor that has its own shaft in simulations.
#[derive(Clone, Debug)]
pub(crate) struct MotorShaft {
    /// Joint of the shaft, whose coordinate is the output coordinate of the motor's gear.
    pub(crate) joint: JointId,
    /// First of the joints driven by the motor, in the order of the drive train's declaration.
    pub(crate) moved: JointId,
    /// Map from the efforts of the actuators to the effort at the output of the motor's gear, in
    /// the mechanism without separate shafts.
    pub(crate) motor: MotorMap,
}

impl Mechanism {
    /// Returns a flag for each drive train: `true` if simulations give its motor a separate shaft,
    /// see [`Group::needs_shafts`].
    pub(crate) fn trains_on_shafts(&self) -> Vec<bool> {
        let trains = self.drive_trains();
        let mut on_shaft = vec![false; trains.len()];
        for group in Group::all(trains).iter().filter(|group| group.needs_shafts(trains)) {
            group.trains.iter().for_each(|&train| on_shaft[train] = true);
        }
        on_shaft
    }

    /// Returns a copy of the mechanism in which each motor selected by [`Self::trains_on_shafts`]
    /// has a massless shaft of its own, which is appended to the bodies and joints. Each of these
    /// motors drives only its shaft, and a gearing connects the shaft with the joints that the
    /// motor drove before. If this creates a loop of geared joints only, a massless body with a
    /// fixed joint divides the loop. Returns `None` if no motor needs a shaft.
    pub(crate) fn with_shafts(&self) -> Option<(Self, Vec<MotorShaft>)> {
        let on_shaft = self.trains_on_shafts();
        if !on_shaft.contains(&true) {
            return None;
        }
        let mut other = self.clone();
        let mut shafts = Vec::new();
        for ((k, motor), _) in self
            .motor_maps()
            .into_iter()
            .enumerate()
            .zip(on_shaft)
            .filter(|(_, on_shaft)| *on_shaft)
        {
            let train = &self.drive_trains[k];
            let moved = train.dofs.first()?.joint;
            let joint = JointId(other.joints.len());
            let geared = |joint: JointId, dof: usize, coefficient: f64| {
                let translates = self.joints[joint.0].joint_type.dofs()[dof].translates();
                GearedDof { joint, dof, coefficient, translates }
            };
            let mut dofs: Vec<GearedDof> =
                train.output_parts().map(|(joint, dof, part)| geared(joint, dof, part)).collect();
            let translates = train.translates();
            dofs.push(GearedDof { joint, dof: 0, coefficient: -1.0, translates });
            let name = format!("{}.motor", train.name);
            other.gearings.push(Gearing { name: name.clone(), dofs, offset: 0.0 });
            let body = BodyId(other.bodies.len());
            other.bodies.push(massless(name.clone()));
            let joint_type = if translates { JointType::Prismatic } else { JointType::Revolute };
            other.joints.push(added_joint(name, joint_type, (BodyId::GROUND, body)));
            let train = &mut other.drive_trains[k];
            train.dofs = vec![GearedDof { joint, dof: 0, coefficient: 1.0, translates }];
            train.share = 1.0;
            shafts.push(MotorShaft { joint, moved, motor });
        }
        while let Some((_, joint)) =
            closing_joint(&other.gearings, (other.bodies.len(), &other.joints))
        {
            other.divide_successor(joint);
        }
        Some((other, shafts))
    }

    /// Inserts a massless body between a joint and its successor. A fixed joint connects the new
    /// body with the successor.
    fn divide_successor(&mut self, joint: JointId) {
        let body = BodyId(self.bodies.len());
        let divided = &mut self.joints[joint.0];
        let successor = std::mem::replace(&mut divided.successor, body);
        let name = format!("{}.divided", divided.name);
        self.bodies.push(massless(name.clone()));
        self.joints.push(added_joint(name, JointType::Fixed, (body, successor)));
    }
}

fn massless(name: String) -> Body {
    Body { name, mass: 0.0, com: Vec3::zero(), inertia: Mat3::zero() }
}

/// Creates a joint without friction whose frames J and K coincide with the frames of its bodies.
fn added_joint(
    name: String,
    joint_type: JointType,
    (predecessor, successor): (BodyId, BodyId),
) -> Joint {
    Joint {
        name,
        joint_type,
        predecessor,
        successor,
        frame_j: Pose::identity(),
        frame_k: Pose::identity(),
        pitch: 0.0,
        actuated: vec![false; joint_type.dofs().len()],
        // No start coordinate is required, because the constraints determine the coordinate.
        start: None,
        friction: Vec::new(),
        compliance: None,
        ranges: Vec::new(),
    }
}
