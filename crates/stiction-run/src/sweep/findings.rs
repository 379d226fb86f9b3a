//! Summary of a study: extremes of the objectives, failures and cautions.

use super::remarks::Remarks;
use super::row::{Row, Status};
use crate::names::width;
use crate::report::animation::MOST_RUNS;
use crate::report::findings_json;
use serde_json::{Map, Value, json};
use std::fmt::{self, Write};
use stiction_draw::numbers::number;
use stiction_format::{Key, Setting};

/// Largest number of failures and cautions that are stored with their text.
const KEPT: usize = 10;
/// Largest number of rows that a summary lists.
pub(super) const LISTED: usize = 20;

/// Summary of a study, accumulated row by row.
#[derive(Clone, Debug)]
pub struct Findings {
    pub(super) keys: Vec<Key>,
    pub(super) objectives: Vec<String>,
    pub(super) rows: u64,
    pub(super) failed: u64,
    pub(super) doubtful: u64,
    /// True as long as every failure was caused by invalid values of the keys.
    are_all_bad_inputs: bool,
    /// Least and greatest value of each objective.
    pub(super) extremes: Vec<Option<[Extreme; 2]>>,
    /// Least and greatest value of each objective in rows without cautions.
    pub(super) sound: Vec<Option<[Extreme; 2]>>,
    /// For each objective, the number of rows with results in which it has no value.
    pub(super) missing: Vec<u64>,
    /// Least and greatest number of each varied key; `None` without numbers.
    pub(super) spans: Vec<Option<(f64, f64)>>,
    /// All cautions and failures.
    pub(super) remarks: Remarks,
    /// First rows with cautions or failures: the number of the row, and the text of the caution or
    /// failure.
    first_remarks: Vec<(u64, String)>,
    pub(super) first: Vec<(u64, Vec<Setting>, Row)>,
}

/// Least or greatest value of an objective, and the row in which it occurs.
#[derive(Clone, Debug)]
pub(super) struct Extreme {
    pub(super) value: f64,
    pub(super) row: u64,
    pub(super) settings: Vec<Setting>,
}

impl Findings {
    /// Creates the summary of a study without rows.
    pub fn new(keys: &[Key], objectives: &[String]) -> Self {
        Self {
            keys: keys.to_vec(),
            objectives: objectives.to_vec(),
            rows: 0,
            failed: 0,
            doubtful: 0,
            are_all_bad_inputs: true,
            extremes: vec![None; objectives.len()],
            sound: vec![None; objectives.len()],
            missing: vec![0; objectives.len()],
            spans: vec![None; keys.len()],
            remarks: Remarks::default(),
            first_remarks: Vec::new(),
            first: Vec::new(),
        }
    }

    /// Adds the results of the row with the given number, counted from 1.
    pub fn add(&mut self, number: u64, settings: &[Setting], row: &Row) {
        self.rows += 1;
        match &row.status {
            Status::Failed { is_bad_input, .. } => {
                self.failed += 1;
                self.are_all_bad_inputs &= is_bad_input;
            }
            Status::Computed { doubts } => self.doubtful += u64::from(!doubts.is_empty()),
        }
        self.remarks.add(number, &row.status);
        if !row.status.is_ok() && self.first_remarks.len() < KEPT {
            self.first_remarks.push((number, row.status.to_string()));
        }
        for (span, setting) in self.spans.iter_mut().zip(settings) {
            let Setting::Number(value) = *setting else { continue };
            let (low, high) = span.unwrap_or((value, value));
            *span = Some((low.min(value), high.max(value)));
        }
        if self.first.len() <= LISTED {
            self.first.push((number, settings.to_vec(), row.clone()));
        }
        for (k, value) in row.values.iter().enumerate() {
            let Some(value) = *value else {
                self.missing[k] += u64::from(!row.status.is_failed());
                continue;
            };
            let extreme = || Extreme { value, row: number, settings: settings.to_vec() };
            update(&mut self.extremes[k], value, extreme);
            if row.status.is_ok() {
                update(&mut self.sound[k], value, extreme);
            }
        }
    }

    /// Returns the designs with the least or greatest value of an objective. Each design occurs
    /// once, with its row, its settings, and a description of its extremes. The list has at most as
    /// many designs as a report page shows.
    pub fn extreme_designs(&self) -> Vec<(u64, &[Setting], String)> {
        let mut all: Vec<(u64, &[Setting], String)> = Vec::new();
        for (objective, extremes) in self.objectives.iter().zip(&self.extremes) {
            let named = ["least", "greatest"].into_iter().zip(extremes.iter().flatten());
            for (what, extreme) in named {
                let words = format!("{what} {objective}");
                match all.iter_mut().find(|(row, ..)| *row == extreme.row) {
                    Some((.., known)) => *known = format!("{known}, {words}"),
                    None => all.push((extreme.row, &extreme.settings, words)),
                }
            }
        }
        all.truncate(MOST_RUNS);
        all
    }

    /// If no design has results, returns true if all failures were caused by invalid values of the
    /// keys, and the reason of the first failure. Returns `None` if any design has results.
    pub fn failure(&self) -> Option<(bool, String)> {
        let (row, reason) = self.first_remarks.first()?;
        (self.rows > 0 && self.failed == self.rows).then(|| {
            (self.are_all_bad_inputs, format!("no design has results; row {row}: {reason}"))
        })
    }

    /// Returns the summary as JSON.
    pub fn json(&self) -> Value {
        let mut objectives = Map::new();
        for (objective, extremes) in self.objectives.iter().zip(&self.extremes) {
            let value = |extreme: &Extreme| json!({ "value": extreme.value, "row": extreme.row, "settings": self.settings_json(&extreme.settings) });
            let value = extremes.as_ref().map(
                |[least, greatest]| json!({ "least": value(least), "greatest": value(greatest) }),
            );
            objectives.insert(objective.clone(), value.unwrap_or(Value::Null));
        }
        let remarks =
            self.first_remarks.iter().map(|(row, status)| json!({ "row": row, "status": status }));
        json!({
            "rows": self.rows,
            "ok": self.rows - self.failed - self.doubtful,
            "with_cautions": self.doubtful,
            "failed": self.failed,
            "objectives": objectives,
            "first_remarks": remarks.collect::<Vec<_>>(),
            "verdicts": findings_json(&self.verdicts()),
        })
    }

    fn settings_json(&self, settings: &[Setting]) -> Value {
        let value = |setting: &Setting| match setting {
            Setting::Number(number) => json!(number),
            Setting::Text(text) => json!(text),
        };
        let named = self.keys.iter().zip(settings);
        Value::Object(named.map(|(key, setting)| (key.to_string(), value(setting))).collect())
    }

    /// Writes the summary for the terminal: all rows of a short study, or the extremes of a long one, and the first
    /// cautions and failures.
    ///
    /// # Errors
    /// Fails if the receiver of the text fails.
    pub fn write(&self, out: &mut impl Write) -> fmt::Result {
        if self.first.len() <= LISTED {
            self.write_rows(out)?;
        } else {
            self.write_extremes(out)?;
        }
        let ok = self.rows - self.failed - self.doubtful;
        let plural = if self.rows == 1 { "design" } else { "designs" };
        write!(out, "\n{} {plural}: {ok} ok", self.rows)?;
        for (count, what) in [(self.doubtful, "with cautions"), (self.failed, "without results")] {
            if count > 0 {
                write!(out, ", {count} {what}")?;
            }
        }
        writeln!(out)?;
        for (row, remark) in &self.first_remarks {
            writeln!(out, "row {row}: {remark}")?;
        }
        let more = self.doubtful + self.failed - self.first_remarks.len() as u64;
        if more > 0 {
            writeln!(out, "and {more} more; the column `status` of sweep.csv shows all of them")?;
        }
        Ok(())
    }

    /// Returns the names of the columns for a list of rows.
    pub(super) fn columns(&self) -> Vec<String> {
        std::iter::once("row".to_owned())
            .chain(self.keys.iter().map(Key::to_string))
            .chain(self.objectives.iter().cloned())
            .collect()
    }

    fn write_rows(&self, out: &mut impl Write) -> fmt::Result {
        let mut lines = vec![self.columns()];
        lines.extend(
            self.first.iter().map(|(row, settings, results)| cells(*row, settings, results)),
        );
        let columns = lines.first().map_or(0, Vec::len);
        let widths: Vec<usize> = (0..columns)
            .map(|k| width(lines.iter().filter_map(|line| line.get(k)).map(String::as_str), 3))
            .collect();
        for line in &lines {
            let cells = line.iter().zip(&widths).map(|(cell, width)| format!("{cell:>width$}"));
            writeln!(out, "{}", cells.collect::<Vec<_>>().join("  "))?;
        }
        Ok(())
    }

    /// Describes the settings at an extreme: keys, values and units.
    pub(super) fn settings_in_words(&self, extreme: &Extreme) -> String {
        let named = self.keys.iter().zip(&extreme.settings);
        let each = named.map(|(key, setting)| match key.unit.as_str() {
            "" => format!("{} = {setting}", key.path),
            unit => format!("{} = {setting} {unit}", key.path),
        });
        each.collect::<Vec<_>>().join(", ")
    }

    fn write_extremes(&self, out: &mut impl Write) -> fmt::Result {
        for (objective, extremes) in self.objectives.iter().zip(&self.extremes) {
            writeln!(out, "{objective}")?;
            let Some([least, greatest]) = extremes else {
                writeln!(out, "  no value")?;
                continue;
            };
            for (what, extreme) in [("least", least), ("greatest", greatest)] {
                let (value, settings) = (number(extreme.value), self.settings_in_words(extreme));
                writeln!(out, "  {what:<9}{value:>10}  row {}: {settings}", extreme.row)?;
            }
        }
        Ok(())
    }
}

/// Updates the least and the greatest value of an objective with the value of a row.
fn update(extremes: &mut Option<[Extreme; 2]>, value: f64, extreme: impl Fn() -> Extreme) {
    match extremes {
        None => *extremes = Some([extreme(), extreme()]),
        Some([least, greatest]) => {
            if value < least.value {
                *least = extreme();
            }
            if value > greatest.value {
                *greatest = extreme();
            }
        }
    }
}

/// Returns the cells of a row as text: its number, settings and objectives.
pub(super) fn cells(row: u64, settings: &[Setting], results: &Row) -> Vec<String> {
    let setting = |setting: &Setting| match setting {
        Setting::Number(value) => number(*value),
        Setting::Text(text) => text.clone(),
    };
    let values = results.values.iter().map(|value| value.map_or("-".to_owned(), number));
    std::iter::once(row.to_string()).chain(settings.iter().map(setting)).chain(values).collect()
}
