//! Reader of the rows of a recording.

use super::super::context::LARGEST;
use super::header::{Header, Role};
use super::messages::Messages;
use crate::diagnostic::{number, quoted};
use crate::signal::recorded::lines::{Cells, Line, parse_number};
use crate::source::Span;

/// Maximum number of lines whose digits are counted before the first row is read.
const SURVEYED: usize = 100_000;

/// Reader of the rows of a recording, one after another, which reports their errors.
pub(super) struct Rows {
    header: Header,
    /// Values of the row read last, in SI units, one for each column; 0 in unused columns.
    row: Vec<f64>,
    /// Standard deviations of the rounding errors of the values in `row`, in SI units.
    rounding: Vec<f64>,
    cells: Cells,
    /// Decimal mark of the file, a point or a comma; `None` until a number contains one.
    decimal_mark: Option<char>,
    is_first: bool,
    last_time: Option<f64>,
    /// Names of the columns for which a wrapped angle has been reported.
    wrapped: Vec<String>,
}

impl Rows {
    pub(super) fn new(header: Header) -> Self {
        let row = vec![0.0; header.columns.len()];
        Self {
            rounding: row.clone(),
            cells: Cells::new(header.delimiter),
            decimal_mark: None,
            header,
            row,
            is_first: true,
            last_time: None,
            wrapped: Vec::new(),
        }
    }

    pub(super) fn header(&self) -> &Header {
        &self.header
    }

    pub(super) fn into_header(self) -> Header {
        self.header
    }

    /// Values of the row read last, in SI units, one for each column of the header.
    pub(super) fn row(&self) -> &[f64] {
        &self.row
    }

    /// Standard deviations of the rounding errors of the row read last, in SI units, one for each
    /// column of the header.
    pub(super) fn rounding(&self) -> &[f64] {
        &self.rounding
    }

    /// Counts the digits with which each column is written in these lines, before the rows are
    /// read. This is necessary for programs that omit trailing zeros: a number written as `1.0` is
    /// as precise as numbers with more digits in the same column.
    pub(super) fn count_digits(&mut self, text: &str, lines: impl Iterator<Item = Line>) {
        let is_used = |role: Role| !matches!(role, Role::Unknown);
        for line in lines.take(SURVEYED) {
            let columns = &mut self.header.columns;
            if columns.iter().filter(|c| is_used(c.role)).all(|c| c.digits.is_full()) {
                return;
            }
            let cells = self.cells.split(text, line, columns.len());
            for (column, cell) in columns.iter_mut().zip(cells).filter(|(c, _)| is_used(c.role)) {
                column.digits.add(text.get(cell.clone()).unwrap_or_default());
            }
        }
    }

    /// Reads a row. Returns false if the number of its cells differs from the number of columns in
    /// the header, or if the header is invalid.
    pub(super) fn read(&mut self, text: &str, line: Line, messages: &mut Messages) -> bool {
        let width = self.header.columns.len();
        // A header without columns is invalid and has been reported.
        if width == 0 {
            return false;
        }
        let is_comma = self.header.delimiter.is_comma();
        let cells = self.cells.split(text, line.clone(), width);
        let count = cells.len();
        if count != width {
            let message = format!("this row has {}, the header has {width}", numbers(count));
            let content = text.get(line.clone()).unwrap_or_default();
            let help = if content.matches('"').count() % 2 == 1 {
                "close the quote"
            } else if is_comma && count > width {
                "with decimal commas, separate columns by semicolons or quote the numbers"
            } else {
                "write one number for each column of the header, or remove the row"
            };
            messages.push_help("ragged", message, line, "the row", Some(help.to_owned()));
            return false;
        }
        let places = self.header.columns.iter_mut().zip(&mut self.row).zip(&mut self.rounding);
        for (((column, last), rounding), cell) in places.zip(cells) {
            let content = text.get(cell.clone()).unwrap_or_default();
            let value = match column.role {
                // The column is not used.
                Role::Unknown => 0.0,
                _ => {
                    check_mark(content, is_comma, &mut self.decimal_mark, cell, messages);
                    let written = read_number(content, cell, messages);
                    column.digits.add(content);
                    *rounding = column.scale.apply(column.digits.rounding(written.unwrap_or(0.0)));
                    written.map_or(f64::NAN, |x| column.scale.apply(x))
                }
            };
            if column.role == Role::Time {
                check_time(value, self.last_time, cell, messages);
                self.last_time = if value.is_nan() { self.last_time } else { Some(value) };
            }
            if column.is_angle && !self.is_first {
                check_turn(value - *last, &column.name, cell, &mut self.wrapped, messages);
            }
            if value.abs() > LARGEST {
                let message = format!("{} is too large", number(value));
                let help = "check the unit of the column, or remove the row".to_owned();
                messages.push_help("range", message, cell.clone(), "too large", Some(help));
            }
            *last = value;
        }
        self.is_first = false;
        true
    }
}

fn numbers(count: usize) -> String {
    if count == 1 { "1 column".to_owned() } else { format!("{count} columns") }
}

/// Reports a number whose decimal mark differs from that of earlier numbers (`known`), or which may
/// contain thousands separators.
fn check_mark(
    content: &str,
    is_comma: bool,
    known: &mut Option<char>,
    cell: &Span,
    messages: &mut Messages,
) {
    let Some(mark) = content.chars().find(|c| matches!(c, ',' | '.')) else { return };
    let (whole, rest) = content.split_once(mark).unwrap_or_default();
    let whole = whole.trim_start_matches(['+', '-']);
    let is_ambiguous = mark == ','
        && is_comma
        && rest.len() == 3
        && rest.bytes().all(|b| b.is_ascii_digit())
        && !whole.starts_with('0')
        && known.is_none();
    let (message, label, help) = if is_ambiguous || rest.contains([',', '.']) {
        let message = format!("{} may contain thousands separators", quoted(content));
        (message, "which number?", "write numbers without thousands separators")
    } else if known.is_some_and(|known| known != mark) {
        let message =
            format!("{} has another decimal mark than the numbers above", quoted(content));
        (message, "point or comma?", "use one decimal mark in the whole file")
    } else {
        *known = Some(mark);
        return;
    };
    messages.push_help("syntax", message, cell.clone(), label, Some(help.to_owned()));
}

/// Help text of the message about a cell that is not a number.
const WITHOUT_NUMBER: &str = "write the measured value, or remove the row";

fn read_number(content: &str, cell: &Span, messages: &mut Messages) -> Option<f64> {
    match parse_number(content).ok_or(()) {
        Ok(x) if x.is_finite() => Some(x),
        // The text of a message that is only counted is not needed.
        _ if messages.is_full() => {
            messages.push("syntax", String::new(), cell.clone(), "");
            None
        }
        Ok(_) => {
            let message = format!("{} is not a finite number", quoted(content));
            let (label, help) = ("expected a finite number", Some(WITHOUT_NUMBER.to_owned()));
            messages.push_help("not-finite", message, cell.clone(), label, help);
            None
        }
        Err(_) => {
            let message = match content {
                "" => "this cell is empty".to_owned(),
                _ => format!("{} is not a number", quoted(content)),
            };
            let help = if content.starts_with('"') { "close the quote" } else { WITHOUT_NUMBER };
            let help = Some(help.to_owned());
            messages.push_help("syntax", message, cell.clone(), "expected a number", help);
            None
        }
    }
}

/// Reports an angle that changes by more than half a turn between two samples, which shows that the
/// angle was wrapped to one turn. `wrapped` contains the names of the columns already reported;
/// each column is reported once.
fn check_turn(
    change: f64,
    name: &str,
    cell: &Span,
    wrapped: &mut Vec<String>,
    messages: &mut Messages,
) {
    // If a number is invalid, which has been reported, the change is NaN and the comparison false.
    let is_wrapped = change.abs() > std::f64::consts::PI;
    if !is_wrapped || wrapped.iter().any(|known| known == name) {
        return;
    }
    wrapped.push(name.to_owned());
    let message = format!(
        "{} changes by {} deg between two samples",
        quoted(name),
        number(change.to_degrees().round())
    );
    let help = "let angles continue beyond a full turn: 358, 360, 362 deg; where \
                a rotation vector r jumps, multiply it by 1 - 2 pi/|r|";
    let label = "more than half a turn";
    messages.push_help("wrapped", message, cell.clone(), label, Some(help.to_owned()));
}

fn check_time(time: f64, last: Option<f64>, cell: &Span, messages: &mut Messages) {
    if let Some(last) = last
        && time <= last
    {
        let message =
            format!("time does not increase: {} s follows {} s", number(time), number(last));
        let help = match time == last {
            true => "keep one of the rows with the same time, or write times with more digits",
            false => "sort the rows by time; if the clock was set back, split the file there",
        };
        let label = "not later than the row above";
        messages.push_help("samples", message, cell.clone(), label, Some(help.to_owned()));
    }
}
