//! Error of the predicted efforts due to the filter, which attenuates the parts of the motion near
//! the cut-off frequency.
//!
//! The theory is in equation (I8) of the book.

use super::filter::{RowFilter, within};
use super::pieces::{self, by_pieces, starting};
use super::reversals::split;
use super::{Prepared, gaps};
use nalgebra::DVector;
use stiction_core::dynamics::{Data, Status};
use stiction_identify::{Kind, Regressor};

impl Prepared {
    /// Estimates the error of the predicted efforts due to the filter, N or N m, in the regression
    /// rows of each actuator: the efforts of the filtered motion minus the efforts of the motion
    /// filtered twice. `None` for steady motions, for simulated motions, whose efforts pass through
    /// the same filter as the measured ones, for pieces of the log that are too short, and if the
    /// forces of the model have no solution at some instant.
    pub(in crate::identify) fn filter_error(
        &self,
        values: &[f64],
        at: &DVector<f64>,
    ) -> Option<Vec<DVector<f64>>> {
        let RowFilter::LowPass(pieces) = &self.mu.filter else { return None };
        let cutoff = self.cutoff.filter(|_| !self.is_simulated)?;
        let parameters = self.regressor.parameters();
        let grid: Vec<f64> = self.instants.iter().map(|(time, _)| *time).collect();
        // Effort terms and offsets are left out, because the filter is assumed to have no effect on
        // them.
        let moving = DVector::from_fn(at.len(), |k, _| match parameters[k].kind {
            Kind::Term(_) | Kind::Offset(_) => 0.0,
            _ => at[k],
        });
        let mut motion: Vec<[Vec<f64>; 3]> = Vec::with_capacity(grid.len());
        for (filter, ends) in pieces {
            if !gaps::is_long(*ends, cutoff) {
                return None;
            }
            let samples = within(&grid, *ends);
            let count = self.instants[samples.clone()].first()?.1[0].len();
            let positions: Vec<Vec<f64>> = (0..count)
                .map(|k| self.instants[samples.clone()].iter().map(|(_, [q, ..])| q[k]).collect())
                .collect();
            let smooth = filter.smooth(&grid[samples.clone()], &positions);
            motion.extend(grid[samples].iter().map(|&time| {
                let targets: Vec<_> = smooth.iter().map(|one| one.signal.at(time)).collect();
                split(&targets)
            }));
        }
        if motion.len() != grid.len() {
            return None;
        }
        let mut regressor = self.regressor.clone();
        regressor.set_static_excess(values);
        let engine = regressor.engine_parameters(values);
        let has_loads = parameters.iter().any(|p| matches!(p.kind, Kind::Mu(_)));
        let efforts_at = |regressor: &mut Regressor, data: &mut Data<f64>, k: usize| {
            let [q, v, a] = &motion[k];
            let mut columns = regressor.at(q, v, a)?;
            if has_loads {
                let solved = regressor.loads(&engine, data, [q, v, a])?;
                for (k, p) in parameters.iter().enumerate() {
                    match p.kind {
                        Kind::Mu(i) => columns.matrix.column_mut(k).scale_mut(solved.loads[i]),
                        // The columns of sliding friction contain the excess.
                        Kind::StaticExcess(_) => columns.matrix.column_mut(k).fill(0.0),
                        _ => {}
                    }
                }
            }
            Ok((columns.known + columns.matrix * &moving).as_slice().to_vec())
        };
        let efforts = by_pieces(pieces::pieces(&grid, &self.starts), |piece| {
            let mut regressor = regressor.clone();
            if let Some(state) = starting(&self.starts, grid[piece.start]) {
                regressor.start_from(state);
            }
            let mut data = regressor.engine_data();
            let each = piece.map(|k| efforts_at(&mut regressor, &mut data, k));
            each.collect::<Vec<Result<Vec<f64>, Status>>>()
        });
        let efforts: Vec<Vec<f64>> = efforts.into_iter().collect::<Result<_, _>>().ok()?;
        let channels = self.block.channels.len();
        let after = self.mu.filter.apply(
            &grid,
            channels,
            |k, out| out.copy_from_slice(&efforts[k]),
            &self.times,
        );
        let each = self.block.channels.iter().enumerate().map(|(channel, rows)| {
            let fixed = &rows.matrix * (at - &moving);
            let before = rows.predicted(at) - fixed;
            DVector::from_fn(rows.len(), |row, _| before[row] - after[rows.steps[row]][channel])
        });
        Some(each.collect())
    }
}
