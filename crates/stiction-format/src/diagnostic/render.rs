//! Rendering of diagnostics as text, with the places underlined in excerpts of the input.

use super::{Diagnostic, Diagnostics, Severity};
use crate::source::{Place, boundary};
use annotate_snippets::{Annotation, AnnotationKind, Element, Level, Origin, Renderer, Snippet};
use std::sync::Arc;

/// Maximum length, in bytes, of a line shown in an excerpt. If a line is longer (minified files),
/// only the position is printed.
const LONGEST_LINE: usize = 500;
/// Maximum number of lines in an excerpt that shows several places.
const MOST_LINES: usize = 200;

pub(super) fn all(diagnostics: &Diagnostics, coloured: bool) -> String {
    let renderer = if coloured { Renderer::styled() } else { Renderer::plain() };
    let mut text = String::new();
    for diagnostic in diagnostics {
        text.push_str(&one(&renderer, diagnostic));
        text.push_str("\n\n");
    }
    match diagnostics.omitted() {
        0 => {
            text.pop();
        }
        1 => text.push_str("… and one more message\n"),
        n => text.push_str(&format!("… and {n} more messages\n")),
    }
    text
}

fn one(renderer: &Renderer, diagnostic: &Diagnostic) -> String {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let mut elements: Vec<Element<'_>> = Vec::new();
    if let Some(place) = &diagnostic.place {
        let mut annotations =
            vec![Annotated { place, label: &diagnostic.label, kind: AnnotationKind::Primary }];
        for (place, label) in &diagnostic.related {
            annotations.push(Annotated { place, label, kind: AnnotationKind::Context });
        }
        elements.extend(excerpts(&annotations));
    }
    if let Some(help) = &diagnostic.help {
        elements.push(Level::HELP.message(help.as_str()).into());
    }
    let title = level.primary_title(diagnostic.message.as_str()).id(diagnostic.code);
    let group = title.elements(elements);
    renderer.render(&[group])
}

struct Annotated<'a> {
    place: &'a Place,
    label: &'a str,
    kind: AnnotationKind,
}

/// The line of text in which a place begins: byte offsets of the start and end of the line, and the
/// byte range to underline in the line.
struct Line {
    start: usize,
    end: usize,
    underline: std::ops::Range<usize>,
}

fn line_of(place: &Place) -> Line {
    let text = place.source.text.as_str();
    let from = boundary(text, place.span.start);
    let start = text.get(..from).and_then(|t| t.rfind('\n')).map_or(0, |newline| newline + 1);
    let rest = text.get(from..).unwrap_or_default();
    let end = from + rest.find('\n').unwrap_or(rest.len());
    let end = start + text.get(start..end).unwrap_or_default().trim_end_matches('\r').len();
    let from = from.min(end);
    let to = boundary(text, place.span.end).clamp(from, end);
    Line { start, end, underline: from..to }
}

/// Creates the excerpts that show the annotated places. Places of the same text that are close to
/// each other share one excerpt.
fn excerpts<'a>(annotations: &[Annotated<'a>]) -> Vec<Element<'a>> {
    let mut elements = Vec::new();
    let mut done = vec![false; annotations.len()];
    for (i, underline) in annotations.iter().enumerate() {
        if std::mem::replace(&mut done[i], true) {
            continue;
        }
        let text = underline.place.source.text.as_str();
        let first = line_of(underline.place);
        let (mut from, mut to) = (first.start, first.end);
        let mut members = vec![(underline, first)];
        for (k, other) in annotations.iter().enumerate().skip(i + 1) {
            if done[k] || !Arc::ptr_eq(&other.place.source, &underline.place.source) {
                continue;
            }
            let line = line_of(other.place);
            let (low, high) = (from.min(line.start), to.max(line.end));
            let between = text.get(low..high).unwrap_or_default();
            if between.lines().take(MOST_LINES + 1).count() <= MOST_LINES {
                (from, to) = (low, high);
                members.push((other, line));
                done[k] = true;
            }
        }
        elements.push(excerpt(text, from, to, &members));
    }
    elements
}

fn excerpt<'a>(
    text: &'a str,
    from: usize,
    to: usize,
    members: &[(&Annotated<'a>, Line)],
) -> Element<'a> {
    let underline = members[0].0;
    let name = underline.place.source.name.as_str();
    let (line, column) = underline.place.line_column();
    let shown = text.get(from..to).unwrap_or_default();
    if underline.place.is_whole() {
        return Origin::path(name).into();
    }
    if shown.lines().any(|line| line.len() > LONGEST_LINE) {
        return Origin::path(name).line(line).char_column(column).into();
    }
    // A byte order mark does not count as a character.
    let skipped = if shown.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
    let from = from + skipped;
    let shown = shown.get(skipped..).unwrap_or_default();
    let before = text.get(..from).unwrap_or_default();
    let above = underline.place.source.begin().lines;
    let line_start = above + before.bytes().filter(|&b| b == b'\n').count() + 1;
    let annotation = |(underline, line): &(&Annotated<'a>, Line)| -> Annotation<'a> {
        let start = line.underline.start.saturating_sub(from);
        let end = line.underline.end.saturating_sub(from).max(start);
        let label = Some(underline.label).filter(|label| !label.is_empty());
        underline.kind.span(start..end).label(label)
    };
    Snippet::source(shown)
        .line_start(line_start)
        .path(name)
        .annotations(members.iter().map(annotation))
        .into()
}
