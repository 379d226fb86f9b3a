//! Plant FMUs: archives that contain the model, and the shared library with the engine.

use super::fmu::archive;
use crate::arguments::{Export as Options, Language, Switch};
use crate::convert;
use crate::failure::Failure;
use std::path::{Path, PathBuf};
use std::{env, fs};
use stiction::{Export, Fmi};

/// Writes the FMU that simulates the robot as a plant (forward dynamics).
pub(super) fn write(
    export: &Export,
    options: &Options,
    files_read: Vec<PathBuf>,
) -> Result<(), Failure> {
    if options.to != Language::Fmu {
        return Err(Failure::input(
            "--plant exports a functional mock-up unit (FMU), but --to names \
                another format",
        )
        .help("write `--to fmu --plant`"));
    }
    let fmi = if options.fmi == 2 { Fmi::Two } else { Fmi::Three };
    let mut plant = export.plant();
    let chosen = &options.plant;
    if let Some(start) = &chosen.from {
        plant = plant.from(start);
    }
    if let Some(load) = &chosen.load {
        plant = plant.load(load);
    }
    if let Some(friction) = chosen.friction {
        plant = plant.friction(friction == Switch::On);
    }
    if let Some(tolerance) = chosen.tolerance {
        plant = plant.tolerance(tolerance);
    }
    for body in &options.force_on {
        plant = plant.force_on(body);
    }
    let unit = plant.fmu(fmi)?;
    let platform = fmi.platform(env::consts::OS, env::consts::ARCH).ok_or_else(|| {
        Failure::input("the FMI standard has no name for this platform").help(match fmi {
            Fmi::Two => "choose `--fmi 3`, which has names for more platforms",
            Fmi::Three => "export the FMU on a computer with Linux, macOS or Windows",
        })
    })?;
    let library = library(chosen.library.as_deref())?;
    let mut files: Vec<(String, Vec<u8>)> =
        unit.files.into_iter().map(|file| (file.name, file.text.into_bytes())).collect();
    let place = format!("binaries/{platform}/{}{}", unit.identifier, env::consts::DLL_SUFFIX);
    files.push((place, library));
    convert::write(&options.output, &archive(&files)?, files_read)
}

/// Reads the shared library with the engine, and checks that its version is that of this program.
fn library(given: Option<&Path>) -> Result<Vec<u8>, Failure> {
    let version = env!("CARGO_PKG_VERSION");
    let name = format!("{}stiction_fmu{}", env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
    let cure = format!(
        "build it with `cargo xtask fmu` in the source code of version {version}, and put it \
         beside the program, or give its path with --library"
    );
    let path = match given {
        Some(path) => path.to_owned(),
        None => {
            let program = env::current_exe().and_then(|path| path.canonicalize());
            let folder = program.ok().and_then(|path| Some(path.parent()?.to_owned()));
            let folder = folder.unwrap_or_default();
            let places = [folder.join(&name), folder.join("../lib").join(&name)];
            let found = places.iter().find(|path| path.is_file());
            found.cloned().ok_or_else(|| {
                let folder = folder.display();
                Failure::input(format!(
                    "a plant needs the library {name}, which is neither in {folder} nor in {folder}/../lib"
                ))
                .help(cure.as_str())
            })?
        }
    };
    let shown = path.display();
    let bytes = fs::read(&path).map_err(|error| {
        Failure::input(format!("cannot read the library {shown}: {error}")).help(cure.as_str())
    })?;
    let contains = |mark: &str| bytes.windows(mark.len()).any(|part| part == mark.as_bytes());
    if !contains("stiction-fmu version ") {
        return Err(Failure::input(format!("{shown} is not the library {name}")).help(cure));
    }
    if !contains(&format!("stiction-fmu version {version};")) {
        let message = format!(
            "the library {shown} does not have version {version}, the version of this program"
        );
        return Err(Failure::input(message).help(cure));
    }
    Ok(bytes)
}
