//! Report of controllers with and without compensation of friction.

use crate::report::html::{self, Column, card, note, section, text};
use crate::report::{Finding, findings, footer, header, repeat};
use serde_json::Value;
use stiction_draw::figure::{Figure, Panel, Trace};
use stiction_draw::numbers::number;
use stiction_format::ModelFile;

/// Largest number of controllers in a plot.
const DRAWN: usize = 7;

/// Result of a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracking {
    /// Name.
    pub label: String,
    /// For each actuator: rms error, peak error, largest effort, largest change of the effort between two samples.
    pub figures: Vec<[f64; 4]>,
    /// Work of all actuators, J.
    pub work: f64,
    /// Number of stick onsets of friction interfaces.
    pub sticks: usize,
    /// Number of reversals of actuators beyond those of the reference.
    pub reversals: usize,
    /// Reason why the simulation ended early, if it did.
    pub ended: Option<String>,
    /// Time, s, and tracking error of each actuator.
    pub errors: Vec<(f64, Vec<f64>)>,
}

/// Results of all controllers.
#[derive(Clone, Debug, PartialEq)]
pub struct Controllers {
    /// Motion, load and conditions in a sentence.
    pub about: String,
    /// Headline figures, each with its meaning.
    pub headlines: Vec<(String, String)>,
    /// Actuators with the units of their positions and efforts.
    pub actuators: Vec<(String, &'static str, &'static str)>,
    /// Results.
    pub tracking: Vec<Tracking>,
    /// Options.
    pub options: Value,
}

/// Writes the report: errors over time, all figures, verdicts. `command` is the command line, if there is one.
pub fn draw_report(model: &ModelFile, found: &Controllers, command: Option<&str>) -> String {
    let cards: Vec<String> =
        found.headlines.iter().map(|(big, small)| card(big, small, false)).collect();
    let inner = [
        header(model, &found.about),
        html::cards(&cards),
        section("Tracking errors", &errors(found)),
        section("Figures", &figures(found)),
        findings(&verdicts(found)),
        repeat(command, &found.options),
        footer(model),
    ];
    html::page(&format!("{}: friction compensation", model.name), &inner.concat())
}

fn errors(found: &Controllers) -> String {
    let panel = |(k, (name, unit, _)): (usize, &(String, &str, &str))| {
        let line = |(colour, own): (usize, &Tracking)| {
            let mut trace = Trace::new(own.errors.len());
            own.errors.iter().for_each(|(time, errors)| trace.push(*time, errors[k]));
            let label = if k == 0 { own.label.as_str() } else { "" };
            trace.line(label, colour, false)
        };
        let lines = found.tracking.iter().take(DRAWN).enumerate().map(line).collect();
        Panel { y_label: format!("{name} [{unit}]"), lines, ..Panel::default() }
    };
    let panels: Vec<Panel> = found.actuators.iter().enumerate().map(panel).collect();
    let title = "Reference minus position of each actuator".to_owned();
    let figure = Figure { title, x_label: "time [s]".to_owned(), panels };
    let more = match found.tracking.len() > DRAWN {
        true => note(&format!("The first {DRAWN} of {} controllers.", found.tracking.len())),
        false => String::new(),
    };
    more + &html::curves(&figure)
}

fn figures(found: &Controllers) -> String {
    let mut rows = Vec::new();
    for own in &found.tracking {
        for (k, (name, unit, effort)) in found.actuators.iter().enumerate() {
            let first = |text: String| if k == 0 { text } else { String::new() };
            let mut cells = vec![first(own.label.clone()), name.clone()];
            match own.figures.get(k) {
                Some([rms, peak, most, change]) => cells.extend([
                    format!("{} {unit}", number(*rms)),
                    format!("{} {unit}", number(*peak)),
                    format!("{} {effort}", number(*most)),
                    format!("{} {effort}", number(*change)),
                ]),
                None => cells.extend([const { String::new() }; 4]),
            }
            let counts = [number(own.work), own.sticks.to_string(), own.reversals.to_string()];
            cells.extend(counts.map(first));
            rows.push(cells.iter().map(|cell| text(cell)).collect());
        }
    }
    let head = [
        ("controller", Column::Text),
        ("actuator", Column::Text),
        ("rms error", Column::Number),
        ("peak error", Column::Number),
        ("largest effort", Column::Number),
        ("change per sample", Column::Number),
        ("work [J]", Column::Number),
        ("stick onsets", Column::Number),
        ("extra reversals", Column::Number),
    ];
    let about = "Work, stick onsets and reversals are of all actuators and interfaces. Reversals beyond those of the \
                 reference come from limit cycles and chatter.";
    note(about) + &html::table_of(&head, &rows)
}

fn verdicts(found: &Controllers) -> Vec<Finding> {
    let mut all = Vec::new();
    for own in &found.tracking {
        if let Some(why) = &own.ended {
            all.push(Finding::bad(
                format!("{} ended early: {why}", own.label),
                "Its figures are those up to this instant, and it is left out of comparisons.",
            ));
        } else if own.reversals > 0 {
            all.push(Finding::open(
                format!("{}: {} reversals beyond those of the reference", own.label, own.reversals),
                "A limit cycle or chatter. Try a smoother transition, a lower bandwidth, or better sensors.",
            ));
        }
    }
    if all.is_empty() {
        all.push(Finding::good(
            "No limit cycles and no chatter",
            "No actuator reverses more often than its reference.",
        ));
    }
    all
}
