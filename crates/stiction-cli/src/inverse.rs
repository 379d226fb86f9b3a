//! `stiction inverse`: inverse dynamics along a motion.

use crate::arguments::Inverse;
use crate::failure::Failure;
use crate::fold::folded;
use crate::outputs::Outputs;
use crate::print;
use crate::progress::Progress;
use crate::sources::{self, DEFAULT_MODEL, note_frictionless, warn};
use std::fs::File;
use std::io::{BufWriter, IsTerminal};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use stiction::{Error, FrictionMode};
use stiction_run::inverse::{Curves, Summary, Tables, write_summary};

pub(crate) fn run(options: &Inverse) -> Result<(), Failure> {
    execute(options).map_err(|failure| failure.into_json(options.json))
}

fn execute(options: &Inverse) -> Result<(), Failure> {
    let robot = sources::robot_or_default(&options.model)?;
    if options.model.name.is_none() {
        note!(
            "No model given: running `{DEFAULT_MODEL}`, a built-in robot whose three driven legs lift and tilt a\n\
             platform; `stiction models` lists all. It is the regular twin of a published robot that is\n\
             singular as printed; `stiction study zhang2018` shows how.\n"
        );
    }
    warn(robot.warnings());
    let mut request = robot.inverse().friction_margin(options.friction_margin);
    if let Some(motion) = &options.motion {
        request = request.motion(motion)?;
    }
    if let Some(load) = &options.load {
        request = request.load(load)?;
    }
    if let Some(friction) = options.friction {
        request = request.friction(friction.into());
    }
    if let Some(step) = options.step {
        request = request.step(step);
    }
    if let Some(threads) = options.threads.or_else(|| std::thread::available_parallelism().ok()) {
        request = request.threads(threads);
    }
    let job = request.job()?;
    let friction = job.friction;
    if friction != FrictionMode::Off {
        note_frictionless(&robot);
    }

    let count = job.instants().map_err(Error::from)?.count();
    let interrupted = listen_for_interrupt();
    let mut outputs =
        options.output.as_deref().map(|dir| Outputs::new(dir, robot.files_read())).transpose()?;
    outputs.as_ref().map_or(Ok(()), Outputs::refuse_interrupted)?;
    let mut tables = match &mut outputs {
        None => None,
        Some(outputs) => {
            let names = Tables::<BufWriter<File>>::files(&job);
            let files =
                names.into_iter().map(|name| outputs.begin(name)).collect::<Result<_, _>>()?;
            let tables = Tables::new(&job, files);
            Some(tables.map_err(|error| outputs.trouble_with_tables(error))?)
        }
    };
    let mut summary = Summary::new(&job);
    let mut curves = outputs.is_some().then(|| Curves::new(&job, count));

    let mut progress = Progress::new();
    let outcome = request.record((&mut summary, &mut curves, &mut tables), |phase, done, of| {
        progress.update(phase, done, of);
        !interrupted.load(Ordering::Relaxed)
    });
    progress.clear();
    let verdict = outcome.map_err(|error| Outputs::explain(outputs.as_ref(), error))?;
    for note in &verdict.assembly_notes {
        note!("{}\n", folded(&format!("note: {note}")));
    }
    if options.friction_margin && verdict.friction_margin.is_none() {
        let why = match friction {
            FrictionMode::Off => "friction is off",
            _ => "no joint slides at any regular sample",
        };
        note!("note: the friction margin to jamming is not known: {why}\n");
    }

    let json = summary.json(&job, &verdict);
    if options.json {
        print(&format!("{json:#}\n"))?;
    } else {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = write_summary(&mut text, &job, &summary, &verdict);
        print(&folded(&text))?;
    }
    if let (Some(mut outputs), Some(tables), Some(curves)) = (outputs, tables, curves) {
        let files = tables.finish().map_err(|error| outputs.trouble_with_tables(error))?;
        for (name, file) in Tables::<BufWriter<File>>::files(&job).into_iter().zip(files) {
            outputs.end(name, file, &[])?;
        }
        outputs.write("summary.json", format!("{json:#}\n").as_bytes())?;
        outputs.write_figures(curves.figures())?;
        let names = outputs.complete(&[
            "friction.svg",
            "friction.png",
            "motors.csv",
            "motors.svg",
            "motors.png",
            "shares.csv",
            "shares.svg",
            "shares.png",
        ])?;
        if !options.json {
            let names: Vec<String> = names.iter().map(|name| name.display().to_string()).collect();
            note!("\nwrote {}", names.join(", "));
        }
    } else if !options.json && std::io::stderr().is_terminal() {
        note!("\nTables and plots: add -o DIR");
    }
    Ok(())
}

/// Installs handlers for Ctrl-C and SIGTERM that set the returned flag, so that the program ends
/// cleanly. A second signal ends it immediately.
pub(crate) fn listen_for_interrupt() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let set = Arc::clone(&flag);
    // Without a handler Ctrl-C still stops the program, but leaves temporary files.
    let _ = ctrlc::set_handler(move || {
        if set.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        note!("\nstopping after the present step; Ctrl-C again stops at once");
    });
    flag
}
