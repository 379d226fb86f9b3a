//! Reports of runs: self-contained HTML pages with a common layout.
//!
//! The functions of `html` escape names and titles, which come from the user's files.

pub(crate) mod animation;
mod finding;
pub(crate) mod html;
mod load_points;

pub(crate) use finding::{Finding, findings, findings_json};

use crate::statistics::{Reactions, Size};
use html::{Column, note, paragraph, section, table, text};
use serde_json::Value;
use stiction_draw::figure::meaning::FRICTION;
use stiction_draw::figure::{Bar, Bars};
use stiction_draw::numbers::number;
use stiction_draw::xml::escape;
use stiction_format::ModelFile;

/// Number of rows that a long table shows initially; the other rows are collapsed.
pub(crate) const LISTED: usize = 8;

/// Largest number of bars in one figure.
const BARS: usize = 12;

/// Returns the heading of a report on a model.
pub(crate) fn header(model: &ModelFile, about: &str) -> String {
    heading(&model.name, &model.title, about)
}

/// Returns the heading of a report: name and title of the model, which may be empty, and a
/// description of the computation.
pub(crate) fn heading(name: &str, title: &str, about: &str) -> String {
    let mut inner = format!("<h1>{}</h1>\n", escape(name));
    if !title.is_empty() {
        inner += &paragraph(title);
    }
    inner + &note(about)
}

/// Returns the table of the peak reactions of all joints, in descending order of force. Moments at
/// most as large as the rounding error of the force times `length`, m, are shown as zero.
pub(crate) fn reactions(names: &[String], reactions: &Reactions, length: f64) -> String {
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by(|&a, &b| reactions.0[b].0.peak.total_cmp(&reactions.0[a].0.peak));
    let of = |size: &Size, noise: f64| match size.peak > noise {
        true => [text(&number(size.peak)), html::instant(size.peak_time)],
        false => [text("0"), String::new()],
    };
    let row = |&k: &usize| {
        let (force, moment) = &reactions.0[k];
        // Moments up to the rounding error of the force become zero.
        let moment = of(moment, 1e-12 * force.peak * length);
        let cells = of(force, 0.0).into_iter().chain(moment);
        std::iter::once(text(&names[k])).chain(cells).collect()
    };
    let rows: Vec<Vec<String>> = order.iter().map(row).collect();
    let head = [
        ("joint", Column::Text),
        ("force [N]", Column::Number),
        ("at [s]", Column::Number),
        ("moment [N m]", Column::Number),
        ("at [s]", Column::Number),
    ];
    let inner = note(
        "Peaks of the complete joint reactions, the largest first. Click a time to see the robot there.",
    ) + &html::long_table(&head, &rows, LISTED);
    section("Joint reactions", &inner)
}

/// Returns a bar chart of the dissipation in each joint, in descending order. `amounts` contains,
/// for each friction interface, the index of its joint and the dissipation in `unit`: energy, J, or
/// power, W.
pub(crate) fn by_joint(
    names: &[String],
    amounts: impl Iterator<Item = (usize, f64)>,
    unit: &str,
) -> String {
    let mut sums = vec![0.0; names.len()];
    for (joint, amount) in amounts {
        sums[joint] += amount;
    }
    let mut order: Vec<usize> = (0..names.len()).filter(|&joint| sums[joint] > 0.0).collect();
    order.sort_by(|&a, &b| sums[b].total_cmp(&sums[a]));
    let bar = |&joint: &usize| Bar {
        label: names[joint].clone(),
        ends: (0.0, sums[joint]),
        mark: None,
        colour: FRICTION,
        leg: None,
    };
    let bars = order.iter().take(BARS).map(bar).collect();
    let title = match order.len() > BARS {
        true => format!("Dissipation by joint, the {BARS} greatest"),
        false => "Dissipation by joint".to_owned(),
    };
    html::bars(&Bars { title, axis: String::new(), unit: unit.to_owned(), bars })
}

/// Returns the section with the options and the program version for repeating the run; `command` is
/// the command line of the run, if any, and `options` are the options in the summary.
pub(crate) fn repeat(command: Option<&str>, options: &Value) -> String {
    let mut inner = String::new();
    if let Some(command) = command {
        inner += &format!("<pre class=\"wide\" tabindex=\"0\">{}</pre>\n", escape(command));
    }
    let given = |value: &&Value| !value.is_null() && value.as_array().is_none_or(|a| !a.is_empty());
    let entries = options.as_object().into_iter().flatten();
    let entries = entries.filter(|(_, value)| given(value));
    let rows: Vec<Vec<String>> =
        entries.map(|(key, value)| vec![key.replace('_', " "), shown(value)]).collect();
    inner += &table(&[("option", Column::Text), ("value", Column::Text)], &rows);
    section("To repeat this run", &(inner + &version()))
}

/// Formats the value of an option.
fn shown(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(value) if value.is_f64() => value.as_f64().map_or(value.to_string(), number),
        Value::Number(count) => count.to_string(),
        Value::Array(all) => all.iter().map(shown).collect::<Vec<_>>().join("; "),
        other => other.to_string(),
    }
}

/// Returns the name and the version of the program.
pub(crate) fn version() -> String {
    note(&format!(
        "stiction {}. All numbers in SI units; the other files of this folder contain them with all digits.",
        env!("CARGO_PKG_VERSION")
    ))
}

/// Returns the footer with the source named by the model file, such as a publication; empty without
/// a source.
pub(crate) fn footer(model: &ModelFile) -> String {
    match model.source.trim() {
        "" => String::new(),
        source => format!("<footer>\n<p class=\"source\">{}</p>\n</footer>\n", escape(source)),
    }
}
