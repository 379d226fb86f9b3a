//! Error of a run: along a motion, through time, or at rest.

use crate::InstantsError;
use stiction_core::dynamics::InverseError;
use stiction_core::forward::ForwardError;
use stiction_core::kinematics::AssemblyError;
use stiction_format::{Diagnostic, Signal};
use thiserror::Error;

/// Error of a receiver of records; for a table that cannot be written, an [`std::io::Error`].
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// Load that the mechanism cannot carry at singular poses.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    /// Error at the first such sample.
    pub first: InverseError,
    /// Time of the first such sample, s.
    pub time: f64,
    /// Least and greatest missing force or moment along the motion.
    pub range: (f64, f64),
    /// Its unit, N or N m.
    pub unit: &'static str,
    /// Number of such samples.
    pub samples: usize,
    /// Number of all samples.
    pub of: usize,
}

/// Error of a run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// The sample times are not valid.
    #[error(transparent)]
    Instants(#[from] InstantsError),
    /// A formula has no finite value.
    #[error("{}", .0.message)]
    NotFinite(
        /// Signal, time and cause.
        Box<Diagnostic>,
    ),
    /// A stop condition has no value in a state, such as the root of a negative number.
    #[error(
        "the stop condition `{condition}` has no value at t = {time} s; write it so that it has one \
         wherever the motion leads"
    )]
    NoCondition {
        /// The condition.
        condition: String,
        /// Time, s.
        time: f64,
    },
    /// The mechanism cannot be assembled at a pose of the motion.
    #[error("at t = {time} s: {error}")]
    Assembly {
        /// Time, s.
        time: f64,
        /// Cause.
        error: AssemblyError,
    },
    /// A body with a local degree of freedom, such as a rod between two spherical joints, carries a
    /// part.
    #[error("`{body}` carries a payload, but can spin freely about its own axis")]
    SpinningPayload {
        /// The body.
        body: String,
    },
    /// A part is picked up or placed where an operating point is asked for.
    #[error(
        "the payload of `{body}` is picked up or placed between t = {from} s and t = {until} s; an \
         operating point needs payloads that are carried all the time"
    )]
    Payload {
        /// The body that carries the part.
        body: String,
        /// First instant, s.
        from: f64,
        /// Last instant, s.
        until: f64,
    },
    /// The forces have no solution.
    #[error("at t = {time} s: {error}")]
    Forces {
        /// Time, s.
        time: f64,
        /// Cause.
        error: InverseError,
    },
    /// The load cannot be carried.
    #[error("at t = {} s: {}", .0.time, .0.first)]
    CannotCarry(Box<Missing>),
    /// The instant at rest is outside the motion.
    #[error("the motion lasts from {start} s to {end} s: there is no position at t = {time:?} s")]
    NoSuchTime {
        /// Requested instant, s.
        time: f64,
        /// First instant of the motion, s.
        start: f64,
        /// Last instant of the motion, s.
        end: f64,
    },
    /// The static friction at an instant is not computed.
    #[error(
        "at t = {time} s the mechanism is singular, or both its constraints and its actuators are \
         redundant: static friction is not computed there"
    )]
    NoStaticFriction {
        /// The instant, s.
        time: f64,
    },
    /// A load depends on the measured state, which only simulations have.
    #[error(
        "the load on `{body}` is a formula over measured coordinates, which act in simulations only (`stiction forward`)"
    )]
    StateLoad {
        /// The body.
        body: String,
    },
    /// A formula of a load has no value in a state.
    #[error(
        "the formula of {load} has no value at t = {time} s; write it so that it has one wherever the motion leads"
    )]
    NoLoad {
        /// The load.
        load: String,
        /// Time, s.
        time: f64,
    },
    /// The controller's model cannot be assembled at the measured position.
    #[error("{0}")]
    Controller(AssemblyError),
    /// The controller's model has no finite efforts.
    #[error("{0}")]
    ControllerForces(InverseError),
    /// The controller failed during the simulation.
    #[error("at t = {time} s the controller cannot compute efforts: {error}")]
    ControllerAt {
        /// Time, s.
        time: f64,
        /// Cause.
        error: Box<Error>,
    },
    /// Forward dynamics has no solution.
    #[error(transparent)]
    Forward(ForwardError),
    /// There is no linear model at an operating point.
    #[error("there is no linear model: {0}")]
    NoLinearModel(
        /// Reason.
        String,
    ),
    /// No position of rest is found.
    #[error("no static equilibrium is found: {0}")]
    NoEquilibrium(
        /// Reason.
        String,
    ),
    /// The checkpoint belongs to another simulation.
    #[error("it does not belong to a simulation of this mechanism")]
    Checkpoint,
    /// A receiver of the records failed.
    #[error("{0}")]
    Receiver(SinkError),
    /// The user stopped the run.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// True for unusable input, false for a valid problem without a solution.
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
            Self::Controller(_) | Self::ControllerForces(_) => true,
            Self::Assembly { error, .. } | Self::Forward(ForwardError::Assembly(error)) => {
                matches!(error, AssemblyError::Open { .. } | AssemblyError::AngleRange { .. })
            }
            Self::Forward(
                ForwardError::Contradiction { .. }
                | ForwardError::Blocked { .. }
                | ForwardError::UnequalGears { .. },
            ) => true,
            _ => false,
        }
    }
}

/// Checks that signals have finite values at an instant, s.
///
/// # Errors
/// [`Error::NotFinite`].
pub(crate) fn check_finite<'s>(
    signals: impl IntoIterator<Item = &'s Signal>,
    time: f64,
) -> Result<(), Error> {
    match signals.into_iter().find_map(|signal| signal.fault_at(time)) {
        Some(fault) => Err(Error::NotFinite(Box::new(fault))),
        None => Ok(()),
    }
}
