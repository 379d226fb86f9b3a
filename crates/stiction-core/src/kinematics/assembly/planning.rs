//! The order in which rates are solved for at a position, and the spins that nothing determines.

use super::super::dof::{self, OpenMotion};
use super::super::error::AssemblyError;
use super::super::motion_constraints::MotionConstraints;
use super::super::system::{Kinematics, column_scales};
use super::Assembly;
use crate::linalg::Svd;
use crate::parameters::Parameters;
use crate::topology::Topology;
use nalgebra::DMatrix;

/// Pivots of the scaled system below this ask for a look at its singular values.
const SUSPICIOUS_PIVOT: f64 = 1e-3;

impl Assembly {
    /// Chooses the elimination at the present, assembled position; finds idle spins.
    pub(super) fn plan(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
    ) -> Result<(), AssemblyError> {
        self.plans += 1;
        let before =
            (self.motion_constraints.clone(), self.row_scales.clone(), self.kinematics.clone());
        let planned = self.plan_anew(topology, parameters);
        if planned.is_err() {
            // What was planned for other positions stays good there.
            (self.motion_constraints, self.row_scales, self.kinematics) = before;
        }
        planned
    }

    pub(super) fn plan_anew(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
    ) -> Result<(), AssemblyError> {
        let coordinates = self.motion_constraints.coordinates().to_vec();
        self.motion_constraints = MotionConstraints::new(topology, &coordinates, &[]);
        self.row_scales = self.motion_constraints.row_scales(parameters.length);
        if self.try_plan(topology, parameters) {
            return Ok(());
        }
        let found = dof::open_motions(
            topology,
            parameters,
            &self.kinematics.bodies,
            &self.scaled_jacobian(topology, parameters),
            &column_scales(topology, parameters.length),
        );
        let open = match found {
            OpenMotion::Spins(spins) => {
                self.motion_constraints = MotionConstraints::new(topology, &coordinates, &spins);
                self.row_scales = self.motion_constraints.row_scales(parameters.length);
                if self.try_plan(topology, parameters) {
                    return Ok(());
                }
                Vec::new()
            }
            OpenMotion::Freedoms(open) => open,
        };
        let open = open.into_iter().map(|motion| motion.named(&self.body_names)).collect();
        Err(AssemblyError::Open { open })
    }

    pub(super) fn try_plan(&mut self, topology: &Topology, parameters: &Parameters<f64>) -> bool {
        self.kinematics = Kinematics::new(topology, &self.motion_constraints, &self.program);
        let (motion_constraints, state) = (&self.motion_constraints, &self.state);
        self.kinematics.place(topology, parameters, motion_constraints, state, &self.targets);
        self.kinematics.linearise(topology, motion_constraints);
        let Ok(plan) = self.kinematics.plan(topology, &self.motion_constraints, parameters.length)
        else {
            return false;
        };
        // A small pivot need not mean a small singular value, but no small one means none.
        if plan.smallest_pivot < SUSPICIOUS_PIVOT {
            let svd = Svd::new(&self.scaled_jacobian(topology, parameters));
            if svd.rank_of_order_one(dof::OPEN) < topology.dofs() {
                return false;
            }
        }
        self.program = plan.compile();
        self.kinematics = Kinematics::new(topology, &self.motion_constraints, &self.program);
        true
    }

    pub(super) fn scaled_jacobian(
        &self,
        topology: &Topology,
        parameters: &Parameters<f64>,
    ) -> DMatrix<f64> {
        let columns = column_scales(topology, parameters.length);
        self.kinematics.scaled_matrix(&self.motion_constraints, &self.row_scales, &columns)
    }
}
