//! How the program says that it failed.

use serde_json::{Value, json};
use std::io::IsTerminal;
use std::process::ExitCode;
use stiction_format::Diagnostics;

/// Why there is no result.
#[derive(Debug)]
pub(crate) struct Failure {
    kind: Kind,
    what: Box<What>,
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The question has no answer.
    NoAnswer,
    /// The input cannot be used.
    Input,
    /// The user stopped it.
    Interrupted,
}

#[derive(Debug)]
enum What {
    /// A message, a way out, and the same for programs.
    Message { message: String, help: Option<String>, details: Value },
    /// Messages about places in texts.
    Diagnostics(Diagnostics),
}

impl Failure {
    /// The input cannot be used.
    pub(crate) fn input(message: impl Into<String>) -> Self {
        Self::message(Kind::Input, message.into())
    }

    /// The question has no answer.
    pub(crate) fn no_answer(message: impl Into<String>) -> Self {
        Self::message(Kind::NoAnswer, message.into())
    }

    /// The user stopped it.
    pub(crate) fn interrupted() -> Self {
        Self::message(Kind::Interrupted, "interrupted; nothing was written".to_owned())
    }

    /// The user stopped it, and something was kept.
    pub(crate) fn interrupted_at(message: String) -> Self {
        Self::message(Kind::Interrupted, message)
    }

    fn message(kind: Kind, message: String) -> Self {
        let what = Box::new(What::Message { message, help: None, details: Value::Null });
        Self { kind, what, json: false }
    }

    /// Adds a way out.
    pub(crate) fn help(mut self, text: impl Into<String>) -> Self {
        if let What::Message { help, .. } = &mut *self.what {
            *help = Some(text.into());
        }
        self
    }

    /// Adds what else there is to say.
    pub(crate) fn note(mut self, text: impl std::fmt::Display) -> Self {
        if let What::Message { message, .. } = &mut *self.what {
            *message += &format!("\n  {text}");
        }
        self
    }

    /// Adds numbers for programs.
    pub(crate) fn details(mut self, value: Value) -> Self {
        if let What::Message { details, .. } = &mut *self.what {
            *details = value;
        }
        self
    }

    /// Tells programs rather than people.
    pub(crate) fn for_programs(mut self, json: bool) -> Self {
        self.json = json;
        self
    }

    /// Says what is wrong: to people on standard error, to programs on standard output.
    pub(crate) fn tell(&self) {
        if self.json {
            // Where nothing arrives there may be somebody who listens elsewhere.
            if let Err(failure) = crate::print(&format!("{:#}\n", self.to_json())) {
                failure.tell();
            }
            return;
        }
        match &*self.what {
            What::Diagnostics(diagnostics) => {
                let colour =
                    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
                tell!("{}", diagnostics.render(colour).trim_end_matches('\n'));
            }
            What::Message { message, help, .. } => {
                tell!("error: {message}");
                if let Some(help) = help {
                    tell!("help: {help}");
                }
            }
        }
    }

    fn to_json(&self) -> Value {
        let kind = match self.kind {
            Kind::NoAnswer => "no-answer",
            Kind::Input => "input",
            Kind::Interrupted => "interrupted",
        };
        match &*self.what {
            What::Diagnostics(diagnostics) => {
                json!({ "error": { "kind": kind, "diagnostics": diagnostics.to_json() } })
            }
            What::Message { message, help, details } => json!({
                "error": { "kind": kind, "message": message, "help": help, "details": details }
            }),
        }
    }

    pub(crate) fn exit_code(&self) -> ExitCode {
        match self.kind {
            Kind::NoAnswer => ExitCode::from(1),
            Kind::Input => ExitCode::from(2),
            Kind::Interrupted => ExitCode::from(130),
        }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &*self.what {
            What::Diagnostics(diagnostics) => f.write_str(&diagnostics.render(false)),
            What::Message { message, .. } => f.write_str(message),
        }
    }
}

impl From<Diagnostics> for Failure {
    fn from(diagnostics: Diagnostics) -> Self {
        Self { kind: Kind::Input, what: Box::new(What::Diagnostics(diagnostics)), json: false }
    }
}

/// Why a file cannot be read.
pub(crate) fn describe(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
        std::io::ErrorKind::PermissionDenied => "you may not read it".to_owned(),
        _ => error.to_string(),
    }
}
