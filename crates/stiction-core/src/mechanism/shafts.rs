//! Shafts of motors that move several joints together: what simulations of their friction add to the mechanism.
//!
//! Equation (G13) of the book's theory.

use super::gearing::check_loops;
use super::{Body, BodyId, GearedDof, Gearing, Joint, JointId, Mechanism, MotorMap};
use crate::joint::JointType;
use crate::spatial::{Mat3, Pose, Vec3};

/// Motor with a shaft of its own.
#[derive(Clone, Debug)]
pub(crate) struct MotorShaft {
    /// Joint of the shaft, whose coordinate is the output coordinate of the motor's gear.
    pub(crate) joint: JointId,
    /// First of the joints that the motor moves.
    pub(crate) moved: JointId,
    /// Effort of the motor as part of the efforts of the actuators.
    pub(crate) motor: MotorMap,
}

impl Mechanism {
    /// For each drive train whether simulations give it a shaft of its own: motors of several joints with friction in
    /// motor or gear, and motors that share efforts with them, directly or through others.
    pub(crate) fn trains_on_shafts(&self) -> Vec<bool> {
        let trains = self.drive_trains();
        let mut on_shaft: Vec<bool> =
            trains.iter().map(|train| train.only_dof().is_none() && train.has_friction()).collect();
        let moves_together = |a: usize, b: usize| {
            trains[a].dofs.iter().any(|driven| trains[b].moves(driven.joint, driven.dof))
        };
        loop {
            let joins = |k: usize| {
                (0..trains.len()).any(|other| on_shaft[other] && moves_together(k, other))
            };
            let Some(next) = (0..trains.len()).find(|&k| !on_shaft[k] && joins(k)) else {
                return on_shaft;
            };
            on_shaft[next] = true;
        }
    }

    /// Returns the mechanism with massless shafts for the motors of [`Self::trains_on_shafts`], after all other bodies and
    /// joints. Each motor drives its shaft alone, and a gearing connects the shaft with the joints. `None` if no motor
    /// needs a shaft, or if all joints of a loop would be geared.
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
            other.bodies.push(Body {
                name: name.clone(),
                mass: 0.0,
                com: Vec3::zero(),
                inertia: Mat3::zero(),
            });
            let joint_type = if translates { JointType::Prismatic } else { JointType::Revolute };
            other.joints.push(Joint {
                name,
                joint_type,
                predecessor: BodyId::GROUND,
                successor: body,
                frame_j: Pose::identity(),
                frame_k: Pose::identity(),
                pitch: 0.0,
                actuated: vec![false],
                // The gearing determines it.
                start: None,
                friction: Vec::new(),
                compliance: None,
                ranges: Vec::new(),
            });
            let train = &mut other.drive_trains[k];
            train.dofs = vec![GearedDof { joint, dof: 0, coefficient: 1.0, translates }];
            train.share = 1.0;
            shafts.push(MotorShaft { joint, moved, motor });
        }
        let mut defects = Vec::new();
        check_loops(&other.gearings, (other.bodies.len(), &other.joints), &mut defects);
        defects.is_empty().then_some((other, shafts))
    }
}
