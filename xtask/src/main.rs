//! The project's own automation: `cargo xtask test`, `cargo xtask validate`, `cargo xtask book`,
//! `cargo xtask peers`, `cargo xtask counts`, `cargo xtask audit`, `cargo xtask dist`,
//! `cargo xtask python`, `cargo xtask wheel`, `cargo xtask playground`, `cargo xtask viewer`, `cargo xtask fmu`.

mod audit;
mod counts;
mod dist;
mod fmu;
mod npm;
mod package;
mod peers;
mod playground;
mod python;
mod validate;
mod viewer;

use std::env;
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};
use validate::{Outcome, Program, validate};

const USAGE: &str = "\
usage: cargo xtask COMMAND

  test       formatting, lints, documentation, all tests and validation: the steps of the
             continuous integration, with the time of each
  validate   compare forces, reactions and motions with other engines, see validation/README.md
  python     tests of the Python package, a part of `test`
  wheel      build the Python package into target/wheels and try it in an empty environment
             --profile NAME  profile of the native module, release by default
             --target TARGET for another system, such as aarch64-unknown-linux-gnu
             --compatibility TAG  tag of the wheel, such as manylinux2014
             --zig           link with Zig against the C library that the tag names
  book       write the generated parts of the book: model file reference and pictures
  peers      compare speed with other engines, see peers/README.md
             --json FILE     write all numbers
             --samples N     number of batches, 300 by default
             --write         write the tables of docs/src/speed.md
  counts     compare instruction counts of the kernels (Callgrind) with the stored ones
             --write         store the counts
  audit      checks to run now and then: dependencies, oldest compiler and versions, features,
             memory, fuzzing
             STEP...         run only these steps
  dist       pack the program with manual page, completions, licences and checksums into target/dist
             TARGET...       for these targets, by default a static one on Linux
  fmu        build the library of plant FMUs for this platform, beside the program in target/release
  playground build the engine for browsers and its page into target/playground
  viewer     bundle the shaded view of meshes with npm into target/viewer; dist and wheel do so
";

fn main() -> ExitCode {
    match env::args().nth(1).as_deref() {
        Some("test") => test(),
        Some("validate") => match validate(Program::ToBuild) {
            Outcome::Passed | Outcome::Skipped => ExitCode::SUCCESS,
            Outcome::Failed => ExitCode::FAILURE,
        },
        Some("book") => book(),
        Some("counts") => counts::counts(env::args().skip(2)),
        Some("audit") => audit::audit(env::args().skip(2)),
        Some("dist") => dist::dist(env::args().skip(2)),
        Some("python") => match package::test(Program::ToBuild) {
            Outcome::Passed | Outcome::Skipped => ExitCode::SUCCESS,
            Outcome::Failed => ExitCode::FAILURE,
        },
        Some("wheel") => package::wheel(env::args().skip(2)),
        Some("peers") => peers::peers(env::args().skip(2)),
        Some("fmu") => fmu::fmu(),
        Some("playground") => playground::playground(),
        Some("viewer") => viewer::viewer(),
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

/// Writes the generated parts of the book. The tests of the book compare them with the files.
fn book() -> ExitCode {
    let mut command = cargo(&["test", "--package", "stiction-cli", "--test", "book"]);
    command.env("STICTION_BOOK", "renew");
    if succeeds(&mut command) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// A cargo command of the test suite: arguments and additional environment variables.
struct Step {
    name: &'static str,
    arguments: &'static [&'static str],
    environment: &'static [(&'static str, &'static str)],
}

/// Commands of the test suite. They are ordered so that clippy and rustdoc share the type-checked
/// dependencies, and tests and validation the compiled ones.
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
    Step {
        name: "compilation of tests",
        arguments: &["test", "--workspace", "--no-run"],
        environment: &[],
    },
    Step { name: "tests", arguments: &["test", "--workspace"], environment: &[] },
];

fn test() -> ExitCode {
    if !has_components() {
        return ExitCode::from(2);
    }
    let mut durations = Vec::new();
    let outcome = test_timed(&mut durations);
    print_durations(&durations);
    if outcome == Outcome::Failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// Runs all steps up to the first failure; appends name and duration of each to `durations`.
fn test_timed(durations: &mut Vec<(&'static str, Duration)>) -> Outcome {
    for step in STEPS {
        eprintln!("\n== {}: cargo {}", step.name, step.arguments.join(" "));
        let start = Instant::now();
        let mut command = cargo(step.arguments);
        command.envs(step.environment.iter().copied());
        let passed = succeeds(&mut command);
        durations.push((step.name, start.elapsed()));
        if !passed {
            eprintln!("\n== {} failed", step.name);
            return Outcome::Failed;
        }
    }
    eprintln!("\n== tests of the Python package");
    let start = Instant::now();
    let outcome = package::test(Program::Built);
    durations.push(("Python package", start.elapsed()));
    if outcome == Outcome::Failed {
        eprintln!("\n== tests of the Python package failed");
        return Outcome::Failed;
    }
    eprintln!("\n== validation: cargo xtask validate");
    let start = Instant::now();
    // The tests of `stiction-cli` have built the program. Building that package alone would compile
    // most dependencies again, with fewer features.
    let outcome = validate(Program::Built);
    durations.push(("validation", start.elapsed()));
    if outcome == Outcome::Failed {
        eprintln!("\n== validation failed");
    }
    outcome
}

/// Prints the duration of every step and its share of the total, the slowest step first.
fn print_durations(durations: &[(&'static str, Duration)]) {
    let total: Duration = durations.iter().map(|(_, duration)| *duration).sum();
    let mut slowest_first = durations.to_vec();
    slowest_first.sort_by_key(|(_, duration)| std::cmp::Reverse(*duration));
    eprintln!("\n== duration of each step, slowest first");
    for (name, duration) in slowest_first {
        let percent = 100.0 * duration.as_secs_f64() / total.as_secs_f64().max(f64::MIN_POSITIVE);
        eprintln!("   {name:<24} {:>6} s {percent:>5.0} %", duration.as_secs());
    }
    eprintln!("   {:<24} {:>6} s", "total", total.as_secs());
}

fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments);
    command
}

/// Returns `true` if a program starts and exits with success; shows nothing of its output.
fn runs(command: &mut Command) -> bool {
    let status = command.stdout(Stdio::null()).stderr(Stdio::null()).status();
    status.is_ok_and(|status| status.success())
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

/// Installs rustfmt and clippy where a minimal toolchain lacks them; returns `false` if that fails.
fn has_components() -> bool {
    let is_installed =
        |name: &str| cargo(&[name, "--version"]).output().is_ok_and(|o| o.status.success());
    if is_installed("fmt") && is_installed("clippy") {
        return true;
    }
    eprintln!("== installing rustfmt and clippy: rustup component add rustfmt clippy");
    let mut install = Command::new("rustup");
    install.args(["component", "add", "rustfmt", "clippy"]);
    if succeeds(&mut install) && is_installed("fmt") && is_installed("clippy") {
        return true;
    }
    eprintln!("== rustfmt or clippy is missing: install both as components of your toolchain");
    false
}
