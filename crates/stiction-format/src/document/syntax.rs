//! Explanations of TOML syntax errors.

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::source::{Place, Source, Span, boundary};
use std::sync::Arc;

/// Adds a diagnostic to `out` for every independent syntax error. Returns the byte ranges with
/// errors: the lines that contain errors, and the ranges of `unclosed`, which are values with
/// unclosed brackets.
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
        errors.push((bracket, format!("this {what} is not closed\u{0}with {close}")));
    }
    errors.sort_by_key(|(span, _)| span.start);

    if let Some(other) = other_language(source, !errors.is_empty()) {
        out.push(other);
        return errors.into_iter().map(|(span, _)| line_around(text, span.start)).collect();
    }
    let mut broken: Vec<Span> = Vec::new();
    let mut repeated_table = false;
    for (span, message) in errors {
        // A second error in the same line is usually a consequence of the first.
        if broken.last().is_some_and(|line| span.start <= line.end) {
            continue;
        }
        let line = line_around(text, span.start);
        let is_header =
            text.get(line.clone()).is_some_and(|line| line.trim_start().starts_with('['));
        broken.push(line);
        // The keys of a repeated table are usually repeated, too.
        if message == "duplicate key" && repeated_table && !is_header {
            continue;
        }
        repeated_table = message == "duplicate key" && is_header;
        if repeated_table {
            out.push(
                Diagnostic::error("syntax", "this table is defined twice")
                    .at(Place::new(source, span), "already defined")
                    .help("put all keys of the table under one header, or rename this table"),
            );
            continue;
        }
        let place = Place::new(source, span.clone());
        out.push(explain(place, text.get(span).unwrap_or_default(), &message));
    }
    broken.extend(unclosed.iter().cloned());
    broken.sort_by_key(|part| part.start);
    broken
}

/// Returns a diagnostic if the text has syntax errors (`is_wrong`) and looks like XML or JSON
/// instead of TOML.
fn other_language(source: &Arc<Source>, is_wrong: bool) -> Option<Diagnostic> {
    let text = source.text.as_str();
    let start = text.find(|c: char| !c.is_whitespace() && c != '\u{feff}')?;
    let language = match text.get(start..)?.chars().next()? {
        '<' => "XML (URDF, SDF, MJCF?)",
        '{' => "JSON",
        _ => return None,
    };
    let place = Place::new(source, start..start + 1);
    is_wrong.then(|| {
        Diagnostic::error("syntax", format!("this looks like {language}, not a model file"))
            .at(place, "not a key")
            .help("a model file is written in TOML; `stiction models` lists examples")
    })
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
        let what = if starts_like_a_number(found) { "quantities with a unit" } else { "strings" };
        return error(&format!("{what} must be quoted"), "no quotes")
            .help(format!("write \"{}\"", found.replace('"', "'")));
    }
    if message.starts_with("string values must be quoted") {
        return error("the value is missing", "expected a value")
            .help("write a number, or a quoted quantity such as \"20 mm\"");
    }
    if message.starts_with("invalid float") || message.starts_with("invalid integer") {
        return error("this is not a number", "not a number").help(format!(
            "if it is a quantity with a unit, write \"{}\"",
            found.replace('"', "'")
        ));
    }
    if message.starts_with("invalid boolean") {
        return error("this is neither `true` nor `false`", "not a value")
            .help(format!("if it is text, write \"{}\"", found.replace('"', "'")));
    }
    if message == "duplicate key" {
        return error("this key is used twice in the same table", "already used")
            .help("rename or delete one of the two");
    }
    if let Some((what, close)) = message.split_once('\u{0}') {
        return error(what, "opened here").help(format!("close it {close}"));
    }
    if message.starts_with("unexpected key or value") {
        return error("unexpected text after the value", "expected the end of the line")
            .help("write one `key = value` per line, decimals with a point, and quantities with a unit in quotes");
    }
    if message.starts_with("cannot extend value of type inline table") {
        return error("a table in braces cannot be extended", "extension of a complete table")
            .help("write this key inside the braces, or the whole table as a [header] with keys");
    }
    if message.starts_with("cannot recurse further") || message.starts_with("recursion limit") {
        return error("this is nested too deeply", "too deep");
    }
    if message.starts_with("key with no value") || message.starts_with("invalid unquoted key") {
        let is_letter = found.starts_with(char::is_alphabetic);
        return match is_letter {
            true => error(
                "unquoted keys consist of letters a to z, digits, `_` and `-`",
                "other letter",
            )
            .help("put the whole key in quotes, or use only these characters"),
            false => error("the `=` between key and value is missing", "expected `=`")
                .help("write `key = value`"),
        };
    }
    if message.starts_with("invalid basic string") || message.starts_with("invalid literal string")
    {
        return error(
            "this string is not closed, or contains an invalid `\\`",
            "the string ends here",
        )
        .help("close it on the same line with the quote that opens it");
    }
    if message.starts_with("unclosed table") {
        return error("this header is not closed", "expected `]`").help("close it with `]`");
    }
    let message = message.trim_end_matches(", expected nothing");
    error(&format!("this is not TOML: {message}"), "")
}

fn starts_like_a_number(text: &str) -> bool {
    text.trim_start_matches(['+', '-', '.']).starts_with(|c: char| c.is_ascii_digit())
}
