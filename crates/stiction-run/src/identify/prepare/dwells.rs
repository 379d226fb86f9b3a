//! Dwells: intervals at standstill in which the static friction limits bound the efforts.
//!
//! The theory is in equation (I9) of the book.

use super::Prepared;
use super::motion::ROWS_PER_PERIOD;
use nalgebra::{DMatrix, DVector};
use stiction_identify::{Dwells, Kind};

/// Factor on the normal loads computed without friction, for an estimate of the largest normal
/// loads at rest. Static friction changes joint reactions by an unknown amount, which is about the
/// loads times the friction coefficient.
const LOADED: f64 = 1.2;
/// Largest number of equal parts into which a dwell is divided. The least and the greatest effort
/// of the dwell are mean efforts of such parts.
const PARTS: usize = 8;

/// Dwell: interval in which the mechanism is at standstill.
#[derive(Clone, Debug)]
pub(super) struct Standstill {
    /// Time of the first regression row of the dwell that is used, s.
    start: f64,
    /// Mean position of each coordinate during the dwell, rad or m.
    position: Vec<f64>,
    /// Least and greatest mean effort of each actuator over the parts of the dwell, N or N m.
    efforts: Vec<[f64; 2]>,
}

impl Standstill {
    /// Multiplies the efforts of an actuator by a positive factor.
    pub(super) fn scale(&mut self, channel: usize, factor: f64) {
        self.efforts[channel].iter_mut().for_each(|effort| *effort *= factor);
    }
}

/// Time between two successive rows, as a multiple of the median time step, above which the log has
/// a gap.
const GAP: f64 = 1.5;

/// Finds the dwells among the regression rows at `times`, s: intervals in which `is_resting` is
/// true. `effort` returns the filtered effort of an actuator in a row, and `position` the values of
/// all coordinates in a row. One period of the cut-off frequency is left out at both ends of a
/// dwell. A dwell ends at a gap in the log, during which the mechanism may have moved.
pub(super) fn standstills(
    times: &[f64],
    is_resting: impl Fn(usize) -> bool,
    effort: impl Fn(usize, usize) -> f64,
    (actuators, position): (usize, impl Fn(usize) -> Vec<f64>),
) -> Vec<Standstill> {
    let margin = ROWS_PER_PERIOD as usize;
    let rows = times.len();
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_unstable_by(f64::total_cmp);
    let longest = GAP * steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let mut all = Vec::new();
    let mut from = 0;
    while from < rows {
        let follows = |k: usize| k == from || times[k] - times[k - 1] <= longest;
        let length = (from..rows).take_while(|&k| is_resting(k) && follows(k)).count();
        if length > 2 * margin {
            let own: Vec<usize> = (from + margin..from + length - margin).collect();
            // Each mean covers at least a period of the cut-off frequency, so it has less noise
            // than a single row.
            let part = own.len().div_ceil(PARTS).max(margin.min(own.len()));
            let efforts = (0..actuators).map(|channel| {
                let means = own.chunks_exact(part).map(|rows| {
                    rows.iter().map(|&k| effort(k, channel)).sum::<f64>() / rows.len() as f64
                });
                means.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], mean| {
                    [low.min(mean), high.max(mean)]
                })
            });
            let efforts: Vec<[f64; 2]> = efforts.collect();
            let count = own.len() as f64;
            let sum = own.iter().map(|&k| position(k)).reduce(|mut sum, own| {
                sum.iter_mut().zip(own).for_each(|(sum, x)| *sum += x);
                sum
            });
            if let Some(sum) = sum {
                let position = sum.iter().map(|x| x / count).collect();
                all.push(Standstill { start: times[own[0]], position, efforts });
            }
        }
        from += length.max(1);
    }
    all
}

impl Prepared {
    /// Sets the bounds of the efforts at rest, with the normal loads for the parameter values
    /// `values`. Returns the number of dwells without bounds and the total number of dwells. A
    /// dwell has no bounds if the forces of the model have no solution at the position of the
    /// dwell, or if an effort term is a formula, which may have any value at rest.
    ///
    /// During a dwell, the mechanism may creep at a rate below the noise of the rates. The bounds
    /// remain valid, because sliding friction obeys the same limits.
    pub(in crate::identify) fn set_dwells(&mut self, values: &[f64]) -> [usize; 2] {
        self.block.dwells.clear();
        let all = self.standstills.len();
        let engine = self.regressor.engine_parameters(values);
        let count = self.block.channels.len();
        let parameters = self.regressor.parameters().to_vec();
        let mut rows = vec![Vec::new(); count];
        let mut regressor = self.regressor.clone();
        regressor.set_static_excess(values);
        for dwell in &self.standstills {
            let rest = vec![0.0; dwell.position.len()];
            let motion: [&[f64]; 3] = [&dwell.position, &rest, &rest];
            // This state agrees with the position of the dwell within the noise, and therefore
            // selects the assembly mode of the log.
            let before = self.rests.partition_point(|(time, _)| *time <= dwell.start);
            let Some((_, state)) = before.checked_sub(1).map(|k| &self.rests[k]) else { continue };
            regressor.start_from(state);
            let Ok(columns) = regressor.at(&dwell.position, &rest, &rest) else { continue };
            let Some((mut limits, fixed)) = regressor.limits() else { continue };
            let mut data = regressor.engine_data();
            let Ok(solved) = regressor.loads(&engine, &mut data, motion) else { continue };
            let mut matrix = columns.matrix;
            for (k, p) in parameters.iter().enumerate() {
                if let Kind::Mu(i) = p.kind {
                    limits.column_mut(k).scale_mut(LOADED * solved.loads[i].abs());
                }
                match p.kind {
                    // The columns contain efforts without friction; `limits` contains the friction.
                    kind if kind.is_friction() => matrix.column_mut(k).fill(0.0),
                    // A formula may have any value at rest.
                    Kind::Term(_) => return [all; 2],
                    _ => {}
                }
            }
            for (channel, rows) in rows.iter_mut().enumerate() {
                let [low, high] = dwell.efforts[channel];
                let known = columns.known[channel];
                let bounds = [low - known + fixed[channel], high - known - fixed[channel]];
                let mut columns = matrix.row(channel).into_owned();
                // An unknown torque constant scales the effort. The middle of the bounds represents
                // this effort.
                let (bounds, constant) =
                    self.scaled_by_constant(channel, bounds, 0.5 * (low + high));
                if let Some((parameter, slope)) = constant {
                    columns[parameter] = slope;
                }
                rows.push((columns, limits.row(channel).into_owned(), bounds));
            }
        }
        let used = rows.first().map_or(0, Vec::len);
        self.block.dwells = rows
            .into_iter()
            .filter(|rows| !rows.is_empty())
            .map(|rows| Dwells {
                matrix: stacked(rows.iter().map(|(row, ..)| row.transpose())),
                limits: stacked(rows.iter().map(|(_, row, _)| row.transpose())),
                bounds: rows.iter().map(|(.., bounds)| *bounds).collect(),
            })
            .collect();
        [all - used, all]
    }
}

fn stacked(rows: impl Iterator<Item = DVector<f64>>) -> DMatrix<f64> {
    DMatrix::from_columns(&rows.collect::<Vec<_>>()).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that a dwell of 40 rows loses four rows at each end, and that a dwell of 8 rows is too
    /// short.
    #[test]
    fn dwells_keep_off_the_motion() {
        let is_resting = |k: usize| (10..50).contains(&k) || (60..68).contains(&k);
        let effort = |k: usize, _: usize| if !(14..46).contains(&k) { 100.0 } else { k as f64 };
        let times: Vec<f64> = (0..80).map(|k| 0.1 * f64::from(k)).collect();
        let find = |times: &[f64]| standstills(times, is_resting, effort, (1, |k| vec![k as f64]));
        let found = find(&times);
        assert_eq!(found.len(), 1);
        // The least mean is that of the first four rows that are used, the greatest that of the
        // last four.
        assert_eq!(found[0].efforts, [[15.5, 43.5]]);
        assert_eq!(found[0].position, [29.5]);
        assert_eq!(found[0].start, times[14]);
        // A gap in the log divides the dwell into two.
        let gap: Vec<f64> =
            times.iter().enumerate().map(|(k, t)| if k < 30 { *t } else { t + 5.0 }).collect();
        let places: Vec<f64> = find(&gap).iter().map(|dwell| dwell.position[0]).collect();
        assert_eq!(places, [19.5, 39.5]);
    }
}
