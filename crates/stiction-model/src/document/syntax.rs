//! What is wrong with the text as TOML, in words that help.

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::source::{Place, Source, Span, boundary};
use std::sync::Arc;

/// Adds a diagnostic for every syntax error that is not the consequence of another, and gives the
/// lines in which there are any.
pub(super) fn report(
    source: &Arc<Source>,
    unclosed: &[Span],
    errors: Vec<toml::de::Error>,
    out: &mut Diagnostics,
) -> Vec<Span> {
    let text = source.text.as_str();
    let mut errors: Vec<(Span, String)> =
        errors.into_iter().map(|e| (e.span().unwrap_or(0..0), e.message().to_owned())).collect();
    for value in unclosed {
        let bracket = value.start..value.start + 1;
        let (what, close) =
            if text.get(bracket.clone()) == Some("{") { ("`{`", "`}`") } else { ("`[`", "`]`") };
        errors.push((bracket, format!("this {what} is never closed\u{0}with {close}")));
    }
    errors.sort_by_key(|(span, _)| span.start);

    let mut broken: Vec<Span> = Vec::new();
    for (span, message) in errors {
        // A second error in a line is mostly the echo of the first.
        if broken.last().is_some_and(|line| span.start <= line.end) {
            continue;
        }
        broken.push(line_around(text, span.start));
        let place = Place::new(source, span.clone());
        out.push(explain(place, text.get(span).unwrap_or_default(), &message));
    }
    broken.extend(unclosed.iter().cloned());
    broken.sort_by_key(|part| part.start);
    broken
}

fn line_around(text: &str, at: usize) -> Span {
    let at = boundary(text, at);
    let (before, after) = text.split_at(at);
    let start = before.rfind('\n').map_or(0, |newline| newline + 1);
    start..after.find('\n').map_or(text.len(), |newline| at + newline)
}

fn explain(place: Place, found: &str, message: &str) -> Diagnostic {
    let error =
        |message: &str, label: &str| Diagnostic::error("syntax", message).at(place.clone(), label);
    let found = found.trim();
    if message.starts_with("string values must be quoted") && !found.is_empty() {
        let truth = match found.to_lowercase().as_str() {
            "yes" | "true" | "on" => Some("true"),
            "no" | "false" | "off" => Some("false"),
            _ => None,
        };
        if let Some(truth) = truth {
            return error(&format!("`{found}` is not understood"), "not understood")
                .help(format!("write {truth}"));
        }
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
