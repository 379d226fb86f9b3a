//! Derivatives of an effort with respect to static friction.

use super::{Acting, FrictionCoupling};
use crate::dynamics::balance::WIDTH;
use crate::friction::OwnFriction;
use crate::friction_problem::normal_load::Configuration;
use crate::spatial::Twist;

impl FrictionCoupling {
    /// Computes the derivative of an effort with respect to each component of static friction, in
    /// units of the friction limit, at the solution of [`Self::settle`]. The derivative is zero for
    /// sliding interfaces. `None` if the coupling is singular.
    pub(in crate::dynamics) fn slopes(
        &mut self,
        actuator: usize,
        at: Configuration<'_>,
        slopes: &mut Vec<f64>,
    ) -> Option<()> {
        self.joint_wrenches();
        let Self { responses, acting, unknowns, problem, workspace, weights, .. } = self;
        // Change of the effort per newton of each normal load.
        weights.clear();
        weights.extend(unknowns.iter().map(|&interface| {
            let Acting { resistance, parts, .. } = acting[interface];
            let components = responses.components(interface).zip(parts);
            let sum = components.map(|(k, part)| responses.effort(k, actuator) * part);
            sum.sum::<f64>() * resistance.coefficient
        }));
        problem.adjoint(at, &self.loads, weights, &mut self.gradients, workspace)?;
        // Derivative of the effort with respect to the wrench of each joint.
        let gains = &mut self.gains;
        gains.clear();
        gains.resize(self.start.len(), Twist::zero());
        for ((&unknown, gradient), weight) in unknowns.iter().zip(&self.gradients).zip(&*weights) {
            gains[at.joint(unknown)] += *gradient * *weight;
        }
        let powers = &mut self.packed;
        responses.powers(gains, powers);
        slopes.clear();
        for component in 0..responses.len() {
            let interface = responses.interface(component);
            let acting = &acting[interface];
            let wrench = self.start[at.joint(interface)];
            let load = at.normal_load(interface, wrench, OwnFriction::none()).value;
            let change = powers[component / WIDTH].0[component % WIDTH];
            let slope = responses.effort(component, actuator) + change;
            slopes.push(slope * acting.resistance.force(load));
        }
        Some(())
    }
}
