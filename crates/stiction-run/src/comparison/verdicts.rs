//! Verdicts on a comparison of runs: differences of their conditions, of the mechanisms and of the figures, and the
//! verdicts of the runs.

use super::{ComparedRun, Comparison, Purpose, Row, Travel};
use crate::names::listed;
use crate::report::{Finding, findings_json};
use serde_json::Value;
use std::fmt::{self, Write};
use stiction_draw::numbers::{number, percent};

/// Largest number of names, runs or figures that one sentence lists.
const NAMED: usize = 6;

impl Comparison {
    /// Returns the verdicts on the comparison, and those of all runs. Runs with the same verdict share one.
    pub(crate) fn findings(&self) -> Vec<Finding> {
        let mut all = Vec::new();
        if self.purpose == Purpose::Models {
            self.conditions(&mut all);
            self.actuators(&mut all);
            self.changes(&mut all);
        }
        self.mobilities(&mut all);
        self.travels(&mut all);
        self.shared(&mut all);
        all
    }

    /// Returns the verdicts as JSON.
    pub(crate) fn findings_json(&self) -> Value {
        findings_json(&self.findings())
    }

    /// Writes the verdicts that require a change as text, a line for each.
    ///
    /// # Errors
    /// Returns an error if writing to `out` fails.
    pub fn write_cautions(&self, out: &mut impl Write) -> fmt::Result {
        let findings = self.findings();
        let mut bad = findings.iter().filter(|finding| finding.is_bad());
        bad.try_for_each(|finding| writeln!(out, "CAUTION: {}", finding.in_one_line()))
    }

    fn runs_with_labels(&self) -> impl Iterator<Item = (&str, &ComparedRun)> {
        self.labels.iter().map(String::as_str).zip(&self.runs)
    }

    /// Lists a property of all runs if it differs, as `A: x, B: y`; `None` if all runs agree.
    fn differing(&self, of: impl Fn(&ComparedRun) -> Option<String>) -> Option<String> {
        let all: Vec<(&str, String)> =
            self.runs_with_labels().filter_map(|(label, run)| Some((label, of(run)?))).collect();
        let (_, first) = all.first()?;
        let differs = all.iter().any(|(_, own)| own != first);
        let each = all.iter().map(|(label, own)| format!("{label}: {own}"));
        differs.then(|| listed(each, NAMED))
    }

    fn conditions(&self, all: &mut Vec<Finding>) {
        let kinds = [
            ("motion", self.differing(|run| Some(run.conditions.motion.clone()))),
            ("load", self.differing(|run| Some(run.conditions.load.clone()))),
            ("friction", self.differing(|run| Some(run.conditions.friction.to_owned()))),
        ];
        let differ = kinds.into_iter().filter_map(|(kind, each)| {
            Some((format!("{kind} ({})", each?), format!("`--{kind}`")))
        });
        let (names, options): (Vec<_>, Vec<_>) = differ.unzip();
        if !names.is_empty() {
            all.push(Finding::open(
                format!("The runs differ in {}", names.join(" and in ")),
                format!(
                    "The models alone do not explain the differences of the figures. If that is not intended, give both \
                     models the same with {}.",
                    options.join(" and ")
                ),
            ));
        }
    }

    fn actuators(&self, all: &mut Vec<Finding>) {
        if !self.has_common_effort() {
            all.push(Finding::open(
                "The efforts of the runs are not compared",
                "Efforts are compared by the name and the unit of the actuator, and no actuator of one model agrees in \
                 both with one of the other. Give corresponding joints the same name in both models; a force is not \
                 compared with a torque.",
            ));
        }
    }

    /// Adds the largest change of an effort, or the verdict that nothing changes.
    fn changes(&self, all: &mut Vec<Finding>) {
        let both: Vec<(&Row, f64, Option<f64>)> = self
            .rows
            .iter()
            .filter_map(|row| row.difference().map(|(by, part)| (row, by, part)))
            .collect();
        if both.is_empty() {
            return;
        }
        let is_equal = |(row, by, _): &(&Row, f64, Option<f64>)| row.is_rounding(*by);
        if both.iter().all(is_equal) {
            let which = match both.len() == self.rows.len() {
                true => "All figures of the runs",
                false => "All figures that both runs have",
            };
            all.push(Finding::open(
                format!("{which} are equal up to rounding"),
                "What differs between the models has no effect on them along this motion with this load. Check whether \
                 the changed values are used: friction is off in some models unless `--friction on` is given.",
            ));
            return;
        }
        let efforts = both.iter().filter(|&one| one.0.is_effort() && !is_equal(one));
        let largest = efforts
            .filter_map(|(row, by, part)| Some((row, by, (*part)?)))
            .max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()));
        if let Some((row, by, part)) = largest {
            let headline = &row.headline;
            let sign = if *by > 0.0 { "+" } else { "" };
            all.push(Finding::good(
                format!(
                    "Largest relative change of an effort: {}, {sign}{} {} ({sign}{})",
                    headline.name,
                    number(*by),
                    headline.unit,
                    percent(Some(part))
                ),
                format!(
                    "The value of {} minus that of {}, relative to the latter.",
                    self.labels[1], self.labels[0]
                ),
            ));
        }
    }

    fn mobilities(&self, all: &mut Vec<Finding>) {
        if let Some(each) = self.differing(|run| run.mobility.map(|count| count.to_string())) {
            all.push(Finding::open(
                format!("The runs differ in their degrees of freedom ({each})"),
                "Some bodies can move more freely in one run than in another: joints differ, or one motion is at a \
                 singular position. `stiction check` describes the mobility of each model.",
            ));
        }
    }

    /// Adds the actuators whose coordinates have no value in common in two runs with motions of the same name.
    fn travels(&self, all: &mut Vec<Finding>) {
        let mut runs = self.runs_with_labels();
        let Some((first, reference)) = runs.next() else { return };
        let mut apart: Vec<String> = Vec::new();
        for (label, run) in runs {
            if run.conditions.motion != reference.conditions.motion {
                continue;
            }
            for own in &run.travel {
                let same = |one: &&Travel| (&one.name, one.unit) == (&own.name, own.unit);
                let Some(other) = reference.travel.iter().find(same) else { continue };
                if own.is_apart(other) {
                    apart.push(format!(
                        "{} ({first}: {}, {label}: {} {})",
                        own.name,
                        between(other.ends),
                        between(own.ends),
                        own.unit
                    ));
                }
            }
        }
        if !apart.is_empty() {
            all.push(Finding::open(
                format!("Actuators travel through different ranges: {}", listed(apart, NAMED)),
                "These ranges have no position in common: the dimensions of the models differ, or the runs are in \
                 different assembly modes. Compare the robots in the report; `start` values in the model select the \
                 assembly mode.",
            ));
        }
    }

    /// Adds the verdicts of all runs. Verdicts with the same meaning become one, which states the runs, and so do verdicts
    /// with the same statement.
    fn shared(&self, all: &mut Vec<Finding>) {
        let mut groups: Vec<Group<'_>> = Vec::new();
        for (label, run) in self.runs_with_labels() {
            for own in &run.findings {
                match groups.iter_mut().find(|group| group.fits(own)) {
                    Some(group) => group.add(label, own),
                    None => groups.push(Group::new(label, own)),
                }
            }
        }
        all.extend(groups.iter().map(|group| group.finding(self.labels.len())));
    }
}

/// Verdicts of several runs that become one.
struct Group<'a> {
    class: &'static str,
    statements: Shared<'a>,
    meanings: Shared<'a>,
}

/// Different texts, each with the labels of the runs to which it belongs.
struct Shared<'a>(Vec<(&'a str, Vec<&'a str>)>);

impl<'a> Group<'a> {
    fn new(label: &'a str, first: &'a Finding) -> Self {
        let mut group = Self {
            class: first.class,
            statements: Shared(Vec::new()),
            meanings: Shared(Vec::new()),
        };
        group.add(label, first);
        group
    }

    fn fits(&self, own: &Finding) -> bool {
        self.class == own.class
            && (self.statements.has(&own.statement) || self.meanings.has(&own.meaning))
    }

    fn add(&mut self, label: &'a str, own: &'a Finding) {
        self.statements.add(label, &own.statement);
        self.meanings.add(label, &own.meaning);
    }

    /// Returns the verdict of the group in a comparison of `count` runs.
    fn finding(&self, count: usize) -> Finding {
        let meaning = match &self.meanings.0[..] {
            [(only, _)] => (*only).to_owned(),
            _ => self.meanings.text(count, " "),
        };
        Finding { class: self.class, statement: self.statements.text(count, "\n"), meaning }
    }
}

impl<'a> Shared<'a> {
    fn has(&self, text: &str) -> bool {
        self.0.iter().any(|(known, _)| *known == text)
    }

    fn add(&mut self, label: &'a str, text: &'a str) {
        match self.0.iter_mut().find(|(known, _)| *known == text) {
            // A run may have several verdicts with the same text.
            Some((_, labels)) if labels.contains(&label) => {}
            Some((_, labels)) => labels.push(label),
            None => self.0.push((text, vec![label])),
        }
    }

    /// Joins the texts, each after the labels of its runs.
    fn text(&self, count: usize, separator: &str) -> String {
        let each = self.0.iter().map(|(text, labels)| match labels.len() {
            own if own == count && count == 2 => format!("Both runs: {text}"),
            own if own == count => format!("All runs: {text}"),
            _ => format!("{}: {text}", listed(labels, NAMED)),
        });
        let mut parts: Vec<String> = each.take(NAMED).collect();
        if let more @ 1.. = self.0.len().saturating_sub(NAMED) {
            parts.push(format!("and {more} more"));
        }
        parts.join(separator)
    }
}

/// Formats the ends of a range.
fn between((least, greatest): (f64, f64)) -> String {
    format!("{} to {}", number(least), number(greatest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::{Conditions, Headline};

    fn run(motion: &str, effort: f64, findings: Vec<Finding>) -> ComparedRun {
        let headline = Headline::new("J effort, peak".to_owned(), "N", effort, (None, effort));
        ComparedRun {
            conditions: Conditions { motion: motion.to_owned(), ..Conditions::default() },
            headlines: vec![headline],
            findings,
            ..ComparedRun::default()
        }
    }

    fn models(runs: [ComparedRun; 2]) -> Vec<String> {
        let labels = ["A", "B"].map(str::to_owned);
        let comparison = Comparison::of_models(labels.into_iter().zip(runs).collect());
        comparison.findings().into_iter().map(|one| one.statement).collect()
    }

    #[test]
    fn differences_are_stated() {
        let statements = models([run("line", 2.0, vec![]), run("circle", 3.0, vec![])]);
        assert_eq!(
            statements,
            [
                "The runs differ in motion (A: line, B: circle)",
                "Largest relative change of an effort: J effort, peak, +1.000 N (+50.0 %)",
            ]
        );
        let equal = models([run("line", 2.0, vec![]), run("line", 2.0 + 1e-14, vec![])]);
        assert_eq!(equal, ["All figures of the runs are equal up to rounding"]);
        let travel = |ends| Travel { name: "J".to_owned(), unit: "rad", ends };
        let of = |ends| ComparedRun { travel: vec![travel(ends)], ..run("line", 2.0, vec![]) };
        let apart = models([of((0.1, 0.5)), of((-2.0, -1.5))]);
        let stated = "different ranges: J (A: 0.1000 to 0.5000, B: -2.000 to -1.500 rad)";
        assert!(apart.iter().any(|one| one.contains(stated)), "{apart:?}");
        let overlap = models([of((0.1, 0.5)), of((0.4, 0.6))]);
        assert!(!overlap.iter().any(|one| one.contains("ranges")), "{overlap:?}");
        // Rounding errors of a resting actuator, and angles that differ by a whole turn.
        for (a, b) in [((0.3, 0.3), (0.3 + 1e-15, 0.3 + 1e-15)), ((3.1, 3.3), (-3.2, -3.0))] {
            let same = models([of(a), of(b)]);
            assert!(!same.iter().any(|one| one.contains("ranges")), "{same:?}");
        }
        // Another motion may move an actuator elsewhere.
        let elsewhere =
            ComparedRun { travel: vec![travel((-2.0, -1.5))], ..run("circle", 2.0, vec![]) };
        let moved = models([of((0.1, 0.5)), elsewhere]);
        assert!(!moved.iter().any(|one| one.contains("ranges")), "{moved:?}");
        let more = ComparedRun {
            headlines: ["J effort, peak", "K effort, peak"]
                .map(|name| Headline::new(name.to_owned(), "N", 2.0, (None, 2.0)))
                .to_vec(),
            ..run("line", 2.0, vec![])
        };
        let partly = models([run("line", 2.0, vec![]), more]);
        assert_eq!(partly, ["All figures that both runs have are equal up to rounding"]);
        let mobile = |count| ComparedRun { mobility: Some(count), ..run("line", 2.0, vec![]) };
        let mobile = models([mobile(2), mobile(3)]);
        assert!(
            mobile.contains(&"The runs differ in their degrees of freedom (A: 2, B: 3)".to_owned())
        );
    }

    #[test]
    fn equal_verdicts_are_stated_once() {
        let a = vec![Finding::good("unique", "u"), Finding::good("index 1", "i")];
        let b = vec![
            Finding::good("unique", "u"),
            Finding::good("index 2", "i"),
            Finding::bad("jams", "j"),
        ];
        let statements = models([run("line", 2.0, a), run("line", 3.0, b)]);
        assert_eq!(statements[1..], ["Both runs: unique", "A: index 1\nB: index 2", "B: jams"]);
    }

    /// Checks that two verdicts of one run with the same text do not count as those of both runs.
    #[test]
    fn a_run_counts_once() {
        let a = ["J leaves", "K leaves"].map(|text| Finding::bad(text, "a range"));
        let b = vec![Finding::bad("K leaves", "another range")];
        let labels = ["A", "B"].map(str::to_owned);
        let runs = labels.into_iter().zip([run("line", 2.0, a.to_vec()), run("line", 2.0, b)]);
        let found = Comparison::of_models(runs.collect()).findings();
        let last = found.last().unwrap();
        assert_eq!(
            (last.statement.as_str(), last.meaning.as_str()),
            ("A: J leaves\nBoth runs: K leaves", "A: a range B: another range")
        );
    }

    /// Checks that equal statements with different meanings become one, with the meaning for each run.
    #[test]
    fn meanings_may_differ() {
        let runs = [("A", "L = 1 m."), ("B", "L = 2 m.")].map(|(label, meaning)| {
            (label.to_owned(), run("line", 2.0, vec![Finding::open("open", meaning)]))
        });
        let found = Comparison::of_models(runs.to_vec()).findings();
        let last = found.last().unwrap();
        assert_eq!(
            (last.statement.as_str(), last.meaning.as_str()),
            ("Both runs: open", "A: L = 1 m. B: L = 2 m.")
        );
    }

    /// Checks that different motions are no finding if they are what is compared.
    #[test]
    fn cases_differ_in_their_conditions() {
        let runs = [
            ("x".to_owned(), run("line", 2.0, vec![])),
            ("y".to_owned(), run("circle", 3.0, vec![])),
        ];
        assert!(Comparison::of_cases(runs.to_vec()).findings().is_empty());
    }
}
