//! Comparison with independent programs, in place of the paper's comparison.

use super::{note, paragraph, right, rounding, section};
use crate::report::{Block, Cell, Column, Section, Table};

/// Results of `validation/`, which compares this table with every run.
const AGREEMENT: &str = include_str!("../../../../validation/agreement.csv");

/// Header and rows of the agreement table.
pub(crate) fn measured() -> (Vec<String>, Vec<Vec<String>>) {
    let mut lines = AGREEMENT.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
    let cells = |line: &str| line.split(',').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let header = lines.next().map(cells).unwrap_or_default();
    (header, lines.map(cells).collect())
}

/// The largest number in the table.
pub(crate) fn worst() -> f64 {
    let (_, rows) = measured();
    let numbers = rows.iter().flat_map(|row| row.iter().skip(5));
    numbers.filter_map(|cell| cell.parse::<f64>().ok()).fold(0.0, f64::max)
}

pub(crate) fn write() -> Section {
    let (header, rows) = measured();
    let mut table = Table {
        id: "engines".into(),
        caption: "Upper bounds of the largest differences, relative to the largest force of the \
            run. Each model is computed along its default motion, and with random variations of \
            geometry, inertia, motion and load."
            .into(),
        columns: header.iter().map(|name| Column::new(name.replace('_', " "), "")).collect(),
        rows: Vec::new(),
    };
    for row in rows {
        let cell = |text: &String| match text.parse::<f64>() {
            Ok(number)
                if text.contains('e') || text.contains('.') && text.matches('.').count() == 1 =>
            {
                Cell::Number(number, 1)
            }
            _ => Cell::Text(text.clone()),
        };
        table.rows.push(row.iter().map(cell).collect());
    }
    let blocks = vec![
        paragraph(
            "The paper compares its driving forces with those of a commercial multibody program \
             and finds a difference of 3.4 %. This study compares with four open-source programs. \
             None of them provides inverse dynamics of closed chains or friction that depends on \
             the load of a joint. Therefore the comparison has two parts: without friction, the \
             dynamics and loop Jacobians of these programs give driving forces and reactions; with \
             friction, the converged friction of this study is applied to them as external loads, \
             and their reactions must reproduce the normal loads from which this friction was \
             computed.",
        ),
        Block::Table(table),
        right(format!(
            "All programs agree to {} or better, for the regular twin and for robots that are not \
             related to the paper.",
            rounding(worst())
        )),
        note(
            "Measured by `validation/` in the source code, which is part of the tests. The printed \
             robot is not among the models, because it has no driving forces to compare.",
        ),
    ];
    section("engines", "A second opinion: four independent programs", blocks)
}
