//! Diagnostics: messages about an input text, with the place in the text and a suggested remedy.

mod render;
mod words;

pub use words::did_you_mean;
pub(crate) use words::{least, nearest, number, or, quoted};

use crate::source::{Place, Source};
use serde_json::{Value, json};
use std::fmt;
use std::sync::Arc;

/// Severity of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Error: the input is unusable.
    Error,
    /// Warning: the input is usable but suspicious. Warnings do not affect results.
    Warning,
}

/// A message about an input text or one place in it.
#[derive(Clone, Debug)]
pub struct Diagnostic {
    /// Severity: error or warning.
    pub severity: Severity,
    /// Kind of problem: a short identifier for programs and searches, such as `unknown-key`.
    pub code: &'static str,
    /// The problem, in one sentence without a full stop.
    pub message: String,
    /// Place in the text; `None` if the message concerns the whole text.
    pub place: Option<Place>,
    /// Short remark printed below the underlined text.
    pub label: String,
    /// Related places in the text, each with the remark printed below it.
    pub related: Vec<(Place, String)>,
    /// Suggested remedy.
    pub help: Option<String>,
}

impl Diagnostic {
    /// Creates an error with a code and a message, without a place.
    pub fn error(code: &'static str, message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Error,
            code,
            message: message.into(),
            place: None,
            label: String::new(),
            related: Vec::new(),
            help: None,
        }
    }

    pub(crate) fn warning(code: &'static str, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, message) }
    }

    /// Sets the place of the message, and the remark printed below the underlined text.
    pub fn at(mut self, place: Place, label: impl Into<String>) -> Self {
        (self.place, self.label) = (Some(place), label.into());
        self
    }

    pub(crate) fn also(mut self, place: Place, label: impl Into<String>) -> Self {
        self.related.push((place, label.into()));
        self
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Sets the suggested remedy; `None` removes it.
    pub fn maybe_help(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }

    /// True for an error, false for a warning.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// Converts the message to a JSON object with the keys `severity`, `code`, `message`, `label`
    /// and `help`. If the place is known, the object also has the keys `file`, `line`, `column`,
    /// `end_line` and `end_column`; lines and columns are counted from 1, columns in characters.
    pub fn to_json(&self) -> Value {
        let mut object = json!({
            "severity": match self.severity { Severity::Error => "error", Severity::Warning => "warning" },
            "code": self.code,
            "message": self.message,
            "label": self.label,
            "help": self.help,
        });
        if let (Some(place), Some(object)) = (&self.place, object.as_object_mut()) {
            let ((line, column), (end_line, end_column)) =
                (place.line_column(), place.end_line_column());
            object.insert("file".into(), json!(place.source.name));
            object.insert("line".into(), json!(line));
            object.insert("column".into(), json!(column));
            object.insert("end_line".into(), json!(end_line));
            object.insert("end_column".into(), json!(end_column));
        }
        object
    }

    /// Tests if `other` has the same message text and the same place as `self`.
    fn repeats(&self, other: &Self) -> bool {
        let place = |d: &Self| d.place.as_ref().map(|p| (Arc::as_ptr(&p.source), p.span.clone()));
        self.message == other.message && place(self) == place(other)
    }
}

/// Maximum number of messages that [`Diagnostics`] stores; further messages are only counted. This
/// limits the memory that a large file with many errors needs.
const MOST_KEPT: usize = 100;

/// All messages about an input.
///
/// `Display` writes plain text; [`Diagnostics::render`] can also write coloured text.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
    errors_omitted: usize,
    warnings_omitted: usize,
}

impl Diagnostics {
    /// Creates an empty list of messages.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a message unless the list already contains one with the same text and place. If the
    /// list is full, the message is only counted.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        if !self.is_full() {
            if !self.list.iter().any(|other| diagnostic.repeats(other)) {
                self.list.push(diagnostic);
            }
        } else if diagnostic.severity == Severity::Error {
            self.errors_omitted += 1;
        } else {
            self.warnings_omitted += 1;
        }
    }

    /// Tests if the list is full, so that further messages are only counted.
    pub(crate) fn is_full(&self) -> bool {
        self.list.len() >= MOST_KEPT
    }

    /// Adds all messages of `other`.
    pub fn append(&mut self, other: Self) {
        self.errors_omitted += other.errors_omitted;
        self.warnings_omitted += other.warnings_omitted;
        for diagnostic in other.list {
            self.push(diagnostic);
        }
    }

    /// Iterates over the stored messages in the order of the list.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.list.iter()
    }

    /// Tests if the list is empty.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Number of messages stored in the list.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Number of messages that were counted but not stored because the list was full.
    pub fn omitted(&self) -> usize {
        self.errors_omitted + self.warnings_omitted
    }

    /// Appends a sentence to the remedy of each message.
    pub(crate) fn explain(&mut self, reason: &str) {
        for diagnostic in &mut self.list {
            diagnostic.help = Some(match diagnostic.help.take() {
                Some(help) => format!("{help}; {reason}"),
                None => reason.to_owned(),
            });
        }
    }

    pub(crate) fn add_omitted_errors(&mut self, count: usize) {
        self.errors_omitted += count;
    }

    /// Tests if any message is an error, including messages that were only counted.
    pub fn has_errors(&self) -> bool {
        self.errors_omitted > 0 || self.list.iter().any(|d| d.severity == Severity::Error)
    }

    /// Sorts the messages by place: first by text, in the order in which the texts appear in the
    /// list, then by position in the text. Messages without a place come first.
    pub(crate) fn sort(&mut self) {
        let mut sources: Vec<*const Source> = Vec::new();
        for place in self.list.iter().filter_map(|d| d.place.as_ref()) {
            let source = Arc::as_ptr(&place.source);
            if !sources.contains(&source) {
                sources.push(source);
            }
        }
        self.list.sort_by_key(|d| {
            d.place.as_ref().map(|place| {
                let source = Arc::as_ptr(&place.source);
                let rank = sources.iter().position(|&s| s == source);
                (rank, place.span.start, place.span.end)
            })
        });
    }

    /// Renders the messages as text for a terminal, with the places underlined. `coloured` adds the
    /// escape sequences for colours.
    pub fn render(&self, coloured: bool) -> String {
        render::all(self, coloured)
    }

    /// Converts the messages to a JSON array of the objects that [`Diagnostic::to_json`] returns.
    pub fn to_json(&self) -> Value {
        Value::Array(self.list.iter().map(Diagnostic::to_json).collect())
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Diagnostics {}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self { list: vec![diagnostic], ..Self::default() }
    }
}

impl<'a> IntoIterator for &'a Diagnostics {
    type Item = &'a Diagnostic;
    type IntoIter = std::slice::Iter<'a, Diagnostic>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}
