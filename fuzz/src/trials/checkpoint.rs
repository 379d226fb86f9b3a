//! `checkpoint.json`, the file that an interrupted run writes, possibly damaged.

use super::texts::{files, model_of};
use serde_json::Value;
use std::cell::Cell;
use stiction_format::{Drives, LoadCase, ModelFile, Source};
use stiction_run::Sink;
use stiction_run::forward::{
    Feed, Job, Recorder, RunCheckpoint, Start, Summary, Tables, write_events, write_summary,
};

/// A block on a slope with a single coordinate, which sticks and slides.
const BLOCK: &str = r#"
gravity = [4, 0, -9]
[bodies.block]
mass = 1
com = [0, 0, 0]
inertia = [1e-3, 1e-3, 1e-3]
[joints.A]
type = "P"
from = "ground"
to = "block"
axis = "x"
actuated = true
friction = { mu = 0.1, mu_static = 0.5 }
[motions.m]
duration = 1
A = "0.1*t"
"#;

fn job<'a>(model: &'a ModelFile, drives: &'a Drives, load: &'a LoadCase) -> Job<'a> {
    Job {
        motion: model.motion("m"),
        drives: Feed::Given(drives),
        start: Start::Moving,
        until: 0.2,
        step: 0.05,
        ..Job::new(model, ("none", load))
    }
}

/// Runs the simulation, from a checkpoint if given; returns the checkpoint of the last sample but
/// one.
fn go_on(mark: Option<&RunCheckpoint>) -> Option<Value> {
    let model = model_of(BLOCK).expect("the block is fine");
    let given = Source::new("--drives", "A = 30 N*sin(20*t)");
    let drives = model.parse_drives(&given, &files).expect("the drives are fine");
    let load = LoadCase::default();
    let job = job(&model, &drives, &load);
    let tables = Tables::new(&job, [(); 6].map(|()| Vec::<u8>::new())).expect("memory");
    let mut recorder = Recorder::new(&job, (Summary::new(&job), tables));
    let mut marks = Vec::new();
    let asked = Cell::new(0);
    let outcome = job.run(
        |sample, mark| {
            marks.push(mark().json());
            recorder.add(sample)
        },
        &|| asked.replace(asked.get() + 1) > 20_000,
        mark,
    );
    let outcome = outcome.ok()?;
    if recorder.last().forward.is_empty() {
        // The command line reads the rows of the earlier samples from its files first.
        return None;
    }
    let (summary, tables) = recorder.sink;
    for (name, file) in Tables::<Vec<u8>>::FILES.into_iter().zip(tables.finish().expect("memory")) {
        super::finite::table(name, &file);
    }
    // Output about events that the checkpoint contained.
    write_events(Vec::new(), &summary, &outcome.events).expect("memory");
    let mut text = String::new();
    write_summary(&mut text, &job, &summary, &outcome).expect("a string takes it");
    let _ = summary.json(&job, &outcome);
    marks.len().checked_sub(2).map(|last_but_one| marks.swap_remove(last_but_one))
}

/// A valid checkpoint, as a seed.
pub fn whole() -> String {
    format!("{:#}", go_on(None).expect("the block moves"))
}

/// Checks a text as the key `mark` of a checkpoint.
pub fn checkpoint(text: &str) {
    let Ok(value) = serde_json::from_str::<Value>(text) else { return };
    let Some(mark) = RunCheckpoint::from_json(&value) else { return };
    go_on(Some(&mark));
}
