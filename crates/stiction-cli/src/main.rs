//! The program `stiction`: inverse and forward dynamics of robots with closed kinematic chains and joint
//! friction, on the command line.
//!
//! This crate handles arguments, output files, progress and exit codes; the library `stiction` performs all
//! computations. Data go to standard output, messages to standard error. Exit codes: 0 success, 1 no solution (a
//! singular position, a mechanism that jams), 2 invalid input, 130 interrupted.

/// Prints a line to standard error, and ignores write errors.
macro_rules! message {
    ($($what:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($what)*);
    }};
}

/// Prints a note in lines that fit on a terminal; `--quiet` suppresses it.
macro_rules! note {
    ($($what:tt)*) => {{
        if !$crate::manners::is_quiet() {
            message!("{}", $crate::fold::folded(&format!($($what)*)));
        }
    }};
}

mod answer;
mod arguments;
mod breakaway;
mod cases;
mod check;
mod compare;
mod compensate;
mod convert;
mod excite;
mod export;
mod failure;
mod fold;
mod forward;
mod identify;
mod inverse;
mod manners;
mod models;
mod operating_point;
mod outputs;
mod progress;
mod report;
mod shell;
mod sources;
mod study;
mod sweep;
mod view;
mod written;

use arguments::{Arguments, Command};
use clap::Parser;
use failure::Failure;
use std::io::Write;
use std::process::ExitCode;

/// Stack size of the computing thread, bytes. The stack of the main thread depends on `ulimit -s`
/// and may be smaller.
const STACK: usize = 16 << 20;

fn main() -> ExitCode {
    let_writes_fail();
    let thread = std::thread::Builder::new().name("main".to_owned()).stack_size(STACK).spawn(run);
    match thread.map(std::thread::JoinHandle::join) {
        Ok(Ok(code)) => code,
        // The panic has been reported.
        Ok(Err(_)) => ExitCode::from(101),
        Err(error) => {
            message!("error: cannot start a thread: {error}");
            ExitCode::from(2)
        }
    }
}

/// Makes a write beyond the file size limit (`ulimit -f`) return an error; by default the system
/// ends the process. Threads inherit this setting.
fn let_writes_fail() {
    #[cfg(unix)]
    {
        use nix::sys::signal::{SigSet, Signal};
        let mut signals = SigSet::empty();
        signals.add(Signal::SIGXFSZ);
        let _ = signals.thread_block();
    }
}

fn run() -> ExitCode {
    let arguments = Arguments::try_parse_from(arguments::with_negative_values(std::env::args_os()))
        .unwrap_or_else(|error| refuse(&error));
    manners::set(arguments.messages);
    let outcome = match arguments.command {
        None => inverse::run(&arguments.inverse),
        Some(Command::Inverse(options)) => inverse::run(&options),
        Some(Command::Compare(options)) => compare::run(&options),
        Some(Command::Forward(options)) => forward::run(&options),
        Some(Command::Identify(options)) => identify::run(&options),
        Some(Command::Excite(options)) => excite::run(&options),
        Some(Command::Sweep(options)) => sweep::run(&options),
        Some(Command::Check(options)) => check::run(&options),
        Some(Command::View(options)) => view::run(&options),
        Some(Command::Breakaway(options)) => breakaway::run(&options),
        Some(Command::Equilibrium(options)) => operating_point::run_equilibrium(&options),
        Some(Command::Linearize(options)) => operating_point::run_linearize(&options),
        Some(Command::Study(options)) => study::run(&options),
        Some(Command::Convert(options)) => convert::run(&options),
        Some(Command::Compensate(options)) => compensate::run(&options),
        Some(Command::Export(options)) => export::run(&options),
        Some(Command::Models(options)) => models::run(&options),
        Some(Command::Schema) => print(&format!("{:#}\n", stiction_format::json_schema())),
        Some(Command::Completions { shell }) => shell::completions(shell),
        Some(Command::Man) => shell::manual(),
    };
    let answered = outcome.and_then(|()| match answer::take() {
        Some(result) => print(&format!("{result:#}\n")),
        None => Ok(()),
    });
    match answered {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.print();
            failure.exit_code()
        }
    }
}

/// Prints the error in the arguments and exits. A misspelt command is parsed as a model and the
/// next argument as a command; this case has its own message.
fn refuse(error: &clap::Error) -> ! {
    use clap::error::ErrorKind::{ArgumentConflict, DisplayHelp, DisplayVersion, InvalidUtf8};
    let first = std::env::args_os().nth(1).unwrap_or_default().to_string_lossy().into_owned();
    let for_programs = std::env::args_os().any(|argument| argument == "--json");
    let failure = match sources::near_command(&first) {
        Some(command) if error.kind() == ArgumentConflict && command != first => {
            Failure::input(format!("there is no command `{first}`"))
                .help(format!("did you mean `stiction {command}`?"))
        }
        None if error.kind() == ArgumentConflict && sources::is_neither_file_nor_model(&first) => {
            Failure::input(format!("there is no command and no model `{first}`"))
                .help("`stiction --help` lists the commands, `stiction models` the built-in models")
        }
        _ if matches!(error.kind(), DisplayHelp | DisplayVersion) => {
            match written(error.print().and_then(|()| std::io::stdout().flush())) {
                Ok(()) => std::process::exit(0),
                Err(failure) => failure,
            }
        }
        _ if error.kind() == InvalidUtf8 => {
            let mut arguments = std::env::args_os();
            let argument = arguments.find(|a| a.to_str().is_none()).unwrap_or_default();
            Failure::input(format!("the argument `{}` is not UTF-8", argument.display())).help(
                "only the model and the value of -o may be paths that are not UTF-8: rename \
                    the file, or create a link to it",
            )
        }
        _ if !for_programs => error.exit(),
        _ => {
            let text = error.render().to_string();
            let (message, usage) = text.split_once("\n\n").unwrap_or((&text, ""));
            let message = message.strip_prefix("error: ").unwrap_or(message);
            Failure::input(message).help(usage.trim())
        }
    };
    failure.into_json(for_programs).print();
    std::process::exit(2)
}

/// Writes a text to standard output. A closed reader of the output is not a failure.
fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    written(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// Converts the result of writing to standard output; a closed reader is not a failure.
fn written(outcome: std::io::Result<()>) -> Result<(), Failure> {
    match outcome {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::input(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}
