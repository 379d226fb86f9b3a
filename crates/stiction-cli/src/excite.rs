//! `stiction excite`: motions that excite parameters for identification.

use crate::answer;
use crate::arguments::Excite;
use crate::failure::Failure;
use crate::fold::folded;
use crate::inverse::listen_for_interrupt;
use crate::outputs::Outputs;
use crate::print;
use crate::progress::Progress;
use crate::sources::{self, warn};
use crate::written::note_files;
use std::sync::atomic::Ordering;
use stiction::run::excite::ExciteSettings;

/// Name of the file with the reference motion.
const REFERENCE: &str = "excite.csv";
/// Name of the file with the reference motion in the coordinates of the actuators.
const ACTUATORS: &str = "actuators.csv";
/// Name of the file with options for `stiction identify`.
const LOG: &str = "log.toml";
/// Name of the file with the results as JSON.
const RESULT: &str = "excite.json";

pub(crate) fn run(options: &Excite) -> Result<(), Failure> {
    execute(options).map_err(|failure| failure.into_json(options.json))
}

fn execute(options: &Excite) -> Result<(), Failure> {
    let robot = sources::robot_or_default(&options.model)?;
    warn(robot.warnings());
    let settings = ExciteSettings {
        motion: options.motion.clone(),
        by_actuators: options.actuators,
        parameters: options.parameters.clone(),
        duration: options.duration,
        base_frequency: options.base_frequency,
        harmonics: usize::from(options.harmonics),
        limits: options.limit.clone(),
        margin: options.singularity_margin,
        seed: options.seed,
        payloads: options.payload.clone(),
        noise: options.noise.clone(),
        step: options.step,
        at_motors: options.at_motors,
        iterations: options.iterations as usize,
    };
    let interrupted = listen_for_interrupt();
    let outputs = options.output.as_deref();
    let outputs = outputs.map(|dir| Outputs::new(dir, robot.files_read())).transpose()?;
    outputs.as_ref().map_or(Ok(()), Outputs::refuse_interrupted)?;
    let mut progress = Progress::new();
    let found = robot.excite(&settings, |done, of| {
        progress.update_search(done, of);
        !interrupted.load(Ordering::Relaxed)
    });
    progress.clear();
    let found = found?;
    let json = found.to_json();
    match options.json {
        true => answer::give(&json),
        false => print(&folded(&found.to_text()))?,
    }
    let Some(mut outputs) = outputs else { return Ok(()) };
    outputs.write(REFERENCE, found.reference_csv().as_bytes())?;
    if let Some(actuators) = found.actuators_csv() {
        outputs.write(ACTUATORS, actuators.as_bytes())?;
    }
    outputs.write(LOG, found.log_toml().as_bytes())?;
    outputs.write(RESULT, format!("{json:#}\n").as_bytes())?;
    let files = outputs.complete(&[ACTUATORS])?;
    if !options.json {
        note_files(&files, true);
    }
    Ok(())
}
