//! Static friction of a robot at rest.

use crate::error::Error;
use crate::explain;
use crate::robot::Robot;
use serde_json::Value;
use std::fmt;
use stiction_core::dynamics::FrictionMode;
use stiction_format::{LoadCase, Motion};
use stiction_run::breakaway::{Findings, look, write_report};
use stiction_run::inverse::Job;

/// Static friction of a robot at rest at a position of its motion; see [`Robot::breakaway`].
#[derive(Clone, Debug)]
pub struct Breakaway {
    robot: Robot,
    motion: Option<(Motion, String)>,
    load: (LoadCase, String),
    at: Option<f64>,
}

impl Breakaway {
    pub(crate) fn new(robot: Robot) -> Self {
        let (motion, load) = (robot.default_motion(), robot.default_load());
        Self { robot, motion, load, at: None }
    }

    /// Sets the motion that leads to the position: its name in the model, the name of a file, or
    /// assignments such as `"A = 60 deg; duration = 0 s"`.
    ///
    /// # Errors
    /// There is no such motion, or the file or the assignments are defective.
    pub fn motion(mut self, motion: &str) -> Result<Self, Error> {
        self.motion = Some(self.robot.parse_motion(motion)?);
        Ok(self)
    }

    /// Sets the load: its name in the model, or assignments such as `"platform.fz = -100 N"`.
    ///
    /// # Errors
    /// There is no such load, or the assignments are defective.
    pub fn load(mut self, load: &str) -> Result<Self, Error> {
        self.load = self.robot.parse_load(load)?;
        Ok(self)
    }

    /// Sets the time of the motion at which the robot rests, s. Default: the start of the motion.
    pub fn at(mut self, time: f64) -> Self {
        self.at = Some(time);
        self
    }

    /// Converts the request to that of `stiction_run`.
    ///
    /// # Errors
    /// The model has no default motion, and none was given.
    pub fn job(&self) -> Result<Job<'_>, Error> {
        let (motion, name) = self.motion.as_ref().ok_or_else(|| self.robot.motion_missing())?;
        Ok(Job {
            model: self.robot.model(),
            motion,
            motion_name: name.clone(),
            load: &self.load.0,
            load_name: self.load.1.clone(),
            friction: FrictionMode::Converged,
            step: None,
            friction_margin: false,
        })
    }

    /// Examines the robot at rest.
    ///
    /// # Errors
    /// The position is singular or out of reach, or the requested time is after the end of the
    /// motion.
    pub fn run(&self) -> Result<Rest, Error> {
        let job = self.job()?;
        let findings = look(&job, self.at).map_err(explain::breakaway)?;
        let json = findings.json(&job);
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = write_report(&mut text, &job, &findings);
        let robot = self.robot.clone();
        Ok(Rest { robot, findings, json, text })
    }
}

/// Results for a robot at rest. `Display` prints them as the command `stiction breakaway` does.
#[derive(Clone, Debug)]
pub struct Rest {
    robot: Robot,
    findings: Findings,
    json: Value,
    text: String,
}

impl Rest {
    /// Least and greatest effort of an actuator for which the robot can remain at rest, N or N m.
    ///
    /// # Errors
    /// There is no actuator of that name.
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
