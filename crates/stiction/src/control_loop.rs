//! Inverse dynamics for control loops: compiled once, without names, input, output or allocation.

use crate::error::Error;
use crate::robot::Robot;
use stiction_core::dynamics::{Data, InverseDynamics, Model, Settings};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::BodyId;
use stiction_run::Error as RunError;
use stiction_run::exchange::Home;

/// Compiled inverse dynamics with the actuators as independent coordinates; see [`Robot::control_loop`].
#[derive(Clone, Debug)]
pub struct ControlLoop {
    /// The compiled model. It does not change.
    pub model: Model,
    /// State and results, allocated once.
    pub data: Data<f64>,
    /// Positions of the actuators at the first instant of the default motion, m or rad, in the order of
    /// [`Robot::actuators`].
    pub position: Vec<f64>,
}

impl ControlLoop {
    /// Compiles a robot at the first instant of its default motion.
    pub(crate) fn new(robot: &Robot) -> Result<Self, Error> {
        let check = robot.check_along();
        let job = check.job()?;
        let home = Home::of(&job)?;
        let mut coordinates = Vec::new();
        let mut targets = Vec::new();
        for (joint, dof) in home.mechanism.actuators() {
            let value = home.coordinates[joint.0][dof].unwrap_or(0.0);
            coordinates.push(Coordinate::Joint { joint, dof });
            targets.push(Target { value, rate: 0.0, acceleration: 0.0 });
        }
        let ground = home.mechanism.base().inverse();
        let poses = home.poses.iter().enumerate().skip(1);
        let initial_poses: Vec<_> =
            poses.map(|(body, pose)| (BodyId(body), ground * *pose)).collect();
        let friction = robot.model().default_friction.unwrap_or_default();
        let settings = Settings { friction, ..Settings::default() };
        let solver =
            InverseDynamics::new(home.mechanism, &initial_poses, &coordinates, &targets, settings)
                .map_err(|error| RunError::Assembly { time: job.motion.start, error })?;
        let model = solver.model().map_err(|reason| {
            Error::no_answer(format!("no control loop for `{}`: {reason}", robot.name())).with_help(
                "give the default motion another first position, away from singular ones",
            )
        })?;
        let data = model.data(solver.state(), settings);
        Ok(Self { model, data, position: targets.iter().map(|target| target.value).collect() })
    }
}
