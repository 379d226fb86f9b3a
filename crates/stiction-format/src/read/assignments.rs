//! Reads assignments in one line, such as `platform.x = 5 mm*sin(2*pi*t); duration = 2 s`, as a
//! table.

use super::context::Context;
use crate::diagnostic::{Diagnostic, quoted};
use crate::document::{Key, Node, Table, Text, Value};
use crate::separated::split;
use crate::source::Span;

/// Reads all assignments in the context's text into a table. Names with dots address nested tables,
/// as in TOML; values are strings or lists of strings.
pub(crate) fn read(context: &Context<'_>) -> Table {
    let text = context.source.text.as_str();
    let mut table = Table { span: 0..text.len(), entries: Vec::new() };
    for statement in split(text, &(0..text.len()), ';') {
        let part = trimmed(text, statement);
        if part.is_empty() {
            continue;
        }
        let content = text.get(part.clone()).unwrap_or_default();
        let Some(equals) = content.find('=') else {
            context.push(
                Diagnostic::error("syntax", "this is not an assignment")
                    .at(context.place(&part), "expected `name = value`")
                    .help("separate assignments by `;`: platform.x = 5 mm*t; duration = 2 s"),
            );
            continue;
        };
        let key = trimmed(text, part.start..part.start + equals);
        let value = trimmed(text, part.start + equals + 1..part.end);
        if key.is_empty() || value.is_empty() {
            let (span, what) = if key.is_empty() { (part, "name") } else { (key, "value") };
            context.push(
                Diagnostic::error("syntax", format!("this assignment has no {what}"))
                    .at(context.place(&span), format!("the {what} is missing"))
                    .help("write `name = value`, as in `A = 60 deg`"),
            );
            continue;
        }
        let value = read_value(text, value);
        if let Err(Conflict { first, of }) = insert(&mut table, segments(text, &key), value) {
            let name = quoted(text.get(key.clone()).unwrap_or_default());
            let (message, here, help) = match of {
                Overlap::Name => {
                    (format!("{name} is given twice"), "again here", "give each name once")
                }
                Overlap::EarlierParts => (
                    format!("{name} cannot be given together with its parts"),
                    "this name",
                    "give either the whole or its parts",
                ),
                Overlap::EarlierWhole => (
                    format!("{name} cannot be given together with the whole"),
                    "this part",
                    "give either the whole or its parts",
                ),
            };
            context.push(
                Diagnostic::error("duplicate", message)
                    .at(context.place(&key), here)
                    .also(context.place(&first), "first here")
                    .help(help),
            );
        }
    }
    table
}

/// Splits a dotted name at its dots.
fn segments(text: &str, key: &Span) -> Vec<Key> {
    split(text, key, '.')
        .into_iter()
        .map(|segment| {
            let span = trimmed(text, segment);
            let name = text.get(span.clone()).unwrap_or_default().trim_matches(['"', '\'']);
            Key { name: name.to_owned(), span }
        })
        .collect()
}

/// Earlier name with which a name cannot be given, and what the two have in common.
struct Conflict {
    first: Span,
    of: Overlap,
}

enum Overlap {
    /// Both names are equal.
    Name,
    /// The earlier names are parts of the name, as `j.angle` is a part of `j`.
    EarlierParts,
    /// The name is a part of the earlier name.
    EarlierWhole,
}

/// Inserts a value under a dotted name, given as a path of keys.
///
/// # Errors
/// If this name, a part of it or its whole already has a value.
fn insert(table: &mut Table, path: Vec<Key>, value: Value) -> Result<(), Conflict> {
    let mut table = table;
    let mut path = path.into_iter().peekable();
    let mut value = Some(value);
    while let Some(key) = path.next() {
        let known = table.entries.iter().position(|(known, _)| known.name == key.name);
        let span = key.span.clone();
        let last = path.peek().is_none();
        let index = match known {
            Some(index) => index,
            None => {
                let node = Node::Table(Table { span: span.clone(), entries: Vec::new() });
                let inner = Value { span: span.clone(), node };
                let new = if last { value.take().unwrap_or(inner) } else { inner };
                table.entries.push((key, new));
                table.entries.len() - 1
            }
        };
        match table.entries.get_mut(index).map(|(first, value)| (first, &mut value.node)) {
            Some((first, node)) if last && known.is_some() => {
                let of = if matches!(node, Node::Table(_)) {
                    Overlap::EarlierParts
                } else {
                    Overlap::Name
                };
                return Err(Conflict { first: first.span.clone(), of });
            }
            Some((_, Node::Table(inner))) => table = inner,
            Some((first, _)) if !last => {
                return Err(Conflict { first: first.span.clone(), of: Overlap::EarlierWhole });
            }
            _ => break,
        }
    }
    Ok(())
}

fn read_value(text: &str, span: Span) -> Value {
    let content = text.get(span.clone()).unwrap_or_default();
    let node = match content.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
        Some(inner) => {
            let inner = span.start + 1..span.start + 1 + inner.len();
            let items = split(text, &inner, ',').into_iter().map(|item| trimmed(text, item));
            let items: Vec<_> = items.filter(|item| !item.is_empty()).collect();
            Node::List(items.into_iter().map(|item| string(text, item)).collect())
        }
        None => return string(text, span),
    };
    Value { span, node }
}

/// Reads a string, with or without quotes.
fn string(text: &str, span: Span) -> Value {
    let content = text.get(span.clone()).unwrap_or_default();
    let quote = content.chars().next().filter(|c| matches!(c, '"' | '\''));
    let inner = quote
        .and_then(|quote| content.strip_prefix(quote)?.strip_suffix(quote))
        .map_or((content, span.start), |inner| (inner, span.start + 1));
    let node = Node::Text(Text { content: inner.0.to_owned(), start: Some(inner.1) });
    Value { span, node }
}

/// Returns the range without the white space at both ends of its text.
fn trimmed(text: &str, range: Span) -> Span {
    let content = text.get(range.clone()).unwrap_or_default();
    let start = range.start + content.len() - content.trim_start().len();
    start..start + content.trim().len()
}
