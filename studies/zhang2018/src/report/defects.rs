//! Consistency checks of a report: duplicate names and broken links.

use super::markup::{destinations, is_name};
use super::{Block, Report, Text};
use std::collections::HashSet;

impl Report {
    /// Describes each duplicate name and broken link; empty for a valid report.
    pub fn defects(&self) -> Vec<String> {
        let mut defects = Vec::new();
        let mut places = HashSet::new();
        let mut place = |name: String, defects: &mut Vec<String>| {
            if !is_name(&name) {
                defects.push(format!("`{name}` is no name: lower-case letters, digits, hyphens"));
            }
            if places.contains(&name) {
                defects.push(format!("`{name}` is there twice"));
            }
            places.insert(name);
        };
        for section in &self.sections {
            place(section.id.clone(), &mut defects);
        }
        let mut equations = HashSet::new();
        for block in self.blocks() {
            match block {
                Block::Table(table) => place(format!("table-{}", table.id), &mut defects),
                Block::Curves { id, .. } => place(format!("figure-{id}"), &mut defects),
                // A repeated equation links to its first occurrence.
                Block::Equation { number, .. }
                    if !number.is_empty() && equations.insert(number) =>
                {
                    place(format!("eq-{}", number.to_lowercase()), &mut defects);
                }
                _ => {}
            }
        }
        let mut files = HashSet::new();
        for (name, _) in self.tables().iter().chain(&self.pictures()) {
            if !files.insert(name.clone()) {
                defects.push(format!("two files are named `{name}`"));
            }
        }
        for text in self.texts() {
            for target in destinations(text) {
                if !target.strip_prefix('#').is_some_and(|name| places.contains(name)) {
                    defects.push(format!("a link leads to `{target}`, which does not exist"));
                }
            }
        }
        self.check_rows(&mut defects);
        defects
    }

    fn check_rows(&self, defects: &mut Vec<String>) {
        for block in self.blocks() {
            let Block::Table(table) = block else { continue };
            for (k, row) in table.rows.iter().enumerate() {
                if row.len() != table.columns.len() {
                    let (cells, columns) = (row.len(), table.columns.len());
                    defects.push(format!(
                        "row {} of `{}` has {cells} cells for {columns} columns",
                        k + 1,
                        table.id
                    ));
                }
            }
        }
    }

    /// All marked-up texts of the report.
    fn texts(&self) -> Vec<&Text> {
        let mut texts: Vec<&Text> = self.lead.iter().chain(&self.footer).collect();
        for block in self.blocks() {
            match block {
                Block::Paragraph(text) | Block::Finding(_, text) => texts.push(text),
                Block::List(items) => texts.extend(items),
                Block::Equation { formula, .. } => texts.push(formula),
                Block::Curves { caption, .. } | Block::Picture { caption, .. } => {
                    texts.push(caption)
                }
                Block::Table(table) => {
                    texts.push(&table.caption);
                    texts.extend(table.columns.iter().map(|column| &column.name));
                    texts.extend(table.rows.iter().flatten().filter_map(super::Cell::text));
                }
            }
        }
        texts
    }
}
