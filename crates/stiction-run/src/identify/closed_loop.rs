//! Output-error method: the model predicts the efforts along motions that are simulated in the closed loop, not along
//! measured motions.
//!
//! Equation (I13) of the book's theory.

use super::chosen::{chosen_efforts, refuse};
use super::identified::{Identified, Named};
use super::prepare::{Deviation, MeasuredLog, Plant};
use super::{IdentifyError as Error, Progress};
use crate::ordered::in_order;
use std::num::NonZero;
use stiction_core::mechanism::Mechanism;
use stiction_format::{Control, ModelFile};
use stiction_identify::{FitVerdict, Verdict};

/// Largest number of simulations of each log.
const ROUNDS: usize = 25;
/// The iteration has converged if no value changes by more than this number of standard deviations.
const SETTLED: f64 = 0.1;
/// Ratio of the difference between simulated and measured positions to the difference between measured and commanded
/// positions above which a caution doubts the controller.
const DOUBTFUL: f64 = 0.3;
/// Least tracking error, m and rad, that the differences are compared with: encoders and clocks cause differences of
/// this order.
const SMALL: [f64; 2] = [1e-5, 1e-4];

/// Logs with motions that are simulated in the closed loop. The simulated model has the values before the last fit,
/// which differ from the identified ones by less than a tenth of a standard deviation if the method has converged.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// Logs with simulated positions in place of the measured ones.
    pub(super) logs: Vec<MeasuredLog>,
    /// Differences between simulated and measured positions.
    pub deviations: Vec<Deviation>,
    /// Number of times each log was simulated.
    pub rounds: usize,
    /// Cautions on logs that are not simulated.
    cautions: Vec<String>,
}

impl Simulated {
    /// Simulates all logs, on all cores.
    fn of(
        plant: Plant<'_>,
        logs: &[MeasuredLog],
        control: (&Control, Option<f64>),
        progress: Progress<'_>,
    ) -> Result<Self, Error> {
        let mut own =
            Self { logs: Vec::new(), deviations: Vec::new(), rounds: 1, cautions: Vec::new() };
        let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
        let mut next = logs.iter();
        // The prediction for a log that cannot be simulated follows the measured motion.
        let work = |log: &MeasuredLog| {
            if log.settings.predict && (!log.is_commanded() || log.log.is_steady) {
                return Ok((log.clone(), Vec::new(), None));
            }
            match log.simulated(plant, control) {
                Ok((log, deviations)) => Ok((log, deviations, None)),
                Err(error) if log.settings.predict => {
                    let caution = format!(
                        "{}; its efforts are predicted along the measured motion",
                        error.message
                    );
                    Ok((log.clone(), Vec::new(), Some(caution)))
                }
                Err(error) => Err(error),
            }
        };
        progress("simulating the closed loop", 0, logs.len());
        in_order(
            threads.min(logs.len()),
            || next.next(),
            work,
            |simulated| {
                let (log, deviations, caution) = simulated?;
                own.logs.push(log);
                own.cautions.extend(caution);
                own.deviations.extend(deviations);
                progress("simulating the closed loop", own.logs.len(), logs.len());
                Ok(true)
            },
        )?;
        Ok(own)
    }
}

/// Simulates the logs with the model, fits the parameters along the simulated motions, and repeats both with the fitted
/// values until they no longer change. `fit` identifies the parameters of the original model from logs.
///
/// # Errors
/// Fails if a log has no commanded positions, if a closed loop cannot be simulated, or if `fit` fails.
pub(super) fn identify(
    model: &ModelFile,
    logs: &[MeasuredLog],
    control: (&Control, Option<f64>),
    progress: Progress<'_>,
    fit: impl Fn(&[MeasuredLog]) -> Result<Identified, Error>,
) -> Result<Identified, Error> {
    refuse_efforts(&model.mechanism, logs)?;
    for log in logs.iter().filter(|log| !log.settings.predict) {
        log.needs_command(", which the output-error method simulates")?;
    }
    let mut now = model.clone();
    let first = Plant { model, values: None, known: model };
    let mut simulated = Simulated::of(first, logs, control, progress)?;
    let mut found = fit(&simulated.logs)?;
    let mut last = f64::INFINITY;
    while last > SETTLED && simulated.rounds < ROUNDS {
        now.mechanism = found.mechanism.clone();
        let values: Vec<f64> = found.parameters.iter().map(Named::of_plant).collect();
        let plant = Plant { model: &now, values: Some(&values), known: model };
        let rounds = simulated.rounds + 1;
        simulated = Simulated { rounds, ..Simulated::of(plant, logs, control, progress)? };
        let before = std::mem::replace(&mut found, fit(&simulated.logs)?);
        last = change(&before, &found);
    }
    let mut doubts: Vec<String> = doubt(&simulated.deviations).into_iter().collect();
    if last > SETTLED {
        doubts.push(format!(
            "the output-error method has not converged: in the last of {ROUNDS} simulations, a value changes by \
             {last:.2} standard deviations"
        ));
    }
    if !doubts.is_empty() && found.verdict == FitVerdict::Identified {
        found.verdict = FitVerdict::FitsOnly;
    }
    found.cautions.extend(simulated.cautions.iter().cloned().chain(doubts));
    found.simulated = Some(simulated);
    Ok(found)
}

impl Named {
    /// Returns the value in a simulated model, which has no constant errors of efforts.
    fn of_plant(&self) -> f64 {
        if self.is_of_log { 0.0 } else { self.value }
    }
}

/// Returns the largest change of a value, in standard deviations.
fn change(before: &Identified, after: &Identified) -> f64 {
    let pairs = before.parameters.iter().zip(&after.parameters);
    let changes = pairs
        .filter(|(_, after)| after.verdict != Verdict::Held && after.sigma > 0.0)
        .map(|(before, after)| (after.value - before.value).abs() / after.sigma);
    changes.fold(0.0, f64::max)
}

/// Returns a caution if the simulated motion differs from the measured one by more than the tracking error suggests.
fn doubt(deviations: &[Deviation]) -> Option<String> {
    let least = |own: &Deviation| SMALL[usize::from(own.unit == "rad")];
    let ratio = |own: &Deviation| own.value / own.tracking.max(least(own));
    let worst = deviations.iter().max_by(|a, b| ratio(a).total_cmp(&ratio(b)))?;
    (ratio(worst) > DOUBTFUL).then(|| {
        format!(
            "{}: the simulated position of {} differs from the measured one by {:.2e} {} (rms), and the measured one \
             from the commanded one by {:.2e} {}: check the gains and the period of `controller`",
            worst.log, worst.actuator, worst.value, worst.unit, worst.tracking, worst.unit
        )
    })
}

/// Refuses efforts that the simulation does not compute.
fn refuse_efforts(mechanism: &Mechanism, logs: &[MeasuredLog]) -> Result<(), Error> {
    for log in logs.iter().filter(|log| !log.settings.predict) {
        let (efforts, at_motors) = chosen_efforts(mechanism, log)?;
        if efforts.iter().any(|effort| effort.unknown.is_some()) {
            return Err(refuse(
                format!("{}: the output-error method needs known torque constants", log.name),
                "give `torque_constant` in the model, or identify it first with another `estimator`",
            ));
        }
        if !at_motors && !mechanism.drive_trains().is_empty() {
            return Err(refuse(
                format!(
                    "{}: the output-error method needs the torques of the motors, not those of their joints",
                    log.name
                ),
                "log `MOTOR.motor_torque` or `MOTOR.current`, or choose another `estimator`",
            ));
        }
    }
    Ok(())
}
