//! `stiction check`: verdicts on a mechanism.

use crate::arguments::Check;
use crate::failure::Failure;
use crate::inverse::{DEFAULT_MODEL, failure_of, listen_for_interrupt, warn};
use crate::outputs::Outputs;
use crate::print;
use crate::progress::Progress;
use crate::sources;
use std::sync::atomic::Ordering;
use stiction_core::dynamics::FrictionMode;
use stiction_format::LoadCase;
use stiction_run::check::{draw_page, examine, write_report};
use stiction_run::inverse::Job;

pub(crate) fn run(options: &Check) -> Result<(), Failure> {
    carry_out(options).map_err(|failure| failure.for_programs(options.json))
}

fn carry_out(options: &Check) -> Result<(), Failure> {
    let found = sources::find(options.model.as_deref().unwrap_or(DEFAULT_MODEL))?;
    if !options.json {
        warn(&found.model.warnings);
    }
    let (motion, motion_name) = found.motion(options.motion.as_deref())?;
    let load = LoadCase::default();
    let job = Job {
        model: &found.model,
        motion: &motion,
        motion_name,
        load: &load,
        load_name: "none".to_owned(),
        friction: FrictionMode::Off,
        step: options.step,
        friction_margin: false,
    };
    let interrupted = listen_for_interrupt();
    // A folder that cannot be written is told before anything is computed.
    let mut outputs = options.output.as_deref().map(Outputs::new).transpose()?;
    let files = match &mut outputs {
        None => None,
        Some(outputs) => Some([
            outputs.begin("check.html")?,
            outputs.begin("check.json")?,
            outputs.begin("mechanism.svg")?,
        ]),
    };
    let mut progress = Progress::new();
    let findings = examine(&job, |phase, done, of| {
        progress.tell(phase, done, of);
        !interrupted.load(Ordering::Relaxed)
    });
    progress.clear();
    let findings = findings.map_err(failure_of)?;
    let json = format!("{:#}\n", findings.json(&job));
    if options.json {
        print(&json)?;
    } else {
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = write_report(&mut text, &job, &findings);
        print(&text)?;
    }
    let (Some(outputs), Some([html, programs, picture])) = (outputs, files) else { return Ok(()) };
    let page = draw_page(&job, &findings).map_err(failure_of)?;
    outputs.end("check.html", html, page.html.as_bytes())?;
    outputs.end("check.json", programs, json.as_bytes())?;
    outputs.end("mechanism.svg", picture, page.picture.as_bytes())?;
    let names = outputs.complete(&[])?;
    if !options.json {
        let names: Vec<String> = names.iter().map(|name| name.display().to_string()).collect();
        tell!("\nwrote {}", names.join(", "));
    }
    Ok(())
}
