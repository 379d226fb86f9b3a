//! Stores the rows of a running parameter study on disk, so that an interrupted study can be
//! continued.

use super::Results;
use crate::arguments::Sweep;
use crate::failure::Failure;
use crate::outputs::Outputs;
use serde_json::{Value, json};
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use stiction::{Error, ErrorKind, Study};
use stiction_format::Setting;
use stiction_run::sweep::{Record, Row, Table};

/// Name of the table of a complete study.
pub(super) const TABLE: &str = "sweep.csv";
/// Name of the table of a running study.
const PARTIAL_TABLE: &str = "sweep.partial.csv";
/// Name of the file that describes a running study.
const PARTIAL_STUDY: &str = "sweep.partial.json";
/// Interval between two writes of rows to the file.
const FLUSH_EVERY: Duration = Duration::from_secs(1);
/// Interval between two writes that wait until the rows are on disk.
const SYNC_EVERY: Duration = Duration::from_secs(30);

/// Writer of the rows of a study.
pub(super) struct Journal {
    table: Table<BufWriter<File>>,
    file: File,
    partial: PathBuf,
    study: PathBuf,
    flushed: Instant,
    synced: Instant,
}

impl Journal {
    /// Creates the table of the study. With `--resume`, opens the table of the interrupted study
    /// and adds its rows to `results`.
    pub(super) fn open(
        outputs: &Outputs,
        about: &Value,
        study: &Study,
        options: &Sweep,
        results: &mut Results,
    ) -> Result<Self, Failure> {
        let (partial, description) = (outputs.path(PARTIAL_TABLE), outputs.path(PARTIAL_STUDY));
        let shard = (options.shard.part, options.shard.parts);
        let identity = json!({ "fingerprint": about["fingerprint"], "shard": [shard.0, shard.1] });
        let earlier = outputs.read(PARTIAL_STUDY);
        let trouble = |error: std::io::Error| outputs.trouble(PARTIAL_TABLE, error);
        let mut length = None;
        match (earlier, options.resume) {
            (None, true) => {
                return Err(Failure::input(format!("there is no {PARTIAL_STUDY} to resume from"))
                    .help("start again without --resume"));
            }
            (Some(_), false) => {
                return Err(Failure::input(format!(
                    "{} holds an interrupted study ({PARTIAL_TABLE})",
                    partial.parent().unwrap_or(Path::new("")).display()
                ))
                .help(format!(
                    "continue it with --resume, give another folder with -o, or remove {PARTIAL_TABLE} and \
                     {PARTIAL_STUDY}"
                )));
            }
            (Some(text), true) => {
                let same =
                    serde_json::from_str::<Value>(&text).is_ok_and(|value| value == identity);
                if !same {
                    return Err(Failure::input(format!(
                        "{PARTIAL_STUDY} belongs to another study: the model, an input file or an option differs"
                    ))
                    .help("give the same options, or another folder with -o"));
                }
                // A study that was killed before its first row has no table.
                if partial.exists() {
                    length = Some(replay(&partial, study, options, results).map_err(trouble)?);
                }
            }
            (None, false) => {
                let text = format!("{identity:#}\n");
                outputs.write_now(PARTIAL_STUDY, text.as_bytes())?;
            }
        }
        let mut how = OpenOptions::new();
        let file = how.create(true).write(true).truncate(false).open(&partial).map_err(trouble)?;
        file.set_len(length.unwrap_or(0)).map_err(trouble)?;
        drop(file);
        let file = OpenOptions::new().append(true).open(&partial).map_err(trouble)?;
        let writer = BufWriter::new(file.try_clone().map_err(trouble)?);
        let table = match length {
            Some(bytes) if bytes > 0 => Table::continued(writer),
            _ => Table::new(study.keys(), study.headers(), writer).map_err(trouble)?,
        };
        let now = Instant::now();
        Ok(Self { table, file, partial, study: description, flushed: now, synced: now })
    }

    /// Appends a row to the table of a running study.
    pub(super) fn add(
        &mut self,
        number: u64,
        settings: &[Setting],
        row: &Row,
    ) -> Result<(), Error> {
        self.write(|journal| {
            journal.table.add(number, settings, row)?;
            if journal.flushed.elapsed() > FLUSH_EVERY {
                journal.table.flush()?;
                journal.flushed = Instant::now();
            }
            if journal.synced.elapsed() > SYNC_EVERY {
                journal.file.sync_data()?;
                journal.synced = Instant::now();
            }
            Ok(())
        })
    }

    /// Writes all rows added so far to the table and waits until they are on disk.
    pub(super) fn flush(&mut self) -> Result<(), Error> {
        self.write(|journal| {
            journal.table.flush()?;
            journal.file.sync_all()
        })
    }

    fn write(&mut self, write: impl FnOnce(&mut Self) -> std::io::Result<()>) -> Result<(), Error> {
        write(self).map_err(|error| {
            Error::new(
                ErrorKind::Output,
                format!("cannot write {}: {error}", self.partial.display()),
            )
            .with_help(
                "free disk space; the same command with --resume continues after the \
                    rows that are already written",
            )
        })
    }

    /// Renames the table of the completed study to its final path `name`.
    pub(super) fn complete(mut self, name: &Path) -> Result<(), Failure> {
        self.flush()?;
        let renamed = std::fs::rename(&self.partial, name);
        renamed.map_err(|error| {
            Failure::input(format!("cannot write {}: {error}", name.display()))
                .help("give another folder with -o")
        })?;
        // The description is useless without its table.
        let _ = std::fs::remove_file(&self.study);
        Ok(())
    }
}

/// Adds the complete rows in the table of an interrupted study to `results`. Returns the length, in
/// bytes, of the header and these rows.
fn replay(
    partial: &Path,
    study: &Study,
    options: &Sweep,
    results: &mut Results,
) -> std::io::Result<u64> {
    let (keys, objectives) = (study.keys().len(), study.headers().len());
    let mut reader = BufReader::new(File::open(partial)?);
    let (mut line, mut length) = (String::new(), 0);
    loop {
        line.clear();
        // A crash may leave bytes at the end that are not text.
        let bytes = reader.read_line(&mut line).unwrap_or(0);
        let Some(content) = line.strip_suffix('\n') else { return Ok(length) };
        if length == 0 {
            if content != header_line(study)? {
                return Ok(0);
            }
        } else {
            let expected = super::number_of(options.shard, results.rows);
            match Record::parse(content, keys, objectives) {
                Some(record) if record.number == expected => {
                    results.add(record.number, &record.settings, &record.row);
                }
                _ => return Ok(length),
            }
        }
        length += bytes as u64;
    }
}

/// Returns the header line of the study's table, without the line break.
fn header_line(study: &Study) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    drop(Table::new(study.keys(), study.headers(), &mut bytes)?);
    let line = String::from_utf8_lossy(&bytes).trim_end_matches('\n').to_owned();
    Ok(line)
}
