//! Lines and cells of a CSV file.

use crate::source::{Source, Span};

/// The bytes of a line.
pub(crate) type Line = Span;

/// All lines that are neither empty nor comments, without their ends.
pub(crate) fn lines(source: &Source) -> impl Iterator<Item = Line> + '_ {
    let text = source.text.as_str();
    let is_begin = source.begin().bytes == 0;
    let is_marked = is_begin && text.starts_with('\u{feff}');
    let mut at = if is_marked { '\u{feff}'.len_utf8() } else { 0 };
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
pub(crate) fn cells(text: &str, line: Line) -> impl Iterator<Item = Span> + '_ {
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
