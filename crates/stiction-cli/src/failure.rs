//! Failures of the program: their text, their JSON and their exit codes.

use crate::fold::folded;
use crate::manners;
use serde_json::json;
use std::process::ExitCode;
use stiction::{Error, ErrorKind};

/// An error and its output format, text or JSON.
#[derive(Debug)]
pub(crate) struct Failure {
    error: Error,
    json: bool,
}

impl Failure {
    /// Failure for invalid input.
    pub(crate) fn input(message: impl Into<String>) -> Self {
        Error::input(message).into()
    }

    /// Failure for a problem without a solution.
    pub(crate) fn no_answer(message: impl Into<String>) -> Self {
        Error::no_answer(message).into()
    }

    /// Failure for an interruption by the user, without results.
    pub(crate) fn interrupted() -> Self {
        Error::interrupted("interrupted; nothing was written").into()
    }

    /// Sets the suggestion.
    pub(crate) fn help(self, text: impl Into<String>) -> Self {
        Self { error: self.error.with_help(text), ..self }
    }

    /// Sets the machine-readable details of the message.
    pub(crate) fn details(self, value: serde_json::Value) -> Self {
        Self { error: self.error.with_details(value), ..self }
    }

    /// Chooses between JSON on standard output and text on standard error.
    pub(crate) fn into_json(self, json: bool) -> Self {
        Self { json, ..self }
    }

    /// Prints the failure: text on standard error, or JSON on standard output.
    pub(crate) fn print(&self) {
        if self.json {
            let text = format!("{:#}\n", json!({ "error": self.error.to_json() }));
            // Standard error may still be open if standard output is closed.
            if let Err(failure) = crate::print(&text) {
                failure.print();
            }
            return;
        }
        match self.error.diagnostics() {
            Some(diagnostics) => {
                let text = diagnostics.render(manners::coloured());
                message!("{}", text.trim_end_matches('\n'));
            }
            None => {
                let mut text = format!("error: {}", self.error.message());
                if let Some(help) = self.error.help() {
                    text += &format!("\nhelp: {help}");
                    if let Some(option) = self.error.option() {
                        text += &format!(" (option --{option})");
                    }
                }
                message!("{}", folded(&text));
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
