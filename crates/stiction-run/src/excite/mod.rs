//! Motions that excite parameters: periodic Fourier series within the limits of the robot, with the
//! largest information about chosen parameters (D-optimal).
//!
//! [`ExciteSettings`] hold what the options say, [`excite`] computes an [`Excitation`], which writes the
//! reference, the description of its logs for [`crate::identify`], the summary and the JSON object.
//!
//! Equations (X1) to (X4) of the book's theory.

mod ascent;
mod coordinates;
mod feasible;
mod files;
mod limit_settings;
mod limits;
mod objective;
mod plan;
mod precision;
mod probe;
mod reference;
mod result;
mod run;
mod series;
mod settings;
mod structure;
mod words;

pub use limits::Used;
pub use precision::{Confounded, Expected};
pub use result::{Actuators, Excitation, Quality};
pub use run::excite;
pub use settings::{ExciteSettings, LimitSetting};

use thiserror::Error;

/// Reason why no motion is designed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct ExciteError {
    /// The mistake, or the limit that no motion keeps.
    pub message: String,
    /// The way out.
    pub help: String,
    /// True if the options are valid, but no motion is possible.
    pub no_answer: bool,
    /// True if the caller stopped the search.
    pub interrupted: bool,
}

impl ExciteError {
    fn input(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { message: message.into(), help: help.into(), no_answer: false, interrupted: false }
    }

    fn no_answer(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { no_answer: true, ..Self::input(message, help) }
    }

    fn interrupted() -> Self {
        Self { interrupted: true, ..Self::input("interrupted; nothing was written", "") }
    }
}
