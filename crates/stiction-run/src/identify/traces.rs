//! Measured and predicted efforts of all logs, and friction over speed: what the report and the table of
//! efforts show.

use super::IdentifyError;
use super::chosen::chosen_efforts;
use super::options::IdentifySettings;
use super::prepare::{MeasuredLog, Prepared};
use super::run::{Identified, differences, parameters_of, read_terms};
use super::selection::{free_groups, options};
use crate::names::Names;
use nalgebra::DVector;
use std::fmt::Write as _;
use stiction_draw::numbers::exact;
use stiction_format::ModelFile;
use stiction_identify::{Choice, Kind, Parameter, Rows};

/// Part of the greatest effect of a unit of friction below which an instant says little about it.
const EFFECT: f64 = 0.5;

/// Efforts of all logs, and friction of all interfaces.
#[derive(Clone, Debug)]
pub struct Traces {
    /// Name and unit of each effort.
    pub efforts: Vec<(String, &'static str)>,
    /// Logs in the order of the fit.
    pub logs: Vec<LogTrace>,
    /// Friction of interfaces and actuators that the data determine.
    pub friction: Vec<FrictionTrace>,
}

/// Efforts of one log, all filtered alike.
#[derive(Clone, Debug)]
pub struct LogTrace {
    /// Name of the log.
    pub name: String,
    /// `true` if the log was fitted.
    pub used_for_fit: bool,
    /// Times, s, with the samples of each effort; `None` where a row is left out.
    pub rows: Vec<(f64, Vec<Option<EffortSample>>)>,
}

/// Effort at one instant, N or N m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffortSample {
    /// Measured effort.
    pub measured: f64,
    /// Effort of the identified model.
    pub predicted: f64,
    /// Effort of the model as it was.
    pub by_model: f64,
}

/// Friction of one interface or actuator over speed.
#[derive(Clone, Debug)]
pub struct FrictionTrace {
    /// Name.
    pub name: String,
    /// Unit of the friction, as an effort of its joint.
    pub unit: &'static str,
    /// Unit of the rate.
    pub rate_unit: &'static str,
    /// For each instant the magnitude of the joint's rate, the friction that the measured effort leaves for it, and
    /// that of the identified law.
    pub points: Vec<[f64; 3]>,
}

impl Traces {
    /// Computes the efforts of all logs with the identified values.
    ///
    /// # Errors
    /// Logs or options that cannot be used, as in [`super::identify`].
    pub fn new(
        model: &ModelFile,
        logs: &[MeasuredLog],
        settings: &IdentifySettings,
        identified: &Identified,
    ) -> Result<Self, IdentifyError> {
        let mechanism = &model.mechanism;
        let terms = read_terms(model, settings)?;
        let mut traces =
            Self { efforts: Names::new(mechanism).drives, logs: Vec::new(), friction: Vec::new() };
        let values: Vec<f64> = identified.parameters.iter().map(|p| p.value).collect();
        for log in logs {
            let (_, at_motors) = chosen_efforts(mechanism, log)?;
            let (offsets, terms_count) = (settings.offsets, terms.len());
            let choice = Choice { at_motors, offsets, terms: terms_count, ..Choice::ALL };
            let delays = identified.taken_back();
            let mut prepared =
                Prepared::new(model, log, (settings.filter, choice), &terms, Some(&delays))?;
            prepared.set_delays(&delays);
            let parameters = parameters_of(&prepared, settings);
            let groups = free_groups(&parameters, &options(mechanism, &parameters, settings)?);
            let priors: Vec<f64> = parameters.iter().map(|p| p.prior).collect();
            // Without forces, the loads before remain, as in the fit.
            let _ = prepared.update_loads(&priors, &groups);
            let before = prepared.predicted(&differences(&parameters, &priors));
            let _ = prepared.update_loads(&values, &groups);
            let at = differences(&parameters, &values);
            let after = prepared.predicted(&at);
            traces.logs.push(log_trace(&prepared, &before, &after));
            if !prepared.predict {
                add_friction(&prepared, &parameters, &at, &mut traces.friction);
            }
        }
        Ok(traces)
    }

    /// The efforts as CSV: log, time, and for each effort the measured, the predicted, the residual, and that of the model
    /// as it was. Cells of rows that are left out are empty.
    pub fn csv(&self) -> String {
        let mut text = "log,time [s]".to_owned();
        for (name, unit) in &self.efforts {
            for what in ["measured", "predicted", "residual", "predicted_by_model"] {
                let _ = write!(text, ",{name}.{what} [{unit}]");
            }
        }
        text.push('\n');
        for log in &self.logs {
            let name = log.name.replace('"', "\"\"");
            for (time, samples) in &log.rows {
                let _ = write!(text, "\"{name}\",");
                exact(&mut text, *time);
                for sample in samples {
                    let Some(EffortSample { measured, predicted, by_model }) = *sample else {
                        text += ",,,,";
                        continue;
                    };
                    for value in [measured, predicted, measured - predicted, by_model] {
                        text.push(',');
                        exact(&mut text, value);
                    }
                }
                text.push('\n');
            }
        }
        text
    }
}

fn log_trace(prepared: &Prepared, before: &[DVector<f64>], after: &[DVector<f64>]) -> LogTrace {
    let channels = &prepared.block.channels;
    let mut rows: Vec<(f64, Vec<Option<EffortSample>>)> =
        prepared.times.iter().map(|time| (*time, vec![None; channels.len()])).collect();
    for (channel, own) in channels.iter().enumerate() {
        for (row, &step) in own.steps.iter().enumerate() {
            rows[step].1[channel] = Some(EffortSample {
                measured: own.measured[row],
                predicted: after[channel][row],
                by_model: before[channel][row],
            });
        }
    }
    LogTrace { name: prepared.name.clone(), used_for_fit: !prepared.predict, rows }
}

/// Adds friction over speed. The columns of load-independent and of viscous friction differ by the magnitude of
/// the joint's rate; the residual with the friction of the interface, over the first of them, is what the measured
/// effort leaves for it.
fn add_friction(
    prepared: &Prepared,
    parameters: &[Parameter],
    at: &DVector<f64>,
    all: &mut Vec<FrictionTrace>,
) {
    for (constant, p) in parameters.iter().enumerate() {
        let is_own = |other: &Parameter| match (p.kind, other.kind) {
            (Kind::Coulomb(i), Kind::Mu(k) | Kind::Coulomb(k) | Kind::Viscous(k)) => i == k,
            (Kind::DriveCoulomb(i), Kind::DriveCoulomb(k) | Kind::DriveViscous(k)) => i == k,
            _ => false,
        };
        let own: Vec<usize> = (0..parameters.len()).filter(|&k| is_own(&parameters[k])).collect();
        let viscous = own
            .iter()
            .copied()
            .find(|&k| matches!(parameters[k].kind, Kind::Viscous(_) | Kind::DriveViscous(_)));
        let Some(viscous) = viscous else { continue };
        let channels = &prepared.block.channels;
        let effect = |rows: &&Rows| rows.matrix.column(constant).norm_squared();
        let Some(rows) = channels.iter().max_by(|a, b| effect(a).total_cmp(&effect(b))) else {
            continue;
        };
        let greatest = rows.matrix.column(constant).amax();
        if greatest == 0.0 {
            continue;
        }
        let residuals = rows.residuals(at);
        let name = p.name.strip_suffix(".coulomb").unwrap_or(&p.name);
        let known = all.iter().position(|trace| trace.name == name);
        let index = known.unwrap_or_else(|| {
            let rate_unit = if p.unit == "N" { "m/s" } else { "rad/s" };
            let (name, points) = (name.to_owned(), Vec::new());
            all.push(FrictionTrace { name, unit: p.unit, rate_unit, points });
            all.len() - 1
        });
        for row in 0..rows.len() {
            let unit = rows.matrix[(row, constant)];
            if unit.abs() < EFFECT * greatest {
                continue;
            }
            let law: f64 = own.iter().map(|&k| rows.matrix[(row, k)] * at[k]).sum();
            let rate = rows.matrix[(row, viscous)] / unit;
            all[index].points.push([rate, (law + residuals[row]) / unit, law / unit]);
        }
    }
}
