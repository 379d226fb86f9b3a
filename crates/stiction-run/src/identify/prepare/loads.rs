//! Linearisation of the load-dependent friction for the regression. The normal loads themselves
//! depend on friction.
//!
//! The theory is in equation (I6) of the book.

use super::Prepared;
use super::filter::RowFilter;
use super::rows::{Assembled, Computed};
use nalgebra::{DMatrix, DVector};
use stiction_core::parameters::Parameters;
use stiction_identify::{DIRECTIONS, Kind, LoadSlopes, Parameter, Regressor, Solved};

/// Data for the regression columns of the friction coefficients.
pub(super) struct MuColumns {
    /// Index of the regression column of each friction coefficient, and the index of its friction
    /// interface.
    columns: Vec<(usize, usize)>,
    /// For each instant, the contribution of each friction coefficient to each effort under unit
    /// normal load. The index is `column * actuators + channel`, where `column` is an index into
    /// [`Self::columns`].
    unit: Vec<Vec<f64>>,
    /// Times of all rows of the regression, s.
    at: Vec<f64>,
    pub(super) filter: RowFilter,
    /// Right-hand side of the regression for each actuator before the linearisation, which still
    /// includes all friction.
    rights: Vec<DVector<f64>>,
    /// Regression columns for each actuator before the linearisation.
    matrices: Vec<DMatrix<f64>>,
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
            matrices: match computed.mu.is_empty() {
                true => Vec::new(),
                false => assembled.block.channels.iter().map(|rows| rows.matrix.clone()).collect(),
            },
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
    /// Linearises the load-dependent friction about the parameter values `values`. The regression
    /// columns become the derivatives of the efforts, including the change of the normal loads; the
    /// right-hand side contains the remaining constant part. Parameters in one of `groups` change
    /// together; parameters in no group are fixed.
    ///
    /// # Errors
    /// If too many instants fail, returns the first time at which the forces have no solution, with
    /// the reason.
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
        let mut solved = self.solved(&engine)?;
        let is_solved: Vec<bool> = solved.iter().map(Option::is_some).collect();
        // An instant without a solution uses the loads of a neighbouring instant, without
        // derivatives.
        let mut before = solved.iter().flatten().next().cloned();
        for found in &mut solved {
            match found {
                Some(found) => before = Some(found.clone()),
                None => found.clone_from(&before),
            }
        }
        let solved: Vec<Solved> = solved.into_iter().flatten().collect();
        let actuators = self.block.channels.len();
        let count = mu.columns.len();
        // Load-dependent friction per unit of each friction coefficient, at the solved normal
        // loads.
        let columns: Vec<Vec<f64>> = mu
            .unit
            .iter()
            .zip(&solved)
            .map(|(unit, solved)| {
                let mut row = unit.clone();
                for (index, &(_, interface)) in mu.columns.iter().enumerate() {
                    let load = solved.loads[interface];
                    row[index * actuators..][..actuators].iter_mut().for_each(|x| *x *= load);
                }
                row
            })
            .collect();
        let grid: Vec<f64> = self.instants.iter().map(|(time, _)| *time).collect();
        let width = actuators * count;
        let filtered =
            mu.filter.apply(&grid, width, |k, out| out.copy_from_slice(&columns[k]), &mu.at);
        for (channel, rows) in self.block.channels.iter_mut().enumerate() {
            rows.right.copy_from(&mu.rights[channel]);
            rows.matrix.copy_from(&mu.matrices[channel]);
            for (row, &step) in rows.steps.iter().enumerate() {
                for (index, &(column, _)) in mu.columns.iter().enumerate() {
                    rows.matrix[(row, column)] = filtered[step][index * actuators + channel];
                }
            }
        }
        drop((columns, filtered));
        // Friction of a joint changes the normal loads, and thereby the friction, of other joints.
        // Inertia also changes them, but this effect is small compared with the direct effect of
        // inertia on the effort. It is neglected, because it would require one more solution for
        // each inertial parameter. The next linearisation uses the changed loads.
        let changes_loads = |group: &&Vec<usize>| {
            matches!(parameters[group[0]].kind, Kind::Mu(_) | Kind::Coulomb(_) | Kind::Viscous(_))
        };
        let moved: Vec<Vec<usize>> = groups.iter().filter(changes_loads).cloned().collect();
        for groups in moved.chunks(DIRECTIONS) {
            let slopes = self.load_friction_slopes(values, groups, (&solved, &is_solved));
            let width = actuators * groups.len();
            let mu = &self.mu;
            let filtered =
                mu.filter.apply(&grid, width, |k, out| out.copy_from_slice(&slopes[k]), &mu.at);
            for (channel, rows) in self.block.channels.iter_mut().enumerate() {
                for (row, &step) in rows.steps.iter().enumerate() {
                    for (number, group) in groups.iter().enumerate() {
                        let derivative = filtered[step][number * actuators + channel];
                        rows.matrix[(row, group[0])] += derivative;
                        rows.right[row] += derivative * values[group[0]];
                    }
                }
            }
        }
        Ok(())
    }

    /// Computes the derivatives of the load-dependent friction with respect to groups of parameters
    /// at each instant, as far as they result from changes of the normal loads. The index is
    /// `group * actuators + channel`. The derivatives are zero where the loads have no derivative,
    /// such as near jamming.
    fn load_friction_slopes(
        &self,
        values: &[f64],
        groups: &[Vec<usize>],
        (solved, is_solved): (&[Solved], &[bool]),
    ) -> Vec<Vec<f64>> {
        let (mu, actuators) = (&self.mu, self.block.channels.len());
        let mut slopes = LoadSlopes::new(&self.regressor, values, groups);
        let each = self.instants.iter().zip(solved.iter().zip(is_solved)).zip(&mu.unit);
        each.map(|(((_, [q, v, a]), (solved, is_solved)), unit)| {
            let mut row = vec![0.0; actuators * groups.len()];
            if !is_solved {
                return row;
            }
            let Ok(loads) = slopes.at(solved, [q, v, a]) else { return row };
            let loads: Vec<_> = loads.collect();
            for (index, &(column, interface)) in mu.columns.iter().enumerate() {
                for number in 0..groups.len() {
                    let factor = values[column] * loads[interface][number];
                    for channel in 0..actuators {
                        row[number * actuators + channel] +=
                            unit[index * actuators + channel] * factor;
                    }
                }
            }
            row
        })
        .collect()
    }

    /// Computes the normal loads at all instants; `None` for an instant at which the forces have no
    /// solution. Fails if there are too many such instants.
    fn solved(&self, engine: &Parameters<f64>) -> Result<Vec<Option<Solved>>, String> {
        let mut data = self.regressor.engine_data();
        let mut failed: Option<String> = None;
        let mut all = Vec::with_capacity(self.instants.len());
        for (time, [q, v, a]) in &self.instants {
            let found = self.regressor.loads(engine, &mut data, [q, v, a]);
            if let Err(status) = &found {
                failed.get_or_insert_with(|| format!("at {time:.4} s: {}", status.reason()));
            }
            all.push(found.ok());
        }
        let failures = all.iter().filter(|found| found.is_none()).count();
        match failures as f64 > super::MAY_FAIL * self.instants.len() as f64 {
            true => Err(failed.unwrap_or_default()),
            false => Ok(all),
        }
    }
}
