//! Virtual environment of Python packages: the other engines, with pinned versions.

use crate::succeeds;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Oldest version of Python for which all packages exist.
const LEAST_PYTHON: (u32, u32) = (3, 11);

/// Returns the Python interpreter of the environment `folder/.venv`. Creates the environment, or renews it
/// after a change of `folder/requirements.txt`.
///
/// # Errors
/// A description of the missing prerequisite.
pub(crate) fn environment(folder: &Path) -> Result<PathBuf, String> {
    let place = folder.join(".venv");
    let python = place.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let requirements = folder.join("requirements.txt");
    let required = fs::read(&requirements).map_err(|error| format!("{requirements:?}: {error}"))?;
    // A copy of the installed requirements, written after all of them are installed.
    let stamp = place.join("installed.txt");
    if fs::read(&stamp).is_ok_and(|installed| installed == required) && is_recent(&python) {
        return Ok(python);
    }
    let Some(system) = ["python3", "python"].into_iter().find(|name| is_recent(Path::new(name)))
    else {
        let (major, minor) = LEAST_PYTHON;
        return Err(format!(
            "Python {major}.{minor} or later is missing; install it as `python3` or `python` on the path"
        ));
    };
    eprintln!("== installing the engines into {}", place.display());
    let made = succeeds(Command::new(system).args(["-m", "venv", "--clear"]).arg(&place));
    let install = ["-m", "pip", "install", "--disable-pip-version-check", "--quiet"];
    let installed = made
        && succeeds(Command::new(&python).args(install).arg("--requirement").arg(&requirements));
    if !installed {
        return Err(format!(
            "pip cannot install the packages of {}; it needs a network and a system for which they \
             exist",
            requirements.display()
        ));
    }
    fs::write(&stamp, required).map_err(|error| format!("{stamp:?}: {error}"))?;
    Ok(python)
}

/// Returns `true` if this interpreter runs and is at least [`LEAST_PYTHON`].
fn is_recent(python: &Path) -> bool {
    let (major, minor) = LEAST_PYTHON;
    let question = format!("import sys; sys.exit(sys.version_info < ({major}, {minor}))");
    let mut command = Command::new(python);
    command.args(["-c", &question]).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}
