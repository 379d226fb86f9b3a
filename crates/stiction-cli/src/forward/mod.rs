//! `stiction forward`: forward dynamics with joints that stick and slip.

mod journal;

use crate::arguments::{Forward, Method as Asked, Switch};
use crate::failure::Failure;
use crate::fold::folded;
use crate::inverse::listen_for_interrupt;
use crate::outputs::{CHECKPOINT, Outputs};
use crate::print;
use crate::progress::Progress;
use crate::sources::{self, DEFAULT_MODEL, note_frictionless, warn};
use journal::{Journal, Kept, begin, partials};
use serde_json::json;
use std::cell::{Cell, RefCell};
use std::io::IsTerminal;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Instant;
use stiction::{Error, ErrorKind, Method, Robot};
use stiction_run::Sink;
use stiction_run::forward::{
    Curves, Ending, Outcome, Recorder, Rows, Summary, Tables, write_events, write_summary,
};

pub(crate) fn run(options: &Forward) -> Result<(), Failure> {
    execute(options).map_err(|failure| failure.into_json(options.json))
}

/// Maps the options to a request.
fn request(robot: &Robot, options: &Forward) -> Result<stiction::Forward, Failure> {
    let mut request = robot.forward();
    if let Some(friction) = options.friction {
        request = request.friction(friction == Switch::On);
    }
    for joint in &options.hold {
        request = request.hold(joint)?;
    }
    for joint in &options.prescribe {
        request = request.prescribe(joint)?;
    }
    if let Some(motion) = &options.motion {
        request = request.motion(motion)?;
    }
    if let Some(load) = &options.load {
        request = request.load(load)?;
    }
    if let Some(drives) = &options.drives {
        request = request.drives(drives)?;
    }
    if let Some(controller) = &options.controller {
        request = request.controller(controller)?;
    }
    if let Some(start) = &options.from {
        request = request.from(start)?;
    }
    if let Some(until) = options.until {
        request = request.until(until);
    }
    if let Some(step) = options.step {
        request = request.step(step);
    }
    let method = match options.method {
        Asked::Automatic => Method::Automatic,
        Asked::EventDriven => Method::EventDriven,
        Asked::TimeStepping => Method::TimeStepping,
    };
    Ok(request.method(method).tolerance(options.tolerance)?)
}

fn execute(options: &Forward) -> Result<(), Failure> {
    let robot = sources::robot_or_default(&options.model)?;
    if !options.json {
        if options.model.name.is_none() {
            note!(
                "No model given: running the built-in `{DEFAULT_MODEL}`. A controller that knows the robot, but \
                 not its friction, follows\nthe robot's own motion.\n"
            );
        }
        warn(robot.warnings());
    }
    let plan = request(&robot, options)?.plan()?;
    let job = plan.job();
    if !options.json && job.friction {
        note_frictionless(&robot);
    }
    let count = job.instants().map_err(Error::from)?.count();
    let interrupted = listen_for_interrupt();
    let limit = Limit::new(options.time_limit)?;
    let mut outputs =
        options.output.as_deref().map(|dir| Outputs::new(dir, robot.files_read())).transpose()?;
    let mut journal = Journal::new(&job, options.checkpoint)?;
    let kept = match &outputs {
        Some(outputs) if options.resume => Some(journal.read(outputs)?),
        _ => None,
    };
    if let Some(kept) = kept.as_ref().filter(|kept| kept.mark.samples > count) {
        return Err(Failure::input(format!(
            "the interrupted run has {} rows, but a run until {} s has only {count}",
            kept.mark.samples, job.until
        ))
        .help("give a later --until, or start again without --resume"));
    }
    let curves = outputs.is_some().then(|| Curves::new(&job, count));
    let mut recorder = Recorder::new(&job, (Summary::new(&job), curves, None));
    if let Some(outputs) = &mut outputs {
        let files = begin(outputs, kept.as_ref())?;
        recorder.sink.2 = Some(match &kept {
            None => Tables::new(&job, files).map_err(|error| outputs.trouble_with_tables(error))?,
            Some(kept) => {
                let mut tables = Tables::onward(&job, files);
                tables.flush().map_err(|error| outputs.trouble_with_tables(error))?;
                read_again(outputs, kept, &mut recorder)?;
                // The files of the interrupted run remain until this run has its own
                // checkpoint.
                journal.write(outputs, &kept.mark, &partials(outputs)?)?;
                for (at, _) in kept.files.iter().filter(|(at, _)| at.ends_with(".partial")) {
                    outputs.remove(at);
                }
                tables
            }
        });
    }

    let progress = RefCell::new(Progress::new());
    let done = Cell::new(kept.as_ref().map_or(0, |kept| kept.mark.samples));
    let outcome = plan.record(
        |sample, mark| {
            recorder.add(sample)?;
            done.set(done.get() + 1);
            if let (Some(outputs), Some(tables)) = (&outputs, &mut recorder.sink.2)
                && journal.is_due()
            {
                tables.flush()?;
                let written =
                    partials(outputs).and_then(|files| journal.write(outputs, &mark(), &files));
                written.map_err(|failure| failure.to_string())?;
            }
            Ok(())
        },
        &|| {
            // Called at every evaluation, because a single row may take long.
            progress.borrow_mut().update_samples("simulating", done.get(), count);
            interrupted.load(Ordering::Relaxed) || limit.is_passed()
        },
        kept.as_ref().map(|kept| &kept.mark),
    );
    progress.borrow_mut().clear();
    let outcome = outcome.map_err(|error| match error {
        error if error.kind() == ErrorKind::Interrupted && limit.is_passed() => limit.failure(None),
        error => Outputs::explain(outputs.as_ref(), error),
    })?;
    let (summary, curves, tables) = recorder.sink;

    let json = summary.json(&job, &outcome);
    let failed = matches!(outcome.ending, Ending::Failed(_));
    let cut = matches!(outcome.ending, Ending::Interrupted);
    if !options.json {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = write_summary(&mut text, &job, &summary, &outcome);
        print(&folded(&text))?;
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
            // Inverse dynamics has no solution for a motion not determined by the actuators.
            outputs.abandon("motion.csv");
        }
        let mut events = Vec::new();
        write_events(&mut events, &summary, &outcome.events)
            .map_err(|error| outputs.trouble("events.csv", error))?;
        outputs.write("events.csv", &events)?;
        outputs.write("summary.json", format!("{json:#}\n").as_bytes())?;
        outputs.write_figures(curves.figures(&summary, &outcome.events))?;
        if let Some(mark) = &outcome.mark {
            let mut tables = partials(&outputs)?;
            // The tables are about to receive their final names.
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
            note!("\nwrote {}", names.join(", "));
        }
        kept = options.output.as_deref();
    } else if !options.json && std::io::stderr().is_terminal() {
        note!("\nTables and plots: add -o DIR");
    }
    let lost = summary.energy_lost(&job.settings, &outcome.events);
    if cut && limit.is_passed() {
        return Err(limit.failure(Some((outcome.last, kept))));
    }
    ended(outcome, kept)?;
    match lost {
        None => Ok(()),
        Some(part) => Err(Failure::no_answer(format!(
            "the energy balance does not close: its relative error is {part:.1e}, so these results are wrong by \
             more than their tolerance"
        ))
        .help("give another --tolerance or --method; the column `error` of energy.csv shows when the energy is lost")
        .details(json!({ "energy_error_relative": part }))),
    }
}

/// Limit of the wall-clock time of a run.
struct Limit {
    start: Instant,
    seconds: Option<f64>,
}

impl Limit {
    /// Starts the clock.
    fn new(seconds: Option<f64>) -> Result<Self, Failure> {
        match seconds {
            Some(given) if given.is_nan() || given <= 0.0 => Err(Failure::input(format!(
                "--time-limit is {given} s, but must be greater than 0"
            ))),
            _ => Ok(Self { start: Instant::now(), seconds }),
        }
    }

    fn is_passed(&self) -> bool {
        self.seconds.is_some_and(|limit| self.start.elapsed().as_secs_f64() > limit)
    }

    /// Failure of a run that ended at the limit after a row at some time, s, with its folder.
    fn failure(&self, last: Option<(f64, Option<&Path>)>) -> Failure {
        let limit = self.seconds.unwrap_or_default();
        let (reached, resume) = match last {
            None => ("its first row".to_owned(), ""),
            Some((time, None)) => (format!("t = {time} s"), ""),
            Some((time, Some(folder))) => (
                format!("t = {time} s; the results up to then are in {}", folder.display()),
                "the same command with --resume continues from there; ",
            ),
        };
        Failure::no_answer(format!("the time limit of {limit} s ended the run at {reached}")).help(
            format!(
                "{resume}give a longer --time-limit, a larger --tolerance or --method time-stepping"
            ),
        )
    }
}

/// Passes the rows that an interrupted run has written to `receive`.
fn read_again(
    outputs: &Outputs,
    kept: &Kept,
    recorder: &mut Recorder<impl Sink<Rows>>,
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
    recorder.read(files, kept.mark.samples).map_err(|error| {
        Failure::input(format!("the rows of the interrupted run cannot be read: {error}"))
    })
}

/// Names of the tables.
const FILES: [&str; 6] = Tables::<Vec<u8>>::FILES;
/// Names of the files that only some runs write.
const POSSIBLE: [&str; 7] = [
    "motion.csv",
    "error.svg",
    "error.png",
    "drives.svg",
    "drives.png",
    "friction.svg",
    "friction.png",
];

/// Converts the end of a simulation to a failure, unless it reached its end time.
fn ended(outcome: Outcome, kept: Option<&Path>) -> Result<(), Failure> {
    let results = kept.map(|folder| {
        format!("the results up to t = {} s are in {}", outcome.last, folder.display())
    });
    match (outcome.ending, results) {
        (Ending::Reached, _) => Ok(()),
        (Ending::Interrupted, Some(results)) => {
            Err(Error::interrupted(format!("interrupted; {results}"))
                .with_help("the same command with --resume continues from there")
                .into())
        }
        (Ending::Interrupted, None) => Err(Failure::interrupted()),
        (Ending::Failed(error), results) => {
            let error = Error::from(*error);
            Err(match results {
                Some(results) => error.with_note(results).into(),
                None => error.into(),
            })
        }
    }
}
