//! What is wrong with the text as TOML, in words that help.

use super::tree::{Node, Table, Value};
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::source::{Place, Source, Span};
use std::sync::Arc;

/// Adds a diagnostic for every syntax error that is not the consequence of another.
pub(super) fn report(
    source: &Arc<Source>,
    table: &Table,
    errors: Vec<toml::de::Error>,
    out: &mut Diagnostics,
) {
    let text = source.text.as_str();
    let mut errors: Vec<(Span, String)> =
        errors.into_iter().map(|e| (e.span().unwrap_or(0..0), e.message().to_owned())).collect();
    // What was read as inside an unclosed bracket was probably not meant to be there.
    let unclosed: Vec<Span> = errors
        .iter()
        .filter(|(_, message)| {
            message.starts_with("unclosed array") || message.starts_with("unclosed inline table")
        })
        .filter_map(|(span, _)| opened_before(table, span.end))
        .collect();
    errors.retain(|(span, _)| {
        !unclosed.iter().any(|open| open.start <= span.start && span.end <= open.end)
    });
    for open in unclosed {
        let bracket = open.start..open.start + 1;
        let (what, close) =
            if text.get(bracket.clone()) == Some("{") { ("`{`", "`}`") } else { ("`[`", "`]`") };
        errors.push((bracket, format!("this {what} is never closed\u{0}with {close}")));
    }
    errors.sort_by_key(|(span, _)| span.start);

    let mut last_line = None;
    for (span, message) in errors {
        let place = Place::new(source, span.clone());
        let (line, _) = place.line_column();
        // A second error in a line is mostly the echo of the first.
        if last_line.replace(line) == Some(line) {
            continue;
        }
        out.push(explain(place, text.get(span).unwrap_or_default(), &message));
    }
}

/// The outermost list or table that the parser took to end at `end`.
fn opened_before(table: &Table, end: usize) -> Option<Span> {
    let mut best: Option<Span> = None;
    let mut pending: Vec<&Value> = table.entries.iter().map(|(_, value)| value).collect();
    while let Some(value) = pending.pop() {
        match &value.node {
            Node::List(list) => pending.extend(list),
            Node::Table(table) => pending.extend(table.entries.iter().map(|(_, value)| value)),
            _ => continue,
        }
        let outermost = best.as_ref().is_none_or(|best| value.span.start < best.start);
        if value.span.end == end && outermost {
            best = Some(value.span.clone());
        }
    }
    best
}

fn explain(place: Place, found: &str, message: &str) -> Diagnostic {
    let error =
        |message: &str, label: &str| Diagnostic::error("syntax", message).at(place.clone(), label);
    let found = found.trim();
    if message.starts_with("string values must be quoted") && !found.is_empty() {
        let what = if starts_like_a_number(found) { "quantities with a unit" } else { "words" };
        return error(&format!("{what} stand between quotes"), "no quotes")
            .help(format!("write \"{}\"", found.replace('"', "'")));
    }
    if message.starts_with("string values must be quoted") {
        return error("there is no value", "nothing stands here")
            .help("a number, or a quantity between quotes such as \"20 mm\"");
    }
    if message.starts_with("invalid float") || message.starts_with("invalid integer") {
        return error("this is not a number", "not a number").help(format!(
            "if it is a quantity with a unit, write \"{}\"",
            found.replace('"', "'")
        ));
    }
    if message.starts_with("invalid boolean") {
        return error("this is neither `true` nor `false`", "not a value")
            .help(format!("if it is a word, write \"{}\"", found.replace('"', "'")));
    }
    if message == "duplicate key" {
        return error("this name is used twice in the same table", "used already")
            .help("give it another name, or delete one of the two");
    }
    if let Some((what, close)) = message.split_once('\u{0}') {
        return error(what, "opened here").help(format!("close it {close}"));
    }
    if message.starts_with("unexpected key or value") {
        return error("the line should end here", "this is too much")
            .help("one `key = value` a line; decimals have a point; quantities with a unit stand between quotes");
    }
    if message.starts_with("cannot recurse further") || message.starts_with("recursion limit") {
        return error("this is nested too deeply", "too deep");
    }
    let message = message.trim_end_matches(", expected nothing");
    error(&format!("this is not TOML: {message}"), "")
}

fn starts_like_a_number(text: &str) -> bool {
    text.trim_start_matches(['+', '-', '.']).starts_with(|c: char| c.is_ascii_digit())
}
