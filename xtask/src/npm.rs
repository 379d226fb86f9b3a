//! Packages of npm, installed below `target` by committed lock files. The packages themselves are
//! not committed.

use crate::succeeds;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Installs the packages of `xtask/NAME/package-lock.json` without running their scripts; returns their folder.
///
/// # Errors
/// The files cannot be copied, or npm fails; the text names the reason.
pub(crate) fn install(name: &str) -> Result<PathBuf, String> {
    let (from, to) = (Path::new("xtask").join(name), Path::new("target/npm").join(name));
    fs::create_dir_all(&to).map_err(|error| format!("{}: {error}", to.display()))?;
    for file in ["package.json", "package-lock.json"] {
        let source = from.join(file);
        fs::copy(&source, to.join(file))
            .map_err(|error| format!("{}: {error}", source.display()))?;
    }
    let mut npm = Command::new("npm");
    npm.args(["ci", "--ignore-scripts", "--no-audit", "--no-fund"]).current_dir(&to);
    if !succeeds(&mut npm) {
        return Err("npm could not install the packages".to_owned());
    }
    to.canonicalize().map_err(|error| format!("{}: {error}", to.display()))
}
