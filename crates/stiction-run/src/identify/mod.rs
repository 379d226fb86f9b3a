//! Identification: from measured logs to inertia and friction, with verdicts.
//!
//! [`IdentifySettings`] hold what the options say, [`identify`] computes an [`Identified`], which writes the
//! summary, the JSON object and the model file.

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

/// Reason why logs or options cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct IdentifyError {
    /// The mistake and its place.
    pub message: String,
    /// The way out, or the empty text if the message contains it.
    pub help: String,
}
