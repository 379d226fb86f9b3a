//! Static friction of a mechanism at rest: effort intervals, breakaway efforts and self-locking.

mod json;
mod page;
mod terminal;

use crate::power_off::{self, PowerOff};
use crate::{Error, Follower, Job, SinkError};
use stiction_core::dynamics::{Forces, FrictionMode, InverseError, Rest, Settings};
use stiction_core::mechanism::Motor;
use stiction_core::spatial::Pose;

pub use page::draw_report;
pub use terminal::write_report;

/// Static-friction results for a mechanism at rest in one pose.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Time at which the motion reaches the pose, s.
    pub time: f64,
    /// Actuator efforts, intervals of these efforts, and joint reactions, all at rest.
    pub forces: Forces,
    /// Breakaway effort of each actuator, and verdicts on self-locking.
    pub rest: Rest,
    /// Indices of the friction interfaces whose normal loads are statically indeterminate.
    pub undetermined_loads: Vec<usize>,
    /// True if some efforts are statically indeterminate because there are more actuators than
    /// degrees of freedom.
    pub redundant_actuators: bool,
    /// Poses of all bodies, the ground first, with positions relative to the reference point of the
    /// inverse dynamics.
    poses: Vec<Pose<f64>>,
    /// For each drive train: the state of its motor, and the cause that holds the motor at rest
    /// with power off.
    motors: Vec<(Motor, PowerOff)>,
}

/// Computes the static-friction results at each sample of a motion, as if the mechanism were at
/// rest there, and passes them to `receive`. Friction always acts; the friction mode of the job is
/// ignored.
///
/// # Errors
/// See [`enum@Error`].
pub fn run(
    job: &Job<'_>,
    mut receive: impl FnMut(&Findings) -> Result<(), SinkError>,
) -> Result<(), Error> {
    let instants = job.instants()?;
    let mut follower = job.assemble(instants.at(0))?;
    for time in instants.iter() {
        follower.go_to(time)?;
        receive(&rest_at(job, &mut follower)?).map_err(Error::Receiver)?;
    }
    Ok(())
}

/// Computes the static-friction results for one pose of the motion, as if the mechanism were at
/// rest there. The pose is the one at `time`, s, or at the first instant of the motion by default.
///
/// # Errors
/// See [`enum@Error`].
pub fn evaluate(job: &Job<'_>, time: Option<f64>) -> Result<Findings, Error> {
    let motion = job.motion;
    let (start, end) = (motion.start, motion.start + motion.duration);
    let time = time.unwrap_or(start);
    // `time` may lie outside the motion by a rounding error.
    let slack = 1e-9 * motion.duration;
    if !(start - slack..=end + slack).contains(&time) {
        return Err(Error::NoSuchTime { time, start, end });
    }
    let time = time.clamp(start, end);
    let instants = job.instants()?;
    let mut follower = job.assemble(instants.at(0))?;
    for next in instants.iter().skip(1).take_while(|t| *t < time).chain([time]) {
        follower.go_to(next)?;
    }
    rest_at(job, &mut follower)
}

/// Computes the static-friction results for the pose that `follower` has reached.
fn rest_at(job: &Job<'_>, follower: &mut Follower<'_>) -> Result<Findings, Error> {
    let (time, solver) = (follower.time(), &mut follower.solver);
    *solver.settings_mut() = Settings { friction: FrictionMode::Converged, ..Settings::default() };
    let mut loads = Vec::new();
    job.loads_at_rest(time, &mut loads)?;
    let rest = solver.rest(&loads).map_err(|error| match error {
        InverseError::Unsettled | InverseError::Singular => Error::NoStaticFriction { time },
        error => Error::Forces { time, error },
    })?;
    let statics = solver.statics();
    let loads = solver.determined_loads(&statics);
    let (forces, trains) = (solver.forces(), solver.mechanism().drive_trains());
    let maps = solver.mechanism().motor_maps();
    let shared = solver.mechanism().shared_motors();
    let power_off = power_off::of((trains, &maps, &shared), forces);
    let motors = trains.iter().zip(&maps).map(|(train, map)| {
        let bounds = map.effort_bounds(&forces.effort_bounds);
        train.motor(map.effort(&forces.efforts), bounds, None, 0.0, 0.0)
    });
    Ok(Findings {
        poses: solver.bodies().pose.clone(),
        motors: motors.zip(power_off).collect(),
        time,
        forces: solver.forces().clone(),
        rest,
        undetermined_loads: (0..loads.len()).filter(|&interface| !loads[interface]).collect(),
        redundant_actuators: statics.determined_drives().contains(&false),
    })
}
