//! `cargo xtask validate`: other engines as second opinions, see `validation/README.md`.
//!
//! They are Python packages, installed into an environment of the project's own. Whoever has no Python or no network
//! can work without them, and is told so; the continuous integration cannot.

use crate::python::environment;
use crate::{cargo, succeeds};
use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// How it went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Passed,
    Failed,
    /// Something is missing on this machine; it has been said what.
    Skipped,
}

/// Builds the program, makes the environment and compares.
pub(crate) fn validate() -> Outcome {
    let xtask = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = xtask.parent().unwrap_or(xtask).join("validation");
    let python = match environment(&folder) {
        Ok(python) => python,
        Err(what) => return missing(&what),
    };
    if !succeeds(&mut cargo(&["build", "--package", "stiction-cli", "--bin", "stiction"])) {
        return Outcome::Failed;
    }
    let Some(program) = built_program() else {
        eprintln!("the program that was built is not beside this one");
        return Outcome::Failed;
    };
    let mut run = Command::new(python);
    run.arg(folder.join("run.py")).arg("--stiction").arg(program).arg("--self-test");
    if succeeds(&mut run) { Outcome::Passed } else { Outcome::Failed }
}

/// Where something is missing: a failure in the continuous integration, else a line that says so.
fn missing(what: &str) -> Outcome {
    if env::var_os("CI").is_some_and(|value| value == "true") {
        eprintln!("== validation failed: {what}");
        return Outcome::Failed;
    }
    eprintln!("== validation with other engines is skipped: {what}");
    Outcome::Skipped
}

/// The program, which cargo puts where it has put this one.
fn built_program() -> Option<PathBuf> {
    let own = env::current_exe().ok()?;
    let program = own.with_file_name(format!("stiction{}", env::consts::EXE_SUFFIX));
    program.is_file().then_some(program)
}
