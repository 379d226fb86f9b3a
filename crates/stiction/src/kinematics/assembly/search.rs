//! The careful way into a position, and what is missing where there is none.

use super::super::error::{AssemblyError, Gap};
use super::super::freedom;
use super::super::system::{Kinematics, column_scales};
use super::{Assembly, NEAR};
use crate::linalg::Svd;
use crate::parameters::Parameters;
use crate::topology::Topology;
use nalgebra::DVector;

/// Steps of the careful method.
const CAREFUL_STEPS: usize = 500;

impl Assembly {
    /// Levenberg and Marquardt's method on all rows: slow, but it needs neither a plan nor a good
    /// guess, and redundant rows do not trouble it.
    pub(super) fn search(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
    ) -> Result<(), AssemblyError> {
        // A motion that cannot be followed shows best as a gap in the loops.
        const PRESCRIBED_WEIGHT: f64 = 100.0;
        if self.kinematics.errors().len() != self.prescription.row_count() {
            self.kinematics = Kinematics::new(topology, &self.prescription, &self.program);
        }
        let columns = column_scales(topology, parameters.length);
        let mut weights = self.prescription.row_scales(parameters.length);
        let closures = topology.constraints;
        weights[closures..].iter_mut().for_each(|w| *w *= PRESCRIBED_WEIGHT);
        let residual = |kinematics: &Kinematics<f64>| {
            DVector::from_iterator(
                weights.len(),
                kinematics.errors().iter().zip(&weights).map(|(e, w)| e * w),
            )
        };

        let (prescription, state) = (&self.prescription, &self.state);
        self.kinematics.place(topology, parameters, prescription, state, &self.targets);
        let mut errors = residual(&self.kinematics);
        let mut damping = 1e-3;
        for _ in 0..CAREFUL_STEPS {
            if errors.amax() < NEAR {
                break;
            }
            self.kinematics.linearise(topology, &self.prescription);
            let jacobian = self.kinematics.scaled_matrix(&self.prescription, &weights, &columns);
            let gradient = jacobian.tr_mul(&errors);
            let normal = jacobian.tr_mul(&jacobian);
            let mut improved = false;
            while damping < 1e12 {
                let mut damped = normal.clone();
                for i in 0..damped.nrows() {
                    damped[(i, i)] += damping;
                }
                let Some(factor) = damped.cholesky() else {
                    damping *= 10.0;
                    continue;
                };
                let step = -factor.solve(&gradient);
                let step: Vec<f64> = step.iter().zip(&columns).map(|(s, c)| s * c).collect();
                self.predicted.clone_from(&self.state);
                self.state.advance(topology, &step);
                let (prescription, state) = (&self.prescription, &self.state);
                self.kinematics.place(topology, parameters, prescription, state, &self.targets);
                let trial = residual(&self.kinematics);
                if trial.norm_squared() < errors.norm_squared() {
                    improved = trial.norm() < errors.norm() * (1.0 - 1e-12);
                    errors = trial;
                    damping = (damping * 0.2).max(1e-15);
                    break;
                }
                self.state.clone_from(&self.predicted);
                damping *= 5.0;
            }
            if !improved {
                break;
            }
        }
        let (prescription, state) = (&self.prescription, &self.state);
        self.kinematics.place(topology, parameters, prescription, state, &self.targets);
        if errors.amax() < 1e-6 {
            Ok(())
        } else {
            Err(AssemblyError::Gap(self.gap(topology, parameters)))
        }
    }

    /// How many coordinates are prescribed and how many freedoms there are, if these are fewer.
    pub(super) fn over_prescribed(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
    ) -> Option<(usize, usize)> {
        self.kinematics.linearise(topology, &self.prescription);
        let rows = self.prescription.row_scales(parameters.length);
        let (closures, freedoms) = (topology.constraints, topology.freedoms());
        let columns = column_scales(topology, parameters.length);
        let all = self.kinematics.scaled_matrix(&self.prescription, &rows, &columns);
        let scaled = all.rows(0, closures).into_owned();
        let rank =
            if closures == 0 { 0 } else { Svd::new(&scaled).rank_of_order_one(freedom::OPEN) };
        let (prescribed, mobility) = (self.prescription.coordinates().len(), freedoms - rank);
        (prescribed > mobility).then_some((prescribed, mobility))
    }

    /// The gap at the present state.
    pub(super) fn gap(&mut self, topology: &Topology, parameters: &Parameters<f64>) -> Gap {
        let prescribed = self.over_prescribed(topology, parameters);
        let errors = self.kinematics.errors();
        let mut worst = Gap { prescribed, ..Gap::default() };
        let mut row = 0;
        for cut in &topology.cuts {
            let (mut length, mut angle) = (0.0_f64, 0.0_f64);
            for constraint in topology.joint_types[cut.joint].constraints() {
                let error = errors[row];
                if constraint.is_moment() {
                    angle = angle.hypot(error);
                } else {
                    length = length.hypot(error);
                }
                row += 1;
            }
            if worst.joint.is_none() || length > worst.length {
                let joint = Some(self.joint_names[cut.joint].clone());
                worst = Gap { joint, length, angle, ..worst };
            }
        }
        for (error, is_angle) in errors.iter().zip(self.prescription.are_angles()).skip(row) {
            let missed = if is_angle { &mut worst.missed_angle } else { &mut worst.missed_length };
            *missed = missed.max(error.abs());
        }
        worst
    }
}
