//! Measured and predicted efforts of all logs, and friction as a function of speed, for the report
//! and the table of efforts.

use super::IdentifyError;
use super::identified::Identified;
use super::options::IdentifySettings;
use super::prepare::{MeasuredLog, Preparation, Prepared};
use super::run::{differences, parameters_of, read_terms};
use super::selection::choice;
use crate::names::{Names, legs_of_actuators};
use crate::report::animation::Animation;
use nalgebra::DVector;
use std::fmt::Write as _;
use stiction_draw::numbers::exact;
use stiction_format::ModelFile;
use stiction_identify::{Kind, Parameter, Regressor, Rows};

/// An instant appears in the plot of friction over speed only if the effect of friction on the
/// effort is at least this fraction of the largest effect in the log.
const EFFECT: f64 = 0.5;

/// Efforts in all logs, and friction of interfaces and actuators as a function of speed.
#[derive(Clone, Debug)]
pub struct Traces {
    /// Name and unit of the effort of each actuator.
    pub efforts: Vec<(String, &'static str)>,
    /// Index of the leg of each actuator, which determines the colour of its curves; `None` for
    /// actuators outside the legs.
    pub(super) legs: Vec<Option<usize>>,
    /// Efforts in each log, in the order in which the logs were given to the identification.
    pub logs: Vec<LogTrace>,
    /// Friction of the interfaces and actuators whose friction the data determine.
    pub friction: Vec<FrictionTrace>,
}

/// Measured and predicted efforts of one log, all filtered in the same way.
#[derive(Clone, Debug)]
pub struct LogTrace {
    /// Name of the log.
    pub name: String,
    /// True if the log was fitted; false if it only checks the prediction.
    pub used_for_fit: bool,
    /// Rows of the log: time, s, and one sample for each actuator; `None` if the effort of the
    /// actuator is left out at this time.
    pub rows: Vec<(f64, Vec<Option<EffortSample>>)>,
    /// Animation of the robot along the log; empty for a log of steady motions.
    pub(super) robot: Animation,
}

/// Effort at one instant, N or N m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffortSample {
    /// Measured and filtered effort.
    pub measured: f64,
    /// Effort that the identified model predicts.
    pub predicted: f64,
    /// Effort that the original model predicts.
    pub by_model: f64,
}

/// Friction of one interface or actuator as a function of speed.
#[derive(Clone, Debug)]
pub struct FrictionTrace {
    /// Name of the friction interface or of the actuator.
    pub name: String,
    /// Unit of the friction, which is expressed as an effort of its joint: N or N m.
    pub unit: &'static str,
    /// Unit of the joint rate: m/s or rad/s.
    pub rate_unit: &'static str,
    /// Points of the plot: magnitude of the joint rate, friction derived from the measured effort,
    /// and friction of the identified law.
    pub points: Vec<[f64; 3]>,
}

impl Traces {
    /// Computes the efforts of all logs with the identified parameter values.
    ///
    /// # Errors
    /// Returns an error if logs or options cannot be used, as in [`super::identify`].
    pub fn new(
        model: &ModelFile,
        logs: &[MeasuredLog],
        settings: &IdentifySettings,
        identified: &Identified,
    ) -> Result<Self, IdentifyError> {
        let mechanism = &model.mechanism;
        let logs = identified.simulated.as_ref().map_or(logs, |own| &own.logs);
        let terms = read_terms(model, settings)?;
        let mut traces = Self {
            efforts: Names::new(mechanism).drives,
            legs: legs_of_actuators(mechanism),
            logs: Vec::new(),
            friction: Vec::new(),
        };
        let values: Vec<f64> = identified.parameters.iter().map(|p| p.value).collect();
        let choice = choice(mechanism, logs, settings, terms.len())?;
        let preparation = Preparation {
            model,
            filter: settings.filter,
            choice: &choice,
            terms: &terms,
            progress: &|_, _, _| {},
        };
        for log in logs {
            let delays = identified.taken_back();
            let mut prepared = Prepared::new(preparation, log, Some(&delays))?;
            prepared.start_constants(&values);
            prepared.set_delays(&delays);
            let parameters = parameters_of(&prepared, settings);
            // Currents are converted by the identified torque constant, because the model has none.
            let prior = |(p, value): (&Parameter, &f64)| match p.kind {
                Kind::TorqueConstant(_) => *value,
                _ => p.prior,
            };
            let priors: Vec<f64> = parameters.iter().zip(&values).map(prior).collect();
            // If the forces have no solution, the earlier normal loads remain, as in the fit.
            let _ = prepared.linearise(&priors, &[]);
            let before = prepared.predicted(&differences(&parameters, &priors));
            // The normal loads are constant, so that the columns of an interface contain only its
            // own friction.
            let _ = prepared.linearise(&values, &[]);
            let at = differences(&parameters, &values);
            let after = prepared.predicted(&at);
            traces.logs.push(log_trace(model, &prepared, &before, &after));
            if !prepared.predict {
                add_friction(&prepared, &parameters, &at, &mut traces.friction);
            }
        }
        Ok(traces)
    }

    /// Returns the efforts as CSV: log, time, and for each effort the measured value, the predicted
    /// value, the residual, and the value of the original model. Cells of left-out rows are empty.
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

fn log_trace(
    model: &ModelFile,
    prepared: &Prepared,
    before: &[DVector<f64>],
    after: &[DVector<f64>],
) -> LogTrace {
    let mut robot = Animation::of_motion(model, prepared.poses.len());
    prepared.poses.iter().for_each(|(time, poses)| robot.push_pose(*time, poses));
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
    LogTrace { name: prepared.name.clone(), used_for_fit: !prepared.predict, rows, robot }
}

/// Adds points to the plots of friction over speed. The magnitude of the joint rate is the ratio of
/// the regressor column of viscous friction to the effort per unit of friction, which is the column
/// of load-independent friction without Stribeck's curve. The friction derived from the measured
/// effort is the residual plus the identified friction, divided by the effort per unit of friction.
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
        let curve = parameters.iter().find_map(|other| match (p.kind, other.kind) {
            (Kind::Coulomb(i), Kind::StaticExcess(k)) if i == k => Some(i),
            _ => None,
        });
        for row in 0..rows.len() {
            let column = rows.matrix[(row, constant)];
            if column.abs() < EFFECT * greatest {
                continue;
            }
            let ratio = rows.matrix[(row, viscous)] / column;
            let factor = curve.map_or(1.0, |i| curve_at(&prepared.regressor, i, ratio));
            let (unit, rate) = (column / factor, ratio * factor);
            let law: f64 = own.iter().map(|&k| rows.matrix[(row, k)] * at[k]).sum();
            all[index].points.push([rate, (law + residuals[row]) / unit, law / unit]);
        }
    }
}

/// Returns the factor of Stribeck's curve of an interface at the speed at which `ratio` is the ratio
/// of the column of viscous friction to that of load-independent friction, rad/s or m/s. The second
/// column contains the factor, so the ratio is the joint rate divided by the factor. The rate therefore lies between the
/// ratio and the ratio times the factor at rest.
fn curve_at(regressor: &Regressor, interface: usize, ratio: f64) -> f64 {
    let per_unit = |kind, speed| regressor.friction_per_unit(kind, interface, speed);
    let ratio_at = |speed| {
        per_unit(Kind::Viscous(interface), speed) / per_unit(Kind::Coulomb(interface), speed)
    };
    let factor = per_unit(Kind::Mu(interface), 0.0);
    // Surface speeds are joint rates times the arm.
    let least = ratio * factor / per_unit(Kind::Coulomb(interface), 0.0);
    let (mut low, mut high) = (least.min(least * factor), least.max(least * factor));
    // Halves the interval to the resolution of doubles.
    for _ in 0..53 {
        let middle = 0.5 * (low + high);
        match ratio_at(middle) < ratio {
            true => low = middle,
            false => high = middle,
        }
    }
    per_unit(Kind::Mu(interface), high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_core::dynamics::{InverseDynamics, Settings};
    use stiction_core::kinematics::{Coordinate, Target};
    use stiction_format::{Source, read};
    use stiction_identify::Choice;

    /// Checks the factor of Stribeck's curve by its definition, from standstill to high speed.
    #[test]
    fn the_factor_of_the_curve_follows_from_the_columns() {
        const MODEL: &str = "gravity = [0, 0, 0]\n[bodies.a]\nmass = 1\ncom = [0.1, 0, 0]\ninertia = [0.1, 0.1, 0.1]\n\
            [joints.J]\ntype = \"R\"\nfrom = \"ground\"\nto = \"a\"\naxis = \"z\"\nactuated = true\n\
            friction = { mu = 0.1, mu_static = 0.18, radius = \"20 mm\", stribeck_velocity = \"10 mm/s\" }\n";
        let model = read(&Source::new("a.toml", MODEL), &|_| Err("no files".into())).unwrap();
        let joint = model.mechanism.joint_id("J").unwrap();
        let target = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
        let solver = InverseDynamics::new(
            model.mechanism,
            &[],
            &[Coordinate::Joint { joint, dof: 0 }],
            &[target],
            Settings::default(),
        );
        let choice = Choice { static_excess: true, ..Choice::ALL };
        let regressor = Regressor::new(solver.unwrap(), &choice).unwrap();
        for rate in [0.0, 1e-3, 0.1, 0.5, 1.0, 3.0, 1e3] {
            let factor = 1.0 + 0.8 * f64::exp(-(rate * 0.020 / 0.010_f64).powi(2));
            let found = curve_at(&regressor, 0, rate / factor);
            assert!((found - factor).abs() < 1e-9, "{rate} rad/s: {found} {factor}");
        }
    }
}
