//! Mechanism at rest: effort intervals under static friction, breakaway efforts and self-locking.

mod json;
mod terminal;

use crate::inverse::{Error, Job};
use crate::power_off::{self, PowerOff, actuators_of};
use stiction_core::dynamics::{Forces, FrictionMode, InverseDynamics, Rest, Settings};
use stiction_core::mechanism::Motor;
use thiserror::Error;

pub use terminal::write_report;

/// Results at one pose at rest.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Instant of the motion, s.
    pub time: f64,
    /// Forces at rest.
    pub forces: Forces,
    /// Breakaway efforts and self-locking.
    pub rest: Rest,
    /// Indices of the friction interfaces whose normal load is undetermined.
    pub undetermined_loads: Vec<usize>,
    /// True if the mechanism has more actuators than statics determines.
    pub redundant_actuators: bool,
    /// Each drive train: its motor, and what keeps it at rest with power off.
    motors: Vec<(Motor, PowerOff)>,
}

/// Error of a breakaway computation.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BreakawayError {
    /// The instant is outside the motion.
    #[error("the motion lasts from {start} s to {end} s: there is no position at t = {time:?} s")]
    NoSuchTime {
        /// Requested instant, s.
        time: f64,
        /// First instant of the motion, s.
        start: f64,
        /// Last instant of the motion, s.
        end: f64,
    },
    /// Error while following the motion or computing the forces.
    #[error(transparent)]
    Job(#[from] Error),
}

/// Computes the results of a mechanism at rest at an instant of its motion, s, by default the
/// first. Friction always acts, independent of the job's friction mode.
///
/// # Errors
/// See [`BreakawayError`].
pub fn look(job: &Job<'_>, time: Option<f64>) -> Result<Findings, BreakawayError> {
    let motion = job.motion;
    let (start, end) = (motion.start, motion.start + motion.duration);
    let time = time.unwrap_or(start);
    // The last instant may differ by rounding.
    let slack = 1e-9 * motion.duration;
    if !(start - slack..=end + slack).contains(&time) {
        return Err(BreakawayError::NoSuchTime { time, start, end });
    }
    let time = time.clamp(start, end);
    let instants = job.instants().map_err(Error::Instants)?;
    let mut solver = job.assemble(instants.at(0))?;
    let mut before = instants.at(0);
    for next in instants.iter().skip(1).take_while(|t| *t < time).chain([time]) {
        job.follow(&mut solver, before, next)?;
        before = next;
    }
    *solver.settings_mut() = Settings { friction: FrictionMode::Converged, ..Settings::default() };
    let mut loads = Vec::new();
    job.loads_at_rest(time, &mut loads)?;
    let rest = solver.rest(&loads).map_err(|error| Error::Forces { time, error })?;
    Ok(findings(&solver, time, rest))
}

fn findings(solver: &InverseDynamics, time: f64, rest: Rest) -> Findings {
    let statics = solver.statics();
    let loads = solver.determined_loads(&statics);
    let (forces, trains) = (solver.forces(), solver.mechanism().drive_trains());
    let actuators = actuators_of(solver.mechanism());
    let power_off = power_off::of(trains, &actuators, forces);
    let motors = trains.iter().zip(&actuators).map(|(train, &actuator)| {
        train.motor(forces.efforts[actuator], forces.effort_bounds[actuator], None, 0.0)
    });
    Findings {
        motors: motors.zip(power_off).collect(),
        time,
        forces: solver.forces().clone(),
        rest,
        undetermined_loads: (0..loads.len()).filter(|&interface| !loads[interface]).collect(),
        redundant_actuators: statics.determined_drives().contains(&false),
    }
}
