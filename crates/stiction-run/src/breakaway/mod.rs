//! A position at rest: what static friction leaves open, at what efforts motion begins, and whether
//! the position holds without drives.

mod json;
mod terminal;

use crate::inverse::{Error, Job};
use stiction_core::dynamics::{Forces, FrictionMode, InverseDynamics, Rest, Settings};
use thiserror::Error;

pub use terminal::write_report;

/// What was found at a position.
#[derive(Clone, Debug)]
pub struct Findings {
    /// The instant of the motion, s.
    pub time: f64,
    /// All forces at rest.
    pub forces: Forces,
    /// Breakaway and holding.
    pub rest: Rest,
    /// Contacts whose load the balance does not determine, by index.
    pub undetermined_loads: Vec<usize>,
    /// Whether there are more actuators than the balance determines.
    pub redundant_actuators: bool,
}

/// Why there are no findings.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BreakawayError {
    /// The motion does not go there.
    #[error("the motion lasts from {start} s to {end} s: there is no position at t = {time:?} s")]
    NoSuchTime {
        /// What was asked for, s.
        time: f64,
        /// The first instant, s.
        start: f64,
        /// The last, s.
        end: f64,
    },
    /// As everywhere.
    #[error(transparent)]
    Job(#[from] Error),
}

/// Stops the mechanism at an instant of its motion (by default the first) and looks at it. The job's
/// mode of friction is not asked for: without friction there is nothing to look at.
///
/// # Errors
/// See [`BreakawayError`].
pub fn look(job: &Job<'_>, time: Option<f64>) -> Result<Findings, BreakawayError> {
    let motion = job.motion;
    let (start, end) = (motion.start, motion.start + motion.duration);
    let time = time.unwrap_or(start);
    // The last instant may be off by rounding.
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
    Findings {
        time,
        forces: solver.forces().clone(),
        rest,
        undetermined_loads: (0..loads.len()).filter(|&interface| !loads[interface]).collect(),
        redundant_actuators: statics.determined_drives().contains(&false),
    }
}
