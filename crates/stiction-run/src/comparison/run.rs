//! One run of a comparison: its conditions, headline figures, cautions and verdicts.

use super::Headline;
use crate::report::Finding;
use std::f64::consts::TAU;

/// Results of one run that a comparison of several runs uses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComparedRun {
    pub(crate) conditions: Conditions,
    /// Least number of degrees of freedom along the motion without passive rotations; `None` if it is not computed.
    pub(crate) mobility: Option<usize>,
    /// Range of the coordinate of each actuator along the motion.
    pub(crate) travel: Vec<Travel>,
    pub(crate) headlines: Vec<Headline>,
    /// Exceeded ranges and limits, and doubts about a recording.
    pub(crate) cautions: Vec<String>,
    pub(crate) findings: Vec<Finding>,
}

/// Conditions of a run that do not belong to the model.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Conditions {
    pub(crate) motion: String,
    pub(crate) load: String,
    pub(crate) friction: &'static str,
}

/// Least and greatest coordinate of an actuator along a motion.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Travel {
    pub(crate) name: String,
    /// Unit of the coordinate, m or rad.
    pub(crate) unit: &'static str,
    pub(crate) ends: (f64, f64),
}

/// Distance between two ranges, relative to their greatest value, up to which they are apart by rounding errors only.
const ROUNDING: f64 = 1e-9;

impl Travel {
    /// Returns true if the range has no position in common with that of the same actuator in another run. Angles that
    /// differ by whole turns are the same position.
    pub(crate) fn is_apart(&self, other: &Self) -> bool {
        let ((low, high), (least, greatest)) = (self.ends, other.ends);
        let turns = match self.unit {
            "rad" => ((low + high - least - greatest) / (2.0 * TAU)).round(),
            _ => 0.0,
        };
        let (low, high) = (low - turns * TAU, high - turns * TAU);
        let size =
            [low, high, least, greatest].into_iter().fold(0.0, |max: f64, x| max.max(x.abs()));
        (least - high).max(low - greatest) > ROUNDING * size
    }
}
