//! Explanations of TOML syntax errors.

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::source::{Place, Source, Span, boundary};
use std::sync::Arc;

/// Adds a diagnostic for every independent syntax error and returns the lines that contain errors.
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
                Diagnostic::error("syntax", "this table is there twice")
                    .at(Place::new(source, span), "there already")
                    .help(
                        "put all keys of a table under one header, or give this one another name",
                    ),
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

/// Diagnostic for a text in a language other than TOML.
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
        Diagnostic::error("syntax", format!("this looks like {language}, not like a model file"))
            .at(place, "no key can begin like this")
            .help("a model is a TOML file: `stiction models` lists examples")
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
    if message.starts_with("cannot extend value of type inline table") {
        return error("a table between braces is complete", "this comes too late")
            .help("write it between the braces, or all of it as [table] and keys");
    }
    if message.starts_with("cannot recurse further") || message.starts_with("recursion limit") {
        return error("this is nested too deeply", "too deep");
    }
    if message.starts_with("key with no value") || message.starts_with("invalid unquoted key") {
        let is_letter = found.starts_with(char::is_alphabetic);
        return match is_letter {
            true => error("such letters need quotes in a name", "not a to z")
                .help("write the whole name between quotes, or with other letters"),
            false => error("there is no `=` between a name and its value", "expected `=`")
                .help("write `key = value`"),
        };
    }
    if message.starts_with("invalid basic string") || message.starts_with("invalid literal string")
    {
        return error("this text is never closed, or has a wrong `\\` in it", "the text ends here")
            .help("close it with the quote it begins with, in the same line");
    }
    if message.starts_with("unclosed table") {
        return error("this header is never closed", "expected `]`").help("close it with `]`");
    }
    let message = message.trim_end_matches(", expected nothing");
    error(&format!("this is not TOML: {message}"), "")
}

fn starts_like_a_number(text: &str) -> bool {
    text.trim_start_matches(['+', '-', '.']).starts_with(|c: char| c.is_ascii_digit())
}
