//! Objectives of a study, such as `peak(leg1.P.effort)` and `min(distance.actuation)`.

use super::column::{Column, columns, split};
use super::statistic::{Function, Statistic};
use crate::inverse::Sample;
use crate::inverse::rows::Rows;
use crate::{Job, Sink, SinkError};
use std::ops::Range;
use std::sync::Arc;
use stiction_format::{Diagnostic, Diagnostics, Place, Source, did_you_mean};

/// Objectives of a study: statistics of columns along a run.
///
/// An objective is a function of a column: `FUNCTION(COLUMN)`. The functions are `peak` (largest
/// magnitude), `rms`, `mean`, `min`, `max`, `range`, `final` and `work` (the integral of a power
/// over time).
///
/// A column is a column of one of the [`Tables`](crate::inverse::Tables), written without its unit,
/// such as `leg1.P.drive` or `distance.actuation`. `leg1.P.effort` is an alias of `leg1.P.drive`.
/// `leg1.S.reaction.force` and `leg1.S.reaction.moment` are magnitudes of vectors. A column name
/// that occurs in several tables refers to the first of these tables in the order `inverse`,
/// `joints`, `reactions`, `friction`, `bodies`, `motors`, `contributions`. A prefix selects another
/// table, as in `friction:leg1.P.power`.
pub struct Objectives {
    rows: Rows,
    items: Vec<Item>,
}

struct Item {
    header: String,
    column: Column,
    /// Column that states whether the value at a sample is statically determinate; `None` if the
    /// table has no such column.
    determined: Option<Column>,
    is_determined: bool,
    statistic: Statistic,
}

impl Objectives {
    /// Parses the objectives in `texts` and finds their columns in the tables of a job.
    ///
    /// # Errors
    /// Returns diagnostics for objectives that cannot be interpreted, each with its location and
    /// the most similar known names.
    pub fn new<S: AsRef<str>>(texts: &[S], job: &Job<'_>) -> Result<Self, Diagnostics> {
        let rows = Rows::new(job);
        let known = columns(job, &rows);
        let mut out = Diagnostics::new();
        let mut items = Vec::new();
        for text in texts {
            let source = Arc::new(Source::new("--objective", text.as_ref()));
            match (Reader { source: &source, known: &known }).read() {
                Ok(item) => items.push(item),
                Err(diagnostic) => out.push(diagnostic),
            }
        }
        if out.has_errors() { Err(out) } else { Ok(Self { rows, items }) }
    }

    /// Returns the headers of the objectives, with units.
    pub fn headers(&self) -> Vec<String> {
        self.items.iter().map(|item| item.header.clone()).collect()
    }

    /// Returns descriptions of the objectives whose values are statically indeterminate, for
    /// messages.
    pub fn doubts(&self) -> impl Iterator<Item = String> {
        let items = self.items.iter().filter(|item| !item.is_determined);
        items.map(|item| format!("`{}` is not unique", item.column.name))
    }

    /// Returns the values of the objectives for the samples so far; `None` for an objective whose
    /// value is not a number.
    pub fn values(&self) -> Vec<Option<f64>> {
        self.items.iter().map(|item| item.statistic.value()).collect()
    }
}

impl Sink<Sample> for Objectives {
    fn add(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.rows.fill(sample);
        for item in &mut self.items {
            item.statistic.add(sample.time, item.column.of(&self.rows));
            if let Some(flag) = &item.determined {
                item.is_determined &= flag.of(&self.rows) != 0.0;
            }
        }
        Ok(())
    }
}

struct Reader<'a> {
    source: &'a Arc<Source>,
    known: &'a [Column],
}

impl Reader<'_> {
    fn fault(&self, span: Range<usize>, message: String, label: &str) -> Diagnostic {
        let place = Place { source: Arc::clone(self.source), span };
        Diagnostic::error("objective", message).at(place, label)
    }

    fn read(&self) -> Result<Item, Diagnostic> {
        let text = self.source.text.as_str();
        let whole = text.trim();
        let start = text.len() - text.trim_start().len();
        let form = "write FUNCTION(COLUMN), for example `peak(leg1.P.effort)` or `min(distance.actuation)`";
        let call = whole.strip_suffix(')').and_then(|rest| rest.split_once('('));
        let Some((function, column)) = call else {
            let fault = self.fault(
                start..start + whole.len(),
                "an objective is a function of a column".to_owned(),
                "expected FUNCTION(COLUMN)",
            );
            return Err(fault.maybe_help(Some(form.to_owned())));
        };
        let name = function.trim();
        let Some(known) = Function::ALL.into_iter().find(|known| known.name() == name) else {
            let names = Function::ALL.map(Function::name);
            let fault = self.fault(
                start..start + function.len(),
                format!("there is no function `{name}`"),
                "unknown function",
            );
            return Err(fault.maybe_help(did_you_mean(name, "functions", names)));
        };
        let at = start + function.len() + 1;
        let place = at..at + column.len();
        let found = self.column(column.trim(), place.clone())?;
        let unit = match (known, found.unit.as_str()) {
            (Function::Work, "W") => "J",
            (Function::Work, unit) => {
                let owner = found.name.rsplit_once('.').map_or("", |(owner, _)| owner);
                let fault = self.fault(
                    place,
                    format!("`work` is the integral of a power; this column is in {unit}"),
                    "not in W",
                );
                let power = format!("{owner}.power");
                let has_power = self.known.iter().any(|column| column.name == power);
                return Err(fault.maybe_help(has_power.then(|| format!("write `work({power})`"))));
            }
            (_, unit) => unit,
        };
        Ok(Item {
            header: format!("{name}({}) [{unit}]", column.trim()),
            statistic: Statistic::new(known, found.has_thermal_rms()),
            determined: found.determined(self.known),
            is_determined: true,
            column: found,
        })
    }

    fn column(&self, written: &str, place: Range<usize>) -> Result<Column, Diagnostic> {
        let (table, rest) = match written.split_once(':') {
            Some((table, rest)) => (Some(table.trim().trim_end_matches(".csv")), rest),
            None => (None, written),
        };
        // A unit in brackets must equal the unit of the column.
        let (name, unit) = split(rest);
        let is_meant = |column: &&Column| {
            column.name == name && table.is_none_or(|table| table == column.table())
        };
        let Some(found) = self.known.iter().find(is_meant) else {
            let fault =
                self.fault(place, format!("there is no column `{written}`"), "unknown column");
            let of_table = self
                .known
                .iter()
                .filter(|column| table.is_none_or(|table| table == column.table()));
            let names: Vec<&str> = of_table.map(|column| column.name.as_str()).collect();
            let help = match (table, names.is_empty()) {
                (Some(table), true) => Some(format!(
                    "there is no table `{table}` in this run; the tables are inverse, joints, reactions, \
                     friction, bodies, motors and contributions"
                )),
                _ => did_you_mean(&name, "columns", names),
            };
            return Err(fault.maybe_help(help));
        };
        if rest.trim_end().ends_with(']') && unit != found.unit {
            let message = format!("the column `{name}` is in {}, not in {unit}", found.unit);
            return Err(self.fault(place, message, "another unit"));
        }
        Ok(found.clone())
    }
}
