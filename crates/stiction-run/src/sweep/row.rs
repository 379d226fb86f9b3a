//! Results of one design of a study.

use std::fmt;

/// Results of one design of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Values of the objectives in the order of the objectives; `None` for an objective without a
    /// value. A failed design has no values.
    pub values: Vec<Option<f64>>,
    /// Success, success with cautions, or failure of the design.
    pub status: Status,
}

/// Outcome of a design.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Status {
    /// The design has results.
    Computed {
        /// Reasons to use the results with care, such as exceeded limits or results that are not
        /// unique.
        doubts: Vec<String>,
    },
    /// The design has no results.
    Failed {
        /// True if the values of the keys are invalid; false if the computation has no solution,
        /// for example at a singular position.
        is_bad_input: bool,
        /// Reason for the failure, in one line.
        reason: String,
    },
}

const OK: &str = "ok";
const CAUTION: &str = "caution: ";
const FAILED: &str = "failed: ";
const NO_ANSWER: &str = "no answer: ";

impl Row {
    /// Creates the results of a failed design with `objectives` objectives. Line breaks in the
    /// reason are removed.
    pub fn failed(objectives: usize, is_bad_input: bool, reason: &str) -> Self {
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        Self { values: vec![None; objectives], status: Status::Failed { is_bad_input, reason } }
    }
}

impl Status {
    /// Returns true if the design has no results.
    pub fn is_failed(&self) -> bool {
        matches!(self, Self::Failed { .. })
    }

    /// Returns true if the design has results without cautions.
    pub fn is_ok(&self) -> bool {
        matches!(self, Self::Computed { doubts } if doubts.is_empty())
    }

    /// Parses a status from the text that its [`Display`](fmt::Display) implementation writes;
    /// `None` for any other text.
    pub fn parse(text: &str) -> Option<Self> {
        let failed =
            |is_bad_input, reason: &str| Self::Failed { is_bad_input, reason: reason.to_owned() };
        if text == OK {
            return Some(Self::Computed { doubts: Vec::new() });
        }
        if let Some(doubts) = text.strip_prefix(CAUTION) {
            return Some(Self::Computed { doubts: vec![doubts.to_owned()] });
        }
        let bad = text.strip_prefix(FAILED).map(|reason| failed(true, reason));
        bad.or_else(|| text.strip_prefix(NO_ANSWER).map(|reason| failed(false, reason)))
    }
}

impl fmt::Display for Status {
    /// Writes `ok`; `caution: …` for results with cautions; `failed: …` for invalid values of the
    /// keys; or `no answer: …` for a computation without a solution.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Computed { doubts } if doubts.is_empty() => f.write_str(OK),
            Self::Computed { doubts } => write!(f, "{CAUTION}{}", doubts.join("; ")),
            Self::Failed { is_bad_input: true, reason } => write!(f, "{FAILED}{reason}"),
            Self::Failed { is_bad_input: false, reason } => write!(f, "{NO_ANSWER}{reason}"),
        }
    }
}
