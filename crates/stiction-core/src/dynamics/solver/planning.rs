//! In what order the balance is solved at a position, and which of its bodies spin idly.

use super::InverseDynamics;
use crate::dynamics::inverse::Inverse;
use crate::dynamics::plan::BalancePlan;
use crate::dynamics::setup::Setup;
use crate::spatial::Mat3;

impl InverseDynamics {
    /// Plans the balance at the present position.
    pub(super) fn replan(&mut self) {
        self.plans += 1;
        self.steady_idle_spins();
        let spins = self.spin_responses();
        let bodies = &self.assembly.kinematics().bodies;
        self.plan = BalancePlan::new(&self.topology, &self.parameters, bodies, &spins);
        self.sharing = None;
        self.inverse = match &self.plan {
            Err(_) => None,
            Ok(balance) => {
                let (topology, parameters) = (&self.topology, &self.parameters);
                let (motion_constraints, motion, _) = self.assembly.parts();
                let setup = Setup { topology, motion_constraints, motion, balance };
                Some(Inverse::new(&setup, parameters))
            }
        };
    }

    /// Gives bodies that spin idly, and have no inertia about the axis of that spin, some. By
    /// convention nothing turns about it, so no result changes; but without it the acceleration
    /// would be anything, or, with friction at the body, infinite: this is the limit of little
    /// inertia.
    pub(super) fn steady_idle_spins(&mut self) {
        let length = self.parameters.length;
        for spin in self.assembly.motion_constraints().spins() {
            let body = spin.body.0;
            let inertia = &mut self.parameters.inertia[body];
            let size = inertia.trace() + self.parameters.mass[body] * length * length;
            if spin.axis.dot(*inertia * spin.axis) <= 1e-12 * size {
                let fictitious = if size > 0.0 { size } else { length * length };
                let [x, y, z] = (spin.axis * fictitious).to_array();
                let about_axis = Mat3::from_columns(spin.axis * x, spin.axis * y, spin.axis * z);
                *inertia = *inertia + about_axis;
            }
        }
    }

    pub(super) fn spin_responses(&mut self) -> Vec<Vec<f64>> {
        let dofs = self.topology.dofs();
        let (motion_constraints, motion, kinematics) = self.assembly.parts();
        (0..motion_constraints.spins().len())
            .map(|spin| {
                let mut response = vec![0.0; dofs];
                kinematics.response_to_spin(motion_constraints, motion, spin, &mut response);
                response
            })
            .collect()
    }
}
