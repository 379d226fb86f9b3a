//! `stiction inverse`: the main job.

use crate::arguments::Inverse;
use crate::failure::Failure;
use crate::outputs::Outputs;
use crate::print;
use crate::progress::Progress;
use crate::sources;
use serde_json::json;
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use stiction_core::dynamics::{FrictionMode, InverseError};
use stiction_core::kinematics::AssemblyError;
use stiction_core::words::significant;
use stiction_format::Diagnostics;
use stiction_run::inverse::{
    BodyTable, Curves, Error, Job, Missing, ShareTable, Summary, Tables, write_summary,
};

/// The built-in robot.
pub(crate) const DEFAULT_MODEL: &str = "zhang2018-regular";

pub(crate) fn run(options: &Inverse) -> Result<(), Failure> {
    carry_out(options).map_err(|failure| failure.for_programs(options.json))
}

fn carry_out(options: &Inverse) -> Result<(), Failure> {
    let name = options.model.as_deref().unwrap_or(DEFAULT_MODEL);
    let found = sources::find(name)?;
    if options.model.is_none() {
        tell!(
            "No model given: running the built-in `{DEFAULT_MODEL}`, the regular twin of a published \
             robot.\nThe robot as printed is singular at every instant of its motion; `stiction \
             study zhang2018` shows how.\n"
        );
    }
    warn(&found.model.warnings);
    let (motion, motion_name) = found.motion(options.motion.as_deref())?;
    let (load, load_name) = found.load(options.load.as_deref())?;
    let friction = match options.friction {
        Some(friction) => friction.into(),
        None => found.model.default_friction.unwrap_or_default(),
    };
    let job = Job {
        model: &found.model,
        motion: &motion,
        motion_name,
        load: &load,
        load_name,
        friction,
        step: options.step,
        friction_margin: options.friction_margin,
    };
    if friction != FrictionMode::Off
        && job.model.mechanism.joints().iter().all(|j| j.friction.is_empty())
    {
        tell!("note: the model declares no friction in any joint\n");
    }

    let count = job.instants().map_err(|error| failure_of(Error::Instants(error)))?.count();
    let interrupted = listen_for_interrupt();
    let mut outputs = options.output.as_deref().map(Outputs::new).transpose()?;
    outputs.as_ref().map_or(Ok(()), Outputs::spare_interrupted)?;
    let mut tables = match &mut outputs {
        None => None,
        Some(outputs) => {
            let files = [
                outputs.begin("inverse.csv")?,
                outputs.begin("reactions.csv")?,
                outputs.begin("friction.csv")?,
            ];
            let tables = Tables::new(&job.model.mechanism, files);
            Some(tables.map_err(|error| outputs.trouble_with_tables(error))?)
        }
    };
    let mut bodies = match &mut outputs {
        None => None,
        Some(outputs) => {
            let table = BodyTable::new(&job.model.mechanism, outputs.begin("bodies.csv")?);
            Some(table.map_err(|error| outputs.trouble("bodies.csv", error))?)
        }
    };
    let mut shares = match &mut outputs {
        Some(outputs) if job.has_shares() => {
            let table = ShareTable::new(&job, outputs.begin("shares.csv")?);
            Some(table.map_err(|error| outputs.trouble("shares.csv", error))?)
        }
        _ => None,
    };
    let mut summary = Summary::new(&job);
    let mut curves = outputs.is_some().then(|| Curves::new(&job, count));

    let mut progress = Progress::new();
    let threads = options.threads.or_else(|| std::thread::available_parallelism().ok());
    let outcome = job.run_on(
        threads.map_or(1, std::num::NonZeroUsize::get),
        |sample| {
            summary.add(sample);
            if let Some(curves) = &mut curves {
                curves.add(sample);
            }
            if let Some(bodies) = &mut bodies {
                bodies.add(sample).map_err(|error| error.to_string())?;
            }
            if let Some(shares) = &mut shares {
                shares.add(sample).map_err(|error| error.to_string())?;
            }
            match &mut tables {
                Some(tables) => tables.add(sample).map_err(|error| error.to_string()),
                None => Ok(()),
            }
        },
        |phase, done, of| {
            progress.tell(phase, done, of);
            !interrupted.load(Ordering::Relaxed)
        },
    );
    progress.clear();
    let verdict = outcome.map_err(|error| match (error, &outputs) {
        (Error::Receiver(error), Some(outputs)) => outputs.trouble_with_tables(error),
        (error, _) => failure_of(error),
    })?;
    if options.friction_margin && verdict.friction_margin.is_none() {
        let why = match friction {
            FrictionMode::Off => "friction is off",
            _ => "at no sample that is not singular does anything slide",
        };
        tell!("note: how far friction can grow is not known: {why}\n");
    }

    let json = summary.json(&job, &verdict);
    if options.json {
        print(&format!("{json:#}\n"))?;
    } else {
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = write_summary(&mut text, &job, &summary, &verdict);
        print(&text)?;
    }
    if let (Some(mut outputs), Some(tables), Some(curves)) = (outputs, tables, curves) {
        let finished = [
            ("inverse.csv", tables.inverse.finish()),
            ("reactions.csv", tables.reactions.finish()),
            ("friction.csv", tables.friction.finish()),
        ];
        for (name, file) in finished {
            let file = file.map_err(|error| outputs.trouble(name, error))?;
            outputs.end(name, file, &[])?;
        }
        if let Some(bodies) = bodies {
            let file = bodies.finish().map_err(|error| outputs.trouble("bodies.csv", error))?;
            outputs.end("bodies.csv", file, &[])?;
        }
        if let Some(shares) = shares {
            let file = shares.finish().map_err(|error| outputs.trouble("shares.csv", error))?;
            outputs.end("shares.csv", file, &[])?;
        }
        outputs.write("summary.json", format!("{json:#}\n").as_bytes())?;
        for (name, figure) in curves.figures() {
            outputs.write(&format!("{name}.svg"), figure.svg().as_bytes())?;
            #[cfg(feature = "png")]
            {
                let file = format!("{name}.png");
                let png = figure.png().map_err(|error| outputs.trouble(&file, error))?;
                outputs.write(&file, &png)?;
            }
        }
        let names = outputs.complete(&[
            "friction.svg",
            "friction.png",
            "shares.csv",
            "shares.svg",
            "shares.png",
        ])?;
        if !options.json {
            let names: Vec<String> = names.iter().map(|name| name.display().to_string()).collect();
            tell!("\nwrote {}", names.join(", "));
        }
    } else if !options.json && std::io::stderr().is_terminal() {
        tell!("\nTables and plots: add -o DIR");
    }
    Ok(())
}

/// Warnings go to standard error and change nothing.
pub(crate) fn warn(warnings: &Diagnostics) {
    if !warnings.is_empty() {
        let colour = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
        tell!("{}", warnings.render(colour));
    }
}

/// A flag that Ctrl-C sets, or whoever else asks the program to end, so that what was begun is cleaned up.
/// Who asks twice does not want to wait for that.
pub(crate) fn listen_for_interrupt() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let set = Arc::clone(&flag);
    // Without a handler Ctrl-C still stops the program, only less tidily.
    let _ = ctrlc::set_handler(move || {
        if set.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        tell!("\nstopping, once the present step is done; Ctrl-C again stops at once");
    });
    flag
}

pub(crate) fn failure_of(error: Error) -> Failure {
    match error {
        Error::NotFinite(diagnostic) => {
            let mut diagnostics = Diagnostics::new();
            diagnostics.push(*diagnostic);
            Failure::from(diagnostics)
        }
        Error::CannotCarry(missing) => cannot_carry(&missing),
        Error::Interrupted => Failure::interrupted(),
        Error::Instants(_) => {
            Failure::input(error.to_string()).help("give another one with --step")
        }
        Error::Forces {
            time,
            error: ref error_of @ InverseError::Locked { ref joint, percent },
        } => Failure::no_answer(format!("at t = {time} s: {error_of}"))
            .help("--friction off shows what the mechanism needs without friction")
            .details(json!({ "time": time, "joint": joint, "percent": percent })),
        error @ Error::Forces { error: InverseError::Unsettled, .. } => {
            Failure::no_answer(error.to_string())
                .help("--friction off shows what the mechanism needs without friction")
        }
        // Put together from coordinates zero, a mechanism may be another one.
        error @ Error::Assembly { error: AssemblyError::Open { .. }, .. } => {
            Failure::input(error.to_string()).help(
                "if there should be no such freedom, a joint is missing, or the mechanism was put together \
                 otherwise than meant: give its joints `start` values near where they are",
            )
        }
        error if error.is_bad_input() => Failure::input(error.to_string()),
        error => Failure::no_answer(error.to_string()),
    }
}

fn cannot_carry(missing: &Missing) -> Failure {
    let InverseError::CannotCarry { body, motion, .. } = &missing.first else {
        return Failure::no_answer(missing.first.to_string());
    };
    let Missing { time, range: (least, greatest), unit, samples, of, .. } = missing;
    let amount = if (greatest - least).abs() < 5e-3 * greatest {
        format!("{} {unit}", significant(*greatest, 6))
    } else {
        format!("{} to {} {unit}", significant(*least, 6), significant(*greatest, 6))
    };
    let when = if *of == 1 {
        format!("at t = {time} s")
    } else if samples == of {
        format!("at every one of {of} samples")
    } else {
        format!("at {samples} of {of} samples, first at t = {time} s")
    };
    let what = if *unit == "N m" { "a moment" } else { "a force" };
    Failure::no_answer(format!(
        "no finite driving force carries this load {when}: the position is singular.\n  With all \
         actuators locked, body `{body}` can still move: {motion}.\n  Nothing resists along that \
         motion: {what} of {amount} is missing there."
    ))
    .help("change the motion or the load, or add an actuator or a constraint that resists this motion")
    .details(json!({
        "first_time": time,
        "samples": samples,
        "of": of,
        "body": body,
        "motion": motion,
        "missing": { "least": least, "greatest": greatest, "unit": unit },
    }))
}
