//! From a log to rows of the regression: filtered positions, efforts and columns.

use super::IdentifyError as Error;
use super::chosen::{assembled, chosen_coordinates, chosen_efforts, refuse};
use super::options::LogSettings;
use nalgebra::{DMatrix, DVector};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::parameters::Parameters;
use stiction_format::{Drives, Log, LowPass, ModelFile, Signal};
use stiction_identify::{Block, Choice, Kind, Parameter, Regressor, Rows};

/// A log with its options.
#[derive(Clone, Debug)]
pub struct MeasuredLog {
    /// Name in results.
    pub name: String,
    /// Its rows.
    pub log: Log,
    /// Its options.
    pub settings: LogSettings,
}

/// Samples of the regressor per period of the cut-off frequency.
const PER_PERIOD: f64 = 16.0;
/// Rows of the regression per period of the cut-off frequency.
const ROWS_PER_PERIOD: f64 = 4.0;
/// Share of friction at rest in a filtered row above which it is left out.
const RESTING: f64 = 0.02;
/// Samples of one extreme value in a row that mean saturation.
const SATURATED: usize = 5;
/// Rows from which a cut-off frequency is suggested.
const EXAMINED: usize = 20_000;
/// Part of the instants that may fail.
const MAY_FAIL: f64 = 0.05;

/// A prepared log.
pub(super) struct Prepared {
    pub(super) name: String,
    pub(super) predict: bool,
    pub(super) block: Block,
    pub(super) regressor: Regressor,
    /// Instants of the regressor: time, then positions, rates, accelerations.
    pub(super) instants: Vec<(f64, [Vec<f64>; 3])>,
    /// Columns of coefficients of friction at all instants, actuator by actuator, for unit loads.
    unit_friction: Vec<Vec<f64>>,
    /// Times of the rows, s, and the rows that each actuator uses.
    pub(super) times: Vec<f64>,
    filter: LowPass,
    pub(super) cutoff: f64,
    /// Standard deviation of white noise of each effort after the filter, N or N m.
    pub(super) effort_noise: Vec<f64>,
    pub(super) cautions: Vec<String>,
}

impl Prepared {
    pub(super) fn new(
        model: &ModelFile,
        log: &MeasuredLog,
        (filter, choice): (Option<f64>, Choice),
        terms: &[Drives],
    ) -> Result<Self, Error> {
        let coordinates = chosen_coordinates(model, log)?;
        let (efforts, _) = chosen_efforts(&model.mechanism, log)?;
        let mut cautions = Vec::new();
        let kept: Vec<usize> = (0..log.log.times.len())
            .filter(|&k| (log.settings.from..=log.settings.until).contains(&log.log.times[k]))
            .collect();
        let times: Vec<f64> = kept.iter().map(|&k| log.log.times[k]).collect();
        let pick = |column: usize| -> Vec<f64> {
            kept.iter().map(|&k| log.log.columns[column].values[k]).collect()
        };
        let positions: Vec<Vec<f64>> =
            coordinates.iter().map(|(_, column)| pick(*column)).collect();
        let (Some(&start), Some(&end)) = (times.first(), times.last()) else {
            return Err(refuse(
                format!("{} has no row in the chosen time", log.name),
                "check `from` and `until`",
            ));
        };
        let rate = (times.len() - 1) as f64 / (end - start);
        for ((_, column), values) in coordinates.iter().zip(&positions) {
            if values.iter().all(|x| *x == values[0]) {
                cautions.push(format!(
                    "{}: `{}` is constant: nothing that needs its motion can be identified",
                    log.name, log.log.columns[*column].name
                ));
            }
        }
        let cutoff = match filter {
            Some(cutoff) => cutoff,
            None => {
                let count = times.len().min(EXAMINED);
                let some: Vec<Vec<f64>> = positions.iter().map(|p| p[..count].to_vec()).collect();
                // Exact positions of a model suggest the highest frequency that the samples carry.
                LowPass::suggested(&times[..count], &some).unwrap_or(0.1 * rate).min(0.1 * rate)
            }
        };
        let (low, high) = (4.0 / (end - start), 0.4 * rate);
        if !(low..=high).contains(&cutoff) {
            return Err(refuse(
                format!(
                    "{}: a filter of {cutoff} Hz does not suit {:.3} s at {rate:.4} samples per second",
                    log.name,
                    end - start
                ),
                format!(
                    "give a cut-off frequency from {low:.2} Hz to {high:.2} Hz by --filter, or a longer log"
                ),
            ));
        }
        let low_pass = LowPass::new(cutoff, (start, end));
        let smooth = low_pass.smooth(&times, &positions);
        let signals: Vec<Signal> = smooth.iter().map(|smooth| smooth.signal.clone()).collect();

        let only: Vec<Coordinate> = coordinates.iter().map(|(coordinate, _)| *coordinate).collect();
        let first: Vec<f64> = signals.iter().map(|signal| signal.at(start).value).collect();
        let solver = assembled(model, log, &only, &first)?;
        let mut regressor = Regressor::new(solver, choice).map_err(|unsuitable| {
            refuse(
                format!("{}: {unsuitable}", log.name),
                "redundant actuation is not identified yet",
            )
        })?;
        let mut carried = model.mechanism.clone();
        for payload in &log.settings.payloads {
            carried = carried.with_payload(payload.body, &payload.part);
        }
        regressor.carry(&carried);

        let step = (PER_PERIOD * cutoff).min(rate).recip();
        let count = ((end - start) / step).floor().max(1.0) as usize;
        let parameters = regressor.parameters().to_vec();
        let (actuators, width) = (efforts.len(), parameters.len());
        let mu: Vec<usize> =
            (0..width).filter(|&k| matches!(parameters[k].kind, Kind::Mu(_))).collect();
        let mut instants = Vec::new();
        let mut unit_friction = Vec::new();
        let mut rows = Vec::new();
        let mut failures: Option<(f64, String)> = None;
        for k in 0..=count {
            let time = (start + k as f64 * step).min(end);
            let targets: Vec<Target<f64>> = signals.iter().map(|signal| signal.at(time)).collect();
            let q: Vec<f64> = targets.iter().map(|t| t.value).collect();
            let v: Vec<f64> = targets.iter().map(|t| t.rate).collect();
            let a: Vec<f64> = targets.iter().map(|t| t.acceleration).collect();
            match regressor.at(&q, &v, &a) {
                Ok(mut columns) => {
                    for (index, drives) in terms.iter().enumerate() {
                        let Some(column) =
                            parameters.iter().position(|p| p.kind == Kind::Term(index))
                        else {
                            continue;
                        };
                        write_term(drives, time, (&only, &targets), &mut columns.matrix, column);
                    }
                    let friction = mu.iter().flat_map(|&k| {
                        columns.matrix.column(k).iter().copied().collect::<Vec<_>>()
                    });
                    unit_friction.push(friction.collect());
                    // Kept in single rows of all signals to be filtered: columns, known effort, rest.
                    let mut row = Vec::with_capacity(actuators * (width + 2));
                    for channel in 0..actuators {
                        row.extend(columns.matrix.row(channel).iter());
                        row.push(columns.known[channel]);
                        row.push(f64::from(u8::from(columns.resting[channel])));
                    }
                    rows.push(row);
                    instants.push((time, [q, v, a]));
                }
                Err(status) => {
                    failures.get_or_insert((time, format!("{status:?}")));
                }
            }
        }
        if let Some((time, why)) = failures {
            let failed = count + 1 - rows.len();
            if rows.len() < 20 || failed as f64 > MAY_FAIL * count as f64 {
                return Err(refuse(
                    format!(
                        "{}: the model cannot follow {failed} of {} positions, first at {time:.4} s: {why}",
                        log.name,
                        count + 1
                    ),
                    "check units, signs and offsets of the positions, and the geometry of the model",
                ));
            }
            cautions.push(format!("{}: {failed} positions that the model cannot reach are left out, first at {time:.4} s", log.name));
        }

        let spacing = (ROWS_PER_PERIOD * cutoff).recip();
        let margin = cutoff.recip();
        let places = (((end - start) - 2.0 * margin) / spacing).floor().max(0.0) as usize;
        let at: Vec<f64> = (0..=places).map(|k| start + margin + k as f64 * spacing).collect();
        let grid: Vec<f64> = instants.iter().map(|(time, _)| *time).collect();
        let filtered = low_pass.apply(
            &grid,
            actuators * (width + 2),
            |k, out| out.copy_from_slice(&rows[k]),
            &at,
        );

        let mut raw: Vec<Vec<f64>> = Vec::new();
        for (column, factor) in &efforts {
            raw.push(pick(*column).iter().map(|x| factor * x).collect());
        }
        let mut saturated = vec![false; times.len()];
        for ((column, _), values) in efforts.iter().zip(&raw) {
            let name = &log.log.columns[*column].name;
            if values.iter().all(|x| *x == values[0]) {
                return Err(refuse(
                    format!("{}: `{name}` is constant", log.name),
                    "log the measured effort, or leave the log out",
                ));
            }
            let found = mark_saturation(values, &mut saturated);
            if let Some((first, count)) = found {
                cautions.push(format!(
                    "{}: {count} samples of `{name}` are at its limit and left out, first in line {}",
                    log.name, log.log.lines[kept[first]]
                ));
            }
        }
        let measured = low_pass.apply(
            &times,
            actuators + 1,
            |k, out| {
                for (slot, values) in out.iter_mut().zip(&raw) {
                    *slot = values[k];
                }
                out[actuators] = f64::from(u8::from(saturated[k]));
            },
            &at,
        );
        let effort_noise =
            raw.iter().map(|values| roughness(values) * (1.8 * cutoff / rate).sqrt()).collect();

        let channels = (0..actuators).map(|channel| {
            let base = channel * (width + 2);
            let used: Vec<usize> = (0..at.len())
                .filter(|&k| {
                    filtered[k][base + width + 1].abs() < RESTING
                        && measured[k][actuators].abs() < RESTING
                })
                .collect();
            let matrix = DMatrix::from_fn(used.len(), width, |row, column| {
                filtered[used[row]][base + column]
            });
            let total = DVector::from_fn(used.len(), |row, _| measured[used[row]][channel]);
            let known = DVector::from_fn(used.len(), |row, _| filtered[used[row]][base + width]);
            Rows { matrix, right: &total - known, measured: total, steps: used }
        });
        let block = Block { channels: channels.collect(), independence: 2.0 / ROWS_PER_PERIOD };
        let resting = block.channels.iter().map(|rows| at.len() - rows.len()).max().unwrap_or(0);
        if 2 * resting > at.len() {
            cautions.push(format!(
                "{}: {} of {} rows are left out, because a joint is at rest there and its friction has only limits",
                log.name, resting, at.len()
            ));
        }
        if log.log.bad_rows.count > 0 {
            let named: Vec<String> = log
                .log
                .bad_rows
                .named
                .iter()
                .map(|(line, why)| format!("line {line}: {why}"))
                .collect();
            cautions.push(format!(
                "{}: {} bad rows are left out: {}",
                log.name,
                log.log.bad_rows.count,
                named.join("; ")
            ));
        }
        Ok(Self {
            name: log.name.clone(),
            predict: log.settings.predict,
            block,
            regressor,
            instants,
            unit_friction,
            times: at,
            filter: low_pass,
            cutoff,
            effort_noise,
            cautions,
        })
    }

    /// Computes the columns of coefficients of friction with the normal loads for these values.
    ///
    /// # Errors
    /// The first time at which there are no forces, with the reason.
    pub(super) fn update_loads(&mut self, values: &[f64]) -> Result<(), String> {
        let parameters: Vec<Parameter> = self.regressor.parameters().to_vec();
        let mu: Vec<(usize, usize)> = (0..parameters.len())
            .filter_map(|k| match parameters[k].kind {
                Kind::Mu(i) => Some((k, i)),
                _ => None,
            })
            .collect();
        if mu.is_empty() {
            return Ok(());
        }
        let engine: Parameters<f64> = self.regressor.engine_parameters(values);
        let mut data = self.regressor.engine_data();
        let mut loads = Vec::with_capacity(self.instants.len());
        let mut failed: Option<String> = None;
        let mut failures = 0;
        for (time, [q, v, a]) in &self.instants {
            match self.regressor.loads(&engine, &mut data, [q, v, a]) {
                Ok(found) => loads.push(found),
                Err(status) => {
                    failures += 1;
                    failed.get_or_insert_with(|| format!("at {time:.4} s: {status:?}"));
                    // The loads of the instant before stand in.
                    let before =
                        loads.last().cloned().unwrap_or_else(|| vec![0.0; engine.interfaces.len()]);
                    loads.push(before);
                }
            }
        }
        if failures as f64 > MAY_FAIL * self.instants.len() as f64 {
            return Err(failed.unwrap_or_default());
        }
        let actuators = self.block.channels.len();
        let grid: Vec<f64> = self.instants.iter().map(|(time, _)| *time).collect();
        let filtered = self.filter.apply(
            &grid,
            actuators * mu.len(),
            |k, out| {
                let units = &self.unit_friction[k];
                for (index, &(_, interface)) in mu.iter().enumerate() {
                    let load = loads[k][interface] - engine.interfaces[interface].load.preload;
                    for channel in 0..actuators {
                        out[index * actuators + channel] =
                            units[index * actuators + channel] * load;
                    }
                }
            },
            &self.times,
        );
        for (channel, rows) in self.block.channels.iter_mut().enumerate() {
            for (row, &step) in rows.steps.iter().enumerate() {
                for (index, &(column, _)) in mu.iter().enumerate() {
                    rows.matrix[(row, column)] = filtered[step][index * actuators + channel];
                }
            }
        }
        Ok(())
    }
}

fn write_term(
    drives: &Drives,
    time: f64,
    (coordinates, targets): (&[Coordinate], &[Target<f64>]),
    matrix: &mut DMatrix<f64>,
    column: usize,
) {
    let measure = |wanted: Coordinate| {
        let place = coordinates.iter().position(|own| *own == wanted);
        place.map_or(Target { value: f64::NAN, rate: f64::NAN, acceleration: f64::NAN }, |k| {
            targets[k]
        })
    };
    for (actuator, law) in &drives.laws {
        matrix[(*actuator, column)] = law.at(time, measure, &[]);
    }
    for (actuator, signal) in &drives.efforts {
        matrix[(*actuator, column)] = signal.at(time).value;
    }
}

/// Marks samples that stay at the greatest or least value; the first of them and their number.
fn mark_saturation(values: &[f64], marks: &mut [bool]) -> Option<(usize, usize)> {
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let (mut first, mut count, mut from) = (None, 0, 0);
    for k in 0..=values.len() {
        let goes_on = k > 0 && k < values.len() && values[k] == values[k - 1];
        if goes_on {
            continue;
        }
        if k - from >= SATURATED && (values[from] == high || values[from] == low) {
            marks[from..k].iter_mut().for_each(|mark| *mark = true);
            first.get_or_insert(from);
            count += k - from;
        }
        from = k;
    }
    first.map(|first| (first, count))
}

/// Standard deviation of white noise, from third differences.
fn roughness(values: &[f64]) -> f64 {
    let sum: f64 = values.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2)).sum();
    (sum / (20.0 * values.len().max(4) as f64 - 60.0).max(1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_runs_at_the_extremes_are_saturated() {
        let values = [0.0, 1.0, 5.0, 5.0, 5.0, 5.0, 5.0, 2.0, 2.0, 2.0, 2.0, 2.0, 5.0, 1.0];
        let mut marks = vec![false; values.len()];
        assert_eq!(mark_saturation(&values, &mut marks), Some((2, 5)));
        assert_eq!(marks.iter().filter(|mark| **mark).count(), 5);
        let mut marks = vec![false; 3];
        assert_eq!(mark_saturation(&[1.0, 2.0, 1.0], &mut marks), None);
    }

    /// White noise of unit variance, by its third differences.
    #[test]
    fn roughness_of_noise_on_a_slow_signal() {
        let mut random = stiction_core::random::Random::new(2);
        // Uniform from -1 to 1: the standard deviation is 1/sqrt(3).
        let values: Vec<f64> =
            (0..20_000).map(|k| (1e-3 * k as f64).sin() * 50.0 + random.number()).collect();
        assert!((roughness(&values) * 3f64.sqrt() - 1.0).abs() < 0.03);
    }
}
