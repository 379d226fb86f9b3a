//! JSON form of a report.

use super::markup::plain;
use super::{Block, Cell, Report, Table};
use serde_json::{Map, Value, json};

impl Report {
    /// Findings and tables of the report as JSON. `findings` lists the `section`, `verdict` and
    /// `text` of each finding; `tables` contains each table by its file name, with `caption`,
    /// `columns` (`name`, `unit`) and `rows`. NaN becomes null, infinities become strings.
    pub fn json(&self) -> Value {
        let mut findings = Vec::new();
        let mut tables = Map::new();
        for section in &self.sections {
            for block in &section.blocks {
                match block {
                    Block::Finding(finding, text) => findings.push(json!({
                        "section": section.id,
                        "verdict": finding.word().to_lowercase(),
                        "text": plain(text),
                    })),
                    Block::Table(table) => {
                        tables.insert(table.id.clone(), of_table(table));
                    }
                    _ => {}
                }
            }
        }
        let sections = self
            .sections
            .iter()
            .map(|section| json!({ "name": section.id, "title": section.title }));
        json!({
            "program": { "name": "stiction", "version": env!("CARGO_PKG_VERSION") },
            "title": self.title,
            "sections": sections.collect::<Vec<_>>(),
            "findings": findings,
            "tables": tables,
        })
    }
}

fn of_table(table: &Table) -> Value {
    let columns = table
        .columns
        .iter()
        .map(|column| json!({ "name": plain(&column.name), "unit": column.unit }));
    let rows = table.rows.iter().map(|row| row.iter().map(of_cell).collect::<Vec<_>>());
    json!({
        "caption": plain(&table.caption),
        "columns": columns.collect::<Vec<_>>(),
        "rows": rows.collect::<Vec<_>>(),
    })
}

fn of_cell(cell: &Cell) -> Value {
    match *cell {
        Cell::Text(ref text) => json!(plain(text)),
        Cell::Number(x, _) | Cell::Fixed(x, _) if x.is_infinite() => {
            json!(if x > 0.0 { "inf" } else { "-inf" })
        }
        // NaN becomes null.
        Cell::Number(x, _) | Cell::Fixed(x, _) => json!(x),
        Cell::Empty => Value::Null,
    }
}
