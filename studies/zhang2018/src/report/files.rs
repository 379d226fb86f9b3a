//! Files of a report: numbers as CSV and figures as SVG on white.

use super::markup::plain;
use super::{Block, Cell, Report, Table};
use stiction_draw::figure::{Figure, Line};
use stiction_draw::{numbers, page};

/// File name of the report's figure with this number.
pub(super) fn picture(number: usize) -> String {
    format!("picture-{number}.svg")
}

impl Report {
    /// CSV files as pairs of name and contents: one for each table, in full double precision, and
    /// one for each figure of curves with the points of its lines.
    ///
    /// Non-finite numbers are `inf`, `-inf` or an empty field. [`Report::defects`] reports
    /// duplicate names.
    pub fn tables(&self) -> Vec<(String, String)> {
        let file = |block: &Block| match block {
            Block::Table(table) => Some((format!("{}.csv", table.id), of_table(table))),
            Block::Curves { id, figure, .. } => Some((format!("{id}.csv"), of_figure(figure))),
            _ => None,
        };
        self.blocks().filter_map(file).collect()
    }

    /// SVG files on white as pairs of name and contents, referenced by [`Report::markdown`].
    pub fn pictures(&self) -> Vec<(String, String)> {
        let mut count = 0;
        let file = |block: &Block| match block {
            Block::Curves { id, figure, .. } if !figure.is_empty() => {
                Some((format!("{id}.svg"), figure.svg()))
            }
            Block::Picture { svg, .. } => {
                count += 1;
                Some((picture(count), on_paper(svg)))
            }
            _ => None,
        };
        self.blocks().filter_map(file).collect()
    }

    /// All blocks in reading order.
    pub(super) fn blocks(&self) -> impl Iterator<Item = &Block> {
        self.sections.iter().flat_map(|section| &section.blocks)
    }
}

/// Converts a picture to a standalone file that always uses the light colours.
fn on_paper(svg: &str) -> String {
    // Dark mode also shows the picture on white.
    let svg = svg.replace("screen and (prefers-color-scheme:dark)", "not all");
    let svg = svg.replace("(prefers-color-scheme:dark)", "not all");
    let style = format!("<style>{}svg{{background:#ffffff}}</style>", page::light());
    match svg.split_once('>') {
        Some((head, rest)) if !head.ends_with('/') => {
            let name = " xmlns=\"http://www.w3.org/2000/svg\"";
            let name = if head.contains(" xmlns=") { "" } else { name };
            format!("{head}{name}>{style}{rest}")
        }
        _ => svg,
    }
}

fn of_table(table: &Table) -> String {
    let head = table.columns.iter().map(|column| named(&plain(&column.name), &column.unit));
    let rows = table.rows.iter().map(|row| row.iter().map(value).collect());
    csv(head.collect(), rows)
}

fn value(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => plain(text),
        Cell::Number(x, _) | Cell::Fixed(x, _) => digits(*x),
        Cell::Empty => String::new(),
    }
}

fn digits(x: f64) -> String {
    let mut text = String::new();
    if !x.is_nan() {
        numbers::exact(&mut text, x);
    }
    text
}

fn named(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

/// CSV of a figure; lines with identical abscissae share their column.
fn of_figure(figure: &Figure) -> String {
    let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
    for Group { abscissae, lines } in groups(figure) {
        let (name, unit) = name_and_unit(&figure.x_label);
        columns.push((unique(&columns, name, unit), abscissae));
        for (panel, line) in lines {
            let (name, unit) = name_and_unit(&figure.panels[panel].y_label);
            let name = match figure.panels.len() {
                1 => line.label.clone(),
                _ => format!("{name}: {}", line.label),
            };
            let values = line.points.iter().map(|point| point.1).collect();
            columns.push((unique(&columns, &name, unit), values));
        }
    }
    let longest = columns.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
    let value = |values: &[f64], k: usize| values.get(k).map_or(String::new(), |x| digits(*x));
    let rows = (0..longest).map(|k| columns.iter().map(|(_, all)| value(all, k)).collect());
    csv(columns.iter().map(|(name, _)| name.clone()).collect(), rows)
}

/// Column name with its unit, made unique among the columns.
fn unique(columns: &[(String, Vec<f64>)], name: &str, unit: &str) -> String {
    let mut own = named(name, unit);
    let mut count = 1;
    while columns.iter().any(|(other, _)| *other == own) {
        count += 1;
        own = named(&format!("{name} ({count})"), unit);
    }
    own
}

/// Lines with identical abscissae and the numbers of their panels.
struct Group<'a> {
    abscissae: Vec<f64>,
    lines: Vec<(usize, &'a Line)>,
}

fn groups(figure: &Figure) -> Vec<Group<'_>> {
    // Compare bits, because NaN does not equal itself.
    let bits = |abscissae: &[f64]| abscissae.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    let mut groups: Vec<Group<'_>> = Vec::new();
    for (k, panel) in figure.panels.iter().enumerate() {
        for line in &panel.lines {
            let abscissae: Vec<f64> = line.points.iter().map(|point| point.0).collect();
            let own = bits(&abscissae);
            match groups.iter_mut().find(|group| bits(&group.abscissae) == own) {
                Some(group) => group.lines.push((k, line)),
                None => groups.push(Group { abscissae, lines: vec![(k, line)] }),
            }
        }
    }
    groups
}

/// Splits a label such as `force [N]` into name and unit.
fn name_and_unit(label: &str) -> (&str, &str) {
    let parts = label.strip_suffix(']').and_then(|label| label.rsplit_once('['));
    parts.map_or((label, ""), |(name, unit)| (name.trim_end(), unit))
}

/// Writes rows under a header; short rows are padded to its length.
fn csv(head: Vec<String>, rows: impl Iterator<Item = Vec<String>>) -> String {
    let width = head.len();
    if width == 0 {
        return String::new();
    }
    let mut writer = csv::Writer::from_writer(Vec::new());
    for mut row in std::iter::once(head).chain(rows) {
        row.resize(width, String::new());
        // Writing to memory cannot fail, and all rows have the same length.
        let _ = writer.write_record(&row);
    }
    let bytes = writer.into_inner().unwrap_or_default();
    String::from_utf8(bytes).unwrap_or_default()
}
