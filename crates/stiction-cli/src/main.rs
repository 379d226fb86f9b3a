//! `stiction`: what a robot with closed kinematic chains needs from its actuators when its joints
//! have friction.
//!
//! Arguments, files, progress and exit codes; nothing else lives here. Data go to standard output,
//! talk to standard error. Exit codes: 0 done, 1 the question has no answer (a singular position, a
//! mechanism that jams), 2 the input cannot be used, 130 interrupted.

/// A line on the standard error; where nobody listens any more it is lost, and that is no error.
macro_rules! tell {
    ($($what:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($what)*);
    }};
}

mod arguments;
mod breakaway;
mod check;
mod convert;
mod failure;
mod forward;
mod inverse;
mod models;
mod outputs;
mod progress;
mod sources;
mod stored;
mod study;

use arguments::{Arguments, Command};
use clap::Parser;
use failure::Failure;
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::try_parse().unwrap_or_else(|error| refuse(&error));
    let outcome = match arguments.command {
        None => inverse::run(&arguments.inverse),
        Some(Command::Inverse(options)) => inverse::run(&options),
        Some(Command::Forward(options)) => forward::run(&options),
        Some(Command::Check(options)) => check::run(&options),
        Some(Command::Breakaway(options)) => breakaway::run(&options),
        Some(Command::Study(options)) => study::run(&options),
        Some(Command::Convert(options)) => convert::run(&options),
        Some(Command::Models(options)) => models::run(&options),
        Some(Command::Schema) => print(&format!("{:#}\n", stiction_format::json_schema())),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.tell();
            failure.exit_code()
        }
    }
}

/// Says what is wrong with the arguments. A misspelt command is taken for a model, and what follows it
/// for a command, so this has to be said otherwise.
fn refuse(error: &clap::Error) -> ! {
    use clap::error::ErrorKind::{ArgumentConflict, DisplayHelp, DisplayVersion};
    let first = std::env::args_os().nth(1).unwrap_or_default().to_string_lossy().into_owned();
    let for_programs = std::env::args_os().any(|argument| argument == "--json");
    let failure = match sources::near_command(&first) {
        Some(command) if error.kind() == ArgumentConflict && command != first => {
            Failure::input(format!("there is no command `{first}`"))
                .help(format!("did you mean `stiction {command}`?"))
        }
        _ if !for_programs || matches!(error.kind(), DisplayHelp | DisplayVersion) => error.exit(),
        _ => {
            let text = error.render().to_string();
            let (message, usage) = text.split_once("\n\n").unwrap_or((&text, ""));
            let message = message.strip_prefix("error: ").unwrap_or(message);
            Failure::input(message).help(usage.trim())
        }
    };
    failure.for_programs(for_programs).tell();
    std::process::exit(2)
}

/// Writes data to standard output. A reader that has gone away is no failure.
fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::input(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}
