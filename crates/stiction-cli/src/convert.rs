//! `stiction convert`: the mechanism in formats of other programs.

use crate::arguments::{Convert, Format};
use crate::failure::Failure;
use crate::fold::folded;
use crate::outputs::Outputs;
use crate::print;
use crate::sources::{self, warn};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use stiction::Error;
use stiction_run::exchange::{Home, Instant, json_text, mjcf, model_file};

pub(crate) fn run(options: &Convert) -> Result<(), Failure> {
    let robot = sources::robot(&options.model, &options.set)?;
    warn(robot.warnings());
    let mut request = robot.check_along();
    if let Some(motion) = &options.motion {
        request = request.motion(motion)?;
    }
    let job = request.job()?;
    let home = Home::of(&job).map_err(Error::from)?;
    let text = match options.to {
        Format::Json => json_text(&home),
        Format::Model => {
            let instant = Instant {
                motion: &home.motion,
                loads: &[],
                friction: robot.model().default_friction,
            };
            model_file(&home.mechanism, robot.title(), instant).map_err(|unwritable| {
                Failure::input(unwritable.to_string())
                    .help("use the same law in both directions; the coefficients may differ")
            })?
        }
        Format::Mjcf => {
            let converted = mjcf(&home)
                .map_err(|unfit| Failure::input(unfit.to_string()).help(unfit.help()))?;
            for note in &converted.notes {
                note!("{}", folded(&format!("note: {note}")));
            }
            converted.text
        }
    };
    match &options.output {
        None => print(&text),
        Some(path) => write(path, &text, robot.files_read()),
    }
}

/// Writes a file atomically. Pipes and devices receive the text directly.
fn write(path: &Path, text: &str, files_read: Vec<PathBuf>) -> Result<(), Failure> {
    let failure = |why: String| {
        Failure::input(format!("cannot write {}: {why}", path.display()))
            .help("give the name of a file with -o")
    };
    if path.is_dir() || path.as_os_str().to_string_lossy().ends_with('/') {
        return Err(failure("it is a folder".into()));
    }
    if path.is_symlink() && !path.exists() {
        return Err(failure("it is a link to a file that does not exist".into()));
    }
    // Keep a symbolic link and write its target.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if files_read.contains(&target) {
        return Err(failure("it is an input of this conversion".into()));
    }
    if target.exists() && !target.is_file() {
        let into = std::fs::OpenOptions::new().write(true).open(&target);
        return into
            .and_then(|mut into| into.write_all(text.as_bytes()))
            .map_err(|error| failure(error.to_string()));
    }
    let name = target.file_name().and_then(|name| name.to_str());
    let name = name.ok_or_else(|| failure("its name is not valid UTF-8".into()))?;
    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    if folder.exists() && !folder.is_dir() {
        return Err(failure(format!("{} is a file", folder.display())));
    }
    let mut outputs = Outputs::new(folder, files_read)?;
    outputs.write(name, text.as_bytes())?;
    outputs.complete(&[])?;
    note!("wrote {}", path.display());
    Ok(())
}
