//! Splits text at separators outside quotes and brackets.

use crate::source::Span;

/// Splits a range at separators outside quotes and brackets, or at all separators if quotes or
/// brackets do not match.
pub(crate) fn split(text: &str, range: &Span, separator: char) -> Vec<Span> {
    split_outside(text, range, separator).unwrap_or_else(|| {
        let mut start = range.start;
        let content = text.get(range.clone()).unwrap_or_default();
        content
            .split(separator)
            .map(|part| {
                let span = start..start + part.len();
                start = span.end + separator.len_utf8();
                span
            })
            .collect()
    })
}

/// Splits a range at separators outside quotes and brackets; `None` if quotes or brackets do not
/// match.
pub(crate) fn split_outside(text: &str, range: &Span, separator: char) -> Option<Vec<Span>> {
    let mut parts = Vec::new();
    let (mut start, mut depth, mut quote) = (range.start, 0u32, None);
    for (at, c) in text.get(range.clone()).unwrap_or_default().char_indices() {
        let at = range.start + at;
        match (quote, c) {
            (Some(open), c) if open == c => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            (None, '(' | '[' | '{') => depth += 1,
            (None, ')' | ']' | '}') => depth = depth.checked_sub(1)?,
            (None, c) if c == separator && depth == 0 => {
                parts.push(start..at);
                start = at + c.len_utf8();
            }
            _ => {}
        }
    }
    parts.push(start..range.end);
    (depth == 0 && quote.is_none()).then_some(parts)
}
