//! `stiction forward`: forward dynamics with joints that stick and slip.

mod journal;

use crate::answer;
use crate::arguments::{Formats, Forward, Method as Asked, Switch};
use crate::cases::{self, Done, SingleRun};
use crate::failure::Failure;
use crate::fold::folded;
use crate::inverse::listen_for_interrupt;
use crate::outputs::{CHECKPOINT, Outputs, SUMMARY, supported};
use crate::print;
use crate::progress::Progress;
use crate::report;
use crate::sources::{self, DEFAULT_MODEL, note_friction, warn};
use crate::written::note_files;
use journal::{Journal, Kept, begin, partials};
use std::cell::{Cell, RefCell};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use stiction::{Error, ErrorKind, Method, Robot};
use stiction_run::Sink;
use stiction_run::forward::{
    Animation, Curves, Ending, Outcome, Recorder, RowEfforts, Rows, Summary, Tables, draw_report,
    write_events, write_summary,
};

pub(crate) fn run(options: &Forward) -> Result<(), Failure> {
    execute(options).map_err(|failure| failure.into_json(options.json))
}

/// Converts the options of the command line to a request to the library `stiction`.
fn request(
    robot: &Robot,
    options: &Forward,
    load: Option<&str>,
) -> Result<stiction::Forward, Failure> {
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
    if let Some(load) = load {
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
    for condition in &options.stop {
        request = request.stop(condition)?;
    }
    if let Some(until) = options.until {
        request = request.until(until);
    }
    if let Some(step) = options.sampling.step {
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
    // A format that this program cannot write is refused before the simulation.
    supported(options.tables.formats())?;
    let robot = sources::filtered_robot(&options.model, &options.filter)?;
    if !options.json {
        if options.model.name.is_none() {
            note!(
                "No model given: running the built-in `{DEFAULT_MODEL}`.\nA computed-torque \
                 controller without friction compensation follows the default motion of this \
                 robot.\n"
            );
        }
        warn(robot.warnings());
    }
    let loads = cases::separate(&options.load);
    let (interrupted, limit) = (listen_for_interrupt(), Limit::new(options.time_limit)?);
    let watch = Watch { interrupted: &interrupted, limit: &limit };
    let folder = options.report.folder(options.output.as_deref())?;
    let folder = folder.as_deref();
    if loads.len() < 2 {
        let request = request(&robot, options, loads.first().copied())?;
        single(&robot, (options, options.resume), &request, folder, watch).map(|_| ())
    } else {
        several(&robot, (options, folder), &cases::cases(&[Vec::new(), loads]), watch)
    }
}

/// Runs one simulation for each of several loads.
fn several(
    robot: &Robot,
    (options, folder): (&Forward, Option<&Path>),
    cases: &[cases::Case<'_>],
    watch: Watch<'_>,
) -> Result<(), Failure> {
    let is_kept = |folder: &Path| folder.join(CHECKPOINT).is_file();
    let any = folder.is_some_and(|all| cases.iter().any(|case| is_kept(&all.join(&case.name))));
    if options.resume && !any {
        return Err(Failure::input(format!("no run has a {CHECKPOINT} to resume from"))
            .help("start again without --resume; runs with -o write a checkpoint every minute, see --checkpoint"));
    }
    // All inputs are checked before the first computation.
    let requests = cases
        .iter()
        .map(|case| {
            let request = request(robot, options, case.load)?;
            request.clone().plan()?;
            Ok(request)
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    let shape = (folder, options.json, options.report);
    let tables: Vec<&str> = FILES.into_iter().chain([EVENTS]).collect();
    let names = SingleRun { tables: &tables, figures: &Curves::FILES, log: "forward.mcap" };
    cases::run_all(robot, shape, names, cases, |index, folder| {
        // Without a checkpoint, a run starts from its beginning. A finished run has a checkpoint at
        // its end.
        let resume = options.resume && folder.is_some_and(is_kept);
        single(robot, (options, resume), &requests[index], folder, watch)
    })?;
    for case in cases {
        let checkpoint = folder.map(|all| all.join(&case.name).join(CHECKPOINT));
        // The envelope is complete: nothing is left to resume.
        let _ = checkpoint.map(std::fs::remove_file);
    }
    Ok(())
}

/// Conditions that end a run early: an interruption by the user, and a time limit.
#[derive(Clone, Copy)]
struct Watch<'a> {
    interrupted: &'a AtomicBool,
    limit: &'a Limit,
}

/// Runs one simulation, prints its summary, and writes its files into `folder`.
fn single(
    robot: &Robot,
    (options, resume): (&Forward, bool),
    request: &stiction::Forward,
    folder: Option<&Path>,
    Watch { interrupted, limit }: Watch<'_>,
) -> Result<Done, Failure> {
    let runs = cases::separate(&options.load).len();
    let is_one_of_many = runs > 1;
    let plan = request.clone().plan()?;
    let job = plan.job();
    sources::refuse_filter(&options.filter, job.motion.map(|motion| (&*job.motion_name, motion)))?;
    if !options.json {
        note_friction(robot, job.friction);
    }
    let count = job.instants().map_err(Error::from)?.count();
    let mut outputs = folder.map(|dir| Outputs::new(dir, robot.files_read())).transpose()?;
    let mut journal = Journal::new(&job, options.checkpoint)?;
    let kept = match &outputs {
        Some(outputs) if resume => Some(journal.read(outputs)?),
        _ => None,
    };
    if let Some(kept) = kept.as_ref().filter(|kept| kept.checkpoint.samples > count) {
        return Err(Failure::input(format!(
            "the interrupted run has {} rows, but a run until {} s has only {count}",
            kept.checkpoint.samples, job.until
        ))
        .help("give a later --until, or start again without --resume"));
    }
    let curves = outputs.is_some().then(|| Curves::new(&job, count));
    let efforts = RowEfforts::new(&job, count);
    let has_report = outputs.is_some() && options.report.is_on();
    let animation = has_report.then(|| Animation::new(&job, count));
    let sinks = (curves, efforts, animation);
    let mut recorder = Recorder::new(&job, (Summary::new(&job), sinks, None));
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
                journal.write(outputs, &kept.checkpoint, &partials(outputs)?)?;
                for (at, _) in kept.files.iter().filter(|(at, _)| at.ends_with(".partial")) {
                    outputs.remove(at);
                }
                tables
            }
        });
    }

    let mut end = kept.as_ref().map(|kept| kept.checkpoint.clone()).filter(|_| is_one_of_many);
    let progress = RefCell::new(Progress::new());
    let done = Cell::new(kept.as_ref().map_or(0, |kept| kept.checkpoint.samples));
    let outcome = plan.record(
        |sample, checkpoint| {
            recorder.add(sample)?;
            done.set(done.get() + 1);
            if is_one_of_many && done.get() == count {
                end = Some(checkpoint());
            }
            if let (Some(outputs), Some(tables)) = (&outputs, &mut recorder.sink.2)
                && journal.is_due()
            {
                tables.flush()?;
                let written = partials(outputs)
                    .and_then(|files| journal.write(outputs, &checkpoint(), &files));
                written.map_err(|failure| failure.to_string())?;
            }
            Ok(())
        },
        &|| {
            // Called at every evaluation of the dynamics, because a single row of the tables may
            // take long.
            progress.borrow_mut().update_samples("simulating", done.get(), count);
            interrupted.load(Ordering::Relaxed) || limit.is_passed()
        },
        kept.as_ref().map(|kept| &kept.checkpoint),
    );
    progress.borrow_mut().clear();
    let outcome = outcome.map_err(|error| match error {
        error if error.kind() == ErrorKind::Interrupted && limit.is_passed() => limit.failure(None),
        error => Outputs::explain(outputs.as_ref(), error),
    })?;
    let (summary, (curves, efforts, animation), tables) = recorder.sink;
    let reel = animation.as_ref().filter(|_| is_one_of_many);
    let reel = reel.and_then(|animation| animation.reel(runs));

    let json = summary.json(&job, &outcome);
    let failed = matches!(outcome.ending, Ending::Failed(_));
    let cut = matches!(outcome.ending, Ending::Interrupted);
    if !options.json {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = write_summary(&mut text, &job, &summary, &outcome);
        print(&folded(&text))?;
    } else if !failed && !cut && !is_one_of_many {
        answer::give(&json);
    }
    let (mut kept, mut written) = (None, Vec::new());
    if let (Some(mut outputs), Some(tables), Some(curves)) = (outputs, tables, curves) {
        let files = tables.finish().map_err(|error| outputs.trouble_with_tables(error))?;
        for (name, file) in FILES.into_iter().zip(files) {
            outputs.end(name, file, &[])?;
        }
        if !outcome.invertible && outcome.checkpoint.is_none() {
            // Inverse dynamics has no solution for a motion not determined by the actuators.
            outputs.abandon("motion.csv");
        }
        let tables: Vec<&str> =
            FILES.into_iter().filter(|name| outputs.partial(name).is_some()).collect();
        // Resuming a simulation requires its CSV tables.
        let formats = options.tables.formats();
        let formats = Formats { csv: formats.csv || outcome.checkpoint.is_some(), ..formats };
        if formats.mcap && outcome.checkpoint.is_none() {
            let sources = ["forward.csv", "forward.csv", "bodies.csv"];
            outputs.write_mcap("forward.mcap", &job.model.mechanism, sources)?;
        }
        outputs.convert_tables(&tables, formats)?;
        let mut events = Vec::new();
        write_events(&mut events, &summary, &outcome.events)
            .map_err(|error| outputs.trouble(EVENTS, error))?;
        outputs.write(EVENTS, &events)?;
        outputs.write(SUMMARY, format!("{json:#}\n").as_bytes())?;
        let figures = curves.figures(&summary, &outcome.events);
        let page = animation.map(|animation| {
            let command = report::command_line();
            draw_report(&job, (&summary, &outcome), &figures, &animation, Some(&command))
        });
        outputs.write_figures(figures)?;
        if let Some(page) = page {
            outputs.write(report::FILE, page.as_bytes())?;
        }
        let end = end.filter(|end| end.samples == count);
        if let Some(checkpoint) = outcome.checkpoint.as_ref().or(end.as_ref()) {
            let mut tables = partials(&outputs)?;
            // The tables are about to receive their final names.
            for ((at, _), name) in tables.iter_mut().zip(FILES) {
                name.clone_into(at);
            }
            journal.write(&outputs, checkpoint, &tables)?;
        } else {
            outputs.remove(CHECKPOINT);
        }
        written = outputs.complete_run(&FILES, &Curves::FILES, "forward.mcap")?;
        kept = folder;
    }
    if !is_one_of_many {
        if !options.json {
            note_files(&written, folder.is_some());
        }
        options.report.show(folder);
    }
    let lost = summary.energy_lost(&job.settings, &outcome.events);
    let compared = summary.compared(&job, &outcome);
    if cut && limit.is_passed() {
        return Err(limit.failure(Some((outcome.last, kept))));
    }
    ended(outcome, kept)?;
    if let Some(part) = lost {
        return Err(stiction::energy_lost(part).into());
    }
    Ok(Done { json, compared, efforts: efforts.curves, reel, files: written })
}

/// Limit on the wall-clock time of a run.
struct Limit {
    start: Instant,
    seconds: Option<f64>,
}

impl Limit {
    /// Starts the measurement of wall-clock time; the limit is in seconds.
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

    /// Creates the failure of a run that has reached the limit. `last` contains the time of the
    /// last row, s, and the folder of the results, if there is one; `last` is `None` if the run has
    /// no row.
    fn failure(&self, last: Option<(f64, Option<&Path>)>) -> Failure {
        let limit = self.seconds.unwrap_or_default();
        let (reached, resume) = match last {
            None => ("before its first row".to_owned(), ""),
            Some((time, None)) => (format!("t = {time} s"), ""),
            Some((time, Some(folder))) => (
                format!("at t = {time} s; the results up to then are in {}", folder.display()),
                "the same command with --resume continues from there; ",
            ),
        };
        Failure::no_answer(format!("the time limit of {limit} s ended the run {reached}")).help(
            format!(
                "{resume}give a longer --time-limit, a larger --tolerance or --method time-stepping"
            ),
        )
    }
}

/// Reads the table rows that an interrupted run has written, and passes them to `recorder`.
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
    recorder.read(files, kept.checkpoint.samples).map_err(|error| {
        Failure::input(format!("the rows of the interrupted run cannot be read: {error}"))
    })
}

/// Names of the tables that every run writes.
const FILES: [&str; 6] = Tables::<Vec<u8>>::FILES;
/// Name of the file with the events of a simulation.
const EVENTS: &str = "events.csv";

/// Converts the end of a simulation to a failure, unless the simulation reached the end time or a
/// stop condition.
fn ended(outcome: Outcome, kept: Option<&Path>) -> Result<(), Failure> {
    let results = kept.map(|folder| {
        format!("the results up to t = {} s are in {}", outcome.last, folder.display())
    });
    match (outcome.ending, results) {
        (Ending::Reached | Ending::Stopped(_), _) => Ok(()),
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
