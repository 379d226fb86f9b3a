//! The rows of a recording.

use super::super::context::LARGEST;
use super::Messages;
use super::header::{Header, Role};
use crate::diagnostic::{number, quoted};
use crate::source::Span;

/// The bytes of a line.
pub(super) type Line = Span;

/// All lines that are neither empty nor comments, without their ends.
pub(super) fn lines(text: &str) -> impl Iterator<Item = Line> + '_ {
    let mut at = if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
    std::iter::from_fn(move || {
        while at < text.len() {
            let rest = text.get(at..).unwrap_or_default();
            let length = rest.find('\n').unwrap_or(rest.len());
            let line = at..at + length;
            at += length + 1;
            let content = text.get(line.clone()).unwrap_or_default().trim();
            if !content.is_empty() && !content.starts_with('#') {
                return Some(line);
            }
        }
        None
    })
}

/// The cells of a line, without white space and quotes around them.
pub(super) fn cells(text: &str, line: Line) -> impl Iterator<Item = Span> + '_ {
    let mut at = line.start;
    text.get(line).unwrap_or_default().split(',').map(move |cell| {
        let start = at + cell.len() - cell.trim_start().len();
        at += cell.len() + 1;
        let cell = cell.trim();
        match cell.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')) {
            Some(inner) => start + 1..start + 1 + inner.len(),
            None => start..start + cell.len(),
        }
    })
}

/// The columns of numbers in SI units.
pub(super) fn read(
    text: &str,
    lines: impl Iterator<Item = Line>,
    header: &Header,
    messages: &mut Messages<'_>,
) -> Vec<Vec<f64>> {
    let width = header.columns.len();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); width];
    if width == 0 {
        return columns;
    }
    let mut last_time: Option<f64> = None;
    let mut wrapped: Vec<String> = Vec::new();
    for line in lines {
        let count = cells(text, line.clone()).count();
        if count != width {
            let message = format!("this row has {}, the header has {width}", numbers(count));
            messages.push("ragged", message, line, "the row");
            continue;
        }
        for (index, cell) in cells(text, line.clone()).enumerate() {
            let (Some(column), Some(values)) = (header.columns.get(index), columns.get_mut(index))
            else {
                continue;
            };
            let value = match column.role {
                // Whatever is in it, nobody will use it.
                Role::Unknown => 0.0,
                _ => read_number(text, &cell, messages).map_or(f64::NAN, |x| column.scale.apply(x)),
            };
            if column.role == Role::Time {
                check_time(value, last_time, &cell, messages);
                last_time = if value.is_nan() { last_time } else { Some(value) };
            }
            if let (true, Some(&last)) = (column.is_angle, values.last()) {
                check_turn(value - last, &column.name, &cell, &mut wrapped, messages);
            }
            if value.abs() > LARGEST {
                let message = format!("{} is too large", number(value));
                messages.push("range", message, cell, "too large to compute with");
            }
            values.push(value);
        }
    }
    columns
}

fn numbers(count: usize) -> String {
    if count == 1 { "1 column".to_owned() } else { format!("{count} columns") }
}

fn read_number(text: &str, cell: &Span, messages: &mut Messages<'_>) -> Option<f64> {
    let content = text.get(cell.clone()).unwrap_or_default();
    match content.parse::<f64>() {
        Ok(x) if x.is_finite() => Some(x),
        // No need to say in words what will not be shown.
        _ if messages.is_full() => {
            messages.push("syntax", String::new(), cell.clone(), "");
            None
        }
        Ok(_) => {
            let message = format!("{} is not a usable number", quoted(content));
            messages.push("not-finite", message, cell.clone(), "expected a finite number");
            None
        }
        Err(_) if content.is_empty() => {
            let message = "there is no number in this cell".to_owned();
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

/// No motion is recorded so coarsely that an angle changes by half a turn from one sample to the
/// next: its counting was begun anew. That is told once for each column.
fn check_turn(
    change: f64,
    name: &str,
    cell: &Span,
    wrapped: &mut Vec<String>,
    messages: &mut Messages<'_>,
) {
    if change.abs() <= std::f64::consts::PI || wrapped.iter().any(|known| known == name) {
        return;
    }
    wrapped.push(name.to_owned());
    let message = format!(
        "{} changes by {} deg from the sample before",
        quoted(name),
        number(change.to_degrees().round())
    );
    let help = "count on over full turns: 358, 360, 362 deg; of a rotation vector turn the whole \
                vector over, r to r (1 - 2 pi/|r|)";
    let label = "more than half a turn at once";
    messages.push_help("wrapped", message, cell.clone(), label, Some(help.to_owned()));
}

fn check_time(time: f64, last: Option<f64>, cell: &Span, messages: &mut Messages<'_>) {
    if let Some(last) = last
        && time <= last
    {
        let message =
            format!("time does not increase: {} s after {} s", number(time), number(last));
        messages.push("samples", message, cell.clone(), "not later than the row above");
    }
}
