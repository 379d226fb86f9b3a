//! Checkpoints of a simulation on disk, from which it resumes after an interruption.

use super::FILES;
use crate::failure::Failure;
use crate::outputs::{CHECKPOINT, Outputs, SUMMARY};
use serde_json::{Value, json};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::time::{Duration, Instant};
use stiction_run::forward::{Job, RunCheckpoint, checksum};

/// Writer of checkpoints at regular intervals of wall-clock time.
pub(super) struct Journal {
    every: Duration,
    last: Instant,
    fingerprint: u64,
}

/// Checkpoint of an interrupted run, and the table rows that this run has written.
pub(super) struct Kept {
    pub(super) checkpoint: RunCheckpoint,
    /// For each table, the file that contains its rows, and the valid length of this file in bytes.
    pub(super) files: Vec<(String, u64)>,
}

impl Journal {
    pub(super) fn new(job: &Job<'_>, every: f64) -> Result<Self, Failure> {
        if every.is_nan() || every < 0.0 {
            return Err(Failure::input(format!("--checkpoint is {every} s"))
                .help("give a time of at least 0 s"));
        }
        // An interval too long for the clock disables checkpoints.
        let every = Duration::try_from_secs_f64(every).unwrap_or(Duration::MAX);
        Ok(Self { every, last: Instant::now(), fingerprint: job.fingerprint() })
    }

    pub(super) fn is_due(&self) -> bool {
        self.last.elapsed() >= self.every
    }

    /// Writes a checkpoint. The tables must have been flushed before.
    pub(super) fn write(
        &mut self,
        outputs: &Outputs,
        checkpoint: &RunCheckpoint,
        files: &[(String, u64); FILES.len()],
    ) -> Result<(), Failure> {
        let tables: Vec<Value> = FILES
            .iter()
            .zip(files)
            .map(|(name, (at, bytes))| json!({ "name": name, "at": at, "bytes": bytes }))
            .collect();
        let checkpoint = checkpoint.json();
        let content = json!({
            "program": { "name": "stiction", "version": env!("CARGO_PKG_VERSION") },
            "fingerprint": format!("{:016x}", self.fingerprint),
            "checksum": checksum_of(&Value::Array(tables.clone()), &checkpoint),
            "tables": tables,
            "checkpoint": checkpoint,
        });
        outputs.write_now(CHECKPOINT, format!("{content:#}\n").as_bytes())?;
        outputs.keep();
        self.last = Instant::now();
        Ok(())
    }

    /// Reads the checkpoint in the output folder. The checkpoint must belong to an interrupted run
    /// of the same simulation: only the end time may differ.
    pub(super) fn read(&self, outputs: &Outputs) -> Result<Kept, Failure> {
        let text = outputs.read(CHECKPOINT).ok_or_else(|| nothing_to_resume(outputs))?;
        let wrong = |what: &str| {
            Failure::input(format!("{CHECKPOINT} {what}")).help("start again without --resume")
        };
        let value: Value = serde_json::from_str(&text).map_err(|error| {
            wrong(&format!("is damaged: line {} is not valid JSON", error.line()))
        })?;
        if !value["fingerprint"].is_string() {
            return Err(wrong("is damaged: it does not say which simulation it belongs to"));
        }
        if value["fingerprint"] != json!(format!("{:016x}", self.fingerprint)) {
            return Err(Failure::input(format!(
                "{CHECKPOINT} belongs to another simulation: the model or an option other than --until differs"
            ))
            .help("give the same options, or start again without --resume"));
        }
        // The checksum reveals changes of the file: a changed digit would define a different
        // simulation.
        if value["checksum"] != json!(checksum_of(&value["tables"], &value["checkpoint"])) {
            return Err(wrong("is damaged"));
        }
        let checkpoint = RunCheckpoint::from_json(&value["checkpoint"]).ok_or_else(|| {
            wrong("is damaged: its `checkpoint`, the state of the simulation, is incomplete")
        })?;
        let tables = value["tables"].as_array().map_or(&[][..], Vec::as_slice);
        let table = |table: &Value| {
            let at = table["at"].as_str().filter(|at| !at.contains(['/', '\\']))?;
            Some((at.to_owned(), table["bytes"].as_u64()?))
        };
        let files: Option<Vec<_>> = tables.iter().map(table).collect();
        let files = files.filter(|files| files.len() == FILES.len());
        Ok(Kept {
            checkpoint,
            files: files.ok_or_else(|| wrong("is damaged: its list of `tables` is incomplete"))?,
        })
    }
}

fn checksum_of(tables: &Value, checkpoint: &Value) -> String {
    format!("{:016x}", checksum(&format!("{tables}{checkpoint}")))
}

/// Returns the temporary file name and the present length, in bytes, of each table that is being
/// written.
///
/// # Errors
/// Returns a failure if the file of a table is missing, because a checkpoint without this file
/// could not be resumed.
pub(super) fn partials(outputs: &Outputs) -> Result<[(String, u64); FILES.len()], Failure> {
    for_each_file(|_, name| {
        outputs.partial(name).ok_or_else(|| {
            Failure::no_answer(format!("{name} disappeared from the folder during the simulation"))
                .help("start again, and keep files named *.partial until the run ends")
        })
    })
}

/// Opens the files of the tables. They are empty, or contain the rows of the interrupted run
/// `kept`.
pub(super) fn begin(
    outputs: &mut Outputs,
    kept: Option<&Kept>,
) -> Result<[BufWriter<File>; FILES.len()], Failure> {
    for_each_file(|index, name| match kept.and_then(|kept| kept.files.get(index)) {
        None => outputs.begin(name),
        Some((at, bytes)) => outputs.begin_with(name, at, *bytes),
    })
}

/// Calls `make` with the index and the name of each table; stops at the first failure.
fn for_each_file<T>(
    mut make: impl FnMut(usize, &'static str) -> Result<T, Failure>,
) -> Result<[T; FILES.len()], Failure> {
    let [a, b, c, d, e, f] = FILES;
    Ok([make(0, a)?, make(1, b)?, make(2, c)?, make(3, d)?, make(4, e)?, make(5, f)?])
}

/// Returns the failure for a folder without a checkpoint, which a complete run removes.
fn nothing_to_resume(outputs: &Outputs) -> Failure {
    let path = outputs.path(CHECKPOINT);
    let folder = path.parent().unwrap_or(Path::new("")).display();
    let failure = Failure::input(format!("there is no {CHECKPOINT} in {folder} to resume from"));
    match outputs.path(SUMMARY).is_file() {
        true => failure.help(format!(
            "the folder contains the {SUMMARY} of a run, which is complete; to simulate longer, start again \
             without --resume",
        )),
        false => failure.help(
            "start again without --resume; runs with -o write a checkpoint every minute, see --checkpoint",
        ),
    }
}
