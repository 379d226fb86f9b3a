//! Output files of a run, which appear complete or not at all.

use crate::arguments::Formats;
use crate::failure::Failure;
use crate::report;
use serde_json::Value;
use std::cell::Cell;
use std::fmt::Display;
use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use stiction::{Error, ErrorKind};
use stiction_core::mechanism::Mechanism;
use stiction_run::Figure;
#[cfg(feature = "mcap")]
use stiction_run::exchange::mcap_of_csv;
use stiction_run::exchange::npz_of_csv;

/// Name of the file with the checkpoint from which an interrupted simulation resumes.
pub(crate) const CHECKPOINT: &str = "checkpoint.json";
/// Name of the file with the summary of a run.
pub(crate) const SUMMARY: &str = "summary.json";
/// Names of the files with the envelope of several runs.
pub(crate) const ENVELOPE: [&str; 2] = ["envelope.json", "envelope.csv"];
/// Size of the buffer of each file in bytes. Tables have kilobytes per row; with larger buffers, the
/// system is called less often.
const BUFFER: usize = 1 << 16;

/// Returns the table formats if this program was built with support for all of them, else a
/// failure.
pub(crate) fn supported(formats: Formats) -> Result<Formats, Failure> {
    if formats.mcap && cfg!(not(feature = "mcap")) {
        return Err(Failure::input("this program was built without MCAP support")
            .help("build it with `--features mcap`, or write NumPy archives with --format npz"));
    }
    Ok(formats)
}

/// Output files of one run in a folder. Each file has a temporary name until all files of the run
/// are complete. If the run fails, its incomplete files are removed. Files of earlier runs are
/// replaced only when all new files are complete.
#[derive(Debug)]
pub(crate) struct Outputs {
    folder: PathBuf,
    pending: Vec<(PathBuf, PathBuf)>,
    /// Folders created for this run, the innermost first.
    made: Vec<PathBuf>,
    begun: SystemTime,
    /// Full paths of the files read for this run, which must not be replaced.
    inputs: Vec<PathBuf>,
    /// True once a checkpoint refers to the incomplete files; these files are then not removed.
    kept: Cell<bool>,
}

impl Outputs {
    /// Creates the folder if it does not exist. `inputs` are the full paths of files that outputs must not replace.
    pub(crate) fn new(folder: &Path, inputs: Vec<PathBuf>) -> Result<Self, Failure> {
        // True for a file that has the path of the folder or of a parent of the folder.
        let blocks = |at: &&Path| at.exists() && !at.is_dir();
        if let Some(file) = folder.ancestors().find(blocks) {
            return Err(Failure::input(format!(
                "-o needs a folder, but {} is a file",
                file.display()
            ))
            .help("give the name of a folder; it is created if it does not exist"));
        }
        let trouble = |why: String| {
            Failure::input(format!("cannot create the folder {}: {why}", folder.display()))
                .help("give another folder with -o")
        };
        let is_missing = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
        let made = folder.ancestors().take_while(is_missing).map(Path::to_owned).collect();
        let outputs = Self {
            folder: folder.to_owned(),
            pending: Vec::new(),
            made,
            begun: SystemTime::now(),
            inputs,
            kept: Cell::new(false),
        };
        // Dropping `outputs` removes the folders that were created.
        fs::create_dir_all(folder).map_err(|error| trouble(error.to_string()))?;
        Ok(outputs)
    }

    /// Returns a failure if the folder contains a simulation that can be resumed; other results
    /// would damage this simulation.
    pub(crate) fn refuse_interrupted(&self) -> Result<(), Failure> {
        if !self.folder.join(CHECKPOINT).exists() {
            return Ok(());
        }
        Err(Failure::input(format!(
            "{} holds an interrupted simulation ({CHECKPOINT}); other results would damage it",
            self.folder.display()
        ))
        .help(format!(
            "give another folder with -o, finish the simulation with --resume, or remove {CHECKPOINT}"
        )))
    }

    fn is_input(&self, path: &Path) -> bool {
        path.canonicalize().is_ok_and(|path| self.inputs.contains(&path))
    }

    /// Creates the file `name` in the folder under a temporary name.
    pub(crate) fn begin(&mut self, name: &str) -> Result<BufWriter<File>, Failure> {
        let complete = self.folder.join(name);
        let partial = self.folder.join(format!(".{name}.{}.partial", std::process::id()));
        if complete.is_dir() {
            return Err(self.trouble(name, "a folder has that name"));
        }
        if complete.exists() && !complete.is_file() {
            // The new file would replace a device or a pipe.
            return Err(self.trouble(name, "it exists and is not a regular file"));
        }
        if self.is_input(&complete) {
            return Err(Failure::input(format!(
                "{} is an input of this run, and its results would replace it",
                complete.display()
            ))
            .help("give another folder with -o"));
        }
        let file = File::create(&partial).map_err(|error| self.trouble(name, error))?;
        self.pending.push((partial, complete));
        Ok(BufWriter::with_capacity(BUFFER, file))
    }

    /// Creates the file `name` in the folder under a temporary name, and copies the first `bytes`
    /// bytes of the file `other` in the folder into it.
    pub(crate) fn begin_with(
        &mut self,
        name: &str,
        other: &str,
        bytes: u64,
    ) -> Result<BufWriter<File>, Failure> {
        let mut file = self.begin(name)?;
        let gone = |why: &dyn Display| {
            let other = self.folder.join(other);
            Failure::input(format!("the rows kept in {} cannot be used: {why}", other.display()))
                .help("start again without --resume")
        };
        let from = File::open(self.folder.join(other)).map_err(|error| gone(&error))?;
        let copied =
            io::copy(&mut from.take(bytes), &mut file).map_err(|e| self.trouble(name, e))?;
        if copied != bytes {
            return Err(gone(&"the file has become shorter"));
        }
        Ok(file)
    }

    /// Returns the temporary name and the present length, in bytes, of the file `name` while it is
    /// being written; `None` for other names.
    pub(crate) fn partial(&self, name: &str) -> Option<(String, u64)> {
        let complete = self.folder.join(name);
        let (partial, _) = self.pending.iter().find(|(_, known)| *known == complete)?;
        let length = fs::metadata(partial).ok()?.len();
        Some((partial.file_name()?.to_str()?.to_owned(), length))
    }

    /// Writes the whole file `name` immediately under its final name, independently of the other
    /// files.
    pub(crate) fn write_now(&self, name: &str, content: &[u8]) -> Result<(), Failure> {
        let partial = self.folder.join(format!(".{name}.{}.partial", std::process::id()));
        let written = File::create(&partial).and_then(|mut file| {
            file.write_all(content)?;
            // Without `sync_all`, a power failure may leave an empty file.
            file.sync_all()?;
            fs::rename(&partial, self.folder.join(name))
        });
        written.map_err(|error| {
            let _ = fs::remove_file(&partial);
            self.trouble(name, error)
        })
    }

    /// Path of the file `name` in the folder.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Text of the file `name` in the folder, if the file exists.
    pub(crate) fn read(&self, name: &str) -> Option<String> {
        fs::read_to_string(self.folder.join(name)).ok()
    }

    /// Removes the file `name` from the folder, if it exists.
    pub(crate) fn remove(&self, name: &str) {
        let _ = fs::remove_file(self.folder.join(name));
    }

    /// Writes the whole file `name` under a temporary name.
    pub(crate) fn write(&mut self, name: &str, content: &[u8]) -> Result<(), Failure> {
        let file = self.begin(name)?;
        self.end(name, file, content)
    }

    /// Writes figures as SVG (and PNG, if enabled) to files with the given names.
    pub(crate) fn write_figures(
        &mut self,
        figures: Vec<(&'static str, Figure)>,
    ) -> Result<(), Failure> {
        for (name, figure) in figures {
            self.write(&format!("{name}.svg"), figure.svg().as_bytes())?;
            #[cfg(feature = "png")]
            {
                let file = format!("{name}.png");
                let png = figure.png().map_err(|error| self.trouble(&file, error))?;
                self.write(&file, &png)?;
            }
        }
        Ok(())
    }

    /// Appends the remaining content `rest` to a file and waits until the file is on disk.
    pub(crate) fn end(
        &self,
        name: &str,
        mut file: BufWriter<File>,
        rest: &[u8],
    ) -> Result<(), Failure> {
        let arrived = |file: &mut BufWriter<File>| -> io::Result<()> {
            file.write_all(rest)?;
            file.flush()?;
            file.get_ref().sync_all()
        };
        arrived(&mut file).map_err(|error| self.trouble(name, error))
    }

    /// Converts the complete CSV tables to NumPy archives (`.npz`) if this format is requested, and
    /// removes the CSV files if CSV is not requested.
    pub(crate) fn convert_tables(
        &mut self,
        tables: &[&str],
        formats: Formats,
    ) -> Result<(), Failure> {
        for table in tables {
            let Some((partial, _)) = self.partial(table) else { continue };
            if formats.npz {
                let name = npz_name(table);
                let file = self.begin(&name)?;
                let source = File::open(self.folder.join(partial));
                let target = file.get_ref().try_clone();
                source
                    .and_then(|source| npz_of_csv(source, target?))
                    .map_err(|error| self.trouble(&name, error))?;
                self.end(&name, file, &[])?;
            }
            if !formats.csv {
                self.abandon(table);
            }
        }
        Ok(())
    }

    /// Writes an MCAP log from the three complete tables: joint coordinates, actuator efforts and
    /// bodies.
    #[cfg(feature = "mcap")]
    pub(crate) fn write_mcap(
        &mut self,
        name: &str,
        mechanism: &Mechanism,
        tables: [&str; 3],
    ) -> Result<(), Failure> {
        let mut sources = Vec::new();
        for table in tables {
            let Some((partial, _)) = self.partial(table) else { return Ok(()) };
            let file = File::open(self.folder.join(partial));
            sources.push(file.map_err(|error| self.trouble(table, error))?);
        }
        let file = self.begin(name)?;
        let [joints, efforts, bodies] = [&sources[0], &sources[1], &sources[2]];
        let written = file.get_ref().try_clone();
        written
            .and_then(|target| mcap_of_csv(mechanism, joints, efforts, bodies, target))
            .map_err(|error| self.trouble(name, error))?;
        self.end(name, file, &[])
    }

    /// Does nothing. This function is never called: a program without MCAP support rejects this
    /// format when it reads its arguments.
    #[cfg(not(feature = "mcap"))]
    pub(crate) fn write_mcap(
        &mut self,
        _: &str,
        _: &Mechanism,
        _: [&str; 3],
    ) -> Result<(), Failure> {
        Ok(())
    }

    /// Removes the incomplete file `name` from the files of this run.
    pub(crate) fn abandon(&mut self, name: &str) {
        let complete = self.folder.join(name);
        self.pending.retain(|(partial, known)| {
            let other = *known != complete;
            if !other {
                // A missing file needs no removal.
                let _ = fs::remove_file(partial);
            }
            other
        });
    }

    /// Keeps the incomplete files from now on, even if the run is never completed.
    pub(crate) fn keep(&self) {
        self.kept.set(true);
    }

    /// Returns whether incomplete files are kept.
    pub(crate) fn is_kept(&self) -> bool {
        self.kept.get()
    }

    /// Gives all files their final names and returns the final paths. Removes files named in
    /// `possible` that this run did not write, because they could be mistaken for results of this
    /// run.
    pub(crate) fn complete(mut self, possible: &[&str]) -> Result<Vec<PathBuf>, Failure> {
        for (partial, complete) in &self.pending {
            fs::rename(partial, complete).map_err(|error| {
                Failure::input(format!("cannot write {}: {error}", complete.display()))
                    .help("give another folder with -o")
            })?;
        }
        self.tidy();
        for name in possible {
            let stale = self.folder.join(name);
            if self.pending.iter().all(|(_, complete)| *complete != stale) && !self.is_input(&stale)
            {
                // Usually the file does not exist.
                let _ = fs::remove_file(stale);
            }
        }
        Ok(std::mem::take(&mut self.pending).into_iter().map(|(_, complete)| complete).collect())
    }

    /// Completes the files of a run as [`Self::complete`]. `tables` (with extension), `figures`
    /// (without) and the `log` are those that any run of the command may write. Runs for several
    /// motions or loads also write envelopes.
    pub(crate) fn complete_run(
        self,
        tables: &[&str],
        figures: &[&str],
        log: &str,
    ) -> Result<Vec<PathBuf>, Failure> {
        let tables = tables.iter().flat_map(|name| [name.to_string(), npz_name(name)]);
        let figures =
            figures.iter().flat_map(|name| [format!("{name}.svg"), format!("{name}.png")]);
        let names: Vec<String> = tables.chain(figures).collect();
        let names = names.iter().map(String::as_str).chain(ENVELOPE);
        let names = names.chain([SUMMARY, log, report::FILE]);
        self.complete(&names.collect::<Vec<_>>())
    }

    /// Returns true if the folder contains the summary of an earlier run.
    pub(crate) fn follows_a_run(&self) -> bool {
        let text = fs::read_to_string(self.folder.join(SUMMARY)).unwrap_or_default();
        let summary: Value = serde_json::from_str(&text).unwrap_or_default();
        summary["program"]["name"] == "stiction"
    }

    /// Removes temporary files that an earlier run left when it was killed: those of checkpoints
    /// and of files that this run also writes.
    fn tidy(&self) {
        let is_older = |path: &Path| {
            let changed = fs::metadata(path).and_then(|about| about.modified());
            changed.is_ok_and(|changed| changed < self.begun)
        };
        for entry in fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let Some(name) = name.to_str() else { continue };
            let Some(whole) = of_partial(name) else { continue };
            let is_own =
                whole == CHECKPOINT || self.pending.iter().any(|(_, own)| own.ends_with(whole));
            if is_own && is_older(&entry.path()) {
                // Files without write permission remain; they are harmless.
                let _ = fs::remove_file(entry.path());
            }
        }
    }

    /// Converts an error of a computation to a failure. `outputs` are the files that the
    /// computation writes, if any.
    pub(crate) fn explain(outputs: Option<&Self>, error: Error) -> Failure {
        match (error.kind(), outputs) {
            (ErrorKind::Output, Some(outputs)) => outputs.trouble_with_tables(error.message()),
            _ => error.into(),
        }
    }

    /// Creates a failure that reports a write error of the file `name`.
    pub(crate) fn trouble(&self, name: &str, error: impl Display) -> Failure {
        self.trouble_with(&self.folder.join(name).display(), error)
    }

    /// Creates a failure that reports a write error of one of the tables.
    pub(crate) fn trouble_with_tables(&self, error: impl Display) -> Failure {
        self.trouble_with(&format_args!("the tables in {}", self.folder.display()), error)
    }

    fn trouble_with(&self, what: &dyn Display, error: impl Display) -> Failure {
        let failure = Failure::input(format!("cannot write {what}: {error}"));
        failure.help(match self.is_kept() {
            true => {
                "the results so far are kept; the same command with --resume continues from there"
            }
            false => "the folder is unchanged; give another one with -o",
        })
    }
}

/// Returns the name of the NPZ file with the numbers of a CSV table.
fn npz_name(table: &str) -> String {
    table.replace(".csv", ".npz")
}

impl Drop for Outputs {
    fn drop(&mut self) {
        for (partial, _) in self.pending.iter().filter(|_| !self.is_kept()) {
            // A missing file needs no removal.
            let _ = fs::remove_file(partial);
        }
        for folder in &self.made {
            // Fails for a folder that is no longer empty; this folder stays.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Returns the final name of the file whose temporary name is `name`; `None` if `name` is not a
/// temporary name.
fn of_partial(name: &str) -> Option<&str> {
    let (whole, id) = name.strip_prefix('.')?.strip_suffix(".partial")?.rsplit_once('.')?;
    id.bytes().all(|byte| byte.is_ascii_digit()).then_some(whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn temporary_names_are_recognised() {
        assert_eq!(of_partial(".inverse.csv.123.partial"), Some("inverse.csv"));
        for other in ["inverse.csv", ".checkpoint.json.partial", ".a.12.part", "a.12.partial", ""] {
            assert_eq!(of_partial(other), None, "{other}");
        }
    }
}
