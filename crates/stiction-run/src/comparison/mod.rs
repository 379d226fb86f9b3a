//! Comparison of runs: headline figures, which are single numbers such as the peak of an effort,
//! side by side, and the efforts of all runs in one plot.

mod curves;
mod headline;
mod page;
mod run;
mod verdicts;

pub use crate::report::animation::Reel;
pub use curves::{EffortCurves, overlay};
pub use headline::Headline;
pub(crate) use headline::motor_headlines;
pub use run::ComparedRun;
pub(crate) use run::{Conditions, Travel};

use serde_json::{Value, json};
use std::fmt::{self, Write};
use stiction_draw::numbers::{exact, number, percent};

/// Headline figures of several runs side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Labels of the compared runs.
    labels: Vec<String>,
    runs: Vec<ComparedRun>,
    rows: Vec<Row>,
    purpose: Purpose,
}

/// Subject of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Purpose {
    /// Models, under the same conditions if possible.
    Models,
    /// Motions and loads of one model.
    Cases,
}

/// Headline figure with its values in several runs. The value is `None` for each run that does not
/// have this figure.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    headline: Headline,
    values: Vec<Option<Headline>>,
}

/// Fraction of the largest term or value below which a value or a difference is a rounding error.
const ROUNDING: f64 = 1e-9;

impl Row {
    /// Returns true for a figure of an actuator effort.
    fn is_effort(&self) -> bool {
        self.headline.name.contains(" effort, ")
    }

    /// Returns the largest magnitude of a value, or of the terms of which the values are sums.
    fn scale(&self) -> f64 {
        let known = self.values.iter().flatten();
        known.fold(0.0, |max, x| max.max(x.value.abs()).max(x.scale))
    }

    /// Returns true if a value of this figure, or a difference between its values, is a rounding error.
    fn is_rounding(&self, difference: f64) -> bool {
        difference.abs() <= ROUNDING * self.scale()
    }

    /// Returns the values of all runs as shown to readers, with rounding errors replaced by zero.
    fn shown_values(&self) -> impl Iterator<Item = Option<f64>> {
        self.values.iter().map(|value| Some(value.as_ref()?.shown()))
    }

    /// Returns the worst value of all runs and the index of the run in which it occurs.
    fn worst(&self) -> Option<(usize, &Headline)> {
        let known = self.values.iter().enumerate().filter_map(|(k, v)| Some((k, v.as_ref()?)));
        let sign = if self.headline.least_is_worst { -1.0 } else { 1.0 };
        known.reduce(|a, b| if sign * b.1.value > sign * a.1.value { b } else { a })
    }

    /// Returns the value of the second run minus that of the first: the absolute difference, and
    /// the difference relative to the first run. `None` if there are not exactly two runs with this
    /// figure. The relative difference is `None` if the value of the first run is a rounding error.
    fn difference(&self) -> Option<(f64, Option<f64>)> {
        let [Some(a), Some(b)] = self.values.as_slice() else { return None };
        let difference = b.value - a.value;
        let is_reference = !self.is_rounding(a.value);
        Some((difference, is_reference.then(|| difference / a.value.abs())))
    }
}

impl Comparison {
    /// Arranges the headline figures of runs of several models side by side. The figures of the first run
    /// come first, followed by the figures of each further run that no earlier run has.
    pub fn of_models(runs: Vec<(String, ComparedRun)>) -> Self {
        Self::new(runs, Purpose::Models)
    }

    /// Arranges the headline figures of runs of one model with several motions or loads side by side, in the order of
    /// [`Self::of_models`].
    pub fn of_cases(runs: Vec<(String, ComparedRun)>) -> Self {
        Self::new(runs, Purpose::Cases)
    }

    fn new(runs: Vec<(String, ComparedRun)>, purpose: Purpose) -> Self {
        let mut rows: Vec<Row> = Vec::new();
        let count = runs.len();
        let (labels, runs): (Vec<String>, Vec<ComparedRun>) = runs.into_iter().unzip();
        for (index, run) in runs.iter().enumerate() {
            for headline in run.headlines.iter().cloned() {
                let same = |row: &Row| {
                    (&row.headline.name, row.headline.unit) == (&headline.name, headline.unit)
                };
                let place = match rows.iter().position(same) {
                    Some(place) => place,
                    None => {
                        let values = vec![None; count];
                        rows.push(Row { headline: headline.clone(), values });
                        rows.len() - 1
                    }
                };
                rows[place].values[index] = Some(headline);
            }
        }
        Self { labels, runs, rows, purpose }
    }

    /// Returns true if all runs have at least one headline figure of an actuator effort in common.
    pub fn has_common_effort(&self) -> bool {
        let mut efforts = self.rows.iter().filter(|row| row.is_effort());
        efforts.any(|row| row.values.iter().all(Option::is_some))
    }

    /// Writes the headline values of two runs and their differences as text.
    ///
    /// # Errors
    /// Returns an error if writing to `out` fails.
    pub fn write_differences(&self, out: &mut impl Write) -> fmt::Result {
        let wide = self.width();
        write!(out, "{:wide$}", "")?;
        self.labels.iter().try_for_each(|label| write!(out, "  {label:>13}"))?;
        writeln!(out, "  {:>13}", "difference")?;
        for row in &self.rows {
            write!(out, "{:wide$}", row.headline.name)?;
            for value in row.shown_values() {
                let text = value.map_or("-".to_owned(), number);
                write!(out, "  {text:>13}")?;
            }
            let (absolute, relative) = match row.difference() {
                Some((difference, relative)) => (number(difference), percent(relative)),
                None => ("-".to_owned(), "-".to_owned()),
            };
            writeln!(out, "  {absolute:>13} {relative:>9}  {}", row.headline.unit)?;
        }
        Ok(())
    }

    /// Writes the worst value of each headline figure, and the run in which it occurs, as text.
    ///
    /// # Errors
    /// Returns an error if writing to `out` fails.
    pub fn write_envelope(&self, out: &mut impl Write) -> fmt::Result {
        let wide = self.width();
        writeln!(out, "{:wide$}  {:>13}       in the run", "envelope", "worst")?;
        for row in &self.rows {
            let Some((run, worst)) = row.worst() else { continue };
            let label = &self.labels[run];
            let at = worst.time.map_or(String::new(), |time| format!(" at t = {} s", number(time)));
            let (name, unit) = (&worst.name, worst.unit);
            writeln!(out, "{name:wide$}  {:>13} {unit:4}  {label}{at}", number(worst.value))?;
        }
        Ok(())
    }

    fn width(&self) -> usize {
        let widths = self.rows.iter().map(|row| row.headline.name.chars().count());
        widths.max().unwrap_or(0)
    }

    /// Returns the comparison as a JSON object. `runs` lists the labels of the runs.
    /// `figures` contains, for each headline figure, its values in the order of the runs, the worst value,
    /// and for two runs the difference. `verdicts` contains the verdicts with their meaning.
    pub fn json(&self) -> Value {
        let figures = self.rows.iter().map(|row| {
            let values: Vec<Option<f64>> =
                row.values.iter().map(|value| Some(value.as_ref()?.value)).collect();
            let worst = row.worst().map(|(run, worst)| {
                json!({ "run": self.labels[run], "value": worst.value, "time": worst.time })
            });
            let mut figure = json!({
                "name": row.headline.name,
                "unit": row.headline.unit,
                "values": values,
                "worst": worst,
            });
            if let Some((difference, relative)) = row.difference() {
                figure["difference"] = json!(difference);
                figure["relative_difference"] = json!(relative);
            }
            figure
        });
        json!({
            "runs": self.labels,
            "figures": figures.collect::<Vec<_>>(),
            "verdicts": self.findings_json(),
        })
    }

    /// Returns all headline figures as CSV, with a row for each figure and a column for each run.
    pub fn csv(&self) -> Vec<u8> {
        let mut table = csv::Writer::from_writer(Vec::new());
        let header = ["figure", "unit"].into_iter().chain(self.labels.iter().map(String::as_str));
        // Writing to memory does not fail.
        let _ = table.write_record(header);
        for row in &self.rows {
            let mut cells = vec![row.headline.name.clone(), row.headline.unit.to_owned()];
            for value in &row.values {
                let mut cell = String::new();
                if let Some(value) = value {
                    exact(&mut cell, value.value);
                }
                cells.push(cell);
            }
            let _ = table.write_record(cells);
        }
        table.into_inner().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headline(name: &str, value: f64, least_is_worst: bool) -> Headline {
        Headline {
            name: name.to_owned(),
            unit: "N",
            value,
            time: None,
            scale: value,
            least_is_worst,
        }
    }

    /// Compares runs with the given headline figures.
    fn comparison(runs: Vec<(&str, Vec<Headline>)>) -> Comparison {
        let run = |headlines| ComparedRun { headlines, ..ComparedRun::default() };
        let runs = runs.into_iter().map(|(label, headlines)| (label.to_owned(), run(headlines)));
        Comparison::of_models(runs.collect())
    }

    /// Checks that a value that is only a rounding error is shown as zero, and that no relative
    /// difference to it is computed.
    #[test]
    fn rounding_errors_are_no_reference() {
        let work = |value: f64, scale: f64| {
            vec![Headline::new("work".to_owned(), "J", value, (None, scale))]
        };
        let relative = |a: f64, b: f64, scale: f64| {
            let runs = vec![("A", work(a, scale)), ("B", work(b, scale))];
            comparison(runs).json()["figures"][0]["relative_difference"].clone()
        };
        assert_eq!(relative(2e-15, -3e-15, 10.0), json!(null));
        let shown = |value, scale| comparison(vec![("A", work(value, scale))]);
        let shown = |value, scale| shown(value, scale).rows[0].shown_values().next().unwrap();
        assert_eq!((shown(2e-15, 10.0), shown(2e-9, 10.0)), (Some(0.0), Some(2e-9)));
        let half = |relative: serde_json::Value| (relative.as_f64().unwrap() - 0.5).abs() < 1e-12;
        assert!(half(relative(2.0, 3.0, 10.0)));
        assert!(half(relative(2e-15, 3e-15, 0.0)));
    }

    #[test]
    fn figures_meet_by_name() {
        let runs = vec![
            ("a", vec![headline("x", 2.0, false), headline("index", 0.5, true)]),
            ("b", vec![headline("index", 0.2, true), headline("y", 1.0, false)]),
        ];
        let comparison = comparison(runs);
        let json = comparison.json();
        assert_eq!(json["figures"][0]["values"], json!([2.0, null]));
        assert_eq!(json["figures"][1]["worst"]["run"], "b");
        assert_eq!(json["figures"][1]["difference"], json!(0.2 - 0.5));
        assert_eq!(json["figures"][2]["values"], json!([null, 1.0]));
        let csv = String::from_utf8(comparison.csv()).unwrap();
        assert_eq!(csv.lines().next(), Some("figure,unit,a,b"));
        assert_eq!(csv.lines().nth(1), Some("x,N,2,"));
    }
}
