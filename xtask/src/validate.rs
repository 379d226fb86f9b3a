//! `cargo xtask validate`: compares the program with other engines, see `validation/README.md`.
//!
//! The engines are Python packages in a virtual environment of the project. Without Python or network the
//! comparison is skipped with a message; in the continuous integration it fails.

use crate::python::engines;
use crate::{cargo, succeeds};
use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Result of the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Passed,
    Failed,
    /// A prerequisite is missing on this machine; a message has named it.
    Skipped,
}

/// Origin of the program under test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Program {
    /// Build the program first.
    ToBuild,
    /// Use the program that the tests have built.
    Built,
}

/// Builds the program if necessary, creates the Python environment and compares.
pub(crate) fn validate(program: Program) -> Outcome {
    let xtask = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = xtask.parent().unwrap_or(xtask).join("validation");
    let python = match engines(&folder) {
        Ok(python) => python,
        Err(what) => return missing(&what),
    };
    let build = &["build", "--package", "stiction-cli", "--bin", "stiction"];
    if program == Program::ToBuild && !succeeds(&mut cargo(build)) {
        return Outcome::Failed;
    }
    let Some(program) = built_program() else {
        eprintln!("== validation: the folder of this program does not contain `stiction`");
        return Outcome::Failed;
    };
    for files in ["robot_files.py", "foreign_files.py"] {
        if !succeeds(Command::new(&python).arg(folder.join(files)).arg(&program)) {
            return Outcome::Failed;
        }
    }
    let mut run = Command::new(python);
    run.arg(folder.join("run.py")).arg("--stiction").arg(program).arg("--self-test");
    if succeeds(&mut run) { Outcome::Passed } else { Outcome::Failed }
}

/// Reports a missing prerequisite: failure in the continuous integration, skipped elsewhere.
fn missing(what: &str) -> Outcome {
    if env::var_os("CI").is_some_and(|value| value == "true") {
        eprintln!("== validation failed: {what}");
        return Outcome::Failed;
    }
    eprintln!("== validation skipped: {what}");
    Outcome::Skipped
}

/// Path of the program; cargo puts all programs of a profile into one folder.
fn built_program() -> Option<PathBuf> {
    let own = env::current_exe().ok()?;
    let program = own.with_file_name(format!("stiction{}", env::consts::EXE_SUFFIX));
    program.is_file().then_some(program)
}
