//! Virtual environments of Python packages with pinned versions.

use crate::{runs, succeeds};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Virtual environment that a step of the automation needs.
pub(crate) struct Environment<'a> {
    /// Folder of the environment.
    pub(crate) place: PathBuf,
    /// File with the packages.
    pub(crate) requirements: &'a Path,
    /// Oldest version of Python for which all packages exist.
    pub(crate) least: (u32, u32),
}

/// Reason why an environment is not available.
#[derive(Debug)]
pub(crate) enum Missing {
    /// No installed Python is recent enough or can create an environment; the text contains the
    /// details.
    Python(String),
    /// The packages cannot be installed; the text contains the details.
    Packages(String),
}

impl Missing {
    pub(crate) fn text(&self) -> &str {
        match self {
            Self::Python(text) | Self::Packages(text) => text,
        }
    }
}

impl Environment<'_> {
    /// Returns the Python interpreter of the environment. Creates the environment, or recreates it
    /// after a change of the requirements.
    ///
    /// # Errors
    /// The missing prerequisite.
    pub(crate) fn interpreter(&self) -> Result<PathBuf, Missing> {
        let python = interpreter_in(&self.place);
        let requirements = self.requirements;
        let required = fs::read(requirements)
            .map_err(|error| Missing::Packages(format!("{requirements:?}: {error}")))?;
        // A copy of the installed requirements, written after all of them are installed.
        let stamp = self.place.join("installed.txt");
        if fs::read(&stamp).is_ok_and(|installed| installed == required)
            && is_recent(&python, self.least)
        {
            return Ok(python);
        }
        eprintln!("== installing Python packages into {}", self.place.display());
        create(&self.place, self.least)?;
        install(&python, &["--requirement".as_ref(), requirements])?;
        fs::write(&stamp, required)
            .map_err(|error| Missing::Packages(format!("{}: {error}", stamp.display())))?;
        Ok(python)
    }
}

/// Returns the Python interpreter of the environment that contains the other engines, in the folder
/// `validation`.
///
/// # Errors
/// A description of the missing prerequisite.
pub(crate) fn engines(validation: &Path) -> Result<PathBuf, String> {
    let requirements = validation.join("requirements.txt");
    // The oldest version for which all engines exist.
    let least = (3, 11);
    let environment =
        Environment { place: validation.join(".venv"), requirements: &requirements, least };
    environment.interpreter().map_err(|missing| missing.text().to_owned())
}

/// Path of the interpreter of a virtual environment.
pub(crate) fn interpreter_in(place: &Path) -> PathBuf {
    place.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })
}

/// Creates an empty virtual environment; an existing environment is replaced.
///
/// # Errors
/// The missing prerequisite.
pub(crate) fn create(place: &Path, least: (u32, u32)) -> Result<(), Missing> {
    let system =
        ["python3", "python"].into_iter().find(|name| is_recent(Path::new(name), least)).ok_or_else(
            || {
                let (major, minor) = least;
                Missing::Python(format!(
                    "Python {major}.{minor} or later is missing; install it as `python3` or `python` on the path"
                ))
            },
        )?;
    match succeeds(Command::new(system).args(["-m", "venv", "--clear"]).arg(place)) {
        true => Ok(()),
        false => Err(Missing::Python(format!(
            "Python cannot create a virtual environment in {}; its module `venv` may be missing",
            place.display()
        ))),
    }
}

/// Installs packages into the environment of an interpreter.
///
/// # Errors
/// The packages cannot be installed.
pub(crate) fn install(python: &Path, what: &[&Path]) -> Result<(), Missing> {
    let install = ["-m", "pip", "install", "--disable-pip-version-check", "--quiet"];
    match succeeds(Command::new(python).args(install).args(what)) {
        true => Ok(()),
        false => Err(Missing::Packages(
            "pip cannot install the packages; it needs a network and a system for which they exist"
                .to_owned(),
        )),
    }
}

/// Returns `true` if this interpreter runs and is at least the given version.
fn is_recent(python: &Path, (major, minor): (u32, u32)) -> bool {
    let question = format!("import sys; sys.exit(sys.version_info < ({major}, {minor}))");
    runs(Command::new(python).args(["-c", &question]))
}
