//! Sections of the report, one file each.

pub(super) mod engines;
pub(super) mod friction;
pub(super) mod headline;
pub(super) mod ideal;
pub(super) mod kinematics;
pub(super) mod map;
pub(super) mod reactions;
pub(super) mod simulation;
pub(super) mod structure;
pub(super) mod twin;

use crate::report::{Block, Cell, Finding, Section, Table};
use stiction_draw::figure::{Figure, Line, Panel};

pub(super) fn section(id: &str, title: &str, blocks: Vec<Block>) -> Section {
    Section { id: id.into(), title: title.into(), blocks }
}

pub(super) fn paragraph(text: impl Into<String>) -> Block {
    Block::Paragraph(text.into())
}

pub(super) fn right(text: impl Into<String>) -> Block {
    Block::Finding(Finding::Right, text.into())
}

pub(super) fn wrong(text: impl Into<String>) -> Block {
    Block::Finding(Finding::Wrong, text.into())
}

pub(super) fn note(text: impl Into<String>) -> Block {
    Block::Finding(Finding::Note, text.into())
}

pub(super) fn open(text: impl Into<String>) -> Block {
    Block::Finding(Finding::Open, text.into())
}

pub(super) fn equation(number: &str, formula: &str) -> Block {
    Block::Equation { number: number.into(), formula: formula.into() }
}

/// Number cell with the given number of significant digits.
pub(super) fn digits(value: f64, digits: usize) -> Cell {
    Cell::Number(value, digits)
}

/// Number cell with the given number of decimals.
pub(super) fn fixed(value: f64, digits: usize) -> Cell {
    Cell::Fixed(value, digits)
}

/// Builds a table from its rows.
pub(super) fn table<const N: usize>(
    id: &str,
    caption: &str,
    columns: [(&str, &str); N],
    rows: impl IntoIterator<Item = [Cell; N]>,
) -> Block {
    let mut table = Table::new(id, caption, columns);
    table.rows = rows.into_iter().map(Vec::from).collect();
    Block::Table(table)
}

/// Points and style of a curve over time: name, colour index, dashed, points.
pub(super) type Drawn<'a> = (&'a str, usize, bool, Vec<(f64, f64)>);

/// Builds a panel of curves over time.
pub(super) fn panel<const N: usize>(y_label: &str, lines: [Drawn<'_>; N]) -> Panel {
    let line = |(label, colour, dashed, points): Drawn<'_>| Line {
        label: label.into(),
        points,
        colour,
        dashed,
    };
    Panel {
        y_label: y_label.into(),
        lines: lines.into_iter().map(line).collect(),
        ..Panel::default()
    }
}

/// Builds a figure of panels over time.
pub(super) fn curves(id: &str, title: &str, panels: Vec<Panel>, caption: &str) -> Block {
    let figure = Figure { title: title.into(), x_label: "time [s]".into(), panels };
    Block::Curves { id: id.into(), figure, caption: caption.into() }
}

/// Formats a number for running text as a power of ten with the given number of digits.
pub(super) fn power_of_ten(value: f64, digits: usize) -> String {
    let text = format!("{value:.*e}", digits.saturating_sub(1));
    match text.split_once('e') {
        Some(("1", power)) => format!("10<sup>{}</sup>", power.replace('-', "−")),
        Some((front, power)) if power != "0" => {
            format!("{front} × 10<sup>{}</sup>", power.replace('-', "−"))
        }
        Some((front, _)) => front.to_owned(),
        None => text,
    }
}

/// Formats a range of counts in words: one number if both limits are equal.
pub(super) fn count_range((least, greatest): (usize, usize)) -> String {
    if least == greatest { least.to_string() } else { format!("{least} to {greatest}") }
}

/// Formats a rounding error in words.
pub(super) fn rounding(value: f64) -> String {
    if value == 0.0 { "exactly zero".into() } else { power_of_ten(value, 1) }
}

/// Minimum and maximum of the values.
pub(super) fn range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    values.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), value| {
        (least.min(value), greatest.max(value))
    })
}

/// Largest magnitude of the values.
pub(super) fn greatest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |most: f64, value| most.max(value.abs()))
}
