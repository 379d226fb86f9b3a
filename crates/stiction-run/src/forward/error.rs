//! Error of a simulation.

use crate::{InstantsError, inverse};
use stiction_core::dynamics::InverseError;
use stiction_core::forward::ForwardError;
use stiction_core::kinematics::AssemblyError;
use stiction_format::Diagnostic;
use thiserror::Error;

/// Error of a simulation.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// The sample times are not valid.
    #[error(transparent)]
    Instants(#[from] InstantsError),
    /// The motion cannot be followed, or its efforts cannot be computed.
    #[error(transparent)]
    Motion(inverse::Error),
    /// A formula has no finite value.
    #[error("{}", .0.message)]
    NotFinite(Box<Diagnostic>),
    /// The controller's model cannot be assembled at the measured position.
    #[error("{0}")]
    Controller(AssemblyError),
    /// The controller's model has no finite efforts.
    #[error("{0}")]
    ControllerForces(InverseError),
    /// The controller failed during the simulation.
    #[error("at t = {time} s the controller has no efforts: {error}")]
    ControllerAt {
        /// Time, s.
        time: f64,
        /// Cause.
        error: Box<Error>,
    },
    /// A part is picked up or placed during the simulation, which is an impact.
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
    /// Forward dynamics has no solution.
    #[error(transparent)]
    Forward(ForwardError),
    /// A receiver of the samples failed.
    #[error("{0}")]
    Receiver(String),
    /// The checkpoint belongs to another simulation.
    #[error("its numbers are not those of a simulation of this mechanism")]
    Mark,
    /// The user stopped the simulation before its first sample.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// True for unusable input, false for a valid problem without a solution.
    pub fn is_bad_input(&self) -> bool {
        let incomplete = |error: &AssemblyError| {
            matches!(error, AssemblyError::Open { .. } | AssemblyError::AngleRange { .. })
        };
        match self {
            Self::Instants(_) | Self::NotFinite(_) | Self::Payload { .. } | Self::Mark => true,
            Self::Motion(error) => error.is_bad_input(),
            Self::Controller(_) | Self::ControllerForces(_) => true,
            Self::Forward(ForwardError::Assembly(error)) => incomplete(error),
            Self::Forward(
                ForwardError::Contradiction { .. }
                | ForwardError::Blocked { .. }
                | ForwardError::GearLoss { .. },
            ) => true,
            _ => false,
        }
    }
}
