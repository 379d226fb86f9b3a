//! `stiction inverse`: inverse dynamics along a motion.

use crate::answer;
use crate::arguments::{Filter, Formats, Friction, Inverse, Report};
use crate::cases::{self, Done, SingleRun};
use crate::failure::Failure;
use crate::fold::folded;
use crate::outputs::{Outputs, SUMMARY, supported};
use crate::print;
use crate::progress::Progress;
use crate::report;
use crate::sources::{self, DEFAULT_MODEL, note_friction, warn};
use crate::written::note_files;
use serde_json::Value;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use stiction::{Error, FrictionMode, Robot};
use stiction_run::Indices;
use stiction_run::comparison::{ComparedRun, EffortCurves, Reel};
use stiction_run::inverse::{Animation, Curves, Summary, Tables, draw_report, write_summary};

pub(crate) fn run(options: &Inverse) -> Result<(), Failure> {
    execute(options).map_err(|failure| failure.into_json(options.json))
}

fn execute(options: &Inverse) -> Result<(), Failure> {
    let robot = sources::filtered_robot(&options.model, &options.filter)?;
    if options.model.name.is_none() {
        note!(
            "No model given: running `{DEFAULT_MODEL}`, whose three driven legs lift and tilt a platform.\n\
             `stiction models` lists all built-in robots. This one is a nonsingular variant of a published\n\
             robot, which is singular with the printed dimensions; `stiction study zhang2018` shows how.\n"
        );
    }
    warn(robot.warnings());
    let interrupted = listen_for_interrupt();
    let lists = [cases::separate(&options.motion), cases::separate(&options.load)];
    let choice = Choice {
        friction: options.friction,
        step: options.sampling.step,
        threads: options.threads.threads,
        friction_margin: options.friction_margin,
        filter: options.filter,
        formats: supported(options.tables.formats())?,
        report: options.report,
        runs: lists.iter().map(|list| list.len().max(1)).product(),
    };
    let folder = options.report.folder(options.output.as_deref())?;
    if lists.iter().any(|list| list.len() > 1) {
        let settings = (options, folder.as_deref());
        return several(&robot, settings, &cases::cases(&lists), &choice, &interrupted);
    }
    let [motion, load] = lists.each_ref().map(|list| list.first().copied());
    let request = choice.request(&robot, motion, load)?;
    let run = along(&robot, &request, &choice, folder.as_deref(), &interrupted, |run| {
        match options.json {
            true => answer::give(&run.json),
            false => print(&folded(&run.text))?,
        }
        Ok(())
    })?;
    if !options.json {
        note_files(&run.files, folder.is_some());
    }
    options.report.show(folder.as_deref());
    Ok(())
}

/// Computes inverse dynamics for several motions and loads.
fn several(
    robot: &Robot,
    (options, folder): (&Inverse, Option<&Path>),
    cases: &[cases::Case<'_>],
    choice: &Choice,
    interrupted: &AtomicBool,
) -> Result<(), Failure> {
    // All inputs are checked before the first computation.
    let requests = cases
        .iter()
        .map(|case| choice.request(robot, case.motion, case.load))
        .collect::<Result<Vec<_>, _>>()?;
    let shape = (folder, options.json, options.report);
    let names = SingleRun {
        tables: &Tables::<BufWriter<File>>::FILES,
        figures: &Curves::FILES,
        log: "inverse.mcap",
    };
    cases::run_all(robot, shape, names, cases, |index, folder| {
        let run = along(robot, &requests[index], choice, folder, interrupted, |run| {
            if options.json { Ok(()) } else { print(&folded(&run.text)) }
        })?;
        let Run { json, compared, efforts, reel, files, .. } = run;
        Ok(Done { json, compared, efforts, reel, files })
    })
}

/// Options of a run except model, motion and load.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice {
    pub(crate) friction: Option<Friction>,
    pub(crate) step: Option<f64>,
    pub(crate) threads: Option<std::num::NonZeroUsize>,
    pub(crate) friction_margin: bool,
    pub(crate) filter: Filter,
    pub(crate) formats: Formats,
    pub(crate) report: Report,
    /// Number of runs of the command; several runs share a report.
    pub(crate) runs: usize,
}

impl Choice {
    /// Converts the options to a request to the library `stiction`.
    pub(crate) fn request(
        &self,
        robot: &Robot,
        motion: Option<&str>,
        load: Option<&str>,
    ) -> Result<stiction::Inverse, Failure> {
        let mut request = robot.inverse().friction_margin(self.friction_margin);
        if let Some(motion) = motion {
            request = request.motion(motion)?;
        }
        if let Some(load) = load {
            request = request.load(load)?;
        }
        if let Some(friction) = self.friction {
            request = request.friction(friction.into());
        }
        if let Some(step) = self.step {
            request = request.step(step);
        }
        if let Some(threads) = self.threads.or_else(|| std::thread::available_parallelism().ok()) {
            request = request.threads(threads);
        }
        Ok(request)
    }
}

/// Results of inverse dynamics along one motion with one load.
pub(crate) struct Run {
    pub(crate) json: Value,
    /// Summary of the run for the terminal.
    pub(crate) text: String,
    pub(crate) compared: ComparedRun,
    pub(crate) efforts: EffortCurves,
    /// Animation of the robot for the common report of several runs.
    pub(crate) reel: Option<Reel>,
    /// Paths of the files that this run has written.
    pub(crate) files: Vec<PathBuf>,
}

/// Computes inverse dynamics along a motion, passes the results to `show`, and then completes the
/// output files in `folder`, which have temporary names until then.
pub(crate) fn along(
    robot: &Robot,
    request: &stiction::Inverse,
    choice: &Choice,
    folder: Option<&Path>,
    interrupted: &AtomicBool,
    show: impl FnOnce(&Run) -> Result<(), Failure>,
) -> Result<Run, Failure> {
    // Only tables and plots, which need a folder, contain the singularity indices of all samples.
    let indices = if folder.is_some() { Indices::All } else { Indices::Least };
    let request = &request.clone().indices(indices);
    let job = request.job()?;
    sources::refuse_filter(&choice.filter, Some((&job.motion_name, job.motion)))?;
    let friction = job.friction;
    note_friction(robot, friction != FrictionMode::Off);

    let count = job.instants().map_err(Error::from)?.count();
    let mut outputs = folder.map(|dir| Outputs::new(dir, robot.files_read())).transpose()?;
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
    let mut efforts = EffortCurves::new(&job.model.mechanism, count);
    let has_report = outputs.is_some() && choice.report.is_on();
    let mut animation = has_report.then(|| Animation::new(&job, count));

    let mut progress = Progress::new();
    let sinks = (&mut summary, (&mut curves, &mut efforts, &mut animation), &mut tables);
    let outcome = request.record(sinks, |phase, done, of| {
        progress.update(phase, done, of);
        !interrupted.load(Ordering::Relaxed)
    });
    progress.clear();
    let verdict = outcome.map_err(|error| Outputs::explain(outputs.as_ref(), error))?;
    for note in &verdict.assembly_notes {
        note!("note: {note}\n");
    }
    if choice.friction_margin && verdict.friction_margin.is_none() {
        let why = match friction {
            FrictionMode::Off => "friction is off",
            _ => "no joint slides at any sample that is not singular",
        };
        note!("note: the friction margin to jamming is not known: {why}\n");
    }

    let json = summary.json(&job, &verdict);
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_summary(&mut text, &job, &summary, &verdict);
    let reel = animation.as_ref().filter(|_| choice.runs > 1);
    let reel = reel.and_then(|animation| animation.reel(choice.runs));
    let compared = summary.compared(&job, &verdict);
    let mut run = Run { json, text, compared, efforts, reel, files: Vec::new() };
    show(&run)?;
    if let (Some(mut outputs), Some(tables), Some(curves)) = (outputs, tables, curves) {
        let files = tables.finish().map_err(|error| outputs.trouble_with_tables(error))?;
        let tables = Tables::<BufWriter<File>>::files(&job);
        for (name, file) in tables.iter().zip(files) {
            outputs.end(name, file, &[])?;
        }
        if choice.formats.mcap {
            let sources = ["joints.csv", "inverse.csv", "bodies.csv"];
            outputs.write_mcap("inverse.mcap", &job.model.mechanism, sources)?;
        }
        outputs.convert_tables(&tables, choice.formats)?;
        outputs.write(SUMMARY, format!("{:#}\n", run.json).as_bytes())?;
        let figures = curves.figures();
        let page = animation.map(|animation| {
            let command = report::command_line();
            draw_report(&job, (&summary, &verdict), &figures, &animation, Some(&command))
        });
        outputs.write_figures(figures)?;
        if let Some(page) = page {
            outputs.write(report::FILE, page.as_bytes())?;
        }
        let tables = Tables::<BufWriter<File>>::FILES;
        run.files = outputs.complete_run(&tables, &Curves::FILES, "inverse.mcap")?;
    }
    Ok(run)
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
        note!("\nstopping after the current step; Ctrl-C again stops at once");
    });
    flag
}
