//! Error of a run along a motion.

use crate::InstantsError;
use stiction_core::dynamics::InverseError;
use stiction_core::kinematics::AssemblyError;
use stiction_format::Diagnostic;
use thiserror::Error;

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

/// Error of a run along a motion.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// The sample times are not valid.
    #[error(transparent)]
    Instants(#[from] InstantsError),
    /// A formula of the motion or of the load has no finite value.
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
    Payload {
        /// The body.
        body: String,
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
    /// A receiver of the samples failed.
    #[error("{0}")]
    Receiver(String),
    /// The user stopped the run.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// True for unusable input, false for a valid problem without a solution.
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
