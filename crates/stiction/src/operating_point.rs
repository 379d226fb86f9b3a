//! Static equilibrium and linear models with access by name.

use crate::FrictionMode;
use crate::error::Error;
use crate::forward::Forward;
use crate::robot::Robot;
use serde_json::Value;
use std::fmt;
use stiction_run::forward::{self as run, LinearModel};

/// Request for a linear model of a robot about an operating point. Set the options, then call
/// [`run`](Self::run). See [`Robot::linearize`].
#[derive(Clone, Debug)]
pub struct Linearize {
    forward: Forward,
    has_efforts: bool,
}

/// Request for the static equilibrium of a robot without friction. Set the options, then call
/// [`run`](Self::run). See [`Robot::equilibrium`].
#[derive(Clone, Debug)]
pub struct Rests {
    forward: Forward,
    nearest: bool,
    friction: bool,
}

/// Defines the methods that set the options common to [`Linearize`] and [`Rests`].
macro_rules! shared_options {
    () => {
        /// Sets the motion: its name in the model, the name of a file, or assignments.
        ///
        /// # Errors
        /// The motion does not exist or is defective.
        pub fn motion(mut self, motion: &str) -> Result<Self, Error> {
            self.forward = self.forward.motion(motion)?;
            Ok(self)
        }

        /// Sets the load: its name in the model, or assignments.
        ///
        /// # Errors
        /// The load does not exist or is defective.
        pub fn load(mut self, load: &str) -> Result<Self, Error> {
            self.forward = self.forward.load(load)?;
            Ok(self)
        }

        /// Sets the state at which the robot is linearised or the search for an equilibrium begins,
        /// as in [`Forward::from`].
        ///
        /// # Errors
        /// An assignment is invalid.
        pub fn from(mut self, state: &str) -> Result<Self, Error> {
            self.forward = self.forward.from(state)?;
            Ok(self)
        }

        /// Locks a joint, with or without an actuator, at its position in the initial state.
        ///
        /// # Errors
        /// The joint does not exist or has no scalar coordinate.
        pub fn hold(mut self, joint: &str) -> Result<Self, Error> {
            self.forward = self.forward.hold(joint)?;
            Ok(self)
        }
    };
}

impl Linearize {
    pub(crate) fn of(robot: &Robot) -> Result<Self, Error> {
        Ok(Self { forward: robot.forward().controller("none")?, has_efforts: false })
    }

    shared_options!();

    /// Sets the time of the motion at which the robot is linearised, s. Default: the start of the motion.
    ///
    /// # Errors
    /// The motion does not include this time, or there is no motion.
    pub fn at(mut self, time: f64) -> Result<Self, Error> {
        self.forward = self.forward.begin_at(time)?;
        Ok(self)
    }

    /// Sets the efforts at the operating point, as in [`Forward::drives`]. Default: the efforts of inverse dynamics
    /// if the actuators determine the motion, else none.
    ///
    /// # Errors
    /// An assignment is invalid.
    pub fn drives(mut self, drives: &str) -> Result<Self, Error> {
        self.forward = self.forward.drives(drives)?;
        self.has_efforts = true;
        Ok(self)
    }

    /// Switches joint friction on or off. Default: the setting of the model or, if it has none, on.
    pub fn friction(mut self, on: bool) -> Self {
        self.forward = self.forward.friction(on);
        self
    }

    /// Linearises the equations of motion about the operating point.
    ///
    /// # Errors
    /// The position is singular, the mechanism has no degree of freedom there, or the robot cannot start.
    pub fn run(&self) -> Result<LinearModel, Error> {
        Ok(self.forward.plan()?.job().linearize(!self.has_efforts)?)
    }
}

impl Rests {
    pub(crate) fn of(robot: &Robot) -> Result<Self, Error> {
        let forward = robot.forward().controller("none")?.friction(false);
        let friction = robot.model().default_friction != Some(FrictionMode::Off);
        Ok(Self { forward, nearest: false, friction })
    }

    shared_options!();

    /// Sets the efforts, as in [`Forward::drives`]. Default: none.
    ///
    /// # Errors
    /// An assignment is invalid.
    pub fn drives(mut self, drives: &str) -> Result<Self, Error> {
        self.forward = self.forward.drives(drives)?;
        Ok(self)
    }

    /// Finds the nearest equilibrium, stable or not, by Newton's method from the initial state.
    /// Default: a stable equilibrium, reached by descending the potential energy.
    pub fn nearest(mut self) -> Self {
        self.nearest = true;
        self
    }

    /// Searches for the equilibrium.
    ///
    /// # Errors
    /// No equilibrium is found; the error states the reason.
    pub fn run(&self) -> Result<Equilibrium, Error> {
        let mut found = self.forward.plan()?.job().equilibrium(self.nearest)?;
        // The equilibrium is computed without friction. The efforts that static friction permits at
        // this position require the model with friction.
        let rubs = self.forward.clone().friction(true).plan()?;
        let mechanism = &rubs.job().model.mechanism;
        let has_friction = mechanism.joints().iter().any(|joint| !joint.friction.is_empty())
            || mechanism.drive_trains().iter().any(|train| train.has_friction());
        if self.friction && has_friction {
            found.holding = Some(rubs.job().holding(&found)?);
        }
        Ok(Equilibrium { found })
    }
}

/// Position in which a robot rests without friction. `Display` prints it as the command `stiction equilibrium` does.
#[derive(Clone, Debug)]
pub struct Equilibrium {
    found: run::Equilibrium,
}

impl Equilibrium {
    /// Coordinate of a joint, m or rad.
    ///
    /// # Errors
    /// The coordinate does not exist.
    pub fn position(&self, coordinate: &str) -> Result<f64, Error> {
        self.found
            .coordinate(coordinate)
            .ok_or_else(|| Error::input(format!("there is no coordinate `{coordinate}`")))
    }

    /// All results as a `stiction_run` type.
    pub fn findings(&self) -> &run::Equilibrium {
        &self.found
    }

    /// All results as JSON, with the keys of `stiction equilibrium --json`.
    pub fn to_json(&self) -> Value {
        self.found.json()
    }
}

impl fmt::Display for Equilibrium {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.found.fmt(f)
    }
}
