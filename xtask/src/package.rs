//! `cargo xtask wheel` builds and tests the Python package as a wheel; `cargo xtask python` runs
//! the tests of the package.

use crate::dist::licences_of_wheel;
use crate::python::{Environment, Missing, create, install, interpreter_in};
use crate::validate::{Outcome, Program};
use crate::{cargo, succeeds};
use std::env;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Oldest version of Python that the package supports.
const LEAST_PYTHON: (u32, u32) = (3, 10);

fn root() -> PathBuf {
    let xtask = Path::new(env!("CARGO_MANIFEST_DIR"));
    xtask.parent().unwrap_or(xtask).to_owned()
}

/// Folder of the package in this project.
fn source() -> PathBuf {
    root().join("crates/stiction-python")
}

/// Folder for all build products of the Python package.
fn built() -> PathBuf {
    root().join("target/python")
}

/// Tests the package with the native module of the current profile.
pub(crate) fn test(program: Program) -> Outcome {
    let requirements = source().join("requirements.txt");
    let environment = Environment {
        place: built().join("tests"),
        requirements: &requirements,
        least: LEAST_PYTHON,
    };
    let python = match environment.interpreter() {
        Ok(python) => python,
        Err(missing) => return skipped(&missing),
    };
    let mut build = cargo(&["build", "--workspace", "--lib", "--bin", "stiction"]);
    if program == Program::Built {
        // With the tests, cargo enables the same features of dependencies as before and compiles
        // only the native module.
        build.arg("--tests");
    }
    if !succeeds(&mut build) {
        return Outcome::Failed;
    }
    let folder = built().join("package");
    let this = env::current_exe().unwrap_or_default();
    let libraries = this.parent().unwrap_or(Path::new(""));
    if let Err(why) = assemble(&folder, libraries) {
        eprintln!("== Python package failed: {why}");
        return Outcome::Failed;
    }
    let mut run = Command::new(python);
    run.args(["-m", "pytest", "--quiet", "--config-file"]).arg(source().join("pyproject.toml"));
    run.arg(source().join("tests")).env("PYTHONPATH", &folder).env("PYTHONDONTWRITEBYTECODE", "1");
    run.env("STICTION", this.with_file_name(format!("stiction{}", env::consts::EXE_SUFFIX)));
    if succeeds(&mut run) { Outcome::Passed } else { Outcome::Failed }
}

/// Reports a missing prerequisite. In continuous integration, packages that cannot be installed
/// count as a failure.
fn skipped(missing: &Missing) -> Outcome {
    let is_ci = env::var_os("CI").is_some_and(|value| value == "true");
    if is_ci && matches!(missing, Missing::Packages(_)) {
        eprintln!("== tests of the Python package failed: {}", missing.text());
        return Outcome::Failed;
    }
    eprintln!("== tests of the Python package skipped: {}", missing.text());
    Outcome::Skipped
}

/// Copies the package's Python files and the native module, which is in `libraries`, into `folder`.
pub(crate) fn assemble(folder: &Path, libraries: &Path) -> Result<(), String> {
    let told = |what: &Path, error: std::io::Error| format!("{}: {error}", what.display());
    let package = folder.join("stiction");
    if package.exists() {
        fs::remove_dir_all(&package).map_err(|error| told(&package, error))?;
    }
    fs::create_dir_all(&package).map_err(|error| told(&package, error))?;
    let from = source().join("python/stiction");
    for entry in fs::read_dir(&from).map_err(|error| told(&from, error))?.flatten() {
        let path = entry.path();
        let is_source =
            ["py", "pyi", "typed"].map(OsStr::new).map(Some).contains(&path.extension());
        if is_source {
            fs::copy(&path, package.join(entry.file_name())).map_err(|error| told(&path, error))?;
        }
    }
    let (prefix, suffix) = (env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
    let library = libraries.join(format!("{prefix}stiction_native{suffix}"));
    let name = if cfg!(windows) { "_native.pyd" } else { "_native.abi3.so" };
    fs::copy(&library, package.join(name)).map_err(|error| told(&library, error))?;
    Ok(())
}

/// Options for building the wheel.
#[derive(Default)]
struct Wheel {
    profile: Option<String>,
    /// Target of the compiler; that of this machine if absent.
    target: Option<String>,
    /// Systems on which the wheel can be installed, such as `manylinux2014`; without this option,
    /// the build tool chooses the tag.
    compatibility: Option<String>,
    /// Links with Zig, which links against old versions of the C library.
    zig: bool,
}

impl Wheel {
    fn parse(mut arguments: impl Iterator<Item = String>) -> Option<Self> {
        let mut wheel = Self::default();
        while let Some(option) = arguments.next() {
            let place = match option.as_str() {
                "--profile" => &mut wheel.profile,
                "--target" => &mut wheel.target,
                "--compatibility" => &mut wheel.compatibility,
                "--zig" => {
                    wheel.zig = true;
                    continue;
                }
                _ => return None,
            };
            *place = Some(arguments.next()?);
        }
        Some(wheel)
    }

    /// True if Python on this machine can install the wheel.
    fn can_be_tried(&self) -> bool {
        self.target.is_none() || self.target == crate::dist::host()
    }
}

/// Builds the wheel into `target/wheels`, and tests it in an empty environment.
pub(crate) fn wheel(arguments: impl Iterator<Item = String>) -> ExitCode {
    let Some(wheel) = Wheel::parse(arguments) else {
        eprintln!(
            "usage: cargo xtask wheel [--profile PROFILE] [--target TARGET] [--compatibility TAG] [--zig]"
        );
        return ExitCode::from(2);
    };
    match build_and_try(&wheel) {
        Ok(wheel) => {
            eprintln!("== wheel: {}", wheel.display());
            ExitCode::SUCCESS
        }
        Err(why) => {
            eprintln!("== wheel failed: {why}");
            ExitCode::FAILURE
        }
    }
}

/// Writes the licence texts to the folder of the package's description, where the build tool looks
/// for them.
fn write_licences() -> Result<(), String> {
    let told = |what: &str, error: std::io::Error| format!("{what}: {error}");
    for name in ["LICENSE-MIT", "LICENSE-APACHE"] {
        fs::copy(root().join(name), source().join(name)).map_err(|error| told(name, error))?;
    }
    let name = "LICENSES-THIRD-PARTY.txt";
    fs::write(source().join(name), licences_of_wheel()?).map_err(|error| told(name, error))
}

/// Tests parameter studies on local clusters of Dask and Ray: the rows must be bitwise equal to
/// those of threads, and as fast.
pub(crate) fn clusters() -> Result<bool, String> {
    let wheel = build_and_try(&Wheel::default())?;
    let place = built().join("clusters");
    let told = |missing: Missing| missing.text().to_owned();
    create(&place, LEAST_PYTHON).map_err(told)?;
    let python = interpreter_in(&place);
    let others = ["dask[dataframe]", "distributed", "pandas", "pytest", "ray"].map(Path::new);
    install(&python, &others).map_err(told)?;
    install(&python, &[&wheel]).map_err(told)?;
    let mut run = Command::new(&python);
    // The tests are in the source tree, where no byte code must remain.
    run.args(["-I", "-B", "-m", "pytest", "-s", "-k", "clusters", "-p", "no:cacheprovider"]);
    run.arg(source().join("tests/test_sweep.py")).env("STICTION_CLUSTERS", "100000");
    Ok(succeeds(run.current_dir(&place)))
}

fn build_and_try(wheel: &Wheel) -> Result<PathBuf, String> {
    let told = |missing: Missing| missing.text().to_owned();
    let requirements = source().join("requirements-wheel.txt");
    let environment = Environment {
        place: built().join("maturin"),
        requirements: &requirements,
        least: LEAST_PYTHON,
    };
    let python = environment.interpreter().map_err(told)?;
    // A separate folder, so that it contains only this wheel.
    let fresh = built().join("wheel");
    let _ = fs::remove_dir_all(&fresh);
    write_licences()?;
    let mut maturin = Command::new(&python);
    let profile = wheel.profile.as_deref().unwrap_or("release");
    maturin.args(["-m", "maturin", "build", "--locked", "--profile", profile, "--manifest-path"]);
    maturin.arg(source().join("Cargo.toml")).arg("--out").arg(&fresh);
    for (option, value) in [("--target", &wheel.target), ("--compatibility", &wheel.compatibility)]
    {
        value.as_ref().map(|value| maturin.args([option, value]));
    }
    if wheel.zig {
        maturin.arg("--zig");
    }
    crate::viewer::include_in(&mut maturin);
    if !succeeds(&mut maturin) {
        return Err("maturin cannot build it".to_owned());
    }
    let files = fs::read_dir(&fresh).map_err(|error| format!("{}: {error}", fresh.display()))?;
    let is_wheel = |path: &PathBuf| path.extension() == Some(OsStr::new("whl"));
    let file =
        files.flatten().map(|entry| entry.path()).find(is_wheel).ok_or("there is no wheel")?;

    if wheel.can_be_tried() {
        let trial = built().join("trial");
        create(&trial, LEAST_PYTHON).map_err(told)?;
        let python = interpreter_in(&trial);
        install(&python, &[&file]).map_err(told)?;
        // Isolated, so that Python finds only the installed package.
        let mut run = Command::new(&python);
        run.arg("-I").arg(source().join("tests/trial.py")).current_dir(&trial);
        if !succeeds(&mut run) {
            return Err("the installed package does not work".to_owned());
        }
    } else {
        eprintln!("== the wheel of another system is not tried");
    }
    let wheels = root().join("target/wheels");
    let kept = wheels.join(file.file_name().unwrap_or_default());
    fs::create_dir_all(&wheels)
        .and_then(|()| fs::rename(&file, &kept))
        .map_err(|error| format!("{}: {error}", kept.display()))?;
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(arguments: &str) -> Option<Wheel> {
        Wheel::parse(arguments.split_whitespace().map(str::to_owned))
    }

    #[test]
    fn options_of_wheels() {
        let plain = parsed("").expect("no option is needed");
        assert!(plain.can_be_tried() && plain.profile.is_none() && !plain.zig);
        let text = "--target riscv64gc-unknown-linux-gnu --zig --compatibility manylinux_2_31";
        let other = parsed(text).expect("all options are known");
        assert!(!other.can_be_tried() && other.zig);
        assert_eq!(other.compatibility.as_deref(), Some("manylinux_2_31"));
        assert!(parsed("--target").is_none() && parsed("--zag").is_none());
    }
}
