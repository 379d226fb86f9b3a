//! Verdicts on parameters, and on a fit as a whole.

use std::fmt;

/// Verdict on a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The data determine the value, with the given standard deviation.
    Identified,
    /// The value fits the data, but is not identified: only a combination with other parameters is
    /// determined, or the standard deviation is too large.
    FitsOnly,
    /// The data contain little or no information on the parameter; the value is that of the model.
    NotExcited,
    /// The parameter was held at the value of the model.
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
    /// The model predicts left-out data as well as the data to which it was fitted.
    Identified,
    /// The model reproduces the data, but with errors that noise does not explain, or that are larger for left-out
    /// data.
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

/// Facts about one value on which its verdict is based.
#[derive(Clone, Copy, Debug)]
pub struct Evidence {
    /// Fraction of the value, from 0 to 1, that the data determine.
    pub resolution: f64,
    /// Estimated value, SI units.
    pub value: f64,
    /// Standard deviation of the value, SI units.
    pub sigma: f64,
    /// Typical magnitude of the parameter, SI units.
    pub scale: f64,
    /// True if the structure of the mechanism allows the parameter to be determined on its own.
    pub is_alone: bool,
    /// False if the efforts of the mechanism do not depend on the parameter, whatever the motion.
    pub has_effect: bool,
    /// Change of the value if the strength of the prior grew by the factor e, SI units; `sigma` contains it.
    pub pull: f64,
    /// Largest correlation of the value's error with that of another parameter, from 0 to 1.
    pub correlation: f64,
}

/// A value counts as identified if the data determine more than this fraction of the value, and if
/// its standard deviation is below [`PRECISE`] times the value.
const RESOLVED: f64 = 0.9;
/// Limit of the standard deviation, as a fraction of the value, for values that [`RESOLVED`]
/// accepts.
const PRECISE: f64 = 0.5;
/// A value that can be determined on its own counts as identified, whatever the strength of the
/// prior, if its standard deviation is below this fraction of the value. The standard deviation
/// contains the error of the prior, so only data can make it this small.
const PRECISE_BY_ITSELF: f64 = 0.05;
/// Limit that replaces [`PRECISE`] if the error of the value is correlated with that of another
/// parameter (see [`CONFOUNDED`]). Only a small difference between the effects of both parameters
/// then determines the value, and any error of the model affects that difference.
const PRECISE_CONFOUNDED: f64 = 0.1;
/// The strength of the prior decides a value, and not the data, if the change of the value with the
/// strength exceeds this fraction of the standard deviation.
const PULLED: f64 = 0.7;
/// Two parameters count as confounded if the correlation of their errors exceeds this value.
pub(crate) const CONFOUNDED: f64 = 0.95;

impl Verdict {
    /// Decides the verdict on a value.
    pub fn of(evidence: &Evidence) -> Self {
        let Evidence { resolution, value, sigma, scale, is_alone, has_effect, pull, correlation } =
            *evidence;
        if !has_effect {
            return Self::NotExcited;
        }
        let size = value.abs().max(0.05 * scale);
        let limit = if correlation > CONFOUNDED { PRECISE_CONFOUNDED } else { PRECISE };
        let is_decided = pull.abs() <= PULLED * sigma;
        if is_decided && resolution > RESOLVED && sigma < limit * size {
            return Self::Identified;
        }
        // The error of a strong prior is part of the standard deviation.
        if is_decided && is_alone && resolution > 0.0 && sigma < PRECISE_BY_ITSELF * value.abs() {
            return Self::Identified;
        }
        match is_alone {
            true if sigma > size => Self::NotExcited,
            true if resolution < 0.5 && sigma > PRECISE_CONFOUNDED * size => Self::NotExcited,
            true => Self::FitsOnly,
            false if resolution < 0.02 => Self::NotExcited,
            // The correlated parameter can compensate any value of this parameter.
            false if correlation > CONFOUNDED && sigma > size => Self::NotExcited,
            false => Self::FitsOnly,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLEAR: Evidence = Evidence {
        resolution: 0.99,
        value: 2.0,
        sigma: 0.4,
        scale: 2.0,
        is_alone: true,
        has_effect: true,
        pull: 0.0,
        correlation: 0.5,
    };

    #[test]
    fn verdicts_need_data_and_precision() {
        assert_eq!(Verdict::of(&CLEAR), Verdict::Identified);
        // The data hardly change this value, so it is as uncertain as the prior.
        let prior = Evidence { resolution: 0.3, sigma: 0.4, ..CLEAR };
        assert_eq!(Verdict::of(&prior), Verdict::NotExcited);
        let shared = Evidence { is_alone: false, ..prior };
        assert_eq!(Verdict::of(&shared), Verdict::FitsOnly);
        // This value is known to half a percent. The prior is strong, and the standard deviation
        // contains the prior's error of 30 %.
        let strong = Evidence { resolution: 0.3, sigma: 0.01, ..CLEAR };
        assert_eq!(Verdict::of(&strong), Verdict::Identified);
        let fair = Evidence { sigma: 0.15, ..strong };
        assert_eq!(Verdict::of(&fair), Verdict::FitsOnly);
        // A prior of another strength would give another value.
        let pulled = Evidence { pull: -0.35, ..CLEAR };
        assert_eq!(Verdict::of(&pulled), Verdict::FitsOnly);
        assert_eq!(Verdict::of(&Evidence { pull: 0.1, ..CLEAR }), Verdict::Identified);
        // The value follows from others through the prior alone, however certain it seems.
        let without = Evidence { has_effect: false, ..CLEAR };
        assert_eq!(Verdict::of(&without), Verdict::NotExcited);
        // Confounded with another parameter, for which the same precision does not suffice.
        let confounded = Evidence { correlation: 0.98, ..CLEAR };
        assert_eq!(Verdict::of(&confounded), Verdict::FitsOnly);
        let open = Evidence { is_alone: false, sigma: 3.0, ..confounded };
        assert_eq!(Verdict::of(&open), Verdict::NotExcited);
        let precise = Evidence { sigma: 0.1, ..confounded };
        assert_eq!(Verdict::of(&precise), Verdict::Identified);
    }
}
