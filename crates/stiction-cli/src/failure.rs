//! Failures of the program, as text or JSON, and their exit codes.

use crate::fold::{folded, folded_diagnostics};
use crate::manners;
use serde_json::json;
use std::process::ExitCode;
use stiction::{Error, ErrorKind};

/// Error of the program, with the format in which it is printed: text or JSON.
#[derive(Debug)]
pub(crate) struct Failure {
    error: Error,
    json: bool,
    /// Description of the run or model that failed, if the command has several runs or models.
    run: Option<String>,
    /// Lines of the message after the first one.
    notes: Vec<String>,
}

impl Failure {
    /// Creates a failure for invalid input.
    pub(crate) fn input(message: impl Into<String>) -> Self {
        Error::input(message).into()
    }

    /// Creates a failure for a problem without a solution.
    pub(crate) fn no_answer(message: impl Into<String>) -> Self {
        Error::no_answer(message).into()
    }

    /// Creates a failure for an interruption by the user, without results.
    pub(crate) fn interrupted() -> Self {
        Error::interrupted("interrupted; nothing was written").into()
    }

    /// Adds a suggestion to the user.
    pub(crate) fn help(self, text: impl Into<String>) -> Self {
        Self { error: self.error.with_help(text), ..self }
    }

    /// Adds a description of the run or model that failed, for commands with several runs or
    /// models.
    pub(crate) fn in_run(self, run: impl Into<String>) -> Self {
        Self { run: Some(run.into()), ..self }
    }

    /// Adds a further line to the message.
    pub(crate) fn note(mut self, line: impl Into<String>) -> Self {
        self.notes.push(line.into());
        self
    }

    /// Selects the output: JSON on standard output if `json` is true, else text on standard error.
    pub(crate) fn into_json(self, json: bool) -> Self {
        Self { json, ..self }
    }

    /// Prints the failure: text on standard error, or JSON on standard output, with the result of
    /// the command, if it is known.
    pub(crate) fn print(&self) {
        if self.json {
            let mut error = self.error.to_json();
            if let Some(run) = &self.run {
                error["run"] = json!(run);
            }
            if !self.notes.is_empty() {
                error["notes"] = json!(self.notes);
            }
            let mut object =
                crate::answer::take().unwrap_or_else(|| crate::answer::with_warnings(json!({})));
            object["error"] = error;
            let text = format!("{object:#}\n");
            // Standard error may still be open if standard output is closed.
            if let Err(failure) = crate::print(&text) {
                failure.print();
            }
            return;
        }
        let run = self.run.as_ref().map_or(String::new(), |run| format!("{run}: "));
        let notes = || self.notes.iter().map(|note| format!("\n  {note}")).collect::<String>();
        match self.error.diagnostics() {
            Some(diagnostics) => {
                if self.run.is_some() {
                    message!("{}", folded(run.trim_end()));
                }
                let text = folded_diagnostics(&diagnostics.render(manners::coloured()));
                message!("{}{}", text.trim_end_matches('\n'), folded(&notes()));
            }
            None => {
                let mut text = format!("error: {run}{}{}", self.error.message(), notes());
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
        Self { error, json: false, run: None, notes: Vec::new() }
    }
}
