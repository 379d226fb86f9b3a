//! `stiction convert`: the mechanism for other programs.

use crate::arguments::{Convert, Format};
use crate::failure::Failure;
use crate::inverse::{failure_of, warn};
use crate::outputs::Outputs;
use crate::print;
use crate::sources;
use std::path::Path;
use stiction::dynamics::FrictionMode;
use stiction_model::LoadCase;
use stiction_study::exchange::{Home, json_text, mjcf};
use stiction_study::inverse::Job;

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
        Format::Mjcf => {
            let converted = mjcf(&home)
                .map_err(|unfit| Failure::input(unfit.to_string()).help(unfit.help()))?;
            for note in &converted.notes {
                eprintln!("note: {note}");
            }
            converted.text
        }
    };
    match &options.output {
        None => print(&text),
        Some(path) => write(path, &text),
    }
}

/// Writes a file that is complete or absent.
fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let name = path.file_name().and_then(|name| name.to_str());
    let Some(name) = name.filter(|_| !path.is_dir()) else {
        return Err(Failure::input(format!("cannot write {}: it is a folder", path.display()))
            .help("give the name of a file with -o"));
    };
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let mut outputs = Outputs::new(folder)?;
    outputs.write(name, text.as_bytes())?;
    outputs.complete(&[])?;
    eprintln!("wrote {}", path.display());
    Ok(())
}
