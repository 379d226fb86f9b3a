//! Compilation of the model for inverse dynamics at the present configuration.

use super::{Compiled, InverseDynamics};
use crate::dynamics::inverse::Inverse;
use crate::dynamics::model::Model;
use crate::dynamics::plan::BalancePlan;
use crate::spatial::Mat3;
use std::sync::Arc;

impl InverseDynamics {
    /// Compiles the model for inverse dynamics at the present configuration.
    pub(super) fn replan(&mut self) {
        self.plans += 1;
        self.compiled_at.clear();
        self.compiled_at.extend_from_slice(self.assembly.coordinates());
        self.add_inertia_about_idle_spins();
        let spins = self.spin_responses();
        let bodies = &self.assembly.kinematics().bodies;
        let balance = BalancePlan::new(&self.topology, &self.parameters, bodies, &spins);
        self.friction_coupling.leave();
        self.compiled = balance.map(|balance| {
            let model = Model {
                mechanism: Arc::clone(&self.mechanism),
                kinematic: self.assembly.model().clone(),
                balance: Arc::new(balance),
                parameters: Arc::clone(&self.parameters),
            };
            Compiled { inverse: Inverse::new(&model), model }
        });
    }

    /// Copies the compiled kinematics of the assembly to the model, because the assembly compiles
    /// them again at some configurations. If the local degrees of freedom have changed, also
    /// compiles the balance again.
    pub(super) fn share_kinematics(&mut self) {
        let Ok(Compiled { model, .. }) = &mut self.compiled else { return };
        let current = self.assembly.model();
        let has_same_spins = model.constraints().spins() == current.constraints.spins();
        let kinematic = &model.kinematic;
        let is_shared = Arc::ptr_eq(&kinematic.rates, &current.rates)
            && Arc::ptr_eq(&kinematic.constraints, &current.constraints);
        if !is_shared {
            model.kinematic.clone_from(current);
        }
        if !has_same_spins {
            self.replan();
        }
    }

    /// Adds inertia to bodies without inertia about the axis of a local degree of freedom. By
    /// convention the rate about this axis is zero, so no result depends on the added inertia.
    /// Without added inertia the acceleration about the axis would be undetermined or, with
    /// friction at the body, infinite. The result is the limit for small inertia.
    pub(super) fn add_inertia_about_idle_spins(&mut self) {
        let length = self.parameters.length;
        for spin in self.assembly.motion_constraints().spins() {
            let body = spin.body.0;
            let inertia = self.parameters.inertia[body];
            let size = inertia.trace() + self.parameters.mass[body] * length * length;
            if spin.axis.dot(inertia * spin.axis) <= 1e-12 * size {
                let fictitious = if size > 0.0 { size } else { length * length };
                let [x, y, z] = (spin.axis * fictitious).to_array();
                let about_axis = Mat3::from_columns(spin.axis * x, spin.axis * y, spin.axis * z);
                Arc::make_mut(&mut self.parameters).inertia[body] = inertia + about_axis;
            }
        }
    }

    pub(super) fn spin_responses(&mut self) -> Vec<Vec<f64>> {
        let dofs = self.topology.dofs();
        let (model, kinematics) = self.assembly.parts();
        (0..model.constraints().spins().len())
            .map(|spin| {
                let mut response = vec![0.0; dofs];
                kinematics.response_to_spin(model, spin, &mut response);
                response
            })
            .collect()
    }
}
