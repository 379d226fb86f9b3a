//! The project's own automation: `cargo xtask test`, `cargo xtask validate`, `cargo xtask book`,
//! `cargo xtask peers`, `cargo xtask counts`, `cargo xtask audit`.

mod audit;
mod counts;
mod peers;
mod python;
mod validate;

use std::env;
use std::process::{Command, ExitCode};
use std::time::Instant;
use validate::{Outcome, validate};

const USAGE: &str = "\
usage: cargo xtask COMMAND

  test       formatting, lints, documentation, all tests and validation, as the continuous
             integration runs them
  validate   forces, reactions and motions against other engines, see validation/README.md
  book       what of the book is generated: the reference of the model file and pictures
  peers      speed beside other engines, see peers/README.md
             --json FILE     all numbers
             --samples N     rounds of batches, by default 300
             --write         the tables of docs/src/speed.md
  counts     instructions of the kernels, by Callgrind, against those that are written down
             --write         write them down
  audit      dependencies, oldest compiler and versions, features, memory, fuzzing: now and then
             STEP...         only these
";

fn main() -> ExitCode {
    match env::args().nth(1).as_deref() {
        Some("test") => test(),
        Some("validate") => match validate() {
            Outcome::Passed | Outcome::Skipped => ExitCode::SUCCESS,
            Outcome::Failed => ExitCode::FAILURE,
        },
        Some("book") => book(),
        Some("counts") => counts::counts(env::args().skip(2)),
        Some("audit") => audit::audit(env::args().skip(2)),
        Some("peers") => peers::peers(env::args().skip(2)),
        Some("help" | "--help" | "-h") => {
            print!("{USAGE}");
            ExitCode::SUCCESS
        }
        other => {
            if let Some(command) = other {
                eprintln!("unknown command `{command}`\n");
            }
            eprint!("{USAGE}");
            ExitCode::from(2)
        }
    }
}

/// Writes what of the book is generated; the same tests compare it when they are run without a word.
fn book() -> ExitCode {
    let mut command = cargo(&["test", "--package", "stiction-cli", "--test", "book"]);
    command.env("STICTION_BOOK", "renew");
    if succeeds(&mut command) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// A command of the suite: what it is for, its arguments to cargo, and environment variables.
struct Step {
    name: &'static str,
    arguments: &'static [&'static str],
    environment: &'static [(&'static str, &'static str)],
}

const STEPS: &[Step] = &[
    Step { name: "formatting", arguments: &["fmt", "--all", "--check"], environment: &[] },
    Step {
        name: "lints",
        arguments: &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"],
        environment: &[],
    },
    Step {
        name: "documentation",
        arguments: &["doc", "--workspace", "--no-deps"],
        environment: &[("RUSTDOCFLAGS", "-D warnings")],
    },
    Step { name: "tests", arguments: &["test", "--workspace"], environment: &[] },
];

fn test() -> ExitCode {
    if !has_components() {
        return ExitCode::from(2);
    }
    for step in STEPS {
        eprintln!("\n== {}: cargo {}", step.name, step.arguments.join(" "));
        let begun = Instant::now();
        let mut command = cargo(step.arguments);
        command.envs(step.environment.iter().copied());
        if !succeeds(&mut command) {
            eprintln!("\n== {} failed", step.name);
            return ExitCode::FAILURE;
        }
        eprintln!("== {}: passed in {} s", step.name, begun.elapsed().as_secs());
    }
    eprintln!("\n== validation: cargo xtask validate");
    let begun = Instant::now();
    match validate() {
        Outcome::Passed => {
            eprintln!("== validation: passed in {} s", begun.elapsed().as_secs());
            ExitCode::SUCCESS
        }
        Outcome::Skipped => ExitCode::SUCCESS,
        Outcome::Failed => {
            eprintln!("\n== validation failed");
            ExitCode::FAILURE
        }
    }
}

fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments);
    command
}

fn succeeds(command: &mut Command) -> bool {
    match command.status() {
        Ok(status) => status.success(),
        Err(error) => {
            eprintln!("cannot run {command:?}: {error}");
            false
        }
    }
}

/// Makes sure that rustfmt and clippy are there; a minimal toolchain comes without them.
fn has_components() -> bool {
    let is_there =
        |name: &str| cargo(&[name, "--version"]).output().is_ok_and(|o| o.status.success());
    if is_there("fmt") && is_there("clippy") {
        return true;
    }
    eprintln!("== rustfmt and clippy are missing: rustup component add rustfmt clippy");
    let mut install = Command::new("rustup");
    install.args(["component", "add", "rustfmt", "clippy"]);
    if succeeds(&mut install) && is_there("fmt") && is_there("clippy") {
        return true;
    }
    eprintln!(
        "rustfmt and clippy are needed for this; install them as components of your toolchain"
    );
    false
}
