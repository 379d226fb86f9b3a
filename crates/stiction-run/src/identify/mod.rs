//! Identification of inertia and friction from measured logs, with verdicts on the results.
//!
//! [`IdentifySettings`] contains the options, and [`identify`] computes an [`Identified`], which
//! provides the summary, the JSON object and the model file.

mod asymmetry;
mod at_rest;
mod chosen;
mod closed_loop;
mod delay;
mod gear_losses;
mod identified;
mod missing;
mod normal_loads;
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
pub use closed_loop::Simulated;
pub use delay::Delay;
pub use identified::{Combined, Identified, Named, Prediction};
pub use missing::Missing;
pub use options::{Estimator, IdentifySettings, LogSettings, TEMPLATE};
pub use prepare::{Deviation, MeasuredLog};
pub use run::identify;
pub use traces::{EffortSample, FrictionTrace, LogTrace, Traces};

use thiserror::Error;

/// Function that receives the name of the present step of a computation, how many of its parts are done, and their
/// number.
pub type Progress<'a> = &'a dyn Fn(&str, usize, usize);

/// Reason why logs or options cannot be used for an identification.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct IdentifyError {
    /// Description of the error and its location.
    pub message: String,
    /// Suggested remedy; empty if the message contains it.
    pub help: String,
}
