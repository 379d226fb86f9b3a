//! Designed motion at any time, and its conversion to the coordinates of the actuators.

use super::ExciteError;
use super::coordinates::Chosen;
use super::objective::{Grid, Objective};
use super::result::Actuators;
use super::series::Series;
use nalgebra::DVector;
use std::f64::consts::TAU;
use stiction_core::kinematics::Coordinate;
use stiction_core::mechanism::JointId;

/// Evaluator of the designed motion at any time.
pub(super) struct Sampled<'a> {
    pub(super) series: &'a Series,
    pub(super) x: &'a DVector<f64>,
    pub(super) grid: &'a Grid,
}

impl Sampled<'_> {
    pub(super) fn at(&self, time: f64, period: f64) -> (f64, [Vec<f64>; 3]) {
        let turns = time / period;
        if (turns - turns.round()).abs() < 1e-9 {
            // Between two periods, the robot is exactly at rest, without rounding errors.
            let rest = vec![0.0; self.grid.centre.len()];
            return (time, [self.grid.centre.clone(), rest.clone(), rest]);
        }
        // The phase refers to the first period, so that all periods have equal numbers up to the
        // rounding of the time.
        let phase = time - period * turns.floor();
        let factors = self.series.factors(phase);
        let size = self.series.free();
        let motion = [0, 1, 2].map(|order| {
            let each = (0..self.grid.centre.len()).map(|i| {
                let base = if order == 0 { self.grid.centre[i] } else { 0.0 };
                base + self.grid.reach[i] * factors[order].dot(&self.x.rows(i * size, size))
            });
            each.collect()
        });
        (time, motion)
    }
}

/// Converts the reference motion to the coordinates of the actuators, with angles that do not jump
/// by full turns. `None` if the motion is designed in these coordinates.
pub(super) fn actuators(
    objective: &mut Objective,
    chosen: &Chosen,
    reference: &[(f64, [Vec<f64>; 3])],
) -> Result<Option<Actuators>, ExciteError> {
    let mechanism = objective.probe().mechanism().clone();
    let driven: Vec<(JointId, usize)> = mechanism.actuators().collect();
    let own = driven.iter().map(|&(joint, dof)| Coordinate::Joint { joint, dof });
    if own.eq(chosen.coordinates.iter().copied()) {
        return Ok(None);
    }
    let names = driven.iter().map(|&(joint, dof)| {
        let content = &mechanism.joints()[joint.0];
        let translates = content.joint_type.dofs()[dof].translates();
        (content.dof_name(dof), if translates { "m" } else { "rad" })
    });
    let mut rows: Vec<[Vec<f64>; 3]> = Vec::with_capacity(reference.len());
    for (_, motion) in reference {
        let found = objective.actuators_at(motion.each_ref().map(Vec::as_slice), &driven);
        let Some(mut row) = found else {
            return Err(ExciteError::no_answer(
                "the robot cannot follow the motion at one of its samples",
                "give a smaller --step, or another --seed",
            ));
        };
        if let Some(before) = rows.last() {
            for ((value, before), &(joint, dof)) in row[0].iter_mut().zip(&before[0]).zip(&driven) {
                if !mechanism.joints()[joint.0].joint_type.dofs()[dof].translates() {
                    *value += TAU * ((before - *value) / TAU).round();
                }
            }
        }
        rows.push(row);
    }
    Ok(Some(Actuators { names: names.collect(), rows }))
}
