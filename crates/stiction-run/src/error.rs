//! Errors of all computations: along a motion, in a simulation, or at rest.

use crate::InstantsError;
use stiction_core::dynamics::InverseError;
use stiction_core::forward::ForwardError;
use stiction_core::kinematics::AssemblyError;
use stiction_format::{Diagnostic, Signal};
use thiserror::Error;

/// Error of a receiver of records, such as an [`std::io::Error`] for a table that cannot be written.
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// Description of a load that the mechanism cannot carry at singular poses of its motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    /// Error at the first singular sample.
    pub first: InverseError,
    /// Time of the first singular sample, s.
    pub time: f64,
    /// Least and greatest magnitude, along the motion, of the force or moment that cannot be balanced.
    pub range: (f64, f64),
    /// Unit of `range`, N or N m.
    pub unit: &'static str,
    /// Number of samples at which the mechanism cannot carry the load.
    pub samples: usize,
    /// Total number of samples of the run.
    pub of: usize,
}

/// Error of a computation along a motion, in a simulation, or at rest.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// The sample times are not valid.
    #[error(transparent)]
    Instants(#[from] InstantsError),
    /// A signal, such as the formula of a motion or load, has no finite value at some time.
    #[error("{}", .0.message)]
    NotFinite(
        /// Description of the signal, the time and the cause.
        Box<Diagnostic>,
    ),
    /// A stop condition cannot be evaluated in some state, for example because it contains the root of a negative
    /// number.
    #[error(
        "the stop condition `{condition}` cannot be evaluated at t = {time} s (for example because \
         of a division by zero or the root of a negative number); write a condition that is \
         defined at every state of the motion"
    )]
    NoCondition {
        /// Text of the stop condition.
        condition: String,
        /// Time at which the stop condition cannot be evaluated, s.
        time: f64,
    },
    /// The mechanism cannot be assembled at a pose of the motion.
    #[error("at t = {time} s: {error}")]
    Assembly {
        /// Time at which the mechanism cannot be assembled, s.
        time: f64,
        /// Reason why the assembly failed.
        error: AssemblyError,
    },
    /// The mechanism cannot follow the reference motion of a controller.
    #[error("at t = {time} s the mechanism cannot follow the reference motion: {error}")]
    Reference {
        /// Time of the reference that the mechanism cannot reach, s.
        time: f64,
        /// Reason why the assembly failed.
        error: AssemblyError,
    },
    /// A payload is attached to a body with a local degree of freedom, such as a rod between two spherical joints.
    #[error("`{body}` carries a payload, but can spin freely about its own axis")]
    SpinningPayload {
        /// Name of the body that carries the payload.
        body: String,
    },
    /// A payload is picked up or placed during the job, but an operating point requires a constant
    /// payload.
    #[error(
        "the payload of `{body}` is picked up or placed between t = {from} s and t = {until} s; an \
         operating point needs payloads that are carried all the time"
    )]
    Payload {
        /// Name of the body that carries the payload.
        body: String,
        /// Time at which the payload is picked up, s.
        from: f64,
        /// Time at which the payload is placed, s.
        until: f64,
    },
    /// Inverse dynamics has no solution at some time.
    #[error("at t = {time} s: {error}")]
    Forces {
        /// Time at which inverse dynamics has no solution, s.
        time: f64,
        /// Reason why inverse dynamics has no solution.
        error: InverseError,
    },
    /// The mechanism cannot carry the load at singular poses.
    #[error("at t = {} s: {}", .0.time, .0.first)]
    CannotCarry(Box<Missing>),
    /// The requested time is outside the motion.
    #[error("the motion lasts from {start} s to {end} s: there is no position at t = {time:?} s")]
    NoSuchTime {
        /// Requested time, s.
        time: f64,
        /// Start of the motion, s.
        start: f64,
        /// End of the motion, s.
        end: f64,
    },
    /// Static friction is not computed at this time.
    #[error(
        "at t = {time} s the mechanism is singular, or friction has no accurate solution: static \
         friction is not computed there"
    )]
    NoStaticFriction {
        /// Time without a result for static friction, s.
        time: f64,
    },
    /// A load is a formula of the measured state, which only simulations have.
    #[error(
        "the load on `{body}` is a formula of measured coordinates; such loads act in simulations \
         only (`stiction forward`)"
    )]
    StateLoad {
        /// Name of the body on which the load acts.
        body: String,
    },
    /// The formula of a load cannot be evaluated in some state.
    #[error(
        "the formula of {load} cannot be evaluated at t = {time} s (for example because of a \
         division by zero or the root of a negative number); write a formula that is defined at \
         every state of the motion"
    )]
    NoLoad {
        /// Description of the load.
        load: String,
        /// Time at which the formula cannot be evaluated, s.
        time: f64,
    },
    /// The controller's model cannot be assembled at the measured position.
    #[error("{0}")]
    Controller(AssemblyError),
    /// Locked joints prevent accelerations of the actuators that the controller requires.
    #[error("with {locked} locked, the actuators cannot move as the controller requires: {error}")]
    ControllerLocked {
        /// Names of the locked joints.
        locked: String,
        /// Contradiction between the accelerations and the locks.
        error: AssemblyError,
    },
    /// The inverse dynamics of the controller's model has no solution.
    #[error("{0}")]
    ControllerForces(InverseError),
    /// Motors that share efforts cannot exert the efforts that the motion requires.
    #[error(
        "at t = {time} s the motors {motors} cannot produce the motion with torques in the ratio \
         of their shares, because a self-locking gear jams; change `share` or the efficiencies of \
         these motors"
    )]
    SharedMotors {
        /// Time at which the motors cannot exert the efforts, s.
        time: f64,
        /// Names of the motors that share efforts.
        motors: String,
    },
    /// Intervals of holding efforts cannot be computed. Motors with losses share the efforts of
    /// several joints, or one of their gears jams, so that the efforts that hold the joints do not
    /// form independent intervals.
    #[error(
        "the motors {motors} share the efforts of several joints and have gear losses, or one of \
         their gears jams even if the motor pushes in the direction of the load: the efforts that \
         hold one joint then depend on those of the others; each joint has an interval of its own \
         only if the efficiencies of these gears are 1"
    )]
    SharedHolding {
        /// Names of the motors concerned.
        motors: String,
    },
    /// The controller failed during the simulation.
    #[error("at t = {time} s the controller cannot compute efforts: {error}")]
    ControllerAt {
        /// Time at which the controller failed, s.
        time: f64,
        /// Error of the controller.
        error: Box<Error>,
    },
    /// Forward dynamics has no solution.
    #[error(transparent)]
    Forward(ForwardError),
    /// An operating point has no linear model.
    #[error("there is no linear model: {0}")]
    NoLinearModel(
        /// Reason why the linear model does not exist.
        String,
    ),
    /// No static equilibrium is found.
    #[error("no static equilibrium is found: {0}")]
    NoEquilibrium(
        /// Reason why no equilibrium was found.
        String,
    ),
    /// The checkpoint was written by a simulation of another mechanism or with other options.
    #[error("the checkpoint does not belong to a simulation of this mechanism")]
    Checkpoint,
    /// A receiver of records failed, for example a table that cannot be written.
    #[error("{0}")]
    Receiver(SinkError),
    /// The user stopped the run.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// Returns true if the input is invalid, and false for a valid problem without a solution.
    pub fn is_bad_input(&self) -> bool {
        match self {
            Self::Instants(_)
            | Self::NotFinite(_)
            | Self::NoCondition { .. }
            | Self::StateLoad { .. }
            | Self::NoLoad { .. }
            | Self::NoSuchTime { .. }
            | Self::Checkpoint => true,
            Self::SpinningPayload { .. } | Self::Payload { .. } => true,
            Self::Controller(_) | Self::ControllerForces(_) | Self::ControllerLocked { .. } => true,
            Self::Assembly { error, .. }
            | Self::Reference { error, .. }
            | Self::Forward(ForwardError::Assembly(error)) => {
                matches!(error, AssemblyError::Open { .. } | AssemblyError::AngleRange { .. })
            }
            Self::Forward(ForwardError::Contradiction { .. } | ForwardError::Blocked { .. }) => {
                true
            }
            _ => false,
        }
    }
}

/// Checks that signals have finite values at the instant `time`, s.
///
/// # Errors
/// Returns [`Error::NotFinite`] for the first signal without a finite value.
pub(crate) fn check_finite<'s>(
    signals: impl IntoIterator<Item = &'s Signal>,
    time: f64,
) -> Result<(), Error> {
    match signals.into_iter().find_map(|signal| signal.fault_at(time)) {
        Some(fault) => Err(Error::NotFinite(Box::new(fault))),
        None => Ok(()),
    }
}
