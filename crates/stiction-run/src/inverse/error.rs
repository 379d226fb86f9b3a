//! Why a job has no result.

use crate::InstantsError;
use stiction_core::dynamics::InverseError;
use stiction_core::kinematics::AssemblyError;
use stiction_format::Diagnostic;
use thiserror::Error;

/// What is missing where loads cannot be carried.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    /// Where it was found first, and what.
    pub first: InverseError,
    /// The first instant, s.
    pub time: f64,
    /// The least and the greatest missing force or moment along the motion, and its unit.
    pub range: (f64, f64),
    /// N or N m.
    pub unit: &'static str,
    /// At how many samples.
    pub samples: usize,
    /// Of how many.
    pub of: usize,
}

/// Why a job has no result.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// There are no instants.
    #[error(transparent)]
    Instants(#[from] InstantsError),
    /// A formula of the motion or of the load has no finite value.
    #[error("{}", .0.message)]
    NotFinite(
        /// Which, when, and why.
        Box<Diagnostic>,
    ),
    /// The mechanism cannot be brought into a position.
    #[error("at t = {time} s: {error}")]
    Assembly {
        /// Time, s.
        time: f64,
        /// Why.
        error: AssemblyError,
    },
    /// A part is carried by a body with a local degree of freedom, such as a rod between two balls.
    #[error("`{body}` carries a payload, but can spin freely about its own axis")]
    Payload {
        /// The body.
        body: String,
    },
    /// There are no forces.
    #[error("at t = {time} s: {error}")]
    Forces {
        /// Time, s.
        time: f64,
        /// Why.
        error: InverseError,
    },
    /// The load cannot be carried.
    #[error("at t = {} s: {}", .0.time, .0.first)]
    CannotCarry(Box<Missing>),
    /// The samples could not be received.
    #[error("{0}")]
    Receiver(String),
    /// The job was stopped.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// Whether the input cannot be used (rather than that the question has no answer).
    pub fn is_bad_input(&self) -> bool {
        matches!(
            self,
            Self::Instants(_)
                | Self::NotFinite(_)
                | Self::Payload { .. }
                | Self::Assembly {
                    error: AssemblyError::Open { .. } | AssemblyError::AngleRange { .. },
                    ..
                }
        )
    }
}
