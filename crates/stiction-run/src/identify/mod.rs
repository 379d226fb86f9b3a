//! Identification of inertia and friction from measured logs, with verdicts on the results.
//!
//! [`IdentifySettings`] contains the options, and [`identify`] computes an [`Identified`], which
//! provides the summary, the JSON object and the model file.

mod asymmetry;
mod at_rest;
mod chosen;
mod delay;
mod missing;
mod options;
mod page;
mod prepare;
mod run;
mod sanity;
mod selection;
mod structure;
mod torque_constants;
mod traces;
mod words;

pub use asymmetry::Asymmetry;
pub use delay::Delay;
pub use missing::Missing;
pub use options::{IdentifySettings, LogSettings, TEMPLATE};
pub use prepare::MeasuredLog;
pub use run::{Combined, Identified, Named, Prediction, identify};
pub use traces::{EffortSample, FrictionTrace, LogTrace, Traces};

use thiserror::Error;

/// Reason why logs or options cannot be used for an identification.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct IdentifyError {
    /// Description of the error and its location.
    pub message: String,
    /// Suggested remedy; empty if the message contains it.
    pub help: String,
}
