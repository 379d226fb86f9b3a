//! Functional mock-up units: archives that contain source code and a binary for this platform.

use crate::arguments::Export as Options;
use crate::convert;
use crate::failure::Failure;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};
use stiction::{Export, Fmi, Fmu};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// C compilers that are tried in this order if the environment variable `CC` is not set.
const COMPILERS: [&str; 3] = ["cc", "gcc", "clang"];

/// Writes the FMU that computes the feed-forward efforts of the actuators.
pub(super) fn write(
    export: &Export,
    options: &Options,
    files_read: Vec<PathBuf>,
) -> Result<(), Failure> {
    let fmi = if options.fmi == 2 { Fmi::Two } else { Fmi::Three };
    let fmu = export.fmu(fmi)?;
    super::note_remarks(export);
    let mut files: Vec<(String, Vec<u8>)> =
        fmu.files.iter().map(|file| (file.name.clone(), file.text.clone().into_bytes())).collect();
    match binary(&fmu, fmi) {
        Ok(binary) => files.push(binary),
        Err(why) => note!(
            "note: the FMU contains only source code: {why}; tools that compile FMUs accept it, others need a binary"
        ),
    }
    convert::write(&options.output, &archive(&files)?, files_read)
}

/// Packs files, each given by its name and content, into a ZIP archive. Equal files yield
/// byte-identical archives.
pub(super) fn archive(files: &[(String, Vec<u8>)]) -> Result<Vec<u8>, Failure> {
    let trouble = |error: &dyn std::fmt::Display| {
        Failure::input(format!("the FMU cannot be archived: {error}"))
    };
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in files {
        let is_binary = name.starts_with("binaries/");
        let file = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(zip::DateTime::default())
            .unix_permissions(if is_binary { 0o755 } else { 0o644 });
        zip.start_file(name, file).map_err(|error| trouble(&error))?;
        zip.write_all(content).map_err(|error| trouble(&error))?;
    }
    Ok(zip.finish().map_err(|error| trouble(&error))?.into_inner())
}

/// Temporary folder, which is removed when the value is dropped.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Compiles the source code for this platform. Returns the path in the archive and the bytes of the
/// binary, or the reason why compilation is impossible.
fn binary(fmu: &Fmu, fmi: Fmi) -> Result<(String, Vec<u8>), String> {
    let platform = fmi
        .platform(env::consts::OS, env::consts::ARCH)
        .ok_or("the FMI standard has no name for this platform")?;
    let compiler = compiler().ok_or("no C compiler is installed (CC, cc, gcc or clang)")?;
    let folder = env::temp_dir().join(format!("stiction-fmu-{}", std::process::id()));
    fs::create_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let folder = Temporary(folder);
    let path = |name: &str| folder.0.join(name);
    for file in &fmu.files {
        let Some(name) = file.name.strip_prefix("sources/") else { continue };
        fs::write(path(name), &file.text).map_err(|error| error.to_string())?;
    }
    let library = format!("{}{}", fmu.identifier, env::consts::DLL_SUFFIX);
    let mut command = Command::new(&compiler[0]);
    command.args(&compiler[1..]);
    command.args(["-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-shared"]);
    if !cfg!(windows) {
        command.arg("-fPIC");
    }
    command.args(["-o", &library]).args(&fmu.sources).arg("-lm").current_dir(&folder.0);
    let output = command.output().map_err(|error| format!("{}: {error}", compiler[0]))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let first = said.lines().find(|line| line.contains("error")).unwrap_or("it failed");
        return Err(format!("{}: {}", compiler[0], first.escape_debug()));
    }
    let content = fs::read(path(&library)).map_err(|error| error.to_string())?;
    Ok((format!("binaries/{platform}/{library}"), content))
}

/// Returns the C compiler and its arguments: those in the environment variable `CC`, or the first
/// of [`COMPILERS`] that is installed.
fn compiler() -> Option<Vec<String>> {
    if let Some(own) = env::var_os("CC") {
        let own = own.to_string_lossy().into_owned();
        if Path::new(&own).exists() {
            return Some(vec![own]);
        }
        let words: Vec<String> = own.split_whitespace().map(str::to_owned).collect();
        if !words.is_empty() {
            return Some(words);
        }
    }
    let runs = |name: &&&str| Command::new(name).arg("--version").output().is_ok();
    COMPILERS.iter().find(runs).map(|name| vec![(*name).to_owned()])
}
