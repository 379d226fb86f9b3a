//! `stiction sweep`: statistics of inverse dynamics for many designs.

mod designs;
mod journal;
mod merge;

use crate::answer;
use crate::arguments::{Shard, Sweep};
use crate::failure::Failure;
use crate::fold::folded;
use crate::inverse::listen_for_interrupt;
use crate::outputs::Outputs;
use crate::print;
use crate::progress::Progress;
use crate::report;
use crate::sources::{self, warn};
use crate::written::note_files;
use designs::Designs;
use journal::{Journal, TABLE};
use serde_json::{Value, json};
use std::num::NonZeroUsize;
use std::sync::atomic::Ordering;
use stiction::{FrictionMode, Robot, Study};
use stiction_run::comparison::Reel;
use stiction_run::forward::checksum;
use stiction_run::sweep::{Findings, Pictures, draw_report};

/// Largest number of plots of an earlier study that are removed from the folder.
const PICTURES: usize = 32;

pub(crate) fn run(options: &Sweep) -> Result<(), Failure> {
    let outcome = match options.merge.as_slice() {
        [] => execute(options),
        folders => merge::merge(options, folders),
    };
    outcome.map_err(|failure| failure.into_json(options.json))
}

fn execute(options: &Sweep) -> Result<(), Failure> {
    if options.model.name.is_none() {
        return Err(Failure::input("a sweep needs a model")
            .help("name a file or a built-in model (`stiction models`), and what to vary; see `stiction sweep --help`"));
    }
    let robot = sources::filtered_robot(&options.model, &options.filter)?;
    warn(robot.warnings());
    let interrupted = listen_for_interrupt();
    let mut sweep = robot.sweep()?;
    if let Some(motion) = &options.motion {
        sweep = sweep.motion(motion);
    }
    if let Some(load) = &options.load {
        sweep = sweep.load(load);
    }
    if let Some(friction) = options.friction {
        sweep = sweep.friction(friction.into());
    }
    if let Some(step) = options.sampling.step {
        sweep = sweep.step(step);
    }
    for objective in &options.objective {
        sweep = sweep.objective(objective);
    }
    let designs = Designs::new(options)?;
    let study = sweep.study(designs.keys())?;
    let mode = options.friction.map(Into::into).or(robot.model().default_friction);
    if mode == Some(FrictionMode::Off) {
        let keys = designs.keys();
        sources::note_friction(&robot, false);
        sources::note_without_effect(&robot, keys.iter().map(|key| key.path.as_str()));
    }
    let about = description(options, &robot, &designs)?;
    // The units are checked before any file of this study is written.
    if let Some(Ok(first)) = designs.iter(options.shard, 0)?.next() {
        study.check_units(&first)?;
    }

    let inputs = robot.files_read().into_iter().chain(designs.file()).collect();
    let folder = options.report.folder(options.output.as_deref())?;
    let outputs = folder.as_deref().map(|dir| Outputs::new(dir, inputs)).transpose()?;
    let mut results = Results::new(&study, designs.shape().filter(|_| options.shard.parts == 1));
    let mut journal = match &outputs {
        Some(outputs) => Some(Journal::open(outputs, &about, &study, options, &mut results)?),
        None => None,
    };
    let done = results.rows;
    let (of, mut progress) = (part_of(designs.count(), options.shard), Progress::new());
    let mut is_stopped = false;
    let threads = options.threads.threads.or_else(|| std::thread::available_parallelism().ok());
    let outcome = study.run(
        designs.iter(options.shard, done)?,
        threads.unwrap_or(NonZeroUsize::MIN),
        |settings, row| {
            let number = number_of(options.shard, results.rows);
            if let Some(journal) = &mut journal {
                journal.add(number, &settings, &row)?;
            }
            results.add(number, &settings, &row);
            progress.update_designs(results.rows, of);
            is_stopped = interrupted.load(Ordering::Relaxed);
            Ok(!is_stopped)
        },
    );
    progress.clear();
    if let Some(journal) = &mut journal {
        journal.flush()?;
    }
    outcome?;
    if is_stopped && results.rows < of {
        return Err(match &outputs {
            None => Failure::interrupted(),
            Some(_) => stiction::Error::interrupted(format!(
                "interrupted after {} of {of} designs",
                results.rows
            ))
            .with_help("the same command with --resume continues from there")
            .into(),
        });
    }
    if results.rows != of {
        return Err(Failure::input(format!(
            "the table of designs has changed during the run: {} of {of} rows were computed",
            results.rows
        ))
        .help("start again, and leave the table unchanged until the run ends"));
    }
    results.finish(
        (options, Some(&study)),
        (robot.name(), robot.title()),
        &about,
        outputs,
        journal,
    )?;
    options.report.show(folder.as_deref());
    Ok(())
}

/// Returns the number of a row in the whole study, from 1; `place` is the index of the row within
/// the part, from 0.
fn number_of(shard: Shard, place: u64) -> u64 {
    (shard.part - 1) + place * shard.parts + 1
}

/// Returns the number of rows in the part `shard` of a study with `count` rows.
fn part_of(count: u64, shard: Shard) -> u64 {
    (count + shard.parts - shard.part) / shard.parts
}

/// Returns a description that identifies a study, with a fingerprint of the options and of the
/// input files. All parts of a study have the same description.
fn description(options: &Sweep, robot: &Robot, designs: &Designs) -> Result<Value, Failure> {
    let mut files = Vec::new();
    for path in robot.files_read().into_iter().chain(designs.file()) {
        let content = std::fs::read(&path)
            .map_err(|error| Failure::input(format!("cannot read {}: {error}", path.display())))?;
        files.push(format!("{:016x}", checksum(&String::from_utf8_lossy(&content))));
    }
    let mut value = json!({
        "model": options.model.name.as_ref().map(|name| name.to_string_lossy()),
        "set": options.model.set,
        "vary": options.vary,
        "table": options.table.as_ref().map(|path| path.to_string_lossy()),
        "design": designs.plan(),
        "samples": options.samples,
        "seed": options.seed,
        "objectives": options.objective,
        "motion": options.motion,
        "load": options.load,
        "friction": options.friction.map(|mode| format!("{mode:?}").to_lowercase()),
        "filter": options.filter.filter,
        "step": options.sampling.step,
        "designs": designs.count(),
    });
    let version = env!("CARGO_PKG_VERSION");
    let fingerprint = checksum(&format!("{version} {value} {files:?}"));
    value["fingerprint"] = json!(format!("{fingerprint:016x}"));
    Ok(value)
}

/// Statistics and pictures of the designs that are computed so far.
pub(crate) struct Results {
    findings: Findings,
    pictures: Pictures,
    rows: u64,
}

impl Results {
    fn new(study: &Study, shape: Option<Vec<u64>>) -> Self {
        Self::of(study.keys(), study.headers(), shape.as_deref())
    }

    fn of(keys: &[stiction_format::Key], objectives: &[String], shape: Option<&[u64]>) -> Self {
        Self {
            findings: Findings::new(keys, objectives),
            pictures: Pictures::new(keys, objectives, shape),
            rows: 0,
        }
    }

    fn add(
        &mut self,
        number: u64,
        settings: &[stiction_format::Setting],
        row: &stiction_run::sweep::Row,
    ) {
        self.rows += 1;
        self.findings.add(number, settings, row);
        self.pictures.add(settings, &row.values);
    }

    /// Returns animations for the report: the robot of each design at which an objective has its
    /// extreme value.
    fn reels(&self, study: &Study) -> Vec<(String, Reel)> {
        let designs = self.findings.extreme_designs();
        let count = designs.len();
        let reel = |(row, settings, words): (u64, &[stiction_format::Setting], String)| {
            // A design with a value has results, so only an animation that is too large for the
            // page fails here; the report then omits it.
            let reel = study.reel(settings, count).ok().flatten()?;
            Some((format!("row {row}: {words}"), reel))
        };
        designs.into_iter().filter_map(reel).collect()
    }

    /// Prints the results, gives the files their final names, and fails if no design has results.
    /// Without `study`, as for merged parts, the report shows no robot.
    fn finish(
        &self,
        (options, study): (&Sweep, Option<&Study>),
        (name, title): (&str, &str),
        about: &Value,
        outputs: Option<Outputs>,
        journal: Option<Journal>,
    ) -> Result<(), Failure> {
        let shard = options.shard;
        let mut json = json!({
            "program": { "name": "stiction", "version": env!("CARGO_PKG_VERSION") },
            "study": about,
            "shard": { "part": shard.part, "parts": shard.parts },
        });
        if let (Some(object), Some(more)) = (json.as_object_mut(), self.findings.json().as_object())
        {
            object.extend(more.clone());
        }
        if options.json {
            answer::give(&json);
        } else {
            let mut text = format!("{}\n\n", stiction_run::heading(name, title));
            // Writing to a string cannot fail.
            let _ = self.findings.write(&mut text);
            print(&folded(&text))?;
        }
        let is_asked = outputs.is_some();
        let mut files = Vec::new();
        if let Some(mut outputs) = outputs {
            outputs.write("sweep.json", format!("{json:#}\n").as_bytes())?;
            for (name, picture) in self.pictures.draw() {
                outputs.write(&name, picture.as_bytes())?;
            }
            if options.report.is_on() {
                let results = (&self.findings, &self.pictures);
                let command = report::command_line();
                let reels = study.map_or_else(Vec::new, |study| self.reels(study));
                let page = draw_report((name, title), results, reels, Some(&command), about);
                outputs.write(report::FILE, page.as_bytes())?;
            }
            let others: Vec<String> = (1..=PICTURES).map(|k| format!("sweep-{k}.svg")).collect();
            let possible = others.iter().map(String::as_str).chain(["sweep.svg", report::FILE]);
            let table = outputs.path(TABLE);
            // Without a journal, as in a merge, the table is one of the other outputs.
            if let Some(journal) = journal {
                journal.complete(&table)?;
                files.push(table);
            }
            files.extend(outputs.complete(&possible.collect::<Vec<_>>())?);
        }
        if !options.json {
            note_files(&files, is_asked);
        }
        match self.findings.failure() {
            None => Ok(()),
            Some((true, reason)) => Err(Failure::input(reason)),
            Some((false, reason)) => Err(Failure::no_answer(reason)),
        }
    }
}
