//! Shafts that the model adds to the mechanism, so that the friction of each motor can be
//! simulated. Motors that drive the same joints get separate shafts if the friction of a motor acts
//! on several joints, or if the loss of a gear depends on the part of the effort that this gear
//! transmits.
//!
//! Equation (G13) of the book's theory.

use super::Forward;
use super::data::Data;
use crate::mechanism::{JointId, Mechanism, MotorShaft};
use crate::spatial::Wrench;

impl Forward {
    /// Returns the mechanism that is simulated, including the added motor shafts, see
    /// [`Mechanism::trains_on_shafts`].
    pub(super) fn simulated(&self) -> &Mechanism {
        self.with_shafts.as_ref().map_or(&self.mechanism, |(mechanism, _)| mechanism)
    }

    /// Returns the joint whose name identifies an interface in results. For an interface on an
    /// added motor shaft, this is the first joint that the motor moves.
    pub(super) fn reported_joint(&self, interface: usize) -> JointId {
        let own = self.parameters.interfaces[interface].joint;
        self.shaft_at(own).map_or(JointId(own), |shaft| shaft.moved)
    }

    /// Returns the added motor shaft to which a joint belongs; `None` for joints of the original
    /// mechanism.
    pub(super) fn shaft_at(&self, joint: usize) -> Option<&MotorShaft> {
        let mut shafts = self.with_shafts.iter().flat_map(|(_, shafts)| shafts);
        shafts.find(|shaft| shaft.joint.0 == joint)
    }

    /// Returns, for each motor or actuator with a nonzero effort in `data`, the index of its joint
    /// and the wrench that it exerts at this joint.
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
