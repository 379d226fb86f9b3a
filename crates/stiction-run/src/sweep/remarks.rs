//! Rows of a study with the same failure or caution, and the meaning of it.

use super::row::Status;
use crate::names::listed;
use crate::report::Finding;

/// Largest number of different remarks that are stored. Texts beyond it are only counted.
const MOST: usize = 24;
/// Largest number of rows that a remark lists.
const NAMED: usize = 12;

/// Failures and cautions of a study, accumulated row by row. Texts that differ only in their numbers are one remark.
#[derive(Clone, Debug, Default)]
pub(super) struct Remarks {
    all: Vec<Remark>,
    /// Number of rows whose remark is not stored.
    others: u64,
}

#[derive(Clone, Debug)]
struct Remark {
    /// Text without its numbers, by which rows are compared.
    pattern: String,
    status: Status,
    count: u64,
    first: Vec<u64>,
}

impl Remarks {
    /// Adds the status of the row with the given number; a row without failure and caution adds nothing.
    pub(super) fn add(&mut self, row: u64, status: &Status) {
        if status.is_ok() {
            return;
        }
        let pattern = without_numbers(&status.to_string());
        match self.all.iter().position(|one| one.pattern == pattern) {
            Some(place) => {
                let one = &mut self.all[place];
                one.count += 1;
                if one.first.len() <= NAMED {
                    one.first.push(row);
                }
            }
            None if self.all.len() < MOST => {
                let status = status.clone();
                self.all.push(Remark { pattern, status, count: 1, first: vec![row] });
            }
            None => self.others += 1,
        }
    }

    /// Returns a verdict for each remark, the most frequent first; `rows` is the number of rows of the study.
    pub(super) fn findings(&self, rows: u64) -> Vec<Finding> {
        let mut all: Vec<&Remark> = self.all.iter().collect();
        all.sort_by_key(|one| std::cmp::Reverse(one.count));
        let mut findings: Vec<Finding> = all.into_iter().map(|one| one.finding(rows)).collect();
        if self.others > 0 {
            findings.push(Finding::bad(
                format!("{} more designs of {rows} have other cautions or no results", self.others),
                "The column `status` of sweep.csv states the reason of each row.",
            ));
        }
        findings
    }
}

impl Remark {
    fn finding(&self, rows: u64) -> Finding {
        let what = match (self.count, self.status.is_failed()) {
            (1, true) => "has no results",
            (_, true) => "have no results",
            (1, false) => "has cautions",
            (_, false) => "have cautions",
        };
        let designs = if rows == 1 { "design" } else { "designs" };
        let numbers = listed(self.first.iter().map(u64::to_string), NAMED);
        let which = match self.count {
            1 => format!("row {numbers}"),
            _ => format!("rows {numbers}; row {}", self.first[0]),
        };
        let text = match &self.status {
            Status::Failed { reason, .. } => reason.clone(),
            Status::Computed { doubts } => doubts.join("; "),
        };
        Finding::bad(
            format!("{} of {rows} {designs} {what}: {which}: {text}", self.count),
            self.meaning(&text),
        )
    }

    fn meaning(&self, text: &str) -> String {
        if let Status::Failed { is_bad_input: true, .. } = self.status {
            return "The model cannot be read with these values; the message states the place. Exclude them from the study, \
                    or write the formulas of the model so that they accept these values."
                .to_owned();
        }
        let mut known: Vec<&str> = Vec::new();
        for (words, meaning) in MEANINGS {
            if text.contains(words) && !known.contains(&meaning) {
                known.push(meaning);
            }
        }
        match known.is_empty() {
            true => OTHERWISE.to_owned(),
            false => known.join(" "),
        }
    }
}

const OTHERWISE: &str = "`stiction inverse` with the values of this row (option `--set`) shows where and why in detail.";
const SINGULAR: &str = "The motion reaches a position in which the actuators cannot balance every load. Exclude these \
     designs, or choose a motion that keeps away from it; the objective `min(distance.actuation)` measures how far \
     away a design is.";
const OUT_OF_REACH: &str = "These designs cannot make the motion. Choose dimensions that reach it, a smaller motion, or \
     other `start` values of the joints.";
const AMBIGUOUS: &str = "Objectives of such efforts and reactions depend on an assumption, so do not choose a design by \
     them. Declare compliances, or remove redundant actuators or constraints.";

/// Words of failures and cautions, with their meaning and advice.
const MEANINGS: [(&str, &str); 17] = [
    (
        "friction locks the mechanism",
        "The mechanism jams: no effort of the actuators maintains the motion. Use longer guides, shorter lever arms or \
         less friction.",
    ),
    (
        "the efforts grow without bound, first",
        "The motion needs unlimited efforts at the stated joint.",
    ),
    ("no finite actuator effort balances", SINGULAR),
    ("the position is singular", SINGULAR),
    ("singular at t =", SINGULAR),
    ("passes a singular position", SINGULAR),
    ("out of reach", OUT_OF_REACH),
    ("the loops do not close", OUT_OF_REACH),
    ("cannot follow the motion smoothly", OUT_OF_REACH),
    ("efforts are not unique", AMBIGUOUS),
    ("` is not unique", AMBIGUOUS),
    (
        "friction has other solutions",
        "The mechanism may take another state of friction than the computed one, depending on its history. Prefer \
         designs with less friction or longer guides.",
    ),
    (" its range of ", OUT_OF_RANGE),
    (" its stroke of ", OUT_OF_RANGE),
    (" % of rated rms torque (", MOTOR),
    (" % of peak torque (", MOTOR),
    (" % of speed limit (", MOTOR),
];
const MOTOR: &str = "A limit of a motor is exceeded. Choose a larger motor, another transmission or a slower motion for \
     these designs.";
const OUT_OF_RANGE: &str = "A joint leaves its declared range, so these designs cannot be built with this joint. Choose \
     a smaller motion, or a joint with a larger range.";

/// Replaces the numbers of a text by `#`; numbers within names remain.
fn without_numbers(text: &str) -> String {
    let word = |word: &str| {
        let inner = word.trim_matches(|c: char| "()[],;:%".contains(c));
        let is_number = inner.parse::<f64>().is_ok();
        if is_number { word.replace(inner, "#") } else { word.to_owned() }
    };
    text.split_whitespace().map(word).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::Row;

    fn statements(remarks: &Remarks, rows: u64) -> Vec<String> {
        remarks.findings(rows).into_iter().map(|one| one.statement).collect()
    }

    #[test]
    fn texts_that_differ_in_numbers_are_one_remark() {
        let mut remarks = Remarks::default();
        let failed = |text: &str| Status::parse(&format!("no answer: {text}")).unwrap();
        remarks.add(1, &failed("at t = 0.1 s: leg1.P misses by (2 mm)"));
        remarks.add(2, &Status::parse("ok").unwrap());
        remarks.add(3, &failed("at t = 0.25 s: leg1.P misses by (3e-1 mm)"));
        remarks.add(4, &failed("at t = 0.25 s: leg2.P misses by (3e-1 mm)"));
        assert_eq!(
            statements(&remarks, 4),
            [
                "2 of 4 designs have no results: rows 1, 3; row 1: at t = 0.1 s: leg1.P misses by (2 mm)",
                "1 of 4 designs has no results: row 4: at t = 0.25 s: leg2.P misses by (3e-1 mm)",
            ]
        );
    }

    /// Checks that errors of inverse dynamics have the advice for their kind.
    #[test]
    fn errors_have_advice() {
        use stiction_core::dynamics::InverseError;
        let locked = |percent| InverseError::Locked { joint: "rod".to_owned(), percent };
        let cases = [
            (locked(80.0), "The mechanism jams"),
            (locked(1e-9), "unlimited efforts"),
            (InverseError::Unsettled, SINGULAR),
            (InverseError::NotFinite { body: "tool".to_owned() }, OTHERWISE),
            (InverseError::Inaccurate { residual: 1e-3 }, OTHERWISE),
        ];
        for (error, meaning) in cases {
            let mut remarks = Remarks::default();
            remarks.add(1, &Row::failed(1, false, &error.to_string()).status);
            let found = remarks.findings(1);
            assert!(found[0].meaning.contains(meaning), "{error}: {found:?}");
            assert!(!found[0].meaning.contains(MOTOR), "{error}: {found:?}");
        }
    }

    /// Checks that the number of stored remarks is limited, and that no row is lost.
    #[test]
    fn remarks_are_limited() {
        let mut remarks = Remarks::default();
        for row in 1..=40 {
            remarks.add(row, &Status::parse(&format!("failed: key x{row}")).unwrap());
        }
        let all = statements(&remarks, 40);
        assert_eq!(all.len(), MOST + 1);
        assert_eq!(all[MOST], "16 more designs of 40 have other cautions or no results");
    }
}
