//! Where a simulation is, written down now and then, so that it can go on after an interruption.

use super::FILES;
use crate::failure::Failure;
use crate::outputs::{CHECKPOINT, Outputs};
use serde_json::{Value, json};
use std::fs::File;
use std::io::BufWriter;
use std::time::{Duration, Instant};
use stiction_run::forward::{Job, Mark, checksum};

/// Says when it is time to write.
pub(super) struct Journal {
    every: Duration,
    last: Instant,
    fingerprint: u64,
}

/// What an earlier run has left.
pub(super) struct Kept {
    pub(super) mark: Mark,
    /// For each table where its rows are, and how many bytes of them count.
    pub(super) files: Vec<(String, u64)>,
}

impl Journal {
    pub(super) fn new(job: &Job<'_>, every: f64) -> Result<Self, Failure> {
        if every.is_nan() || every < 0.0 {
            return Err(Failure::input(format!("--checkpoint is {every} s"))
                .help("give a time that is not negative"));
        }
        // What is too long for a clock is never.
        let every = Duration::try_from_secs_f64(every).unwrap_or(Duration::MAX);
        Ok(Self { every, last: Instant::now(), fingerprint: job.fingerprint() })
    }

    pub(super) fn is_due(&self) -> bool {
        self.last.elapsed() >= self.every
    }

    /// Writes down where it is; tables must have been flushed.
    pub(super) fn write(
        &mut self,
        outputs: &Outputs,
        mark: &Mark,
        files: &[(String, u64); FILES.len()],
    ) -> Result<(), Failure> {
        let tables: Vec<Value> = FILES
            .iter()
            .zip(files)
            .map(|(name, (at, bytes))| json!({ "name": name, "at": at, "bytes": bytes }))
            .collect();
        let mark = mark.json();
        let content = json!({
            "program": { "name": "stiction", "version": env!("CARGO_PKG_VERSION") },
            "fingerprint": format!("{:016x}", self.fingerprint),
            "checksum": checksum_of(&Value::Array(tables.clone()), &mark),
            "tables": tables,
            "mark": mark,
        });
        outputs.write_now(CHECKPOINT, format!("{content:#}\n").as_bytes())?;
        outputs.keep();
        self.last = Instant::now();
        Ok(())
    }

    /// What an earlier run of the same has left in the folder.
    pub(super) fn read(&self, outputs: &Outputs) -> Result<Kept, Failure> {
        let text = outputs.read(CHECKPOINT).ok_or_else(|| {
            Failure::input(format!("there is no {CHECKPOINT} to go on from"))
                .help("begin anew without --resume; long runs with -o write it now and then, see --checkpoint")
        })?;
        let wrong = |what: &str| {
            Failure::input(format!("{CHECKPOINT} {what}")).help("begin anew without --resume")
        };
        let value: Value = serde_json::from_str(&text).map_err(|error| {
            wrong(&format!("is damaged: it is no JSON any more (line {})", error.line()))
        })?;
        if !value["fingerprint"].is_string() {
            return Err(wrong("is damaged: it does not say of which simulation it is"));
        }
        if value["fingerprint"] != json!(format!("{:016x}", self.fingerprint)) {
            return Err(Failure::input(format!(
                "{CHECKPOINT} is of another simulation: the model, or an option other than --until, has changed"
            ))
            .help("give the same options, or begin anew without --resume"));
        }
        // A digit that is another one would be a simulation that is another one.
        if value["checksum"] != json!(checksum_of(&value["tables"], &value["mark"])) {
            return Err(wrong("is damaged"));
        }
        let mark = Mark::from_json(&value["mark"]).ok_or_else(|| {
            wrong("is damaged: its `mark`, the state of the simulation, is not complete")
        })?;
        let tables = value["tables"].as_array().map_or(&[][..], Vec::as_slice);
        let table = |table: &Value| {
            let at = table["at"].as_str().filter(|at| !at.contains(['/', '\\']))?;
            Some((at.to_owned(), table["bytes"].as_u64()?))
        };
        let files: Option<Vec<_>> = tables.iter().map(table).collect();
        let files = files.filter(|files| files.len() == FILES.len());
        Ok(Kept { mark, files: files.ok_or_else(|| {
            wrong("is damaged: its `tables`, which say what of each file counts, are not complete")
        })? })
    }
}

fn checksum_of(tables: &Value, mark: &Value) -> String {
    format!("{:016x}", checksum(&format!("{tables}{mark}")))
}

/// Where the tables are that are being written, and how long.
///
/// # Errors
/// One of them is gone: a checkpoint without it would be worth nothing.
pub(super) fn partials(outputs: &Outputs) -> Result<[(String, u64); FILES.len()], Failure> {
    for_each_file(|_, name| {
        outputs.partial(name).ok_or_else(|| {
            Failure::no_answer(format!("{name} is gone from the folder while it is written"))
                .help("begin anew, and leave files named *.partial alone until it ends")
        })
    })
}

/// Begins the tables anew or with what is kept.
pub(super) fn begin(
    outputs: &mut Outputs,
    kept: Option<&Kept>,
) -> Result<[BufWriter<File>; FILES.len()], Failure> {
    for_each_file(|index, name| match kept.and_then(|kept| kept.files.get(index)) {
        None => outputs.begin(name),
        Some((at, bytes)) => outputs.begin_with(name, at, *bytes),
    })
}

/// What is made of each table by its place and its name; the first failure is the last.
fn for_each_file<T>(
    mut make: impl FnMut(usize, &'static str) -> Result<T, Failure>,
) -> Result<[T; FILES.len()], Failure> {
    let [a, b, c, d, e, f] = FILES;
    Ok([make(0, a)?, make(1, b)?, make(2, c)?, make(3, d)?, make(4, e)?, make(5, f)?])
}
