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
    /// A part is picked up or placed during a simulation, which is an impact.
    #[error(
        "the payload of `{body}` is picked up or placed between t = {from} s and t = {until} s; a \
         simulation needs payloads that are carried all the time"
    )]
    Payload {
        /// The body that carries the part.
        body: String,
        /// First instant of the simulation, s.
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
    /// The checkpoint belongs to another simulation.
    #[error("it does not belong to a simulation of this mechanism")]
    Mark,
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
            Self::Instants(_) | Self::NotFinite(_) | Self::NoSuchTime { .. } | Self::Mark => true,
            Self::SpinningPayload { .. } | Self::Payload { .. } => true,
            Self::Controller(_) | Self::ControllerForces(_) => true,
            Self::Assembly { error, .. } | Self::Forward(ForwardError::Assembly(error)) => {
                matches!(error, AssemblyError::Open { .. } | AssemblyError::AngleRange { .. })
            }
            Self::Forward(
                ForwardError::Contradiction { .. }
                | ForwardError::Blocked { .. }
                | ForwardError::GearLoss { .. },
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
