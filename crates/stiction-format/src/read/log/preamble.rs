//! Finds the header of a log below the lines that recorders write before it.

use crate::expression::unit_of;
use crate::signal::recorded::lines::{Cells, Delimiter, parse_number};
use crate::source::Span;

/// Maximum number of lines in which the header is searched.
pub(super) const SEARCHED: usize = 64;

/// Position of a log's header, and layout of its lines.
pub(super) struct Head {
    /// Line that contains the names of the columns.
    pub(super) names: Span,
    /// Line of the units below the names, which some recorders write.
    pub(super) units: Option<Span>,
    /// Separator between columns.
    pub(super) delimiter: Delimiter,
    /// True if lines end with commas that a spreadsheet has added to a file that uses another separator.
    pub(super) has_commas: bool,
    /// Number of lines before the first row of numbers.
    pub(super) lines: usize,
}

/// Finds the header: the first line with a known name, or else the first line of names that is followed, possibly
/// after a line of units, by two rows with as many cells, at least two of which are numbers. Without such a line, the
/// first line is the header.
pub(super) fn find(text: &str, lines: &[Span], is_known: impl Fn(&str) -> bool) -> Option<Head> {
    let first = lines.first()?;
    let declared = Delimiter::declared(&text[first.clone()]);
    let from = usize::from(declared.is_some() && lines.len() > 1);
    let head = |at: usize| -> Option<Head> {
        let (names, has_commas) = unpadded(text, &lines[at]);
        let delimiter = declared.unwrap_or_else(|| Delimiter::of(&text[names.clone()]));
        let has_commas = has_commas && !delimiter.is_comma();
        let names = if has_commas { names } else { lines[at].clone() };
        Some(Head { names, units: None, delimiter, has_commas, lines: at + 1 })
    };
    let found = |at: usize, needs_name: bool| {
        let head = head(at)?;
        let cells = |line: usize| -> Vec<&str> { head.cells(text, lines.get(line)) };
        let names = cells(at);
        let are_rows = |line: usize| {
            let is_row = |line: usize| {
                let row = cells(line);
                row.len() == names.len() && numbers(&row) >= 2
            };
            is_row(line) && (line + 1 == lines.len() || is_row(line + 1))
        };
        if names.len() < 2 || 2 * numbers(&names) > names.len() {
            return None;
        }
        let below = cells(at + 1);
        let has_units = below.len() == names.len() && are_units(&below);
        let is_header = match needs_name {
            true => names.iter().any(|name| is_known(name)),
            false => are_rows(at + 1 + usize::from(has_units)),
        };
        if has_units && is_header {
            let units = Some(head.content(text, &lines[at + 1]));
            return Some(Head { units, lines: at + 2, ..head });
        }
        is_header.then_some(head)
    };
    let mut all =
        [true, false].into_iter().flat_map(|needs| (from..lines.len()).map(move |at| (at, needs)));
    all.find_map(|(at, needs_name)| found(at, needs_name)).or_else(|| head(from))
}

/// Describes a log without a header, in which all lines are rows with `columns` cells. Commas may
/// be decimal commas, so the separator is the first of tab, semicolon and comma that divides the
/// first row into this number of cells.
pub(super) fn none(text: &str, lines: &[Span], columns: usize) -> Option<Head> {
    let first = lines.first()?;
    let declared = Delimiter::declared(&text[first.clone()]);
    let from = usize::from(declared.is_some() && lines.len() > 1);
    let row = &text[lines[from].clone()];
    let fits = |delimiter: &Delimiter| {
        let split = Cells::new(*delimiter).split(text, lines[from].clone(), columns).len();
        split == columns
    };
    let delimiter = declared.or_else(|| Delimiter::ALL.into_iter().find(fits));
    Some(Head {
        names: first.start..first.start,
        units: None,
        delimiter: delimiter.unwrap_or_else(|| Delimiter::of(row)),
        has_commas: false,
        lines: from,
    })
}

impl Head {
    /// Returns the range of a line without the commas that a spreadsheet has added.
    pub(super) fn content(&self, text: &str, line: &Span) -> Span {
        if self.has_commas { unpadded(text, line).0 } else { line.clone() }
    }

    fn cells<'a>(&self, text: &'a str, line: Option<&Span>) -> Vec<&'a str> {
        let Some(line) = line else { return Vec::new() };
        let mut cells = Cells::new(self.delimiter);
        let spans = cells.split(text, self.content(text, line), usize::MAX);
        spans.iter().map(|span| &text[span.clone()]).collect()
    }
}

fn unpadded(text: &str, line: &Span) -> (Span, bool) {
    let content = text[line.clone()].trim_end();
    let bare = content.trim_end_matches(',');
    (line.start..line.start + bare.len(), bare.len() < content.len())
}

fn numbers(cells: &[&str]) -> usize {
    cells.iter().filter(|cell| parse_number(cell).is_some()).count()
}

/// Tests if each cell is a unit, `%`, `-` or empty, and at least one cell is a unit.
fn are_units(cells: &[&str]) -> bool {
    let is_unit = |cell: &&str| unit_of(cell).is_ok();
    cells.iter().all(|cell| cell.is_empty() || ["%", "-"].contains(cell) || is_unit(cell))
        && cells.iter().any(|cell| !cell.is_empty() && is_unit(cell))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> (String, Option<String>, usize) {
        let mut lines = Vec::new();
        let mut at = 0;
        for line in text.split('\n') {
            lines.push(at..at + line.len());
            at += line.len() + 1;
        }
        let head = find(text, &lines, |name| name == "time [s]").unwrap();
        let units = head.units.map(|units| text[units].to_owned());
        (text[head.names].to_owned(), units, head.lines)
    }

    #[test]
    fn a_plain_header_is_the_first_line() {
        assert_eq!(found("time [s],q\n0,1\n1,2"), ("time [s],q".into(), None, 1));
        assert_eq!(found("sep=;\ntime [s];q\n0;1\n1;2"), ("time [s];q".into(), None, 2));
        // Rows that cannot be read do not hide the header.
        assert_eq!(found("time [s],q,r\nx,y,z\n0,1,2"), ("time [s],q,r".into(), None, 1));
        assert_eq!(found("time [s],q\nx,1\nx,2"), ("time [s],q".into(), None, 1));
    }

    /// Checks that decimal commas do not separate cells if another separator divides the row into
    /// the named columns.
    #[test]
    fn rows_without_header_are_divided_into_the_named_columns() {
        let cells = |text: &str, columns: usize| -> (Vec<String>, usize) {
            let first = text.find('\n').unwrap();
            let lines = [0..first, first + 1..text.len()];
            let head = none(text, &lines, columns).unwrap();
            let row = head.cells(text, lines.get(head.lines));
            (row.iter().map(|cell| (*cell).to_owned()).collect(), head.lines)
        };
        for (text, first) in [
            ("0,1;2,5;3,5\n0,2;2,5;3,5", "0,1"),
            ("0,1\t2,5\t3,5\n0,2\t2,5\t3,5", "0,1"),
            ("1;2;3;\n1;2;3;", "1"),
            ("1,2,3\n1,2,3", "1"),
        ] {
            let (row, skipped) = cells(text, 3);
            // A separator at the end of a row adds an empty cell.
            assert_eq!((row.len().min(3), row[0].as_str(), skipped), (3, first, 0), "{text}");
        }
        let (row, skipped) = cells("sep=;\n0,1;2,5", 2);
        assert_eq!((row, skipped), (vec!["0,1".to_owned(), "2,5".to_owned()], 1));
    }

    #[test]
    fn lines_of_a_recorder_are_above_the_header() {
        let text = "Date:;2020-07-06,,\nMax. samples:;500,,\nRecorded samples:;500,,\n\
                    Scale:;0;True;2.000;5.000,,\n\
                    Trigger:;1;0.0;name\nTriggerAttributes:;1;4;0x30\n;Velocity;Torque,,\nms;rpm;%,,\n0.0;0;-1200,,was -8.9\n\
                    256.0;0;-9.4,,\n512.0;0;-9.4,,\n";
        let (names, units, lines) = found(text);
        assert_eq!(
            (names.as_str(), units.as_deref(), lines),
            (";Velocity;Torque", Some("ms;rpm;%"), 8)
        );
    }
}
