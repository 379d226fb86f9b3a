//! Compilation of a robot for batches of states.

use super::{Coordinate, States};
use crate::coordinates::{named, which};
use crate::error::Error;
use crate::request::{Loaded, Request};
use crate::robot::Robot;
use std::sync::{Mutex, OnceLock};
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_core::kinematics::{Coordinate as Which, Target};
use stiction_core::mechanism::BodyId;
use stiction_core::spatial::Pose;
use stiction_format::Motion;
use stiction_run::exchange::Home;
use stiction_run::inverse::Motors;
use stiction_run::{Error as RunError, Job};

/// Request for a robot compiled for batches of states; see [`Robot::states`].
pub type Compile = Request<Compiled>;

/// Options for the compilation of a robot for batches of states.
#[derive(Clone, Debug)]
pub struct Compiled {
    coordinates: Option<Vec<String>>,
    friction: FrictionMode,
    at: Option<f64>,
}

impl Loaded for Compiled {}

/// Longest step of a coordinate between two solutions of the loop closure. Longer moves are divided
/// into steps of at most this length. Unit: rad for angles; fraction of the characteristic length
/// for lengths.
const STEP: f64 = 0.1;

impl Compile {
    pub(crate) fn of(robot: &Robot) -> Self {
        let friction = robot.model().default_friction.unwrap_or_default();
        let mut request = Self::new(robot, Compiled { coordinates: None, friction, at: None });
        if robot.model().motions.is_empty() {
            request.motion = Some((Motion::pose(), "none".to_owned()));
        }
        request
    }

    /// Sets the coordinates of a state, by name: joint coordinates such as `leg1.P`, and coordinates that
    /// the motion prescribes, such as `platform.x`. Default: all actuators.
    ///
    /// # Errors
    /// The coordinate does not exist.
    pub fn coordinates<S: AsRef<str>>(mut self, names: &[S]) -> Result<Self, Error> {
        for name in names {
            which(&self.robot, name.as_ref())?;
        }
        self.task.coordinates = Some(names.iter().map(|name| name.as_ref().to_owned()).collect());
        Ok(self)
    }

    /// Sets the coupling of friction with the reactions that cause it: iterated to convergence,
    /// computed in one pass, or off.
    pub fn friction(mut self, friction: FrictionMode) -> Self {
        self.task.friction = friction;
        self
    }

    /// Sets the time of the motion, s, at which the home position is taken and the load is
    /// evaluated. Default: the start of the motion.
    pub fn at(mut self, time: f64) -> Self {
        self.task.at = Some(time);
        self
    }

    /// Compiles the robot at its home position.
    ///
    /// # Errors
    /// The home position cannot be assembled or is singular, or the coordinates do not determine the motion.
    pub fn compile(&self) -> Result<States, Error> {
        let mut request = self.clone();
        if let (Some(at), Some((motion, _))) = (self.task.at, &mut request.motion) {
            let (start, end) = (motion.start, motion.start + motion.duration);
            if !(start..=end).contains(&at) {
                return Err(RunError::NoSuchTime { time: at, start, end }.into());
            }
            (motion.start, motion.duration) = (at, end - at);
        }
        let job = request.along(self.task.friction)?;
        let time = job.motion.start;
        let locked = job.locked_start()?;
        let job = match &locked {
            Some((motion, _)) => Job { motion, ..job },
            None => job,
        };
        let home = Home::of(&job)?;
        let (mechanism, load) =
            job.load.attached(&home.mechanism, (time, time)).map_err(|payload| {
                RunError::Payload {
                    body: home.mechanism.bodies()[payload.body.0].name.clone(),
                    from: time,
                    until: time,
                }
            })?;
        let mut loads = Vec::new();
        Job { load: &load, ..job.clone() }.loads_at(time, &mut loads)?;

        let by_actuators = self.task.coordinates.is_none();
        let named = named(&self.robot, &home, self.task.coordinates.as_deref())?;
        let whiches: Vec<Which> = named.iter().map(|(_, which, _)| *which).collect();
        let values: Vec<f64> = named.iter().map(|(.., value)| *value).collect();
        let at_rest = |&value: &f64| Target { value, rate: 0.0, acceleration: 0.0 };
        let targets: Vec<Target<f64>> = values.iter().map(at_rest).collect();
        let settings = Settings { friction: self.task.friction, ..Settings::default() };
        let guesses = guesses(&home);
        let solver = InverseDynamics::new(mechanism, &guesses, &whiches, &targets, settings)
            .map_err(|error| self.unfit(RunError::Assembly { time, error }))?;
        let model = solver.model().map_err(|reason| {
            Error::no_answer(format!(
                "`{}` cannot be compiled at its home position: {reason}",
                self.robot.name()
            ))
            .with_help("choose another home position, away from singular ones")
            .with_option("at")
        })?;
        let types: Vec<_> = model.mechanism().joints().iter().map(|j| j.joint_type).collect();
        let length = model.parameters().length;
        let coordinates = named.into_iter().map(|(name, which, _)| {
            let (unit, step) = match which.is_angle(&types) {
                true => ("rad", STEP),
                false => ("m", STEP * length),
            };
            Coordinate { name, unit, step }
        });
        Ok(States {
            robot: self.robot.clone(),
            prototype: model.data(solver.state(), settings),
            start: solver.state().clone(),
            spare: Mutex::default(),
            coordinates: coordinates.collect(),
            home: values,
            home_poses: guesses,
            by_actuators,
            motors: Motors::new(model.mechanism(), settings.friction, |_| settings.rest_speed),
            actuators: model.mechanism().actuators().map(|(joint, dof)| (joint.0, dof)).collect(),
            loads,
            load_name: job.load_name.clone(),
            derivatives: OnceLock::new(),
            model,
        })
    }

    fn unfit(&self, error: RunError) -> Error {
        let error = Error::from(error);
        let names = match &self.task.coordinates {
            None => self.robot.actuators().collect::<Vec<_>>().join(", "),
            Some(names) => names.join(", "),
        };
        Error::new(
            error.kind(),
            format!("the coordinates {names} do not determine the motion: {}", error.message()),
        )
        .with_help("choose other coordinates, one for each degree of freedom")
        .with_option("coordinates")
    }
}

/// Poses of all bodies at the home position, in the ground's frame: initial guesses for assembly.
pub(crate) fn guesses(home: &Home<'_>) -> Vec<(BodyId, Pose<f64>)> {
    let ground = home.mechanism.base().inverse();
    let poses = home.poses.iter().enumerate().skip(1);
    poses.map(|(body, pose)| (BodyId(body), ground * *pose)).collect()
}
