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
        caption: "Largest differences, relative to the largest force of the run: upper bounds. Each model along its default \
                  motion and along variations of geometry, inertia, motion and load drawn at random."
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
            "The paper compares its driving forces with those of a commercial multibody program and finds 3.4 %. Here \
             the comparison is made with four open ones, each in its own way. None of them has a call for the inverse \
             dynamics of closed chains, and none has friction that grows with a joint's load; what is compared is this: \
             without friction, their own dynamics and Jacobians of the loops give driving forces and reactions; with our \
             converged frictions applied to them as loads from outside, their own reactions must reproduce the loads \
             that we used.",
        ),
        Block::Table(table),
        right(format!(
            "All agree to {} or better, on the regular twin and on robots that have nothing to do with the paper.",
            rounding(worst())
        )),
        note(
            "Measured by `validation/` of the source code, which is part of its tests. The robot as printed is not among \
             the models: it has no driving forces to compare.",
        ),
    ];
    section("engines", "A second opinion: four independent programs", blocks)
}
