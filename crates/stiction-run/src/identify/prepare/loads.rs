//! Regression columns of the friction coefficients, linearised about the normal loads, which depend on the
//! coefficients.
//!
//! Equation (I6) of the book's theory.

use super::Prepared;
use super::filter::RowFilter;
use super::rows::{Assembled, Computed};
use nalgebra::DVector;
use stiction_core::parameters::Parameters;
use stiction_identify::{Kind, Parameter, Regressor};

/// Step of forward differences as a fraction of a coefficient, and the smallest coefficient to which the fraction
/// refers.
const STEP: f64 = 1e-5;
const LEAST: f64 = 0.01;

/// Data for the regression columns of the friction coefficients.
pub(super) struct MuColumns {
    /// Index of each friction coefficient's column in the matrix of the regression, and its friction interface.
    columns: Vec<(usize, usize)>,
    /// Contribution to each effort of the friction under unit normal load, at each instant; the index is `column *
    /// actuators + channel`.
    unit: Vec<Vec<f64>>,
    /// Times of all rows, s.
    at: Vec<f64>,
    pub(super) filter: RowFilter,
    /// Right-hand sides of the regression that contain all friction, for each actuator.
    rights: Vec<DVector<f64>>,
}

impl MuColumns {
    pub(super) fn new(
        regressor: &Regressor,
        computed: &Computed,
        assembled: &Assembled,
        filter: RowFilter,
    ) -> Self {
        let parameters = regressor.parameters();
        let interface = |k: usize| match parameters[k].kind {
            Kind::Mu(interface) => Some((k, interface)),
            _ => None,
        };
        Self {
            columns: computed.mu.iter().filter_map(|&k| interface(k)).collect(),
            unit: computed.unit_friction.clone(),
            at: assembled.at.clone(),
            filter,
            rights: assembled.block.channels.iter().map(|rows| rows.right.clone()).collect(),
        }
    }
}

impl MuColumns {
    /// Adds a change of the measured efforts of an actuator to its right-hand side.
    pub(super) fn shift(&mut self, channel: usize, change: &DVector<f64>) {
        self.rights[channel] += change;
    }
}

impl Prepared {
    /// Linearises the load-dependent friction about the parameter values `values`. The columns become derivatives of
    /// the efforts with converged normal loads, and the right-hand side contains the remaining constant part.
    /// Parameters in one of `groups` change together; parameters in none of them are held.
    ///
    /// # Errors
    /// The first time at which the forces have no solution, with the reason, if too many instants fail.
    pub(in crate::identify) fn update_loads(
        &mut self,
        values: &[f64],
        groups: &[Vec<usize>],
    ) -> Result<(), String> {
        let parameters: Vec<Parameter> = self.regressor.parameters().to_vec();
        let mu = &self.mu;
        if mu.columns.is_empty() {
            return Ok(());
        }
        let engine = self.regressor.engine_parameters(values);
        let mut loads = self.loads(&engine)?;
        // A failed instant takes the loads of the one before.
        let mut before = vec![0.0; engine.interfaces.len()];
        for found in &mut loads {
            match found {
                Some(found) => before.clone_from(found),
                None => *found = Some(before.clone()),
            }
        }
        let loads: Vec<Vec<f64>> = loads.into_iter().flatten().collect();
        let place = |k: &usize| mu.columns.iter().position(|(column, _)| column == k);
        let moved: Vec<(usize, Vec<usize>)> = groups
            .iter()
            .filter_map(|group| Some((group.iter().find_map(place)?, group.clone())))
            .collect();
        let actuators = self.block.channels.len();
        let count = mu.columns.len();
        // The columns, then for each group the friction that the change of loads adds.
        let mut signals: Vec<Vec<f64>> = Vec::with_capacity(self.instants.len());
        for (unit, loads) in mu.unit.iter().zip(&loads) {
            let mut row = vec![0.0; actuators * (count + moved.len())];
            for (index, &(_, interface)) in mu.columns.iter().enumerate() {
                let load = loads[interface] - engine.interfaces[interface].load.preload;
                for channel in 0..actuators {
                    row[index * actuators + channel] = unit[index * actuators + channel] * load;
                }
            }
            signals.push(row);
        }
        for (number, (_, group)) in moved.iter().enumerate() {
            let size = group.iter().map(|&k| values[k]).fold(LEAST, f64::max);
            let step = STEP * size;
            let mut changed = values.to_vec();
            group.iter().for_each(|&k| changed[k] += step);
            let engine_after = self.regressor.engine_parameters(&changed);
            // Near a lock the loads exist on one side only: without derivative, as a fixed point.
            let Ok(after) = self.loads(&engine_after) else { continue };
            for (k, after) in after.iter().enumerate() {
                let Some(after) = after else { continue };
                for (index, &(column, interface)) in mu.columns.iter().enumerate() {
                    let preload =
                        |engine: &Parameters<f64>| engine.interfaces[interface].load.preload;
                    let change = (after[interface] - preload(&engine_after))
                        - (loads[k][interface] - preload(&engine));
                    let factor = values[column] * change / step;
                    for channel in 0..actuators {
                        signals[k][(count + number) * actuators + channel] +=
                            mu.unit[k][index * actuators + channel] * factor;
                    }
                }
            }
        }
        let grid: Vec<f64> = self.instants.iter().map(|(time, _)| *time).collect();
        let width = actuators * (count + moved.len());
        let filtered =
            mu.filter.apply(&grid, width, |k, out| out.copy_from_slice(&signals[k]), &mu.at);
        for (channel, rows) in self.block.channels.iter_mut().enumerate() {
            rows.right.copy_from(&mu.rights[channel]);
            for (row, &step) in rows.steps.iter().enumerate() {
                for (index, &(column, _)) in mu.columns.iter().enumerate() {
                    rows.matrix[(row, column)] = filtered[step][index * actuators + channel];
                }
                for (number, (first, group)) in moved.iter().enumerate() {
                    let derivative = filtered[step][(count + number) * actuators + channel];
                    let column = mu.columns[*first].0;
                    rows.matrix[(row, column)] += derivative;
                    debug_assert!(group.iter().all(|&k| matches!(parameters[k].kind, Kind::Mu(_))));
                    rows.right[row] += derivative * values[column];
                }
            }
        }
        Ok(())
    }

    /// Normal loads at all instants, N; `None` for an instant at which the forces have no solution.
    fn loads(&self, engine: &Parameters<f64>) -> Result<Vec<Option<Vec<f64>>>, String> {
        let mut data = self.regressor.engine_data();
        let mut failed: Option<String> = None;
        let mut loads = Vec::with_capacity(self.instants.len());
        for (time, [q, v, a]) in &self.instants {
            let found = self.regressor.loads(engine, &mut data, [q, v, a]);
            if let Err(status) = &found {
                failed.get_or_insert_with(|| format!("at {time:.4} s: {status:?}"));
            }
            loads.push(found.ok());
        }
        let failures = loads.iter().filter(|loads| loads.is_none()).count();
        match failures as f64 > super::MAY_FAIL * self.instants.len() as f64 {
            true => Err(failed.unwrap_or_default()),
            false => Ok(loads),
        }
    }
}
