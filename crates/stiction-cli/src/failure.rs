//! Failures of the program: their text, their JSON and their exit codes.

use serde_json::json;
use std::io::IsTerminal;
use std::process::ExitCode;
use stiction::{Error, ErrorKind};

/// An error, with the form in which the user asked for it.
#[derive(Debug)]
pub(crate) struct Failure {
    error: Error,
    json: bool,
}

impl Failure {
    /// A failure because the input cannot be used.
    pub(crate) fn input(message: impl Into<String>) -> Self {
        Error::input(message).into()
    }

    /// A failure because the question has no answer.
    pub(crate) fn no_answer(message: impl Into<String>) -> Self {
        Error::no_answer(message).into()
    }

    /// A failure because the user stopped the program, without results.
    pub(crate) fn interrupted() -> Self {
        Error::interrupted("interrupted; nothing was written").into()
    }

    /// Sets the suggestion.
    pub(crate) fn help(self, text: impl Into<String>) -> Self {
        Self { error: self.error.with_help(text), ..self }
    }

    /// Sets the numbers behind the message, for programs.
    pub(crate) fn details(self, value: serde_json::Value) -> Self {
        Self { error: self.error.with_details(value), ..self }
    }

    /// Chooses between JSON on standard output and text on standard error.
    pub(crate) fn as_json(self, json: bool) -> Self {
        Self { json, ..self }
    }

    /// Prints the failure: text on standard error, or JSON on standard output.
    pub(crate) fn print(&self) {
        if self.json {
            let text = format!("{:#}\n", json!({ "error": self.error.to_json() }));
            // Where standard output is closed, standard error may still be read.
            if let Err(failure) = crate::print(&text) {
                failure.print();
            }
            return;
        }
        match self.error.diagnostics() {
            Some(diagnostics) => {
                let colour =
                    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
                message!("{}", diagnostics.render(colour).trim_end_matches('\n'));
            }
            None => {
                message!("error: {}", self.error.message());
                match (self.error.help(), self.error.option()) {
                    (Some(help), Some(option)) => message!("help: {help} (option --{option})"),
                    (Some(help), None) => message!("help: {help}"),
                    (None, _) => {}
                }
            }
        }
    }

    pub(crate) fn exit_code(&self) -> ExitCode {
        match self.error.kind() {
            ErrorKind::NoAnswer => ExitCode::from(1),
            ErrorKind::Interrupted => ExitCode::from(130),
            _ => ExitCode::from(2),
        }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.error.message())
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self { error, json: false }
    }
}
