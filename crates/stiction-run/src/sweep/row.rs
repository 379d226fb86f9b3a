//! Results of one design.

use std::fmt;

/// Results of a design.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Values of the objectives, in their order; `None` where there is none: a design that failed has no values.
    pub values: Vec<Option<f64>>,
    /// Success, success with cautions, or failure of the design.
    pub status: Status,
}

/// Status of a design.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Status {
    /// There are results.
    Computed {
        /// Reasons to read them with care: limits that are exceeded, results that are not unique.
        doubts: Vec<String>,
    },
    /// There are no results.
    Failed {
        /// True if the values cannot be used, false if the question has no answer, such as at a singular position.
        is_bad_input: bool,
        /// The reason, in one line.
        reason: String,
    },
}

const OK: &str = "ok";
const CAUTION: &str = "caution: ";
const FAILED: &str = "failed: ";
const NO_ANSWER: &str = "no answer: ";

impl Row {
    /// Results of a design that has none, for this number of objectives. The reason becomes one line.
    pub fn failed(objectives: usize, is_bad_input: bool, reason: &str) -> Self {
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        Self { values: vec![None; objectives], status: Status::Failed { is_bad_input, reason } }
    }
}

impl Status {
    /// True if there are no results.
    pub fn is_failed(&self) -> bool {
        matches!(self, Self::Failed { .. })
    }

    /// True if there are results without doubts.
    pub fn is_ok(&self) -> bool {
        matches!(self, Self::Computed { doubts } if doubts.is_empty())
    }

    /// Reads the text of a status; `None` for any other text.
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
    /// `ok`; `caution: …` where results have doubts; `failed: …` for values that cannot be used, `no answer: …`
    /// for a question without one.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Computed { doubts } if doubts.is_empty() => f.write_str(OK),
            Self::Computed { doubts } => write!(f, "{CAUTION}{}", doubts.join("; ")),
            Self::Failed { is_bad_input: true, reason } => write!(f, "{FAILED}{reason}"),
            Self::Failed { is_bad_input: false, reason } => write!(f, "{NO_ANSWER}{reason}"),
        }
    }
}
