//! `cargo xtask viewer`: the shaded view of reports, bundled from three.js into `target/viewer/shaded.js`.
//!
//! Releases, wheels and the playground contain it. All other builds need no npm and draw robots without meshes.

use crate::{npm, succeeds};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const FOLDER: &str = "target/viewer";
/// Program of esbuild in the folder of the installed packages.
const ESBUILD: &str = "node_modules/esbuild/bin/esbuild";
const ENTRY: &str = "crates/stiction-draw/src/viewer/shaded/shaded.js";

pub(crate) fn viewer() -> ExitCode {
    match bundle() {
        Ok(file) => {
            eprintln!("   {}: build with STICTION_SHADED={0}", file.display());
            ExitCode::SUCCESS
        }
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::FAILURE
        }
    }
}

/// Configures a build so that it contains the shaded view, and the script of the moving robot
/// minified by esbuild. Without npm, the build contains the unmodified script and no shaded view,
/// and a note is printed.
pub(crate) fn include_in(build: &mut Command) {
    if include_shaded_in(build).is_some() {
        let esbuild = Path::new("target/npm/viewer").join(ESBUILD);
        build.env("STICTION_ESBUILD", esbuild.canonicalize().unwrap_or(esbuild));
    }
}

/// Configures a build so that it contains the shaded view, and returns the file of the script.
/// Without npm, the build contains no shaded view, and a note is printed.
pub(crate) fn include_shaded_in(build: &mut Command) -> Option<PathBuf> {
    match bundle() {
        Ok(file) => {
            build.env("STICTION_SHADED", &file);
            Some(file)
        }
        Err(why) => {
            eprintln!("== without the shaded view of meshes: {why}");
            None
        }
    }
}

/// Bundles the script, which begins with the licence of three.js; returns its full path.
fn bundle() -> Result<PathBuf, String> {
    if !succeeds(Command::new("npm").arg("--version").stdout(std::process::Stdio::null())) {
        return Err("npm is not installed".to_owned());
    }
    let tools = npm::install("viewer")?;
    let told = |path: &Path, error: std::io::Error| format!("{}: {error}", path.display());
    fs::create_dir_all(FOLDER).map_err(|error| told(Path::new(FOLDER), error))?;
    let licence = tools.join("node_modules/three/LICENSE");
    let licence = fs::read_to_string(&licence).map_err(|error| told(&licence, error))?;
    let file = Path::new(FOLDER).join("shaded.js");
    let mut esbuild = Command::new("node");
    esbuild
        .arg(tools.join(ESBUILD))
        .arg(ENTRY)
        .args(["--bundle", "--minify", "--format=iife", "--target=es2022", "--legal-comments=none"])
        .args(["--log-level=warning", "--charset=ascii"])
        .arg(format!("--banner:js=/*! three.js\n{} */", licence.trim()))
        .arg(format!("--outfile={}", file.display()))
        .env("NODE_PATH", tools.join("node_modules"));
    if !succeeds(&mut esbuild) {
        return Err("esbuild could not bundle the script".to_owned());
    }
    file.canonicalize().map_err(|error| told(&file, error))
}
