//! `cargo xtask validate`: other engines as second opinions, see `validation/README.md`.
//!
//! They are Python packages, installed into an environment of the project's own. Whoever has no Python or no network
//! can work without them, and is told so; the continuous integration cannot.

use crate::{cargo, succeeds};
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The least version of Python for which all packages exist.
const LEAST_PYTHON: (u32, u32) = (3, 11);

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

/// The Python of the environment, which is made or renewed if need be.
fn environment(folder: &Path) -> Result<PathBuf, String> {
    let place = folder.join(".venv");
    let python = place.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let requirements = folder.join("requirements.txt");
    let wanted = fs::read(&requirements).map_err(|error| format!("{requirements:?}: {error}"))?;
    // The requirements that were installed, kept when all of them are there.
    let stamp = place.join("installed.txt");
    if fs::read(&stamp).is_ok_and(|installed| installed == wanted) && answers(&python) {
        return Ok(python);
    }
    let Some(system) = ["python3", "python"].into_iter().find(|name| answers(Path::new(name)))
    else {
        let (major, minor) = LEAST_PYTHON;
        return Err(format!(
            "it needs Python {major}.{minor} or later, as `python3` or `python` on the path"
        ));
    };
    eprintln!("== validation: installing the engines into {}", place.display());
    let made = succeeds(Command::new(system).args(["-m", "venv", "--clear"]).arg(&place));
    let install = ["-m", "pip", "install", "--disable-pip-version-check", "--quiet"];
    let installed = made
        && succeeds(Command::new(&python).args(install).arg("--requirement").arg(&requirements));
    if !installed {
        return Err(format!(
            "the packages of {} could not be installed; that needs a network, and a system for \
             which they exist",
            requirements.display()
        ));
    }
    fs::write(&stamp, wanted).map_err(|error| format!("{stamp:?}: {error}"))?;
    Ok(python)
}

/// Whether this is a Python that is recent enough.
fn answers(python: &Path) -> bool {
    let (major, minor) = LEAST_PYTHON;
    let question = format!("import sys; sys.exit(sys.version_info < ({major}, {minor}))");
    let mut command = Command::new(python);
    command.args(["-c", &question]).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// The program, which cargo puts where it has put this one.
fn built_program() -> Option<PathBuf> {
    let own = env::current_exe().ok()?;
    let program = own.with_file_name(format!("stiction{}", env::consts::EXE_SUFFIX));
    program.is_file().then_some(program)
}
