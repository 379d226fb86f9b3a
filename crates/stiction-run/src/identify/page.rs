//! Report of an identification as a self-contained HTML page.

use super::identified::{Identified, Named};
use super::traces::{EffortSample, FrictionTrace, LogTrace, Traces};
use crate::report::animation::together;
use crate::report::html::{self, Column, card, long_table, note, section, table_of, text};
use crate::report::{Finding, findings, footer, header, repeat};
use serde_json::json;
use stiction_draw::figure::meaning::{FRICTION, MEASURED, OF_LEG};
use stiction_draw::figure::{Figure, Line, Panel, Trace};
use stiction_draw::numbers::number;
use stiction_format::ModelFile;
use stiction_identify::{FitVerdict, Verdict};

/// Number of rows that a long table shows initially; the other rows are collapsed.
const LISTED: usize = 40;
/// Largest number of measured points in a friction plot.
const POINTS: usize = 400;
/// Largest number of points of the friction curve that is drawn. Each point is a mean over measured
/// points of similar speed.
const INTERVALS: usize = 40;
/// Half the width of the dash that marks a measured point, as a fraction of the horizontal axis.
const DASH: f64 = 2.5e-3;

impl Identified {
    /// Returns the report as HTML: verdict, measured and predicted efforts, residuals, friction
    /// over speed, identified values compared with those of the model, and cautions. `command` is
    /// the command line that produced the results, if any.
    pub fn report(&self, model: &ModelFile, traces: &Traces, command: Option<&str>) -> String {
        let logs: Vec<String> = self
            .predictions
            .iter()
            .map(|p| match p.used_for_fit {
                true => p.log.clone(),
                false => format!("{} (for prediction only)", p.log),
            })
            .collect();
        let about = format!("Inertia and friction identified from {}.", logs.join(", "));
        let each = traces.logs.iter().map(|log| efforts(traces, log));
        let friction: String = traces.friction.iter().filter_map(friction).collect();
        let friction = match friction.is_empty() {
            true => friction,
            false => section("Friction", &(note(FRICTION_NOTE) + &friction)),
        };
        let cutoffs: Vec<String> =
            self.cutoffs.iter().flatten().map(|hz| format!("{} Hz", number(*hz))).collect();
        let options = json!({
            "logs": logs.join(", "), "filter": cutoffs.join(", "), "prior_strength": self.strength,
        });
        let reel = |log: &LogTrace| Some((log.name.clone(), log.robot.reel(traces.logs.len())?));
        let caption = match traces.logs.len() {
            1 => "The robot along the log.",
            _ => "The robot along the first log; along the other ones it is dashed and grey.",
        };
        let robots = together(traces.logs.iter().filter_map(reel).collect(), caption);
        let is_moving = !robots.is_empty();
        let inner = [
            header(model, &about),
            self.cards(),
            html::warnings(&self.cautions),
            if is_moving { section("The robot", &robots) } else { robots },
            section(
                "Efforts, measured and predicted",
                &(self.errors() + &each.collect::<String>()),
            ),
            friction,
            section("Parameters", &self.values()),
            findings(&self.findings()),
            repeat(command, &options),
            footer(model),
        ];
        let (title, inner) = (format!("{}: identification", model.name), inner.concat());
        match is_moving {
            true => html::page_with_robot(&title, &inner),
            false => html::page(&title, &inner),
        }
    }

    fn cards(&self) -> String {
        let count = |verdict| self.parameters.iter().filter(|p| p.verdict == verdict).count();
        let free = self.parameters.len() - count(Verdict::Held);
        let is_bad = matches!(self.verdict, FitVerdict::Failed | FitVerdict::NotExcited);
        let mut all = vec![
            card(&self.verdict.to_string(), "verdict on the fit", is_bad),
            card(
                &format!("{} of {free}", count(Verdict::Identified)),
                "parameters identified individually",
                false,
            ),
        ];
        for (used, what) in [(true, "of the fitted logs"), (false, "of logs that were not used")] {
            let own = self.predictions.iter().filter(|p| p.used_for_fit == used);
            let errors = own.flat_map(|p| &p.error_percent);
            let errors = errors.filter_map(|(name, error)| Some((name, (*error)?)));
            if let Some((name, error)) = errors.max_by(|a, b| a.1.total_cmp(&b.1)) {
                let what = format!("largest relative error {what}: {name}");
                all.push(card(&format!("{} %", number(error)), &what, false));
            }
        }
        html::cards(&all)
    }

    /// Returns the HTML table of the relative errors of the predicted efforts, for each log and
    /// actuator.
    fn errors(&self) -> String {
        let mut rows = Vec::new();
        for p in &self.predictions {
            for ((name, error), prior) in p.error_percent.iter().zip(&p.prior_percent) {
                let used = if p.used_for_fit { "fitted" } else { "predicted" };
                let [error, prior] =
                    [error, prior].map(|percent| percent.map_or("no rows".to_owned(), number));
                rows.push([p.log.as_str(), used, name, &error, &prior].map(text).to_vec());
            }
        }
        let head = [
            ("log", Column::Text),
            ("", Column::Text),
            ("effort", Column::Text),
            ("error [%]", Column::Number),
            ("of the unchanged model [%]", Column::Number),
        ];
        note(
            "Each error is the root mean square of the residuals divided by that of the measured \
             effort. Measured and predicted efforts have passed the same filter; rows in which a \
             joint rests are left out.",
        ) + &long_table(&head, &rows, LISTED)
    }

    fn values(&self) -> String {
        let head = [
            ("parameter", Column::Text),
            ("unit", Column::Text),
            ("model", Column::Number),
            ("identified", Column::Number),
            ("standard deviation", Column::Number),
            ("change / deviation", Column::Number),
            ("verdict", Column::Text),
        ];
        let row = |p: &&Named| {
            // Adding zero removes the sign of a negative zero.
            let change = (10.0 * (p.value - p.prior) / p.sigma).round() / 10.0 + 0.0;
            let change = if change.is_finite() { format!("{change:.1}") } else { "-".to_owned() };
            let [value, sigma] = [p.value, p.sigma].map(number);
            let prior = if p.prior.is_nan() { "none".to_owned() } else { number(p.prior) };
            let verdict = p.verdict.to_string();
            [p.name.as_str(), &unit(p.unit), &prior, &value, &sigma, &change, &verdict]
                .map(text)
                .to_vec()
        };
        let of = |told: bool| -> Vec<Vec<String>> {
            let is_told = |p: &&Named| {
                (matches!(p.verdict, Verdict::Identified | Verdict::FitsOnly) == told)
                    && p.verdict != Verdict::Held
            };
            self.parameters.iter().filter(is_told).map(|p| row(&p)).collect()
        };
        let mut inner = long_table(&head, &of(true), LISTED);
        inner += &html::folded("not excited by these logs", &table_of(&head, &of(false)));
        let held = self.parameters.iter().filter(|p| p.verdict == Verdict::Held);
        let held: Vec<Vec<String>> = held.map(|p| row(&p)).collect();
        inner += &html::folded("held at the values of the model", &table_of(&head, &held));
        if self.combinations.is_empty() {
            return inner;
        }
        let head = [
            ("combination", Column::Text),
            ("unit", Column::Text),
            ("identified", Column::Number),
            ("standard deviation", Column::Number),
            ("verdict", Column::Text),
        ];
        let rows: Vec<Vec<String>> = self
            .combinations
            .iter()
            .map(|c| {
                let verdict = c.verdict.to_string();
                let cells =
                    [c.name.as_str(), &unit(c.unit), &number(c.value), &number(c.sigma), &verdict];
                cells.map(text).to_vec()
            })
            .collect();
        inner
            + &note(
                "The efforts depend only on these combinations, not on the individual parameters in them.",
            )
            + &long_table(&head, &rows, LISTED)
    }

    fn findings(&self) -> Vec<Finding> {
        let statement = format!("The fit: {}", self.verdict);
        let ratio = format!(
            "In cross-validation, the squared residuals of left-out blocks of the logs are {} \
             times those of the fit.",
            number(self.left_out)
        );
        let mut all = vec![match self.verdict {
            FitVerdict::Identified => Finding::good(statement, ratio),
            FitVerdict::FitsOnly => Finding::open(statement, ratio),
            _ => Finding::bad(statement, ratio),
        }];
        for (a, b, cure) in &self.confounded {
            all.push(Finding::open(format!("{a} and {b} are not distinguished"), cure.clone()));
        }
        all
    }
}

const FRICTION_NOTE: &str = "Friction of each joint against the magnitude of its rate, as an \
    effort of the joint that opposes its motion. Points are the measured efforts minus everything \
    else that was identified; the line is the identified law, averaged over the normal loads at \
    each rate.";

/// Returns a unit with `²` in place of `^2`, as in the other tables of HTML pages.
fn unit(unit: &str) -> String {
    unit.replace("^2", "²")
}

/// Returns the HTML plots of one log: measured and predicted efforts, and residuals.
fn efforts(traces: &Traces, log: &LogTrace) -> String {
    let count = log.rows.len();
    let figure = |title: String,
                  lines: &[(&str, usize, bool)],
                  pick: fn(&EffortSample) -> Vec<f64>| {
        let panel = |(channel, (name, unit)): (usize, &(String, &'static str))| {
            let mut curves: Vec<Trace> = lines.iter().map(|_| Trace::new(count)).collect();
            for (time, samples) in &log.rows {
                match &samples[channel] {
                    Some(sample) => {
                        let values = pick(sample);
                        curves.iter_mut().zip(values).for_each(|(c, value)| c.push(*time, value));
                    }
                    None => curves.iter_mut().for_each(Trace::interrupt),
                }
            }
            let lines = curves.into_iter().zip(lines);
            let lines =
                lines.map(|(curve, (label, colour, dashed))| curve.line(label, *colour, *dashed));
            Panel {
                y_label: format!("{name} [{unit}]"),
                lines: lines.collect(),
                leg: traces.legs[channel],
                ..Panel::default()
            }
        };
        let panels = traces.efforts.iter().enumerate().map(panel).collect();
        html::curves(&Figure { title, x_label: "time [s]".to_owned(), panels })
    };
    let used = if log.used_for_fit { "fitted" } else { "not used for the fit" };
    let both = figure(
        format!("Efforts: {}, {used}", log.name),
        &[("measured", MEASURED, false), ("predicted", OF_LEG, true)],
        |sample| vec![sample.measured, sample.predicted],
    );
    let residuals = figure(
        format!("Residuals: {}", log.name),
        &[("measured less predicted", OF_LEG, false)],
        |sample| vec![sample.measured - sample.predicted],
    );
    both + &residuals
}

/// Returns the HTML plot of an identified friction law and of the measured points; `None` if no
/// point is finite.
fn friction(trace: &FrictionTrace) -> Option<String> {
    let mut points = trace.points.clone();
    points.retain(|point| point.iter().all(|x| x.is_finite()));
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (first, last) = (points.first()?[0], points.last()?[0]);
    let half = DASH * (last - first);
    let stride = points.len().div_ceil(POINTS);
    let dots = points.iter().step_by(stride).flat_map(|[rate, data, _]| {
        [(rate - half, *data), (rate + half, *data), (f64::NAN, f64::NAN)]
    });
    let size = points.len().div_ceil(INTERVALS).max(1);
    let law = points.chunks(size).map(|chunk| {
        let mean = |k: usize| chunk.iter().map(|p| p[k]).sum::<f64>() / chunk.len() as f64;
        (mean(0), mean(2))
    });
    let line = |label: &str, points: Vec<(f64, f64)>, colour| Line {
        label: label.to_owned(),
        points,
        colour,
        dashed: false,
    };
    let lines = vec![
        line("data", dots.collect(), MEASURED),
        line("identified law", law.collect(), FRICTION),
    ];
    let panel = Panel { y_label: format!("friction [{}]", trace.unit), lines, ..Panel::default() };
    Some(html::curves(&Figure {
        title: trace.name.clone(),
        x_label: format!("rate [{}]", trace.rate_unit),
        panels: vec![panel],
    }))
}
