//! Motion of a log in the closed loop of robot and controller, simulated with a model.

use super::efforts::Efforts;
use super::motion::{Used, suggested_cutoff, unwrap};
use super::{MeasuredLog, Prepared, filter, gaps, spikes};
use crate::dofs::{Dof, actuated, dofs_of};
use crate::forward::{Ending, Job, Start};
use crate::identify::IdentifyError as Error;
use crate::identify::chosen::{chosen_coordinates, refuse};
use crate::identify::run::differences;
use nalgebra::{DVector, Matrix3, Vector3};
use std::ops::Range;
use stiction_core::forward::Known;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_format::{Control, LoadCase, LogColumn, LogRole, LowPass, ModelFile, Motion, Signal};

/// Least number of samples whose fitted parabola gives position and rate at the start of a simulation.
const START: usize = 5;

/// Difference between the simulated and the measured position of an actuator in one log.
#[derive(Clone, Debug)]
pub struct Deviation {
    /// Name of the log.
    pub log: String,
    /// Name of the actuator.
    pub actuator: String,
    /// Root mean square of the filtered difference, m or rad.
    pub value: f64,
    /// Root mean square of the filtered difference between the measured and the commanded position, m or rad.
    pub tracking: f64,
    /// Unit of both.
    pub unit: &'static str,
}

/// Efforts of the controller in the simulation of a log.
#[derive(Clone, Debug)]
pub(in crate::identify) struct SimulatedEfforts {
    /// Parameter values of the simulated model; `None` for those of the original model.
    values: Option<Vec<f64>>,
    /// Effort of each actuator in each row of the log, N or N m.
    efforts: Vec<Vec<f64>>,
    /// Cut-off frequency of the filter, Hz, chosen for the measured log.
    pub(super) cutoff: f64,
}

/// Simulated motion, commanded position and effort of each actuator at one sample.
struct Sample {
    time: f64,
    actuators: Vec<(Target<f64>, f64, f64)>,
}

/// Model whose closed loop is simulated.
#[derive(Clone, Copy, Debug)]
pub(in crate::identify) struct Plant<'a> {
    /// Simulated model.
    pub(in crate::identify) model: &'a ModelFile,
    /// Parameter values of this model; `None` for those of the original model.
    pub(in crate::identify) values: Option<&'a [f64]>,
    /// Original model, which the controller knows.
    pub(in crate::identify) known: &'a ModelFile,
}

impl MeasuredLog {
    /// Simulates the closed loop of a model and its controller along the commanded motion. Returns a copy of the log in
    /// which the simulated positions of the actuators replace all measured positions, and the differences between both
    /// if the positions of the actuators are measured. Each piece between gaps that the filter cannot bridge is simulated
    /// from its first measured position. `filter` is the cut-off frequency, Hz; `None` selects one automatically.
    ///
    /// # Errors
    /// Fails if the simulation does not reach the end of the log.
    pub(in crate::identify) fn simulated(
        &self,
        plant: Plant<'_>,
        (control, filter): (&Control, Option<f64>),
    ) -> Result<(Self, Vec<Deviation>), Error> {
        let used = Used::of(self)?;
        let cutoff = filter.unwrap_or_else(|| self.suggested_cutoff(plant.known, &used));
        let gap = (0.5 / cutoff).max(gaps::SAMPLES / used.rate);
        let mut pieces = gaps::pieces(&used.times, gap);
        pieces.retain(|ends| gaps::is_long(*ends, cutoff));
        let [model, known] = [plant.model, plant.known].map(|own| self.carrying(own));
        let dofs = dofs_of(&model.mechanism);
        let places = actuated(&dofs);
        let mut positions = vec![vec![0.0; self.log.times.len()]; places.len()];
        let [mut commanded, mut efforts] = [positions.clone(), positions.clone()];
        for ends in &pieces {
            let rows = &used.rows[filter::within(&used.times, *ends)];
            let of_log = (&used, *ends, cutoff);
            let samples = self.closed_loop([&model, &known], control, of_log, &places)?;
            for &row in rows {
                let time = self.log.times[row];
                for actuator in 0..places.len() {
                    let [position, reference, effort] = interpolated(&samples, actuator, time);
                    positions[actuator][row] = position;
                    commanded[actuator][row] = reference;
                    efforts[actuator][row] = effort;
                }
            }
        }
        let driven: Vec<&Dof> = places.iter().map(|&place| &dofs[place]).collect();
        let filtered = (&used, &pieces[..], cutoff);
        let deviations = self.deviations(filtered, &driven, [&positions, &commanded]);
        let mut log = self.without_motion();
        let columns = driven.iter().zip(positions).map(|(dof, values)| LogColumn {
            name: format!("{} (simulated)", dof.name),
            role: LogRole::Coordinate(coordinate(dof)),
            values,
        });
        log.log.columns.extend(columns);
        let values = plant.values.map(<[f64]>::to_vec);
        log.simulated = Some(SimulatedEfforts { values, efforts, cutoff });
        Ok((log, deviations))
    }

    /// Returns the cut-off frequency, Hz, that suits the measured positions or, if the log lacks them, the commanded ones.
    fn suggested_cutoff(&self, model: &ModelFile, used: &Used<'_>) -> f64 {
        let of = |is_measured: bool| -> Vec<Vec<f64>> {
            let columns = self.log.columns.iter().enumerate();
            let each = columns.filter_map(|(index, column)| {
                let coordinate = match column.role {
                    LogRole::Coordinate(coordinate) if is_measured => coordinate,
                    LogRole::Reference(coordinate) if !is_measured => coordinate,
                    _ => return None,
                };
                let mut values = used.pick(index);
                spikes::replace(&used.times, &mut values, &used.samples(), 0.0);
                if is_angle(model, coordinate) {
                    used.samples().into_iter().for_each(|own| {
                        unwrap(&mut values[own]);
                    });
                }
                Some(values)
            });
            each.collect()
        };
        let measured = of(true);
        let values = if measured.is_empty() { of(false) } else { measured };
        suggested_cutoff(used, &values)
    }

    /// Simulates one piece of the log, from its first to its last time `ends`, s. `places` are the indices of the
    /// actuators among the degrees of freedom of all joints.
    fn closed_loop(
        &self,
        [model, known]: [&ModelFile; 2],
        control: &Control,
        (used, ends, cutoff): (&Used<'_>, (f64, f64), f64),
        places: &[usize],
    ) -> Result<Vec<Sample>, Error> {
        let fail = |what: &dyn std::fmt::Display| {
            refuse(
                format!("{}: the closed loop cannot be simulated: {what}", self.name),
                "check `controller` and the commanded positions; begin with a model that the controller can move",
            )
        };
        let motion = self.commanded_motion(model, used, ends);
        let load = LoadCase::default();
        let start = self.measured_start(model, &motion, (used, ends, cutoff));
        let job = Job {
            motion: Some(&motion),
            control: Some(control),
            known: Some(known),
            start: start.as_deref().map_or(Start::Moving, Start::Known),
            from: ends.0,
            until: ends.1,
            step: used.rate.recip(),
            ..Job::new(model, ("log", &load))
        };
        let mut samples = Vec::new();
        let outcome = job
            .run(
                |sample, _| {
                    let each = places.iter().zip(sample.reference).zip(&sample.instant.drives);
                    let actuators = each.map(|((&place, reference), effort)| {
                        (sample.joints[place], reference.value, *effort)
                    });
                    samples
                        .push(Sample { time: sample.instant.time, actuators: actuators.collect() });
                    Ok(())
                },
                &|| false,
                None,
            )
            .map_err(|error| fail(&error))?;
        match outcome.ending {
            Ending::Failed(error) => Err(fail(&error)),
            _ if samples.len() < 2 => Err(fail(&"it has a single sample")),
            _ => Ok(samples),
        }
    }

    /// Returns a copy of a model that carries the payloads of the log.
    pub(super) fn carrying(&self, model: &ModelFile) -> ModelFile {
        let mut carrying = model.clone();
        for payload in &self.settings.payloads {
            carrying.mechanism = carrying.mechanism.with_payload(payload.body, &payload.part);
        }
        carrying
    }

    /// Returns the commanded motion between two times, s, as splines through its samples.
    fn commanded_motion(&self, plant: &ModelFile, used: &Used<'_>, ends: (f64, f64)) -> Motion {
        let samples = filter::within(&used.times, ends);
        let references = self.log.columns.iter().enumerate();
        let coordinates = references.filter_map(|(index, column)| {
            let LogRole::Reference(coordinate) = column.role else { return None };
            let values = continuous(plant, used, (index, coordinate), samples.clone());
            Some((coordinate, Signal::through(&used.times[samples.clone()], values)))
        });
        let coordinates = coordinates.collect();
        Motion { start: ends.0, duration: ends.1 - ends.0, coordinates, ..Motion::pose() }
    }

    /// Returns the measured positions and rates at the start of a piece of the log; `None` if the log lacks positions. They
    /// are those of the command, if the coordinate is commanded, and of a parabola through the difference during one
    /// period of the cut-off frequency.
    fn measured_start(
        &self,
        plant: &ModelFile,
        motion: &Motion,
        (used, ends, cutoff): (&Used<'_>, (f64, f64), f64),
    ) -> Option<Vec<Known>> {
        let chosen = chosen_coordinates(plant, self).ok()?;
        let mut samples = filter::within(&used.times, ends);
        let period = filter::within(&used.times, (ends.0, ends.0 + cutoff.recip()));
        samples.end = period.end.max(samples.start + START).min(samples.end);
        let times = &used.times[samples.clone()];
        let each = chosen.iter().map(|chosen| {
            let column = (chosen.position?, chosen.coordinate);
            let mut values = continuous(plant, used, column, samples.clone());
            let mut commands = motion.coordinates.iter();
            let command = commands.find(|(coordinate, _)| *coordinate == chosen.coordinate);
            let at = |time: f64| command.map(|(_, signal)| signal.at(time));
            for (value, time) in values.iter_mut().zip(times) {
                *value -= at(*time).map_or(0.0, |target| target.value);
            }
            let (value, rate) = start_of(times, &values);
            let [value, rate] = match at(times[0]) {
                Some(target) => [value + target.value, rate + target.rate],
                None => [value, rate],
            };
            Some(Known { coordinate: chosen.coordinate, value: Some(value), rate: Some(rate) })
        });
        each.collect()
    }

    /// Compares simulated, measured and commanded positions of each actuator whose position is measured. The differences
    /// are filtered, so that noise of the encoders counts little.
    fn deviations(
        &self,
        (used, pieces, cutoff): (&Used<'_>, &[(f64, f64)], f64),
        driven: &[&Dof],
        [simulated, commanded]: [&[Vec<f64>]; 2],
    ) -> Vec<Deviation> {
        let each = driven.iter().enumerate().filter_map(|(actuator, dof)| {
            let is_own = |role: LogRole| role == LogRole::Coordinate(coordinate(dof));
            let measured = self.log.columns.iter().position(|column| is_own(column.role))?;
            let mut measured = used.pick(measured);
            spikes::replace(&used.times, &mut measured, &used.samples(), 0.0);
            let turn = std::f64::consts::TAU;
            let rms = |other: &[f64]| {
                let (mut sum, mut count) = (0.0, 0.0);
                for ends in pieces {
                    let samples = filter::within(&used.times, *ends);
                    let first = samples.start;
                    let difference = |k: usize, out: &mut [f64]| {
                        let difference = other[used.rows[first + k]] - measured[first + k];
                        // Encoders count within one turn.
                        let turns = if dof.translates { 0.0 } else { (difference / turn).round() };
                        out[0] = difference - turns * turn;
                    };
                    let times = &used.times[samples];
                    let margin = cutoff.recip();
                    let inner = filter::within(times, (ends.0 + margin, ends.1 - margin));
                    let low_pass = LowPass::new(cutoff, *ends);
                    for row in low_pass.apply(times, 1, difference, &times[inner]) {
                        sum += row[0] * row[0];
                        count += 1.0;
                    }
                }
                (sum / f64::max(count, 1.0)).sqrt()
            };
            Some(Deviation {
                log: self.name.clone(),
                actuator: dof.name.clone(),
                value: rms(&simulated[actuator]),
                tracking: rms(&commanded[actuator]),
                unit: dof.units()[0],
            })
        });
        each.collect()
    }
}

fn is_angle(model: &ModelFile, coordinate: Coordinate) -> bool {
    let joints = model.mechanism.joints();
    let types: Vec<_> = joints.iter().map(|joint| joint.joint_type).collect();
    coordinate.is_angle(&types)
}

/// Returns samples of a column, given by its index and its coordinate; angles are continuous over full turns.
fn continuous(
    model: &ModelFile,
    used: &Used<'_>,
    (index, coordinate): (usize, Coordinate),
    samples: Range<usize>,
) -> Vec<f64> {
    let mut values = used.pick(index)[samples].to_vec();
    if is_angle(model, coordinate) {
        unwrap(&mut values);
    }
    values
}

fn coordinate(dof: &Dof) -> Coordinate {
    Coordinate::Joint { joint: dof.joint, dof: dof.index }
}

impl Prepared {
    /// Replaces the efforts that the model would need along the simulated motion by the efforts of the simulated
    /// controller. The regression then compares measured and simulated efforts that passed through the same filter and
    /// belong to the same instants: the filter, and the steps of a sampled controller, cause no error.
    pub(super) fn use_simulated(
        &mut self,
        simulated: &SimulatedEfforts,
        rows: &[usize],
    ) -> Result<(), String> {
        let priors = || self.regressor.parameters().iter().map(|p| p.prior).collect();
        let values: Vec<f64> = simulated.values.clone().unwrap_or_else(priors);
        self.linearise(&values, &[])?;
        let predicted = self.predicted(&differences(self.regressor.parameters(), &values));
        let Some(Efforts { times, filter, .. }) = &self.efforts else { return Ok(()) };
        let width = simulated.efforts.len();
        let write = |k: usize, out: &mut [f64]| {
            out.iter_mut().zip(&simulated.efforts).for_each(|(out, own)| *out = own[rows[k]]);
        };
        let filtered = filter.apply(times, width, write, &self.times);
        for (channel, predicted) in predicted.iter().enumerate() {
            let rows = &mut self.block.channels[channel];
            let change =
                rows.steps.iter().zip(predicted).map(|(&step, p)| p - filtered[step][channel]);
            let change = DVector::from_iterator(rows.len(), change);
            rows.right += &change;
            self.mu.shift(channel, &change);
        }
        Ok(())
    }
}

/// Returns the simulated position, by cubic interpolation between the samples, and the commanded position and the
/// effort of an actuator at a time, s.
fn interpolated(samples: &[Sample], actuator: usize, time: f64) -> [f64; 3] {
    let next = samples.partition_point(|sample| sample.time < time).clamp(1, samples.len() - 1);
    let [from, to] = [&samples[next - 1], &samples[next]];
    let step = to.time - from.time;
    let part = ((time - from.time) / step).clamp(0.0, 1.0);
    let [(a, before, first), (b, after, second)] =
        [from, to].map(|sample| sample.actuators[actuator]);
    let rest = 1.0 - part;
    let position = rest * rest * (1.0 + 2.0 * part) * a.value
        + part * part * (1.0 + 2.0 * rest) * b.value
        + part * rest * step * (rest * a.rate - part * b.rate);
    [position, rest * before + part * after, rest * first + part * second]
}

/// Returns value and rate, at the first time, of the parabola that fits the samples best.
fn start_of(times: &[f64], values: &[f64]) -> (f64, f64) {
    let scale = times[times.len() - 1] - times[0];
    if scale.is_nan() || scale <= 0.0 {
        return (values[0], 0.0);
    }
    let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for (time, value) in times.iter().zip(values) {
        let t = (time - times[0]) / scale;
        let row = Vector3::new(1.0, t, t * t);
        matrix += row * row.transpose();
        right += row * *value;
    }
    match matrix.try_inverse().map(|inverse| inverse * right) {
        Some(found) if times.len() > 3 => (found[0], found[1] / scale),
        _ => (values[0], (values[values.len() - 1] - values[0]) / scale),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_and_a_cubic_are_exact() {
        let times: Vec<f64> = (0..20).map(|k| 3.0 + 0.01 * f64::from(k)).collect();
        let at = |t: f64| 0.2 - 0.7 * (t - 3.0) + 4.0 * (t - 3.0).powi(2);
        let values: Vec<f64> = times.iter().map(|t| at(*t)).collect();
        let (value, rate) = start_of(&times, &values);
        assert!((value - 0.2).abs() < 1e-12 && (rate + 0.7).abs() < 1e-9, "{value} {rate}");
        let sample = |t: f64| {
            let target = Target { value: t.powi(3), rate: 3.0 * t * t, acceleration: 6.0 * t };
            Sample { time: t, actuators: vec![(target, 2.0 * t, 1.0 - t)] }
        };
        let samples: Vec<Sample> = [0.0, 0.5, 1.5, 2.0].map(sample).into();
        for t in [0.0, 0.1, 0.5, 0.9, 1.7, 2.0] {
            let [position, reference, effort] = interpolated(&samples, 0, t);
            assert!((position - t.powi(3)).abs() < 1e-12, "{t} {position}");
            assert!((reference - 2.0 * t).abs() < 1e-12, "{t} {reference}");
            assert!((effort - 1.0 + t).abs() < 1e-12, "{t} {effort}");
        }
    }
}
