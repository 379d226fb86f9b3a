//! The error type of the library.

use serde_json::{Value, json};
use std::fmt;
use stiction_format::Diagnostics;

/// Reason why a computation has no result: a message with its place, the relevant numbers, and a
/// suggestion.
///
/// `Display` and `Debug` both print the message with its suggestion and, if it concerns a model
/// file, the underlined place, so that a program whose `main` returns this error prints it
/// readably.
pub struct Error(Box<Content>);

struct Content {
    kind: ErrorKind,
    message: Message,
}

enum Message {
    /// A message with an optional suggestion and the relevant numbers.
    Plain { text: String, help: Option<String>, option: Option<&'static str>, details: Value },
    /// Messages that refer to places in a model file or in another text.
    Diagnostics(Diagnostics),
}

/// Class of an [`Error`], which determines the exit code of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The input cannot be used: an unknown name, a defective model, a file that cannot be read.
    Input,
    /// The problem has no solution: a singular position, a mechanism that jams, a loop that cannot close.
    NoAnswer,
    /// The caller stopped the computation.
    Interrupted,
    /// A receiver of the results failed, for example because a disk was full.
    Output,
}

impl Error {
    /// Creates an error with a message: a sentence without a full stop.
    pub fn new(kind: ErrorKind, message: impl Into<String>) -> Self {
        let message =
            Message::Plain { text: message.into(), help: None, option: None, details: Value::Null };
        Self(Box::new(Content { kind, message }))
    }

    /// Creates an error of kind [`ErrorKind::Input`].
    pub fn input(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Input, message)
    }

    /// Creates an error of kind [`ErrorKind::NoAnswer`].
    pub fn no_answer(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::NoAnswer, message)
    }

    /// Creates an error of kind [`ErrorKind::Interrupted`].
    pub fn interrupted(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Interrupted, message)
    }

    /// Sets the suggestion. The suggestions of diagnostics do not change.
    pub fn with_help(mut self, suggestion: impl Into<String>) -> Self {
        if let Message::Plain { help, .. } = &mut self.0.message {
            *help = Some(suggestion.into());
        }
        self
    }

    /// Names the option that can avoid the error: a method of the request, or, with leading dashes, an option of the
    /// command line.
    pub fn with_option(mut self, name: &'static str) -> Self {
        if let Message::Plain { option, .. } = &mut self.0.message {
            *option = Some(name);
        }
        self
    }

    /// Appends a line to the message.
    pub fn with_note(mut self, note: impl fmt::Display) -> Self {
        if let Message::Plain { text, .. } = &mut self.0.message {
            *text += &format!("\n  {note}");
        }
        self
    }

    /// Sets the relevant numbers, a JSON object in SI units.
    pub fn with_details(mut self, numbers: Value) -> Self {
        if let Message::Plain { details, .. } = &mut self.0.message {
            *details = numbers;
        }
        self
    }

    /// Class of the error.
    pub fn kind(&self) -> ErrorKind {
        self.0.kind
    }

    /// The message without the suggestion; for diagnostics, their whole text.
    pub fn message(&self) -> String {
        match &self.0.message {
            Message::Plain { text, .. } => text.clone(),
            Message::Diagnostics(diagnostics) => diagnostics.render(false).trim_end().to_owned(),
        }
    }

    /// The suggestion, if the error has one. Diagnostics have their own suggestions.
    pub fn help(&self) -> Option<&str> {
        match &self.0.message {
            Message::Plain { help, .. } => help.as_deref(),
            Message::Diagnostics(_) => None,
        }
    }

    /// Name of the option that can avoid the error, if there is one.
    pub fn option(&self) -> Option<&'static str> {
        match self.0.message {
            Message::Plain { option, .. } => option,
            Message::Diagnostics(_) => None,
        }
    }

    /// The messages with their places in the text, if the error is about a text.
    pub fn diagnostics(&self) -> Option<&Diagnostics> {
        match &self.0.message {
            Message::Plain { .. } => None,
            Message::Diagnostics(diagnostics) => Some(diagnostics),
        }
    }

    /// The error as a JSON object: `kind`, and either `diagnostics` or `message`, `help`, `option` and
    /// `details`.
    pub fn to_json(&self) -> Value {
        let kind = match self.0.kind {
            ErrorKind::Input => "input",
            ErrorKind::NoAnswer => "no-answer",
            ErrorKind::Interrupted => "interrupted",
            ErrorKind::Output => "output",
        };
        match &self.0.message {
            Message::Plain { text, help, option, details } => json!({
                "kind": kind, "message": text, "help": help, "option": option, "details": details,
            }),
            Message::Diagnostics(diagnostics) => {
                json!({ "kind": kind, "diagnostics": diagnostics.to_json() })
            }
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message())?;
        match (self.help(), self.option()) {
            (Some(help), Some(option)) => write!(f, "\nhelp: {help} (option `{option}`)"),
            (Some(help), None) => write!(f, "\nhelp: {help}"),
            (None, _) => Ok(()),
        }
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Error {}

impl From<Diagnostics> for Error {
    fn from(diagnostics: Diagnostics) -> Self {
        let message = Message::Diagnostics(diagnostics);
        Self(Box::new(Content { kind: ErrorKind::Input, message }))
    }
}
