//! Shafts that the model adds to the mechanism for motors of several joints, so that their friction is simulated.
//!
//! Equation (G13) of the book's theory.

use super::Forward;
use super::data::Data;
use super::error::ForwardError;
use crate::mechanism::{JointId, Mechanism};
use crate::spatial::Wrench;

impl Forward {
    /// The mechanism that is simulated: with added shafts for motors of several joints that have friction.
    pub(super) fn simulated(&self) -> &Mechanism {
        self.with_shafts.as_ref().map_or(&self.mechanism, |(mechanism, _)| mechanism)
    }

    /// Joint by which results name an interface. If the interface is on an added motor shaft, it is the first joint
    /// that the motor moves.
    pub(super) fn reported_joint(&self, interface: usize) -> JointId {
        let own = JointId(self.parameters.interfaces[interface].joint);
        let shafts = self.with_shafts.iter().flat_map(|(_, shafts)| shafts);
        shafts.filter(|shaft| shaft.joint == own).map(|shaft| shaft.moved).next().unwrap_or(own)
    }

    /// Checks that the friction of every motor of several joints can be simulated.
    ///
    /// # Errors
    /// [`ForwardError::FrictionOfSeveral`].
    pub(super) fn check_motors(&self) -> Result<(), ForwardError> {
        let on_shaft = self.mechanism.trains_on_shafts();
        let trains = self.mechanism.drive_trains().iter().zip(on_shaft);
        for (train, _) in trains.filter(|(_, on_shaft)| *on_shaft) {
            let refused = |problem: String| {
                Err(ForwardError::FrictionOfSeveral { actuator: train.name.clone(), problem })
            };
            if self.with_shafts.is_none() {
                return refused(
                    "because geared joints alone close a loop; divide a body of the loop by a fixed joint"
                        .into(),
                );
            }
            let actuators = &self.topology.actuators;
            let is_moved = |a: &&usize| {
                let at = actuators[**a];
                train.moves(JointId(at.joint), at.dof)
            };
            if let Some(&actuator) = self.prescribed.iter().find(is_moved) {
                let at = actuators[actuator];
                let joint = self.mechanism.joints()[at.joint].dof_name(at.dof);
                return refused(format!(
                    "while the motion of `{joint}` is prescribed; move `{joint}` by an effort or a controller"
                ));
            }
        }
        Ok(())
    }

    /// Returns the wrench of each motor or actuator that exerts an effort, with the index of its joint.
    pub(super) fn actuator_wrenches<'a>(
        &'a self,
        data: &'a Data,
    ) -> impl Iterator<Item = (usize, Wrench<f64>)> + 'a {
        let shafts = || self.with_shafts.iter().flat_map(|(_, shafts)| shafts);
        let by_shafts = move |actuator: usize| {
            shafts().any(|shaft| shaft.motor.terms.iter().any(|term| term.actuator == actuator))
        };
        let actuators = self.topology.actuators.iter().enumerate().zip(&data.efforts);
        let direct = actuators
            .filter(move |((index, _), _)| !by_shafts(*index))
            .map(|((_, at), effort)| (at.joint, at.dof, *effort));
        let by_motors = shafts().map(|shaft| (shaft.joint.0, 0, shaft.motor.effort(&data.efforts)));
        direct.chain(by_motors).filter(|(.., effort)| *effort != 0.0).map(|(joint, dof, effort)| {
            let dof = &self.topology.joint_types[joint].dofs()[dof];
            (joint, data.bodies.effort(dof, joint) * effort)
        })
    }
}
