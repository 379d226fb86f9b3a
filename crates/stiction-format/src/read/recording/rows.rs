//! Reader of the rows of a recording.

use super::super::context::LARGEST;
use super::header::{Header, Role};
use super::messages::Messages;
use crate::diagnostic::{number, quoted};
use crate::signal::recorded::lines::{Line, cells};
use crate::source::Span;

/// Reads rows one after another and reports their errors.
pub(super) struct Rows {
    header: Header,
    /// The previous row, in SI units.
    row: Vec<f64>,
    is_first: bool,
    last_time: Option<f64>,
    /// Columns whose wrapped angles were reported.
    wrapped: Vec<String>,
}

impl Rows {
    pub(super) fn new(header: Header) -> Self {
        let row = vec![0.0; header.columns.len()];
        Self { header, row, is_first: true, last_time: None, wrapped: Vec::new() }
    }

    pub(super) fn header(&self) -> &Header {
        &self.header
    }

    pub(super) fn into_header(self) -> Header {
        self.header
    }

    /// The last row, in SI units.
    pub(super) fn row(&self) -> &[f64] {
        &self.row
    }

    /// Reads a row; returns false unless it has as many numbers as the header.
    pub(super) fn read(&mut self, text: &str, line: Line, messages: &mut Messages) -> bool {
        let width = self.header.columns.len();
        // The header is invalid, which has been reported.
        if width == 0 {
            return false;
        }
        let count = cells(text, line.clone()).count();
        if count != width {
            let message = format!("this row has {}, the header has {width}", numbers(count));
            messages.push("ragged", message, line, "the row");
            return false;
        }
        let places = self.header.columns.iter().zip(&mut self.row);
        for ((column, last), cell) in places.zip(cells(text, line)) {
            let value = match column.role {
                // The column is not used.
                Role::Unknown => 0.0,
                _ => read_number(text, &cell, messages).map_or(f64::NAN, |x| column.scale.apply(x)),
            };
            if column.role == Role::Time {
                check_time(value, self.last_time, &cell, messages);
                self.last_time = if value.is_nan() { self.last_time } else { Some(value) };
            }
            if column.is_angle && !self.is_first {
                check_turn(value - *last, &column.name, &cell, &mut self.wrapped, messages);
            }
            if value.abs() > LARGEST {
                let message = format!("{} is too large", number(value));
                messages.push("range", message, cell, "too large");
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

fn read_number(text: &str, cell: &Span, messages: &mut Messages) -> Option<f64> {
    let content = text.get(cell.clone()).unwrap_or_default();
    match content.parse::<f64>() {
        Ok(x) if x.is_finite() => Some(x),
        // Skip the wording of a message that is only counted.
        _ if messages.is_full() => {
            messages.push("syntax", String::new(), cell.clone(), "");
            None
        }
        Ok(_) => {
            let message = format!("{} is not a finite number", quoted(content));
            messages.push("not-finite", message, cell.clone(), "expected a finite number");
            None
        }
        Err(_) if content.is_empty() => {
            let message = "this cell is empty".to_owned();
            messages.push("syntax", message, cell.clone(), "expected a number");
            None
        }
        Err(_) => {
            let message = format!("{} is not a number", quoted(content));
            messages.push("syntax", message, cell.clone(), "expected a number");
            None
        }
    }
}

/// Reports an angle that changes by more than half a turn between samples, which shows that its
/// count was wrapped to one turn. One message per column.
fn check_turn(
    change: f64,
    name: &str,
    cell: &Span,
    wrapped: &mut Vec<String>,
    messages: &mut Messages,
) {
    // An invalid number has been reported already.
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
    let help = "continue angles beyond a full turn: 358, 360, 362 deg; multiply a rotation vector r by \
                1 - 2 pi/|r|";
    let label = "more than half a turn";
    messages.push_help("wrapped", message, cell.clone(), label, Some(help.to_owned()));
}

fn check_time(time: f64, last: Option<f64>, cell: &Span, messages: &mut Messages) {
    if let Some(last) = last
        && time <= last
    {
        let message =
            format!("time does not increase: {} s follows {} s", number(time), number(last));
        messages.push("samples", message, cell.clone(), "not later than the row above");
    }
}
