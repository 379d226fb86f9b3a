//! Verdicts on parameters and on the fit.

use std::fmt;

/// Verdict on a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The data determine the value, to the standard deviation.
    Identified,
    /// The value fits, but only a combination with other parameters is determined.
    FitsOnly,
    /// These data say little or nothing about it; the value is that of the model.
    NotExcited,
    /// It was not estimated.
    Held,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Identified => "identified",
            Self::FitsOnly => "fits only",
            Self::NotExcited => "not excited",
            Self::Held => "held",
        })
    }
}

/// Verdict on a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitVerdict {
    /// The model predicts data that were left out as well as data that it was fitted to.
    Identified,
    /// The model reproduces the data, with errors that noise does not explain or that grow where data
    /// were left out.
    FitsOnly,
    /// The data determine hardly any parameter.
    NotExcited,
    /// The model does not reproduce the data.
    Failed,
}

impl fmt::Display for FitVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Identified => "identified",
            Self::FitsOnly => "fits only",
            Self::NotExcited => "not excited",
            Self::Failed => "failed",
        })
    }
}

impl Verdict {
    /// Verdict from the part that the data determine, the standard deviation, the scale of the value,
    /// and whether the structure of the mechanism lets it be determined alone.
    pub fn of(resolution: f64, sigma: f64, value: f64, scale: f64, is_alone: bool) -> Self {
        let size = value.abs().max(0.05 * scale);
        if resolution > 0.9 && sigma < 0.5 * size {
            return Self::Identified;
        }
        match is_alone {
            true if resolution < 0.5 || sigma > size => Self::NotExcited,
            true => Self::FitsOnly,
            false if resolution < 0.02 => Self::NotExcited,
            false => Self::FitsOnly,
        }
    }
}
