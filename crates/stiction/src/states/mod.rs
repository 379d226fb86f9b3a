//! Inverse dynamics, kinematics, Jacobians and mass matrices of batches of states, for a robot that
//! is compiled once.

mod batch;
mod compile;
mod derivatives;
mod rows;

pub use batch::{Batch, InverseRows, MotionRows, Outputs, Rows};
pub(crate) use compile::guesses;
pub use compile::{Compile, Compiled};
pub use derivatives::Derivatives;
pub use rows::Workers;

use crate::control_loop::ControlLoop;
use crate::error::Error;
use crate::robot::Robot;
use std::sync::{Mutex, OnceLock};
use stiction_core::dynamics::{Data, FrictionMode, Model, Status};
use stiction_core::kinematics::State;
use stiction_core::mechanism::BodyId;
use stiction_core::spatial::Pose;
use stiction_core::statics::AppliedLoad;
use stiction_run::inverse::Motors;

/// Maximum number of unused solver data objects that are stored for reuse.
const MOST_SPARE: usize = 64;

/// A robot compiled for batches of states; see [`Robot::states`].
///
/// A state is a row `q` of independent coordinates, with rates `v` and accelerations `a`. The
/// assembly mode is that of the home position: each row is reached from the previous row in steps
/// that are short enough to remain in this mode. A batch is divided into groups of a fixed number
/// of rows, and the first row of each group is reached from the home position, so results do not
/// depend on the number of threads.
#[derive(Debug)]
pub struct States {
    robot: Robot,
    model: Model,
    /// Solver data at the home position, from which the data of each thread are copied.
    prototype: Data<f64>,
    start: State<f64>,
    spare: Mutex<Vec<Data<f64>>>,
    coordinates: Vec<Coordinate>,
    home: Vec<f64>,
    /// Poses of the bodies at the home position, in the ground's frame.
    home_poses: Vec<(BodyId, Pose<f64>)>,
    /// True if the coordinates are those of the actuators, in the same order.
    by_actuators: bool,
    motors: Motors,
    /// Joint and degree of freedom of each actuator, by index.
    actuators: Vec<(usize, usize)>,
    loads: Vec<AppliedLoad<f64>>,
    load_name: String,
    /// Program for the derivatives, recorded when first used.
    derivatives: OnceLock<derivatives::Recorded>,
}

/// Independent coordinate of the states of a batch.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinate {
    /// Name, such as `leg1.P` or `platform.x`.
    pub name: String,
    /// Unit, `m` or `rad`.
    pub unit: &'static str,
    /// Longest step of the coordinate between two solutions of the loop closure, m or rad; longer
    /// moves are divided into several steps.
    step: f64,
}

impl States {
    /// The coordinates, in the order of the columns of `q`, `v` and `a`.
    pub fn coordinates(&self) -> &[Coordinate] {
        &self.coordinates
    }

    /// Home position: coordinates at the first instant of the motion, or at the time that the
    /// option `at` of the request set, m or rad.
    pub fn home(&self) -> &[f64] {
        &self.home
    }

    /// Name of the load that acts in all rows.
    pub fn load_name(&self) -> &str {
        &self.load_name
    }

    /// Friction mode: iterated, decoupled (one-pass), or off.
    pub fn friction(&self) -> FrictionMode {
        self.prototype.settings.friction
    }

    /// The robot that was compiled.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// Converts the compiled robot to a control loop with the same model, solver data and home
    /// position.
    pub(crate) fn into_control_loop(self) -> ControlLoop {
        ControlLoop { model: self.model, data: self.prototype, position: self.home }
    }

    /// Returns the program for the derivatives of the efforts; records the program at the first
    /// call.
    fn recorded_derivatives(&self) -> Result<&derivatives::Recorded, Error> {
        if let Some(recorded) = self.derivatives.get() {
            return Ok(recorded);
        }
        // No lock is held during the recording: if the process were forked meanwhile, the child
        // process would wait for the lock forever.
        let recorded = derivatives::Recorded::of(self)?;
        Ok(self.derivatives.get_or_init(|| recorded))
    }

    /// Returns solver data at the home position: stored data that no thread uses, or a copy of the
    /// prototype.
    fn borrow_data(&self) -> Data<f64> {
        // Does not wait for the lock: in a process forked while another thread held the lock, the
        // wait would never end.
        let spare = self.spare.try_lock().ok().and_then(|mut spare| spare.pop());
        let mut data = spare.unwrap_or_else(|| self.prototype.clone());
        self.go_home(&mut data);
        data
    }

    fn go_home(&self, data: &mut Data<f64>) {
        data.start_from(&self.start);
        data.settings = self.prototype.settings;
    }

    fn return_data(&self, data: Data<f64>) {
        if let Ok(mut spare) = self.spare.try_lock()
            && spare.len() < MOST_SPARE
        {
            spare.push(data);
        }
    }

    /// Rejects a computation that needs the actuators as coordinates if other coordinates were
    /// chosen.
    fn refuse_other_coordinates(&self, what: &str) -> Result<(), Error> {
        if self.by_actuators {
            return Ok(());
        }
        let names: Vec<&str> = self.coordinates.iter().map(|c| c.name.as_str()).collect();
        Err(Error::input(format!(
            "{what} needs the actuators as coordinates, but the chosen coordinates are {}",
            names.join(", ")
        ))
        .with_help("leave the coordinates out: the actuators are the default"))
    }
}

/// Short name of a status, as an identifier for programs.
pub fn status_name(status: Status) -> &'static str {
    match status {
        Status::Converged => "converged",
        Status::InputNotFinite => "input_not_finite",
        Status::LoopsOpen { .. } => "loops_open",
        Status::MotionInconsistent => "motion_inconsistent",
        Status::Singular => "singular",
        Status::SpringWithoutDirection { .. } => "spring_without_direction",
        Status::SpringTurned { .. } => "spring_turned",
        Status::NoOverlap { .. } => "no_overlap",
        Status::FrictionNotConverged { .. } => "friction_not_converged",
        Status::FrictionLocks => "friction_locks",
        Status::Unbalanced { .. } => "unbalanced",
        _ => "other",
    }
}

/// Reason why a row has no result, as a sentence without a full stop.
pub fn status_reason(status: Status) -> &'static str {
    match status {
        Status::LoopsOpen { .. } => {
            "the loops do not close: the position cannot be reached from the home position along a straight \
             line in the coordinates"
        }
        status => status.reason(),
    }
}
