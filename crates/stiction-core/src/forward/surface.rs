//! Sliding motion at the surfaces of friction interfaces, and the wrenches of friction on their
//! joints.

use super::Forward;
use super::constraint_jacobian::each_dof;
use crate::kinematics::Bodies;
use crate::spatial::Wrench;

impl Forward {
    /// Returns a copy of the bodies with the body accelerations for given accelerations of the
    /// spanning tree.
    pub(super) fn accelerated(&self, bodies: &Bodies<f64>, accelerations: &[f64]) -> Bodies<f64> {
        let mut bodies = bodies.clone();
        bodies.accelerate(&self.topology, accelerations);
        bodies
    }

    /// Returns the relative acceleration of the surfaces of an interface along each of its DOFs,
    /// m/s^2. `bodies` must contain the accelerations of all bodies.
    pub(super) fn surface_acceleration(&self, bodies: &Bodies<f64>, interface: usize) -> [f64; 3] {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let content = &parameters.interfaces[interface];
        let (predecessor, successor) = topology.ends[content.joint];
        let own = bodies.joint_bias(topology, parameters, content.joint);
        let relative = bodies.acceleration[successor] - bodies.acceleration[predecessor] - own;
        let arms = content.arms(parameters.pitch[content.joint]);
        let dofs = topology.joint_types[content.joint].dofs();
        let mut surface = [0.0; 3];
        for ((value, arm), dof) in surface.iter_mut().zip(arms).zip(&dofs[content.shape.dofs()]) {
            *value = arm * relative.power(bodies.effort(dof, content.joint));
        }
        surface
    }

    /// Returns, for each DOF of an interface, the wrench at the joint that one newton of friction
    /// at the surface exerts.
    pub(super) fn unit_frictions(
        &self,
        bodies: &Bodies<f64>,
        interface: usize,
    ) -> Vec<Wrench<f64>> {
        let content = &self.parameters.interfaces[interface];
        let arms = content.arms(self.parameters.pitch[content.joint]);
        let each = (0..content.shape.dofs().len()).map(|place| {
            let mut efforts = [0.0; 3];
            efforts[place] = -arms[place];
            bodies.wrench_of(&self.topology, content, efforts)
        });
        each.collect()
    }

    /// Returns the sliding velocity of an interface along one of its DOFs, m/s, for given rates of
    /// the spanning tree.
    pub(super) fn surface_rate(
        &self,
        bodies: &Bodies<f64>,
        rates: &[f64],
        interface: usize,
        place: usize,
    ) -> f64 {
        self.surface_rates(bodies, interface, place)(rates)
    }

    /// Returns [`Self::surface_rate`] as a function of the rates of the spanning tree.
    pub(super) fn surface_rates(
        &self,
        bodies: &Bodies<f64>,
        interface: usize,
        place: usize,
    ) -> impl Fn(&[f64]) -> f64 + use<> {
        let topology = &self.topology;
        let content = &self.parameters.interfaces[interface];
        let arm = content.arms(self.parameters.pitch[content.joint])[place];
        let dof = &topology.joint_types[content.joint].dofs()[content.shape.dofs().start + place];
        let effort = bodies.effort(dof, content.joint);
        let mut terms = Vec::new();
        each_dof(topology, content.joint, |tree_dof, sign| {
            terms.push((tree_dof, sign * bodies.screws[tree_dof].power(effort)));
        });
        move |rates| arm * terms.iter().map(|(tree_dof, part)| part * rates[*tree_dof]).sum::<f64>()
    }

    /// Computes the sliding velocity of an interface along one of its DOFs, m/s, from the rates of
    /// actuators with prescribed motion. `rate` returns the rate of an actuator, given its index in
    /// the list of prescribed actuators; accelerations can be used instead of rates. Returns `None`
    /// if the prescribed actuators do not determine the velocity. They determine it for DOFs of
    /// their own joints, and for an added motor shaft if they prescribe all joints that the motor
    /// moves.
    pub(super) fn prescribed_rate(
        &self,
        interface: usize,
        place: usize,
        rate: impl Fn(usize) -> f64,
    ) -> Option<f64> {
        if self.prescribed.is_empty() {
            return None;
        }
        let content = &self.parameters.interfaces[interface];
        let arm = content.arms(self.parameters.pitch[content.joint])[place];
        let index = |actuator: usize| self.prescribed.iter().position(|&known| known == actuator);
        if let Some(shaft) = self.shaft_at(content.joint) {
            let moving = shaft.motor.terms.iter().filter(|term| term.part != 0.0);
            let each = moving.map(|term| Some(term.part * rate(index(term.actuator)?)));
            return each.sum::<Option<f64>>().map(|sum| arm * sum);
        }
        let at = (content.joint, content.shape.dofs().start + place);
        let mut actuators = self.topology.actuators.iter();
        let actuator = actuators.position(|actuator| (actuator.joint, actuator.dof) == at)?;
        Some(arm * rate(index(actuator)?))
    }

    /// Returns true if prescribed actuators determine the motion of an interface along one of its
    /// DOFs.
    pub(super) fn is_prescribed_place(&self, interface: usize, place: usize) -> bool {
        self.prescribed_rate(interface, place, |_| 0.0).is_some()
    }
}
