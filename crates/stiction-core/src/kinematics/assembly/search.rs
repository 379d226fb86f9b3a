//! The careful way into a position, and what is missing where there is none.

use super::super::coordinate::{Coordinate, Target};
use super::super::dof;
use super::super::error::{AssemblyError, Gap};
use super::super::motion_constraints::MotionConstraints;
use super::super::rotation_vector::RotationVector;
use super::super::system::{Kinematics, column_scales};
use super::{Assembly, NEAR};
use crate::linalg::Svd;
use crate::parameters::Parameters;
use crate::spatial::Mat3;
use nalgebra::DVector;
use std::sync::Arc;

/// Steps of the careful method.
const CAREFUL_STEPS: usize = 500;
/// How often it begins anew beside where it began, or moves away from where prescribed angles of a body are
/// not defined.
const NUDGES: usize = 8;
/// By how much: rad, and characteristic lengths.
const NUDGE: f64 = 0.1;

impl Assembly {
    /// The careful search, which needs neither a plan nor a good guess. Whole orientations in angles like
    /// those of the order zxz are looked for as rotations first: between frames that are parallel, as they
    /// are at first, such angles say nothing.
    pub(super) fn search(&mut self, parameters: &Parameters<f64>) -> Result<(), AssemblyError> {
        if let Some((motion_constraints, targets)) = self.by_rotations() {
            let motion_constraints =
                core::mem::replace(&mut self.model.constraints, Arc::new(motion_constraints));
            let targets = core::mem::replace(&mut self.targets, targets);
            // What is missed is told by what was prescribed.
            let _ = self.search_directly(parameters);
            (self.model.constraints, self.targets) = (motion_constraints, targets);
        }
        self.search_directly(parameters)
    }

    /// The prescription with such orientations as rotation vectors; none if there are none.
    fn by_rotations(&self) -> Option<(MotionConstraints, Vec<Target<f64>>)> {
        let mut coordinates = self.model.constraints.coordinates().to_vec();
        let mut targets = self.targets.clone();
        let mut some = false;
        for first in 0..coordinates.len() {
            let Coordinate::Angle { body, order, index: 0 } = coordinates[first] else { continue };
            let place = |index| {
                let angle = Coordinate::Angle { body, order, index };
                coordinates.iter().position(|c| *c == angle)
            };
            let (Some(second), Some(third)) = (place(1), place(2)) else { continue };
            if order.is_tait_bryan() {
                continue;
            }
            let places = [first, second, third];
            let turn = |k: usize| {
                Mat3::about_axis(order.axes()[k], self.targets[places[k]].value.sin_cos())
            };
            let vector = RotationVector::of(turn(0) * turn(1) * turn(2)).value;
            for (axis, place) in places.into_iter().enumerate() {
                coordinates[place] = Coordinate::RotationVector { body, axis };
                let value = vector.component(axis);
                targets[place] = Target { value, rate: 0.0, acceleration: 0.0 };
            }
            some = true;
        }
        let spins = self.model.constraints.spins();
        some.then(|| (MotionConstraints::new(&self.model.topology, &coordinates, spins), targets))
    }

    /// Levenberg and Marquardt's method on all rows: slow, but it needs neither a plan nor a good
    /// guess, and redundant rows do not trouble it.
    fn search_directly(&mut self, parameters: &Parameters<f64>) -> Result<(), AssemblyError> {
        // A motion that cannot be followed shows best as a gap in the loops.
        const PRESCRIBED_WEIGHT: f64 = 100.0;
        if self.kinematics.errors().len() != self.model.constraints.row_count() {
            self.kinematics =
                Kinematics::new(&self.model.topology, &self.model.constraints, &self.model.rates);
        }
        let columns = column_scales(&self.model.topology, parameters.length);
        let mut weights = self.model.constraints.row_scales(parameters.length);
        let closures = self.model.topology.constraints;
        weights[closures..].iter_mut().for_each(|w| *w *= PRESCRIBED_WEIGHT);
        let residual = |kinematics: &Kinematics<f64>| {
            DVector::from_iterator(
                weights.len(),
                kinematics.errors().iter().zip(&weights).map(|(e, w)| e * w),
            )
        };

        let (motion_constraints, state) = (&self.model.constraints, &self.state);
        self.kinematics.place(
            &self.model.topology,
            parameters,
            motion_constraints,
            state,
            &self.targets,
        );
        let mut errors = residual(&self.kinematics);
        let mut damping = 1e-3;
        let mut nudges = 0;
        for _ in 0..CAREFUL_STEPS {
            if errors.amax() < NEAR {
                break;
            }
            self.kinematics.linearise(&self.model.topology, &self.model.constraints);
            let jacobian =
                self.kinematics.scaled_matrix(&self.model.constraints, &weights, &columns);
            if nudges < NUDGES && !jacobian.iter().all(|slope| slope.is_finite()) {
                // Angles like those of the order zxz have no rates where the frames are parallel, as they are
                // at first: from there no step would be found, though the position is within reach.
                nudges += 1;
                self.nudge(&columns, nudges);
                let (motion_constraints, state) = (&self.model.constraints, &self.state);
                self.kinematics.place(
                    &self.model.topology,
                    parameters,
                    motion_constraints,
                    state,
                    &self.targets,
                );
                errors = residual(&self.kinematics);
                continue;
            }
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
                self.state.advance(&self.model.topology, &step);
                let (motion_constraints, state) = (&self.model.constraints, &self.state);
                self.kinematics.place(
                    &self.model.topology,
                    parameters,
                    motion_constraints,
                    state,
                    &self.targets,
                );
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
        let (motion_constraints, state) = (&self.model.constraints, &self.state);
        self.kinematics.place(
            &self.model.topology,
            parameters,
            motion_constraints,
            state,
            &self.targets,
        );
        if errors.amax() < 1e-6 { Ok(()) } else { Err(AssemblyError::Gap(self.gap(parameters))) }
    }

    /// Moves all freedoms a little, each time otherwise.
    fn nudge(&mut self, columns: &[f64], time: usize) {
        let moves = columns.iter().enumerate();
        let moves = moves.map(|(k, c)| NUDGE * c * ((k + time) as f64).cos());
        self.state.advance(&self.model.topology, &moves.collect::<Vec<f64>>());
    }

    /// [`Self::reassemble`] from the first guess, and from beside it where that finds nothing: from a dead centre or
    /// another position in which all is stretched, every first step leads nowhere.
    pub(super) fn assemble(&mut self, parameters: &Parameters<f64>) -> Result<(), AssemblyError> {
        let begin = self.state.clone();
        let outcome = self.reassemble(parameters);
        if !matches!(outcome, Err(AssemblyError::Gap(_))) {
            return outcome;
        }
        let columns = column_scales(&self.model.topology, parameters.length);
        for time in 1..=NUDGES {
            self.state.clone_from(&begin);
            self.nudge(&columns, time);
            if self.reassemble(parameters).is_ok() {
                return Ok(());
            }
        }
        outcome
    }

    /// How many coordinates are prescribed and how many freedoms there are, if these are fewer.
    pub(super) fn over_prescribed(
        &mut self,
        parameters: &Parameters<f64>,
    ) -> Option<(usize, usize)> {
        self.kinematics.linearise(&self.model.topology, &self.model.constraints);
        let rows = self.model.constraints.row_scales(parameters.length);
        let (closures, dofs) = (self.model.topology.constraints, self.model.topology.dofs());
        let columns = column_scales(&self.model.topology, parameters.length);
        let all = self.kinematics.scaled_matrix(&self.model.constraints, &rows, &columns);
        let scaled = all.rows(0, closures).into_owned();
        let rank = if closures == 0 { 0 } else { Svd::new(&scaled).rank_of_order_one(dof::OPEN) };
        let (prescribed, mobility) = (self.model.constraints.coordinates().len(), dofs - rank);
        (prescribed > mobility).then_some((prescribed, mobility))
    }

    /// The gap at the present state.
    pub(super) fn gap(&mut self, parameters: &Parameters<f64>) -> Gap {
        let prescribed = self.over_prescribed(parameters);
        let errors = self.kinematics.errors();
        let scale = parameters.length;
        let mut worst = Gap { prescribed, scale, ..Gap::default() };
        let size = |length: f64, angle: f64| length / scale + angle;
        let mut row = 0;
        for cut in &self.model.topology.cuts {
            let (mut length, mut angle) = (0.0_f64, 0.0_f64);
            for constraint in self.model.topology.joint_types[cut.joint].constraints() {
                let error = errors[row];
                if constraint.is_moment() {
                    angle = angle.hypot(error);
                } else {
                    length = length.hypot(error);
                }
                row += 1;
            }
            if worst.joint.is_none() || size(length, angle) > size(worst.length, worst.angle) {
                let joint = Some(self.joint_names[cut.joint].clone());
                worst = Gap { joint, length, angle, ..worst };
            }
        }
        for (error, is_angle) in errors.iter().zip(self.model.constraints.are_angles()).skip(row) {
            let missed = if is_angle { &mut worst.missed_angle } else { &mut worst.missed_length };
            *missed = missed.max(error.abs());
        }
        worst
    }
}
