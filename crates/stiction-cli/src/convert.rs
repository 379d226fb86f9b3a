//! `stiction convert`: the mechanism for other programs.

use crate::arguments::{Convert, Format};
use crate::failure::Failure;
use crate::inverse::{failure_of, warn};
use crate::outputs::Outputs;
use crate::print;
use crate::sources;
use std::io::Write as _;
use std::path::Path;
use stiction_core::dynamics::FrictionMode;
use stiction_format::LoadCase;
use stiction_run::exchange::{Home, Instant, json_text, mjcf, model_file};
use stiction_run::inverse::Job;

pub(crate) fn run(options: &Convert) -> Result<(), Failure> {
    let found = sources::find(&options.model)?;
    warn(&found.model.warnings);
    let (motion, motion_name) = found.motion(options.motion.as_deref())?;
    let load = LoadCase::default();
    let job = Job {
        model: &found.model,
        motion: &motion,
        motion_name,
        load: &load,
        load_name: "none".to_owned(),
        friction: FrictionMode::Off,
        step: None,
        friction_margin: false,
    };
    let home = Home::of(&job).map_err(failure_of)?;
    let text = match options.to {
        Format::Json => json_text(&home),
        Format::Model => {
            let instant = Instant {
                motion: &home.motion,
                loads: &[],
                friction: found.model.default_friction,
            };
            model_file(&home.mechanism, &found.model.title, instant).map_err(|unwritable| {
                Failure::input(unwritable.to_string())
                    .help("give it the same law both ways, with other coefficients")
            })?
        }
        Format::Mjcf => {
            let converted = mjcf(&home)
                .map_err(|unfit| Failure::input(unfit.to_string()).help(unfit.help()))?;
            for note in &converted.notes {
                tell!("note: {note}");
            }
            converted.text
        }
    };
    match &options.output {
        None => print(&text),
        Some(path) => write(path, &text, &options.model),
    }
}

/// Writes a file that is complete or absent; into what is there and is no file, as a pipe, as it comes.
fn write(path: &Path, text: &str, model: &str) -> Result<(), Failure> {
    let failure = |why: String| {
        Failure::input(format!("cannot write {}: {why}", path.display()))
            .help("give the name of a file with -o")
    };
    if path.is_dir() || path.as_os_str().to_string_lossy().ends_with('/') {
        return Err(failure("it is a folder".into()));
    }
    if path.is_symlink() && !path.exists() {
        return Err(failure("it is a link that leads nowhere".into()));
    }
    // A link keeps leading to what it led to.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if Path::new(model).canonicalize().is_ok_and(|own| own == target) {
        return Err(failure("that is the model itself".into()));
    }
    if sources::was_read(&target) {
        return Err(failure("it was read for this".into()));
    }
    if target.exists() && !target.is_file() {
        let into = std::fs::OpenOptions::new().write(true).open(&target);
        return into
            .and_then(|mut into| into.write_all(text.as_bytes()))
            .map_err(|error| failure(error.to_string()));
    }
    let name = target.file_name().and_then(|name| name.to_str());
    let name = name.ok_or_else(|| failure("its name is no text".into()))?;
    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    if folder.exists() && !folder.is_dir() {
        return Err(failure(format!("{} is a file", folder.display())));
    }
    let mut outputs = Outputs::new(folder)?;
    outputs.write(name, text.as_bytes())?;
    outputs.complete(&[])?;
    tell!("wrote {}", path.display());
    Ok(())
}
