//! Parser of TOML text into a document tree that stores the place of each key and value. The parser
//! reports all syntax errors at once.

mod change;
mod change_leg;
mod repair;
mod syntax;
pub(crate) mod tree;

pub(crate) use change::{apply, segments};
pub(crate) use tree::{Key, Node, Table, Text, Value};

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::source::{Place, Source, Span};
use std::sync::Arc;
use toml::de::{DeInteger, DeTable, DeValue};

/// Maximum size of a model file, bytes.
const MOST_BYTES: usize = 2 << 20;
/// Maximum nesting depth; valid model files have five levels.
const MOST_LEVELS: usize = 32;

/// Formats the key of a table, with quotes where TOML requires them.
pub(crate) fn key(name: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    match !name.is_empty() && name.chars().all(plain) {
        true => name.to_owned(),
        false => toml::Value::from(name).to_string(),
    }
}

/// Document tree of a text. Parts of the text with syntax errors are missing in the tree.
#[derive(Clone, Debug)]
pub(crate) struct Document {
    pub(crate) root: Table,
    /// Byte ranges with syntax errors: whole lines, and values with unclosed brackets. Other errors
    /// in these ranges are likely consequences, and a name that seems undefined may be defined in
    /// them.
    pub(crate) broken: Vec<Span>,
}

/// Parses a document and applies the changes of its source. Adds errors to `out`; returns `None` if
/// the text is too large or contains a zero byte.
pub(crate) fn parse(source: &Arc<Source>, out: &mut Diagnostics) -> Option<Document> {
    let mut document = parse_unchanged(source, out)?;
    apply(source, &mut document, out);
    Some(document)
}

/// Parses a document without applying the changes of its source. Adds errors to `out`; returns
/// `None` if the text is too large or contains a zero byte.
pub(crate) fn parse_unchanged(source: &Arc<Source>, out: &mut Diagnostics) -> Option<Document> {
    let text = source.text.as_str();
    if text.len() > MOST_BYTES {
        let (size, limit) = (text.len() >> 20, MOST_BYTES >> 20);
        let message = format!("the file has {size} MiB; a model file has at most {limit} MiB");
        out.push(Diagnostic::error("syntax", message).at(Place::new(source, 0..0), "").help(
            "check the file name; long motions belong in a CSV file: `file = \"motion.csv\"`",
        ));
        return None;
    }
    if let Some(at) = text.find('\0') {
        out.push(
            Diagnostic::error("syntax", "this is not a text file")
                .at(Place::new(source, at..at + 1), "a zero byte")
                .help("a model is a TOML file in UTF-8"),
        );
        return None;
    }
    let repaired = repair::close_brackets(source);
    let (root, errors) = DeTable::parse_recoverable(&repaired.text);
    let root = Table { span: 0..0, entries: entries(root.get_ref(), text, 0) };
    let broken = syntax::report(source, &repaired.unclosed, errors, out);
    Some(Document { root, broken })
}

/// Returns the entries of a table in the order of the text; the TOML parser sorts them by key.
fn entries(table: &DeTable<'_>, text: &str, level: usize) -> Vec<(Key, Value)> {
    let mut entries: Vec<_> = table
        .iter()
        .map(|(key, value)| {
            let key = Key { name: key.get_ref().to_string(), span: key.span() };
            (key, convert(value, text, level + 1))
        })
        .collect();
    entries.sort_by_key(|(key, _)| key.span.start);
    entries
}

fn convert(value: &toml::Spanned<DeValue<'_>>, text: &str, level: usize) -> Value {
    let span = value.span();
    // Tables and lists that are nested too deeply become `Node::Other`, which the reader reports.
    let inside = level < MOST_LEVELS;
    let node = match value.get_ref() {
        DeValue::String(content) => {
            Node::Text(Text { start: start_of(content, text, &span), content: content.to_string() })
        }
        DeValue::Integer(integer) => Node::Number(integer_value(integer)),
        DeValue::Float(float) => Node::Number(float.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => Node::Flag(*flag),
        DeValue::Datetime(_) => Node::Other,
        DeValue::Array(list) if inside => {
            Node::List(list.iter().map(|item| convert(item, text, level + 1)).collect())
        }
        DeValue::Table(table) if inside => {
            Node::Table(Table { span: span.clone(), entries: entries(table, text, level) })
        }
        DeValue::Array(_) | DeValue::Table(_) => Node::Other,
    };
    Value { span, node }
}

fn integer_value(integer: &DeInteger<'_>) -> f64 {
    let digits = integer.as_str();
    match integer.radix() {
        // Integers beyond 64 bits are read as floating-point numbers.
        10 => digits.parse().unwrap_or(f64::NAN),
        radix => i128::from_str_radix(digits, radix).map_or(f64::INFINITY, |i| i as f64),
    }
}

/// Returns the byte offset of a string's content in the text; `None` if the string is written with
/// escapes. `span` is the byte range of the string with its quotes.
fn start_of(content: &str, text: &str, span: &Span) -> Option<usize> {
    let raw = text.get(span.clone())?;
    let quotes = if raw.starts_with("\"\"\"") || raw.starts_with("'''") {
        // A line break after the opening quotes does not belong to the content.
        let inner = raw.get(3..)?;
        3 + if inner.starts_with("\r\n") { 2 } else { usize::from(inner.starts_with('\n')) }
    } else {
        usize::from(raw.starts_with(['"', '\'']))
    };
    // After an escape the text differs from the content.
    raw.get(quotes..)?.starts_with(content).then_some(span.start + quotes)
}
