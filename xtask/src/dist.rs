//! `cargo xtask dist`: archives of the program for machines without a compiler, in `target/dist`.
//!
//! An archive contains the program, the library of plant FMUs, a manual page, completions for
//! shells, and the licences of everything that is linked into the program. `SHA256SUMS` has the
//! checksums of all archives in the folder. The target of Linux is musl: such a program is static
//! and runs on any distribution.

use crate::{cargo, succeeds, viewer};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::env;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const FOLDER: &str = "target/dist";
/// Shells and the customary names of their completions.
const SHELLS: [(&str, &str); 5] = [
    ("bash", "stiction.bash"),
    ("zsh", "_stiction"),
    ("fish", "stiction.fish"),
    ("powershell", "_stiction.ps1"),
    ("elvish", "stiction.elv"),
];
/// Files of the project in every archive.
const DOCUMENTS: [&str; 4] = ["README.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE"];

pub(crate) fn dist(targets: impl Iterator<Item = String>) -> ExitCode {
    let mut targets: Vec<String> = targets.collect();
    let Some(host) = host() else {
        eprintln!("rustc does not name the target of this machine");
        return ExitCode::FAILURE;
    };
    if targets.is_empty() {
        targets.push(usual(&host));
    }
    for target in &targets {
        if let Err(why) = archive(target, &host) {
            eprintln!("== {target}: {why}");
            return ExitCode::FAILURE;
        }
    }
    match checksums() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("== checksums: {why}");
            ExitCode::FAILURE
        }
    }
}

/// Target triple of this machine.
pub(crate) fn host() -> Option<String> {
    let output = Command::new("rustc").arg("-vV").output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    text.lines().find_map(|line| line.strip_prefix("host: ").map(str::to_owned))
}

/// Default target of a release: the static target on Linux, elsewhere that of the machine.
fn usual(host: &str) -> String {
    host.replace("-linux-gnu", "-linux-musl")
}

/// True if the standard library of a target is installed.
pub(crate) fn has_target(target: &str) -> bool {
    let library =
        Command::new("rustc").args(["--print", "target-libdir", "--target", target]).output();
    let library = library.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    library.is_ok_and(|library| !library.is_empty() && Path::new(&library).is_dir())
}

/// Builds and packs the program for a target.
fn archive(target: &str, host: &str) -> Result<(), String> {
    if !has_target(target) {
        return Err(format!("its standard library is not installed: rustup target add {target}"));
    }
    eprintln!("== {target}: building");
    let build = ["build", "--release", "--locked", "-p", "stiction-cli", "--target", target];
    let mut build = cargo(&build);
    viewer::include_in(&mut build);
    if !succeeds(&mut build) {
        return Err("the build failed".to_owned());
    }
    let metadata = metadata(target)?;
    let version = version(&metadata).ok_or("the version is unknown")?;
    let name = format!("stiction-{version}-{target}");
    let folder = Path::new(FOLDER).join(&name);
    let _ = fs::remove_dir_all(&folder);
    let failed = |error: std::io::Error| error.to_string();
    fs::create_dir_all(folder.join("completions")).map_err(failed)?;
    fs::create_dir_all(folder.join("man")).map_err(failed)?;

    let program = if target.contains("windows") { "stiction.exe" } else { "stiction" };
    let built = Path::new("target").join(target).join("release").join(program);
    fs::copy(&built, folder.join(program)).map_err(failed)?;
    for document in DOCUMENTS {
        fs::copy(document, folder.join(document)).map_err(|e| format!("{document}: {e}"))?;
    }
    // A program for another machine does not run here, so a native program writes the texts.
    let runs = target == host || target == usual(host);
    let here = if runs { built } else { native()? };
    for (shell, file) in SHELLS {
        let text = said(&here, &["completions", shell])?;
        fs::write(folder.join("completions").join(file), text).map_err(failed)?;
    }
    fs::write(folder.join("man/stiction.1"), said(&here, &["man"])?).map_err(failed)?;
    fs::write(folder.join("THIRD-PARTY-LICENSES.txt"), licences(&metadata)?).map_err(failed)?;
    add_library(target, &folder)?;
    if runs {
        tried(&folder.join(program))?;
    }
    let file = pack(&name, target)?;
    eprintln!("== {target}: {FOLDER}/{file}");
    Ok(())
}

/// Adds the library that `stiction export --to fmu --plant` copies into FMUs, in the folder of the
/// program. Simulators load the library, so it uses the usual C library of the system, although the
/// program is static.
fn add_library(target: &str, folder: &Path) -> Result<(), String> {
    let target = target.replace("-linux-musl", "-linux-gnu");
    if !has_target(&target) {
        eprintln!(
            "== the archive has no library of plant FMUs: the standard library of {target} is not installed"
        );
        return Ok(());
    }
    if !crate::fmu::build(&["--locked", "--target", &target]) {
        return Err("the build of the library of plant FMUs failed".to_owned());
    }
    let library = match &target {
        target if target.contains("windows") => "stiction_fmu.dll",
        target if target.contains("apple") => "libstiction_fmu.dylib",
        _ => "libstiction_fmu.so",
    };
    let built = Path::new("target").join(&target).join("release").join(library);
    fs::copy(&built, folder.join(library)).map_err(|e| format!("{}: {e}", built.display()))?;
    Ok(())
}

/// Runs the program and returns its standard output.
fn said(program: &Path, arguments: &[&str]) -> Result<Vec<u8>, String> {
    let output = Command::new(program).args(arguments).output();
    let output = output.map_err(|error| format!("{}: {error}", program.display()))?;
    match output.status.success() && !output.stdout.is_empty() {
        true => Ok(output.stdout),
        false => Err(format!("`stiction {}` failed", arguments.join(" "))),
    }
}

/// Builds the program for this machine.
fn native() -> Result<PathBuf, String> {
    match succeeds(&mut cargo(&["build", "--release", "--locked", "-p", "stiction-cli"])) {
        true => {
            Ok(Path::new("target/release").join(format!("stiction{}", env::consts::EXE_SUFFIX)))
        }
        false => Err("the build for this machine failed".to_owned()),
    }
}

/// Tests the packed program without environment variables, in an empty folder.
fn tried(program: &Path) -> Result<(), String> {
    let program = program.canonicalize().map_err(|error| error.to_string())?;
    let empty = Path::new(FOLDER).join("empty");
    fs::create_dir_all(&empty).map_err(|error| error.to_string())?;
    let output = Command::new(&program)
        .args(["inverse", "3rps", "--json", "-o", "results"])
        .env_clear()
        .current_dir(&empty)
        .output()
        .map_err(|error| error.to_string())?;
    let value = serde_json::from_slice::<Value>(&output.stdout);
    let is_good = output.status.success() && value.is_ok_and(|value| value["drives"].is_object());
    let _ = fs::remove_dir_all(&empty);
    if is_good { Ok(()) } else { Err("the packed program does not run".to_owned()) }
}

/// Packs a folder with names and times that do not depend on this machine; returns the name of the
/// archive.
fn pack(name: &str, target: &str) -> Result<String, String> {
    let is_windows = target.contains("windows");
    let file = format!("{name}.{}", if is_windows { "zip" } else { "tar.gz" });
    let _ = fs::remove_file(Path::new(FOLDER).join(&file));
    let mut command = if is_windows && !cfg!(windows) {
        let mut zip = Command::new("zip");
        zip.args(["-q", "-r", "-X", &file, name]);
        zip
    } else {
        let mut tar = Command::new("tar");
        if is_windows {
            // The tar of Windows chooses the format by the file extension.
            tar.args(["-a", "-cf", &file, name]);
        } else if cfg!(target_os = "linux") {
            let fixed = ["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "--mtime=@0"];
            tar.args(fixed).args(["-czf", &file, name]).env("GZIP", "-n");
        } else {
            tar.args(["-czf", &file, name]);
        }
        tar
    };
    match succeeds(command.current_dir(FOLDER)) {
        true => Ok(file),
        false => Err(format!("cannot pack {file}")),
    }
}

/// Writes the checksums of all archives.
fn checksums() -> Result<(), String> {
    let entries = fs::read_dir(FOLDER).map_err(|error| error.to_string())?;
    let names = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok());
    let mut archives: Vec<String> =
        names.filter(|name| name.ends_with(".tar.gz") || name.ends_with(".zip")).collect();
    archives.sort();
    let tools: [(&str, &[&str]); 2] = [("sha256sum", &[]), ("shasum", &["-a", "256"])];
    for (tool, options) in tools {
        let output = Command::new(tool).args(options).args(&archives).current_dir(FOLDER).output();
        if let Ok(output) = output
            && output.status.success()
        {
            return fs::write(Path::new(FOLDER).join("SHA256SUMS"), output.stdout)
                .map_err(|error| error.to_string());
        }
    }
    Err("neither sha256sum nor shasum runs here".to_owned())
}

/// Packages that are linked into the program for a target, as cargo describes them.
fn metadata(target: &str) -> Result<Value, String> {
    let arguments = ["metadata", "--format-version=1", "--locked", "--filter-platform", target];
    let output = cargo(&arguments).output().map_err(|error| error.to_string())?;
    serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())
}

fn program_package(metadata: &Value) -> Option<&Value> {
    metadata["packages"].as_array()?.iter().find(|package| package["name"] == "stiction-cli")
}

fn version(metadata: &Value) -> Option<String> {
    Some(program_package(metadata)?["version"].as_str()?.to_owned())
}

/// Names, licences and licence texts of all packages of other authors that are linked into the Python package.
pub(crate) fn licences_of_wheel() -> Result<String, String> {
    let arguments = ["metadata", "--format-version=1", "--locked"];
    let output = cargo(&arguments).output().map_err(|error| error.to_string())?;
    let metadata: Value =
        serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())?;
    licences_of(&metadata, "stiction-python")
}

fn licences(metadata: &Value) -> Result<String, String> {
    licences_of(metadata, "stiction-cli")
}

/// Names, licences and licence texts of all packages of other authors that are linked into a package of this project.
fn licences_of(metadata: &Value, package: &str) -> Result<String, String> {
    let nodes = metadata["resolve"]["nodes"].as_array().ok_or("cargo resolves nothing")?;
    let all = metadata["packages"].as_array();
    let root = all.into_iter().flatten().find(|known| known["name"] == package);
    let root = root.and_then(|package| package["id"].as_str());
    let mut reached: BTreeSet<&str> = BTreeSet::new();
    let mut open: Vec<&str> = root.into_iter().collect();
    while let Some(id) = open.pop() {
        if !reached.insert(id) {
            continue;
        }
        let node = nodes.iter().find(|node| node["id"] == id);
        let dependencies = node.and_then(|node| node["deps"].as_array()).into_iter().flatten();
        // Dependencies of tests and of builds are not linked.
        let is_linked = |dependency: &&Value| {
            let kinds = dependency["dep_kinds"].as_array();
            kinds.is_some_and(|kinds| kinds.iter().any(|kind| kind["kind"].is_null()))
        };
        open.extend(
            dependencies.filter(is_linked).filter_map(|dependency| dependency["pkg"].as_str()),
        );
    }
    let packages = metadata["packages"].as_array().ok_or("cargo names no packages")?;
    let mut all: BTreeMap<String, &Value> = BTreeMap::new();
    for package in packages {
        let is_ours = package["source"].is_null();
        if !is_ours && package["id"].as_str().is_some_and(|id| reached.contains(id)) {
            let name = format!("{} {}", text(package, "name"), text(package, "version"));
            all.insert(name, package);
        }
    }
    let mut out = "Software of other authors that is linked into stiction.\n".to_owned();
    for (name, package) in all {
        let rule = "=".repeat(80);
        let _ = write!(out, "\n{rule}\n{name}: {}\n", text(package, "license"));
        let folder = Path::new(text(package, "manifest_path")).parent();
        let mut files: Vec<PathBuf> = folder
            .and_then(|folder| fs::read_dir(folder).ok())
            .into_iter()
            .flatten()
            .flatten()
            .map(|entry| entry.path())
            .filter(|path| is_licence(path))
            .collect();
        files.sort();
        for file in files {
            let content =
                fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
            let _ = write!(out, "\n{}\n", String::from_utf8_lossy(&content).trim_end());
        }
    }
    Ok(out)
}

fn text<'a>(package: &'a Value, key: &str) -> &'a str {
    package[key].as_str().unwrap_or_default()
}

fn is_licence(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_uppercase();
    let begins = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"];
    path.is_file() && begins.iter().any(|begin| name.starts_with(begin))
}
