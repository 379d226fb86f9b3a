//! The environment of Python packages in `validation/.venv`: other engines, pinned.

use crate::succeeds;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The least version of Python for which all packages exist.
const LEAST_PYTHON: (u32, u32) = (3, 11);

/// The Python of the environment, which is made or renewed if need be. `folder` is that of
/// `requirements.txt`.
///
/// # Errors
/// What is missing, in words.
pub(crate) fn environment(folder: &Path) -> Result<PathBuf, String> {
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
    eprintln!("== installing the engines into {}", place.display());
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
