//! Elimination plan for the rate equations, and detection of local degrees of freedom.

use super::super::coordinate::Coordinate;
use super::super::dof::{self, OpenMotion};
use super::super::error::AssemblyError;
use super::super::motion_constraints::{MotionConstraints, Spin};
use super::super::system::{Kinematics, column_scales};
use super::Assembly;
use crate::linalg::{SparseMatrix, Svd};
use crate::parameters::Parameters;
use crate::spatial::Vec3;
use std::sync::Arc;

/// If a pivot of the scaled system is smaller than this value, the rank is determined from singular
/// values.
const SUSPICIOUS_PIVOT: f64 = 1e-3;

impl Assembly {
    /// Compiles the elimination plan at the present closed configuration, and locks local degrees
    /// of freedom.
    pub(super) fn plan(&mut self, parameters: &Parameters<f64>) -> Result<(), AssemblyError> {
        self.plans += 1;
        let before =
            (Arc::clone(&self.model.constraints), self.row_scales.clone(), self.kinematics.clone());
        let planned = self.replan(parameters);
        match planned {
            Ok(()) => self.planned_at.clone_from(&self.state.coordinates),
            // The earlier plan remains valid at other configurations.
            Err(_) => (self.model.constraints, self.row_scales, self.kinematics) = before,
        }
        planned
    }

    pub(super) fn replan(&mut self, parameters: &Parameters<f64>) -> Result<(), AssemblyError> {
        let coordinates = self.model.constraints.coordinates().to_vec();
        self.constrain(&coordinates, &[]);
        self.row_scales = self.model.constraints.row_scales(parameters.length);
        if self.try_plan(parameters) {
            return Ok(());
        }
        let found = dof::open_motions(
            &self.model.topology,
            parameters,
            &self.kinematics.bodies,
            self.scaled_jacobian(parameters),
            &column_scales(&self.model.topology, parameters.length),
        );
        let open = match found {
            OpenMotion::Spins(spins) => {
                self.constrain(&coordinates, &spins);
                self.row_scales = self.model.constraints.row_scales(parameters.length);
                if self.try_plan(parameters) {
                    return Ok(());
                }
                Vec::new()
            }
            OpenMotion::Others(open) => open,
        };
        let open = open.into_iter().map(|motion| motion.named(&self.body_names)).collect();
        Err(AssemblyError::Open { open })
    }

    /// Returns the rotation axis of each body in the locked passive spins, in the body's frame;
    /// `None` for a body that does not rotate in any of them.
    pub(super) fn spin_axes(&mut self, parameters: &Parameters<f64>) -> Vec<Option<Vec3<f64>>> {
        let mut axes = vec![None; self.body_names.len()];
        let spins = self.model.constraints.spins().len();
        if spins == 0 {
            return axes;
        }
        let (topology, constraints) = (&self.model.topology, &self.model.constraints);
        self.kinematics.place(topology, parameters, constraints, &self.state, &self.targets);
        self.kinematics.linearise(topology, parameters, constraints);
        let bodies = &self.kinematics.bodies;
        let all = self.scaled_jacobian(parameters).to_dense();
        let svd = Svd::new(&all.rows(0, all.nrows() - spins).into_owned());
        let columns = column_scales(&self.model.topology, parameters.length);
        for motion in svd.null_space(self.model.topology.dofs() - spins) {
            let rates: Vec<f64> = motion.iter().zip(&columns).map(|(x, s)| x * s).collect();
            let twists = dof::body_twists(&self.model.topology, bodies, &rates);
            for (body, twist) in twists.iter().enumerate() {
                // All independent spins of one body have the same axis.
                if twist.angular.norm() > dof::SMALL {
                    let axis = bodies.pose[body].rotation.transpose_mul(twist.angular);
                    axes[body] = axis.direction();
                }
            }
        }
        axes
    }

    pub(super) fn constrain(&mut self, coordinates: &[Coordinate], spins: &[Spin]) {
        let constraints = MotionConstraints::new(&self.model.topology, coordinates, spins);
        self.model.constraints = Arc::new(constraints);
    }

    pub(super) fn try_plan(&mut self, parameters: &Parameters<f64>) -> bool {
        self.kinematics =
            Kinematics::new(&self.model.topology, &self.model.constraints, &self.model.rates);
        let (motion_constraints, state) = (&self.model.constraints, &self.state);
        self.kinematics.place(
            &self.model.topology,
            parameters,
            motion_constraints,
            state,
            &self.targets,
        );
        self.kinematics.linearise(&self.model.topology, parameters, motion_constraints);
        let Ok(plan) =
            self.kinematics.plan(&self.model.topology, &self.model.constraints, parameters.length)
        else {
            return false;
        };
        // A small pivot does not imply a small singular value, but without small pivots all
        // singular values are large.
        if plan.smallest_pivot < SUSPICIOUS_PIVOT {
            let jacobian = self.scaled_jacobian(parameters);
            let columns = jacobian.ncols();
            if dof::decompose(jacobian).rank() < columns {
                return false;
            }
        }
        self.model.rates = Arc::new(plan.compile());
        self.kinematics =
            Kinematics::new(&self.model.topology, &self.model.constraints, &self.model.rates);
        true
    }

    pub(super) fn scaled_jacobian(&self, parameters: &Parameters<f64>) -> SparseMatrix {
        let columns = column_scales(&self.model.topology, parameters.length);
        self.kinematics.scaled_matrix(&self.model.constraints, &self.row_scales, &columns)
    }
}
