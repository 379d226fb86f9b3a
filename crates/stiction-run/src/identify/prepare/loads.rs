//! Linearisation of the load-dependent friction for the regression. The normal loads themselves
//! depend on friction.
//!
//! The theory is in equation (I6) of the book.

use super::Prepared;
use super::filter::RowFilter;
use super::pieces::{by_pieces, pieces, starting};
use super::rows::{Assembled, Computed};
use crate::identify::run::differences;
use nalgebra::{DMatrix, DVector};
use stiction_core::dynamics::Status;
use stiction_identify::{Kind, LoadSlopes, Parameter, Regressor, Solved};

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

/// Normal loads at one instant, and the derivatives of the friction that result from them.
struct Instant {
    solved: Solved,
    /// Derivatives of the load-dependent friction with respect to groups of parameters, as far as
    /// they result from changes of the normal loads. The index is `group * actuators + channel`.
    /// Empty where the loads have no derivative, such as near jamming.
    slopes: Vec<f64>,
}

/// Places of the signals of each instant, after which the regression columns are filtered.
struct Layout {
    actuators: usize,
    columns: usize,
    curves: usize,
    groups: usize,
}

impl Layout {
    /// Place of the load-dependent friction of a column of [`MuColumns::columns`] in an effort.
    fn column(&self, index: usize, channel: usize) -> usize {
        index * self.actuators + channel
    }

    /// Places of the load-independent friction, and of the derivative with respect to the excess of
    /// static friction, of an interface of [`MuColumns::curves`].
    fn curve(&self, index: usize, channel: usize) -> [usize; 2] {
        let first = (self.columns + 2 * index) * self.actuators + channel;
        [first, first + self.actuators]
    }

    /// Place of the change of the friction by the change of the loads due to a group of parameters.
    fn group(&self, number: usize, channel: usize) -> usize {
        (self.columns + 2 * self.curves + number) * self.actuators + channel
    }

    fn width(&self) -> usize {
        self.group(self.groups, 0)
    }
}

impl MuColumns {
    /// Copies the row `k` of [`Self::unit`], for the present excess of static friction of
    /// `regressor`.
    fn unit_at(&self, k: usize, regressor: &Regressor, solved: &Solved, unit: &mut Vec<f64>) {
        unit.clone_from(&self.unit[k]);
        let actuators = unit.len() / self.columns.len();
        for CurveColumns { interface, mu, first, .. } in &self.curves {
            let per_unit =
                |kind| regressor.friction_per_unit(kind, *interface, solved.velocities[*interface]);
            let before = 1.0 + first * per_unit(Kind::StaticExcess(*interface));
            let factor = per_unit(Kind::Mu(*interface)) / before;
            unit[mu * actuators..][..actuators].iter_mut().for_each(|x| *x *= factor);
        }
    }

    /// Computes [`Instant::slopes`] from the derivative of the normal load of each interface (rows)
    /// with respect to each group (columns). `unit` is a row of [`Self::unit_at`].
    fn friction_slopes(&self, values: &[f64], loads: &DMatrix<f64>, unit: &[f64]) -> Vec<f64> {
        let actuators = unit.len() / self.columns.len();
        let mut slopes = vec![0.0; actuators * loads.ncols()];
        for (&(column, interface), unit) in self.columns.iter().zip(unit.chunks(actuators)) {
            for (number, slopes) in slopes.chunks_mut(actuators).enumerate() {
                let factor = values[column] * loads[(interface, number)];
                slopes.iter_mut().zip(unit).for_each(|(slope, unit)| *slope += unit * factor);
            }
        }
        slopes
    }

    /// Writes the signals of one instant. `unit` is a row of [`Self::unit_at`].
    fn write(
        &self,
        regressor: &Regressor,
        values: &[f64],
        (unit, instant): (&[f64], &Instant),
        (layout, out): (&Layout, &mut [f64]),
    ) {
        let Instant { solved, slopes } = instant;
        let actuators = layout.actuators;
        out.fill(0.0);
        // Load-dependent friction per unit of each friction coefficient.
        for (index, &(_, interface)) in self.columns.iter().enumerate() {
            for channel in 0..actuators {
                let place = layout.column(index, channel);
                out[place] = unit[place] * solved.loads[interface];
            }
        }
        for (index, curve) in self.curves.iter().enumerate() {
            let CurveColumns { interface, mu, coulomb, .. } = curve;
            let (velocity, load) = (solved.velocities[*interface], solved.loads[*interface]);
            let per_unit = |kind| regressor.friction_per_unit(kind, *interface, velocity);
            let shape = per_unit(Kind::Mu(*interface));
            let constant = per_unit(Kind::Coulomb(*interface)) / shape;
            // Friction of the interface at high speed, without viscous friction.
            let sliding = values[self.columns[*mu].0] * load + values[*coulomb] * constant;
            let excess = per_unit(Kind::StaticExcess(*interface)) / shape * sliding;
            for channel in 0..actuators {
                let own = unit[layout.column(*mu, channel)];
                let [at_constant, at_excess] = layout.curve(index, channel);
                out[at_constant] = own * constant;
                out[at_excess] = own * excess;
            }
        }
        let first = layout.group(0, 0);
        out[first..][..slopes.len()].copy_from_slice(slopes);
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
        // Friction of a joint, and inertia of bodies, change the normal loads of other joints, and
        // thereby their friction.
        let changes_loads = |group: &&Vec<usize>| {
            group.iter().map(|&k| parameters[k].kind).any(|kind| {
                kind.interface().is_some() || !self.regressor.loaded_bodies(kind).is_empty()
            })
        };
        let groups: Vec<Vec<usize>> = groups.iter().filter(changes_loads).cloned().collect();
        let unknowns = differences(&parameters, values);
        let instants = self.instants_at(values, &groups)?;
        let mu = &self.mu;
        let layout = Layout {
            actuators: self.block.channels.len(),
            columns: mu.columns.len(),
            curves: mu.curves.len(),
            groups: groups.len(),
        };
        let grid: Vec<f64> = self.instants.iter().map(|(time, _)| *time).collect();
        let mut unit = Vec::new();
        let write = |k: usize, out: &mut [f64]| {
            mu.unit_at(k, &self.regressor, &instants[k].solved, &mut unit);
            mu.write(&self.regressor, values, (&unit, &instants[k]), (&layout, out));
        };
        let filtered = mu.filter.apply(&grid, layout.width(), write, &mu.at);
        for (channel, rows) in self.block.channels.iter_mut().enumerate() {
            rows.right.copy_from(&mu.rights[channel]);
            rows.matrix.copy_from(&mu.matrices[channel]);
            for (row, &step) in rows.steps.iter().enumerate() {
                let filtered = &filtered[step];
                for (index, &(column, _)) in mu.columns.iter().enumerate() {
                    rows.matrix[(row, column)] = filtered[layout.column(index, channel)];
                }
                for (index, curve) in mu.curves.iter().enumerate() {
                    let [constant, excess] =
                        layout.curve(index, channel).map(|place| filtered[place]);
                    rows.matrix[(row, curve.coulomb)] = constant;
                    rows.matrix[(row, curve.excess)] = excess;
                    // Sliding friction contains the excess, so its column is a derivative only.
                    rows.right[row] += excess * values[curve.excess];
                }
                for (number, group) in groups.iter().enumerate() {
                    let derivative = filtered[layout.group(number, channel)];
                    rows.matrix[(row, group[0])] += derivative;
                    rows.right[row] += derivative * unknowns[group[0]];
                }
            }
        }
        Ok(())
    }

    /// Computes the normal loads at all instants, and their derivatives with respect to `groups` of
    /// parameters. An instant at which the forces have no solution has the loads of a
    /// neighbouring instant, without derivatives. Fails if there are too many such instants.
    fn instants_at(&self, values: &[f64], groups: &[Vec<usize>]) -> Result<Vec<Instant>, String> {
        let (regressor, mu) = (&self.regressor, &self.mu);
        let engine = regressor.engine_parameters(values);
        let times: Vec<f64> = self.instants.iter().map(|(time, _)| *time).collect();
        let found = by_pieces(pieces(&times, &self.starts), |piece| {
            let mut data = regressor.engine_data();
            if let Some(state) = starting(&self.starts, times[piece.start]) {
                data.start_from(state);
            }
            let mut slopes = LoadSlopes::new(regressor, groups);
            let mut unit = Vec::new();
            let each = piece.map(|k| {
                let (_, [q, v, a]) = &self.instants[k];
                let solved = regressor.loads(&engine, &mut data, [q, v, a])?;
                let slopes = match slopes.at(&solved, (&engine, &data)) {
                    Ok(loads) if !groups.is_empty() => {
                        mu.unit_at(k, regressor, &solved, &mut unit);
                        mu.friction_slopes(values, &loads, &unit)
                    }
                    _ => Vec::new(),
                };
                Ok(Instant { solved, slopes })
            });
            each.collect::<Vec<Result<Instant, Status>>>()
        });
        let failed = || found.iter().zip(&self.instants).filter(|(found, _)| found.is_err());
        if failed().count() as f64 > super::MAY_FAIL * self.instants.len() as f64 {
            let first = failed().find_map(|(found, (time, _))| {
                let status = found.as_ref().err()?;
                Some(format!("at {time:.4} s: {}", status.reason()))
            });
            return Err(first.unwrap_or_default());
        }
        let mut before = found.iter().flatten().next().map(|own| own.solved.clone());
        let each = found.into_iter().filter_map(|found| {
            if let Ok(found) = &found {
                before = Some(found.solved.clone());
            }
            found.ok().or_else(|| Some(Instant { solved: before.clone()?, slopes: Vec::new() }))
        });
        Ok(each.collect())
    }
}
