//! Request that computes the static friction of a robot at rest, and its results.

use crate::error::Error;
use crate::request::{Loaded, Request, Sampled};
use crate::robot::Robot;
use serde_json::Value;
use std::fmt;
use stiction_core::dynamics::FrictionMode;
use stiction_run::breakaway::{self, Findings, write_report};
use stiction_run::{Job, SinkError};

/// Request to compute the static friction of a robot at rest at a position of its motion; see
/// [`Robot::breakaway`].
pub type Breakaway = Request<StaticFriction>;

/// Options of [`Breakaway`].
#[derive(Clone, Debug)]
pub struct StaticFriction {
    at: Option<f64>,
}

impl Loaded for StaticFriction {}

impl Breakaway {
    pub(crate) fn of(robot: &Robot) -> Self {
        Self::new(robot, StaticFriction { at: None })
    }

    /// Sets the time of the motion at which the robot rests, s. Default: the start of the motion.
    pub fn at(mut self, time: f64) -> Self {
        self.task.at = Some(time);
        self
    }

    /// Converts the request to a [`Job`], which the functions of `stiction_run` that write reports
    /// require.
    ///
    /// # Errors
    /// The model has no default motion, and none was set.
    pub fn job(&self) -> Result<Job<'_>, Error> {
        self.along(FrictionMode::Converged)
    }

    /// Examines the robot at rest at the time that the option `at` sets;
    /// [`samples`](Request::samples) examines it at every sample of the motion.
    ///
    /// # Errors
    /// The position is singular or out of reach, or the requested time is after the end of the
    /// motion.
    pub fn run(&self) -> Result<Rest, Error> {
        let job = self.job()?;
        Ok(Rest::new(&self.robot, &job, breakaway::evaluate(&job, self.task.at)?))
    }
}

impl Sampled for StaticFriction {
    type Sample = Rest;
    type Outcome = ();

    fn complete(request: &Breakaway) -> Result<Breakaway, Error> {
        request.along(FrictionMode::Converged)?;
        Ok(request.clone())
    }

    fn compute(
        request: &Breakaway,
        receive: &mut dyn FnMut(Rest) -> Result<(), SinkError>,
        _is_stopped: &dyn Fn() -> bool,
    ) -> Result<(), Error> {
        let job = request.along(FrictionMode::Converged)?;
        let receive =
            |findings: &Findings| receive(Rest::new(&request.robot, &job, findings.clone()));
        Ok(breakaway::run(&job, receive)?)
    }
}

/// Results of a [`Breakaway`] request for one position of the robot at rest. `Display` prints the
/// results as the command `stiction breakaway` does.
#[derive(Clone, Debug)]
pub struct Rest {
    robot: Robot,
    findings: Findings,
    json: Value,
    text: String,
}

impl Rest {
    fn new(robot: &Robot, job: &Job<'_>, findings: Findings) -> Self {
        let json = findings.json(job);
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = write_report(&mut text, job, &findings);
        Self { robot: robot.clone(), findings, json, text }
    }

    /// Time of the motion at which the robot rests, s.
    pub fn time(&self) -> f64 {
        self.findings.time
    }

    /// Smallest and largest effort of an actuator, N or N m, for which the robot remains at rest.
    ///
    /// # Errors
    /// No actuator has that name.
    pub fn effort_bounds(&self, actuator: &str) -> Result<(f64, f64), Error> {
        Ok(self.findings.forces.effort_bounds[self.robot.names().actuator(actuator)?])
    }

    /// All results as a `stiction_run` type.
    pub fn findings(&self) -> &Findings {
        &self.findings
    }

    /// All results as JSON, with the keys of `stiction breakaway --json`.
    pub fn to_json(&self) -> &Value {
        &self.json
    }
}

impl fmt::Display for Rest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}
