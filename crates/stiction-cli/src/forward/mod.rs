//! `stiction forward`: what a mechanism does.

mod journal;
mod setup;

use crate::arguments::Forward;
use crate::failure::Failure;
use crate::inverse::{DEFAULT_MODEL, failure_of as failure_of_motion, listen_for_interrupt, warn};
use crate::outputs::{CHECKPOINT, Outputs};
use crate::print;
use crate::progress::Progress;
use crate::sources;
use journal::{Journal, Kept, begin, partials};
use serde_json::json;
use setup::Setup;
use std::cell::{Cell, RefCell};
use std::io::IsTerminal;
use std::path::Path;
use std::sync::atomic::Ordering;
use stiction_core::forward::ForwardError;
use stiction_core::kinematics::AssemblyError;
use stiction_run::forward::{
    Curves, Ending, Error, Layout, Outcome, Rows, Scribe, Summary, Tables, read_rows, write_events,
    write_summary,
};

pub(crate) fn run(options: &Forward) -> Result<(), Failure> {
    carry_out(options).map_err(|failure| failure.for_programs(options.json))
}

fn carry_out(options: &Forward) -> Result<(), Failure> {
    let found = sources::find(options.model.as_deref().unwrap_or(DEFAULT_MODEL))?;
    if !options.json {
        if options.model.is_none() {
            tell!(
                "No model given: running the built-in `{DEFAULT_MODEL}`. A controller that knows the robot, but \
                 not its friction, follows\nthe robot's own motion.\n"
            );
        }
        warn(&found.model.warnings);
    }
    let setup = Setup::new(found, options)?;
    let job = setup.job(options)?;
    if !options.json
        && job.friction
        && job.model.mechanism.joints().iter().all(|j| j.friction.is_empty())
    {
        tell!("note: the model declares no friction in any joint\n");
    }
    let count = job.instants().map_err(|error| failure_of(Error::Instants(error)))?.count();
    let layout = Layout::new(&job.model.mechanism, job.followers());
    let interrupted = listen_for_interrupt();
    let mut outputs = options.output.as_deref().map(Outputs::new).transpose()?;
    let mut journal = Journal::new(&job, options.checkpoint)?;
    let kept = match &outputs {
        Some(outputs) if options.resume => Some(journal.read(outputs)?),
        _ => None,
    };
    if let Some(kept) = kept.as_ref().filter(|kept| kept.mark.samples > count) {
        return Err(Failure::input(format!(
            "{} rows were written before the interruption, but up to --until {} s there are {count}",
            kept.mark.samples, job.until
        ))
        .help("give a later instant, or begin anew without --resume"));
    }
    let mut summary = Summary::new(&layout);
    let mut curves = outputs.is_some().then(|| Curves::new(&job, &layout, count));
    let mut scribe = Scribe::new(&job.model.mechanism);
    let mut tables = match &mut outputs {
        None => None,
        Some(outputs) => {
            let files = begin(outputs, kept.as_ref())?;
            Some(match &kept {
                None => Tables::new(&layout, files)
                    .map_err(|error| outputs.trouble_with_tables(error))?,
                Some(kept) => {
                    let mut tables = Tables::onward(files);
                    tables.flush().map_err(|error| outputs.trouble_with_tables(error))?;
                    let receive = |rows: &Rows| {
                        summary.add(rows);
                        scribe.follow(rows);
                        if let Some(curves) = &mut curves {
                            curves.add(rows);
                        }
                    };
                    read_again(outputs, &layout, kept, receive)?;
                    // What it began with stays until this run has written down where it is itself.
                    journal.write(outputs, &kept.mark, &partials(outputs)?)?;
                    for (at, _) in kept.files.iter().filter(|(at, _)| at.ends_with(".partial")) {
                        outputs.remove(at);
                    }
                    tables
                }
            })
        }
    };
    let mut rows = Rows::default();

    let progress = RefCell::new(Progress::new());
    let done = Cell::new(kept.as_ref().map_or(0, |kept| kept.mark.samples));
    let tables_cell = RefCell::new(&mut tables);
    let outcome = job.run(
        |sample| {
            scribe.write(&layout, sample, &mut rows);
            summary.add(&rows);
            if let Some(curves) = &mut curves {
                curves.add(&rows);
            }
            match &mut *tables_cell.borrow_mut() {
                Some(tables) => tables.add(&layout, &rows).map_err(|error| error.to_string()),
                None => Ok(()),
            }
        },
        |now, _, mark| {
            done.set(now);
            if let (Some(outputs), Some(tables)) = (&outputs, &mut *tables_cell.borrow_mut())
                && journal.is_due()
            {
                tables.flush().map_err(|error| error.to_string())?;
                let written =
                    partials(outputs).and_then(|files| journal.write(outputs, &mark(), &files));
                written.map_err(|failure| failure.to_string())?;
            }
            Ok(())
        },
        &|| {
            // Asked for at every evaluation: a single row may take long.
            progress.borrow_mut().tell_samples("simulating", done.get(), count);
            interrupted.load(Ordering::Relaxed)
        },
        kept.as_ref().map(|kept| &kept.mark),
    );
    progress.borrow_mut().clear();
    let outcome = outcome.map_err(|error| match (error, &outputs) {
        (Error::Receiver(error), Some(outputs)) => outputs.trouble_with_tables(error),
        (error, _) => failure_of(error),
    })?;

    let json = summary.json(&job, &outcome);
    let failed = matches!(outcome.ending, Ending::Failed(_));
    let cut = matches!(outcome.ending, Ending::Interrupted);
    if !options.json {
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = write_summary(&mut text, &job, &summary, &outcome);
        print(&text)?;
    } else if !failed && !cut {
        print(&format!("{json:#}\n"))?;
    }
    let mut kept = None;
    if let (Some(mut outputs), Some(tables), Some(curves)) = (outputs, tables, curves) {
        let files = tables.finish().map_err(|error| outputs.trouble_with_tables(error))?;
        for (name, file) in FILES.into_iter().zip(files) {
            outputs.end(name, file, &[])?;
        }
        if !outcome.invertible && outcome.mark.is_none() {
            // Inverse dynamics could not be asked for it.
            outputs.abandon("motion.csv");
        }
        let mut events = Vec::new();
        write_events(&mut events, &summary, &outcome.events)
            .map_err(|error| outputs.trouble("events.csv", error))?;
        outputs.write("events.csv", &events)?;
        outputs.write("summary.json", format!("{json:#}\n").as_bytes())?;
        for (name, figure) in curves.figures(&summary, &outcome.events) {
            outputs.write(&format!("{name}.svg"), figure.svg().as_bytes())?;
            #[cfg(feature = "png")]
            {
                let file = format!("{name}.png");
                let png = figure.png().map_err(|error| outputs.trouble(&file, error))?;
                outputs.write(&file, &png)?;
            }
        }
        if let Some(mark) = &outcome.mark {
            let mut tables = partials(&outputs)?;
            // The tables will have their own names in a moment.
            for ((at, _), name) in tables.iter_mut().zip(FILES) {
                name.clone_into(at);
            }
            journal.write(&outputs, mark, &tables)?;
        } else {
            outputs.remove(CHECKPOINT);
        }
        let names = outputs.complete(&POSSIBLE)?;
        if !options.json {
            let names: Vec<String> = names.iter().map(|name| name.display().to_string()).collect();
            tell!("\nwrote {}", names.join(", "));
        }
        kept = options.output.as_deref();
    } else if !options.json && std::io::stderr().is_terminal() {
        tell!("\nTables and plots: add -o DIR");
    }
    let lost = summary.energy_lost(&job.settings, &outcome.events);
    ended(outcome, kept)?;
    match lost {
        None => Ok(()),
        Some(part) => Err(Failure::no_answer(format!(
            "the account of energy does not close: {:.1e} of what is turned over is lost, so these results are \
             wrong by more than their tolerance",
            part
        ))
        .help("a smaller --tolerance, another --method; something may change faster than steps see: look at error in energy.csv")
        .details(json!({ "energy_error_relative": part }))),
    }
}

/// Goes through the rows that an earlier run has written.
fn read_again(
    outputs: &Outputs,
    layout: &Layout,
    kept: &Kept,
    receive: impl FnMut(&Rows),
) -> Result<(), Failure> {
    let mut texts = Vec::new();
    for (name, (at, bytes)) in FILES.iter().zip(&kept.files) {
        let mut text =
            outputs.read(at).ok_or_else(|| outputs.trouble(name, "it cannot be read"))?;
        text.truncate(usize::try_from(*bytes).unwrap_or(usize::MAX));
        texts.push(std::io::Cursor::new(text));
    }
    let Ok([a, b, c, d, e, f]) = <[_; 6]>::try_from(texts) else { return Ok(()) };
    let (mut a, mut b, mut c, mut d, mut e, mut f) = (a, b, c, d, e, f);
    let files: [&mut dyn std::io::Read; 6] = [&mut a, &mut b, &mut c, &mut d, &mut e, &mut f];
    read_rows(layout, files, kept.mark.samples, receive).map_err(|error| {
        Failure::input(format!("what was computed before cannot be read: {error}"))
    })
}

/// The tables.
const FILES: [&str; 6] = Tables::<Vec<u8>>::FILES;
/// Files that not every run has.
const POSSIBLE: [&str; 7] = [
    "motion.csv",
    "error.svg",
    "error.png",
    "drives.svg",
    "drives.png",
    "friction.svg",
    "friction.png",
];

/// Whether it ended as it should.
fn ended(outcome: Outcome, kept: Option<&Path>) -> Result<(), Failure> {
    let upto = kept.map(|folder| {
        format!("what was computed up to t = {} s is in {}", outcome.last, folder.display())
    });
    let on = "the same with --resume goes on from there";
    match (outcome.ending, upto) {
        (Ending::Reached, _) => Ok(()),
        (Ending::Interrupted, Some(words)) => {
            Err(Failure::interrupted_at(format!("interrupted; {words}")).help(on))
        }
        (Ending::Interrupted, None) => Err(Failure::interrupted()),
        (Ending::Failed(error), Some(words)) => Err(failure_of(*error).note(words)),
        (Ending::Failed(error), None) => Err(failure_of(*error)),
    }
}

pub(crate) fn failure_of(error: Error) -> Failure {
    let bad_input = error.is_bad_input();
    let words = error.to_string();
    match error {
        Error::Motion(error) => failure_of_motion(error),
        Error::NotFinite(diagnostic) => {
            failure_of_motion(stiction_run::inverse::Error::NotFinite(diagnostic))
        }
        Error::Instants(_) => {
            Failure::input(words).help("give another one with --step, or another end with --until")
        }
        Error::Controller(error @ (AssemblyError::Open { .. } | AssemblyError::Gap(_))) => {
            Failure::input(format!(
                "the controller needs actuators that determine the motion, as many as there are freedoms: {error}"
            ))
            .help("take `--controller` with type = pd, and kp and kd for each actuator; or --drives")
        }
        Error::Controller(_) | Error::ControllerForces(_) => {
            Failure::input(format!("the controller cannot begin: {words}"))
                .help("start elsewhere with --from, or take another controller")
        }
        Error::ControllerAt { time, .. } => Failure::no_answer(words)
            .help("less bandwidth, a limit, or a PD controller may get through; see where the mechanism has gone with -o")
            .details(json!({ "time": time })),
        Error::Forward(error) => failure_of_forward(&error, bad_input),
        Error::Interrupted => Failure::interrupted(),
        Error::Mark => Failure::input(format!("{CHECKPOINT} is damaged: {words}")).help("begin anew without --resume"),
        _ if bad_input => Failure::input(words),
        _ => Failure::no_answer(words),
    }
}

fn failure_of_forward(error: &ForwardError, bad_input: bool) -> Failure {
    let message = error.to_string();
    match error {
        ForwardError::Assembly(_) | ForwardError::Contradiction { .. } if bad_input => {
            Failure::input(message)
        }
        ForwardError::Blocked { .. } => Failure::input(message)
            .help("give other rates with --from, or hold something else with --hold"),
        ForwardError::Impact { time, percent, .. } => Failure::no_answer(message)
            .help("prescribe motions without kinks, and keep locks away from dead centres: `stiction check` shows singular positions")
            .details(json!({ "time": time, "percent": percent })),
        ForwardError::NoAcceleration { time, joint, percent } => Failure::no_answer(message)
            .help("less friction, a longer `bending_span` if it is a guide, or a law smoothed with `regularisation_velocity` lets it go on; at a singular position nothing but other drives, locks or another start does; see the chapter on forward dynamics")
            .details(json!({ "time": time, "joint": joint, "percent": percent })),
        ForwardError::NoChoice { time, joint } => Failure::no_answer(message)
            .help("less friction there, or a law smoothed with `regularisation_velocity`, lets it go on")
            .details(json!({ "time": time, "joint": joint })),
        ForwardError::Massless { time, body } => Failure::no_answer(message)
            .help("give the body a mass and moments of inertia, or hold that motion with --hold")
            .details(json!({ "time": time, "body": body })),
        ForwardError::Open { time, joint, gap } => Failure::no_answer(message)
            .help("keep the motion that is prescribed within reach, and away from singular positions: `stiction check` shows them")
            .details(json!({ "time": time, "joint": joint, "gap": gap })),
        ForwardError::Stiff { time, step, tolerance, .. } => Failure::no_answer(message)
            .help("a larger --tolerance, or a smoother law of friction")
            .details(json!({ "time": time, "step": step, "tolerance": tolerance })),
        ForwardError::Runaway { time, body, speed } => Failure::no_answer(message)
            .help("is a controller unstable? less gain or more samples may help; else look at efforts and loads at that time")
            .details(json!({ "time": time, "body": body, "speed": speed })),
        ForwardError::NotFinite { time, .. } => Failure::no_answer(message)
            .help("look at the efforts and loads at that time")
            .details(json!({ "time": time })),
        _ => Failure::no_answer(message),
    }
}
