//! Linearisation of the load-dependent friction for the regression. The normal loads themselves
//! depend on friction.
//!
//! The theory is in equation (I6) of the book.

use super::Prepared;
use super::filter::RowFilter;
use super::rows::{Assembled, Computed};
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;
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
    /// Interfaces with Stribeck's curve whose excess of static friction is a parameter.
    curves: Vec<CurveColumns>,
    /// Times of all rows of the regression, s.
    at: Vec<f64>,
    pub(super) filter: RowFilter,
    /// Right-hand side of the regression for each actuator before the linearisation, which still
    /// includes all friction.
    rights: Vec<DVector<f64>>,
    /// Regression columns for each actuator before the linearisation.
    matrices: Vec<DMatrix<f64>>,
}

/// Regression columns of an interface with Stribeck's curve.
struct CurveColumns {
    interface: usize,
    /// Index of the friction coefficient in [`MuColumns::columns`].
    mu: usize,
    /// Columns of the excess of static friction and of the load-independent friction.
    excess: usize,
    coulomb: usize,
    /// Excess of static friction in [`MuColumns::unit`].
    first: f64,
}

impl CurveColumns {
    /// Finds the interfaces in `parameters`. `columns` are those of [`MuColumns`].
    fn all(parameters: &[Parameter], columns: &[(usize, usize)]) -> Vec<Self> {
        let each = parameters.iter().enumerate().filter_map(|(excess, p)| {
            let Kind::StaticExcess(interface) = p.kind else { return None };
            let mu = columns.iter().position(|(_, own)| *own == interface)?;
            let coulomb = parameters.iter().position(|own| own.kind == Kind::Coulomb(interface))?;
            Some(Self { interface, mu, excess, coulomb, first: p.prior })
        });
        each.collect()
    }
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
        let columns: Vec<_> = computed.mu.iter().filter_map(|&k| interface(k)).collect();
        Self {
            curves: CurveColumns::all(parameters, &columns),
            columns,
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
    /// Returns [`Self::unit`] for the present excess of static friction of `regressor`.
    fn unit_now(&self, regressor: &Regressor, solved: &[Solved]) -> Cow<'_, [Vec<f64>]> {
        if self.curves.is_empty() {
            return Cow::Borrowed(&self.unit);
        }
        let mut unit = self.unit.clone();
        for (unit, solved) in unit.iter_mut().zip(solved) {
            let actuators = unit.len() / self.columns.len();
            for CurveColumns { interface, mu, first, .. } in &self.curves {
                let per_unit = |kind| {
                    regressor.friction_per_unit(kind, *interface, solved.velocities[*interface])
                };
                let before = 1.0 + first * per_unit(Kind::StaticExcess(*interface));
                let factor = per_unit(Kind::Mu(*interface)) / before;
                unit[mu * actuators..][..actuators].iter_mut().for_each(|x| *x *= factor);
            }
        }
        Cow::Owned(unit)
    }

    /// Computes the columns of load-independent friction and of the excess of static friction of all interfaces in
    /// [`Self::curves`] at one instant, for each effort. `unit` is the row of [`Self::unit_now`].
    fn curve_columns(
        &self,
        regressor: &Regressor,
        values: &[f64],
        (unit, solved): (&[f64], &Solved),
    ) -> Vec<f64> {
        let actuators = unit.len() / self.columns.len();
        let mut row = Vec::with_capacity(2 * self.curves.len() * actuators);
        for CurveColumns { interface, mu, coulomb, .. } in &self.curves {
            let (velocity, load) = (solved.velocities[*interface], solved.loads[*interface]);
            let per_unit = |kind| regressor.friction_per_unit(kind, *interface, velocity);
            let shape = per_unit(Kind::Mu(*interface));
            let constant = per_unit(Kind::Coulomb(*interface)) / shape;
            // Friction of the interface at high speed, without viscous friction.
            let sliding = values[self.columns[*mu].0] * load + values[*coulomb] * constant;
            let excess = per_unit(Kind::StaticExcess(*interface)) / shape * sliding;
            let own = &unit[mu * actuators..][..actuators];
            row.extend(own.iter().map(|x| x * constant));
            row.extend(own.iter().map(|x| x * excess));
        }
        row
    }

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
        if self.mu.columns.is_empty() {
            return Ok(());
        }
        self.regressor.set_static_excess(values);
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
        let mu = &self.mu;
        let unit = mu.unit_now(&self.regressor, &solved);
        let actuators = self.block.channels.len();
        let count = mu.columns.len();
        // Load-dependent friction per unit of each friction coefficient, at the solved normal
        // loads.
        let columns: Vec<Vec<f64>> = unit
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
        let width = 2 * mu.curves.len() * actuators;
        if width > 0 {
            let row = |k: usize, out: &mut [f64]| {
                let own = (&unit[k][..], &solved[k]);
                out.copy_from_slice(&mu.curve_columns(&self.regressor, values, own));
            };
            let filtered = mu.filter.apply(&grid, width, row, &mu.at);
            for (channel, rows) in self.block.channels.iter_mut().enumerate() {
                for (row, &step) in rows.steps.iter().enumerate() {
                    for (index, curve) in mu.curves.iter().enumerate() {
                        let own = &filtered[step][2 * index * actuators..];
                        rows.matrix[(row, curve.coulomb)] = own[channel];
                        rows.matrix[(row, curve.excess)] = own[actuators + channel];
                        // Sliding friction contains the excess, so its column is a derivative only.
                        rows.right[row] += own[actuators + channel] * values[curve.excess];
                    }
                }
            }
        }
        // Friction of a joint changes the normal loads, and thereby the friction, of other joints.
        // Inertia also changes them, but this effect is small compared with the direct effect of
        // inertia on the effort. It is neglected, because it would require one more solution for
        // each inertial parameter. The next linearisation uses the changed loads.
        let changes_loads = |group: &&Vec<usize>| {
            let kind = parameters[group[0]].kind;
            matches!(
                kind,
                Kind::Mu(_) | Kind::StaticExcess(_) | Kind::Coulomb(_) | Kind::Viscous(_)
            )
        };
        let moved: Vec<Vec<usize>> = groups.iter().filter(changes_loads).cloned().collect();
        for groups in moved.chunks(DIRECTIONS) {
            let slopes = self.load_friction_slopes(values, groups, (&solved, &is_solved, &unit));
            let width = actuators * groups.len();
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
        (solved, is_solved, unit): (&[Solved], &[bool], &[Vec<f64>]),
    ) -> Vec<Vec<f64>> {
        let (mu, actuators) = (&self.mu, self.block.channels.len());
        let mut slopes = LoadSlopes::new(&self.regressor, values, groups);
        let each = self.instants.iter().zip(solved.iter().zip(is_solved)).zip(unit);
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
