//! Recovery from unclosed brackets, which would otherwise hide all later errors.

use crate::source::{Source, Span};
use std::borrow::Cow;
use toml::de::{DeTable, DeValue};

/// Maximum number of unclosed brackets that are repaired in one text.
const MAX_REPAIRS: usize = 8;

/// A repaired text. It has the length of the original text; values with unclosed brackets are
/// overwritten with `0` and spaces.
pub(super) struct Repaired<'a> {
    pub(super) text: Cow<'a, str>,
    /// Byte ranges that were overwritten, each from an unclosed bracket to the estimated end of its
    /// value.
    pub(super) unclosed: Vec<Span>,
}

/// Overwrites the values with unclosed brackets in the text of `source`, at most `MAX_REPAIRS`
/// values.
pub(super) fn close_brackets(source: &Source) -> Repaired<'_> {
    let mut repaired = Repaired { text: Cow::Borrowed(&source.text), unclosed: Vec::new() };
    while repaired.unclosed.len() < MAX_REPAIRS {
        // A valid text is the usual case, and this check is cheap.
        if DeTable::parse(&repaired.text).is_ok() {
            break;
        }
        let (root, errors) = DeTable::parse_recoverable(&repaired.text);
        let is_unclosed = |message: &str| {
            message.starts_with("unclosed array") || message.starts_with("unclosed inline table")
        };
        let ends = errors.iter().filter(|error| is_unclosed(error.message()));
        let ends: Vec<usize> = ends.filter_map(|error| Some(error.span()?.end)).collect();
        let Some(open) = opened(root.get_ref(), &ends) else { break };
        let value = open..end_of_value(&repaired.text, open);
        let text = blank(&repaired.text, &value);
        repaired.text = Cow::Owned(text);
        repaired.unclosed.push(value);
    }
    repaired
}

/// Byte offset of the first array or table whose end in the parser's tree is one of `ends`.
fn opened(root: &DeTable<'_>, ends: &[usize]) -> Option<usize> {
    let mut first = None;
    let mut pending: Vec<&toml::Spanned<DeValue<'_>>> = root.values().collect();
    while let Some(value) = pending.pop() {
        match value.get_ref() {
            DeValue::Array(list) => pending.extend(list.iter()),
            DeValue::Table(table) => pending.extend(table.values()),
            _ => continue,
        }
        let span = value.span();
        if span.start < span.end && ends.contains(&span.end) {
            first = Some(first.unwrap_or(span.start).min(span.start));
        }
    }
    first
}

/// Estimates the byte offset of the end of the unclosed value that begins at byte `open`. The value
/// is assumed to end before the next line that contains `=` or begins a table.
fn end_of_value(text: &str, open: usize) -> usize {
    let mut at = open;
    for (i, line) in text.get(open..).unwrap_or_default().split_inclusive('\n').enumerate() {
        // Rows of numbers or strings can belong to the value; a header such as `[joints.A]` cannot.
        let header = line.trim_start().strip_prefix('[').map(|rest| rest.trim_start_matches('['));
        let begins_table = header.is_some_and(|rest| rest.starts_with(char::is_alphabetic));
        if i > 0 && (line.contains('=') || begins_table) {
            break;
        }
        at += line.len();
    }
    open + text.get(open..at).unwrap_or_default().trim_end().len()
}

/// Overwrites a range of the text with `0` and spaces; line breaks are kept.
fn blank(text: &str, part: &Span) -> String {
    let (before, rest) = text.split_at_checked(part.start).unwrap_or((text, ""));
    let (inside, after) = rest.split_at_checked(part.len()).unwrap_or((rest, ""));
    let mut blank = String::with_capacity(text.len());
    blank.push_str(before);
    for (i, byte) in inside.bytes().enumerate() {
        blank.push(match byte {
            b'\n' => '\n',
            b'\r' => '\r',
            _ if i == 0 => '0',
            _ => ' ',
        });
    }
    blank.push_str(after);
    blank
}
