//! Design of motions that excite parameters: periodic Fourier series within the limits of the
//! robot, with the largest information about chosen parameters (D-optimal).
//!
//! [`ExciteSettings`] contains the options, and [`excite`] computes an [`Excitation`]. The
//! excitation provides the reference motion, the options for [`crate::identify`], a summary as
//! text, and all results as a JSON object.
//!
//! The theory is in equations (X1) to (X4) of the book.

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

/// Reason why no motion was designed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct ExciteError {
    /// Text that describes the mistake in the options, or the limit that no motion satisfies.
    pub message: String,
    /// Text that suggests a remedy.
    pub help: String,
    /// True if the options are valid, but no motion satisfies them.
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
