//! Files that appear complete or not at all.

use crate::failure::Failure;
use crate::sources::was_read;
use std::cell::Cell;
use std::fmt::Display;
use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Says where an interrupted simulation goes on.
pub(crate) const CHECKPOINT: &str = "checkpoint.json";

/// Files being written into a folder, each under a name of its own until all are complete. What is
/// not completed is removed; what stood there before stays until then.
#[derive(Debug)]
pub(crate) struct Outputs {
    folder: PathBuf,
    pending: Vec<(PathBuf, PathBuf)>,
    /// The folders that were not there before, the innermost first.
    made: Vec<PathBuf>,
    begun: SystemTime,
    /// Whether what is not complete stays, since a file says how to go on from there.
    kept: Cell<bool>,
}

impl Outputs {
    /// Makes the folder if need be.
    pub(crate) fn new(folder: &Path) -> Result<Self, Failure> {
        // What stands where a folder is wanted, itself or above.
        let blocks = |at: &&Path| at.exists() && !at.is_dir();
        if let Some(file) = folder.ancestors().find(blocks) {
            return Err(Failure::input(format!(
                "-o wants a folder, but {} is a file",
                file.display()
            ))
            .help("give the name of a folder, which may be new"));
        }
        let trouble = |why: String| {
            Failure::input(format!("cannot make the folder {}: {why}", folder.display()))
                .help("give another folder with -o")
        };
        let is_missing = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
        let made = folder.ancestors().take_while(is_missing).map(Path::to_owned).collect();
        let outputs = Self {
            folder: folder.to_owned(),
            pending: Vec::new(),
            made,
            begun: SystemTime::now(),
            kept: Cell::new(false),
        };
        // Should only some of them be made, they go with `outputs`.
        fs::create_dir_all(folder).map_err(|error| trouble(error.to_string()))?;
        Ok(outputs)
    }

    /// Refuses a folder from which an interrupted simulation can go on: other results would spoil that.
    pub(crate) fn spare_interrupted(&self) -> Result<(), Failure> {
        if !self.folder.join(CHECKPOINT).exists() {
            return Ok(());
        }
        Err(Failure::input(format!(
            "{} holds an interrupted simulation ({CHECKPOINT}), which could not go on beside other results",
            self.folder.display()
        ))
        .help(format!(
            "give another folder with -o; end the simulation with --resume; or remove {CHECKPOINT}"
        )))
    }

    /// Begins a file.
    pub(crate) fn begin(&mut self, name: &str) -> Result<BufWriter<File>, Failure> {
        let complete = self.folder.join(name);
        let partial = self.folder.join(format!(".{name}.{}.partial", std::process::id()));
        if complete.is_dir() {
            return Err(self.trouble(name, "there is a folder of that name"));
        }
        if complete.exists() && !complete.is_file() {
            // A device or a pipe would be gone.
            return Err(self.trouble(name, "what is there is no file"));
        }
        if was_read(&complete) {
            return Err(Failure::input(format!(
                "{} was read for this run, and its results would take its place",
                complete.display()
            ))
            .help("give another folder with -o"));
        }
        let file = File::create(&partial).map_err(|error| self.trouble(name, error))?;
        self.pending.push((partial, complete));
        Ok(BufWriter::new(file))
    }

    /// Begins a file with the first `bytes` of another one of the folder.
    pub(crate) fn begin_with(
        &mut self,
        name: &str,
        other: &str,
        bytes: u64,
    ) -> Result<BufWriter<File>, Failure> {
        let mut file = self.begin(name)?;
        let gone = |why: &dyn Display| {
            let other = self.folder.join(other);
            Failure::input(format!("what was kept in {} cannot be used: {why}", other.display()))
                .help("begin anew without --resume")
        };
        let from = File::open(self.folder.join(other)).map_err(|error| gone(&error))?;
        let copied =
            io::copy(&mut from.take(bytes), &mut file).map_err(|e| self.trouble(name, e))?;
        if copied != bytes {
            return Err(gone(&"it is shorter than it was"));
        }
        Ok(file)
    }

    /// The name under which a file is being written, and its present length.
    pub(crate) fn partial(&self, name: &str) -> Option<(String, u64)> {
        let complete = self.folder.join(name);
        let (partial, _) = self.pending.iter().find(|(_, known)| *known == complete)?;
        let length = fs::metadata(partial).ok()?.len();
        Some((partial.file_name()?.to_str()?.to_owned(), length))
    }

    /// Writes a whole file at once, whatever becomes of the others.
    pub(crate) fn write_now(&self, name: &str, content: &[u8]) -> Result<(), Failure> {
        let partial = self.folder.join(format!(".{name}.{}.partial", std::process::id()));
        let written = File::create(&partial).and_then(|mut file| {
            file.write_all(content)?;
            // Otherwise a power cut may leave the name without the content.
            file.sync_all()?;
            fs::rename(&partial, self.folder.join(name))
        });
        written.map_err(|error| {
            let _ = fs::remove_file(&partial);
            self.trouble(name, error)
        })
    }

    /// A file of the folder, if it is there.
    pub(crate) fn read(&self, name: &str) -> Option<String> {
        fs::read_to_string(self.folder.join(name)).ok()
    }

    /// Removes a file of the folder, if it is there.
    pub(crate) fn remove(&self, name: &str) {
        let _ = fs::remove_file(self.folder.join(name));
    }

    /// Writes a whole file.
    pub(crate) fn write(&mut self, name: &str, content: &[u8]) -> Result<(), Failure> {
        let file = self.begin(name)?;
        self.end(name, file, content)
    }

    /// Writes the rest of a file and makes sure that it has arrived.
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

    /// Takes back a file that was begun.
    pub(crate) fn abandon(&mut self, name: &str) {
        let complete = self.folder.join(name);
        self.pending.retain(|(partial, known)| {
            let other = *known != complete;
            if !other {
                // It may be gone already; there is nobody to tell.
                let _ = fs::remove_file(partial);
            }
            other
        });
    }

    /// What is not complete stays where it is from now on, also if it never will be.
    pub(crate) fn keep(&self) {
        self.kept.set(true);
    }

    /// Whether what is not complete stays.
    pub(crate) fn is_kept(&self) -> bool {
        self.kept.get()
    }

    /// Gives all files their names; returns these. Those of `possible` that were not written this
    /// time would be taken for results of this run, and are removed.
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
            if self.pending.iter().all(|(_, complete)| *complete != stale) && !was_read(&stale) {
                // Mostly there is none.
                let _ = fs::remove_file(stale);
            }
        }
        Ok(std::mem::take(&mut self.pending).into_iter().map(|(_, complete)| complete).collect())
    }

    /// Removes what runs that were killed have left of the same files.
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
                // Whoever may not do that is not disturbed by it either.
                let _ = fs::remove_file(entry.path());
            }
        }
    }

    /// A failure about one of the files.
    pub(crate) fn trouble(&self, name: &str, error: impl Display) -> Failure {
        self.trouble_with(&self.folder.join(name).display(), error)
    }

    /// A failure about the tables, whichever of them it was.
    pub(crate) fn trouble_with_tables(&self, error: impl Display) -> Failure {
        self.trouble_with(&format_args!("the tables in {}", self.folder.display()), error)
    }

    fn trouble_with(&self, what: &dyn Display, error: impl Display) -> Failure {
        let failure = Failure::input(format!("cannot write {what}: {error}"));
        failure.help(match self.is_kept() {
            true => "what was done until then is kept: the same with --resume goes on from there",
            false => "nothing was changed in the folder; give another one with -o",
        })
    }
}

impl Drop for Outputs {
    fn drop(&mut self) {
        for (partial, _) in self.pending.iter().filter(|_| !self.is_kept()) {
            // It may be gone already; there is nobody to tell.
            let _ = fs::remove_file(partial);
        }
        for folder in &self.made {
            // Only those that are still empty go.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// The name of the file of which this is the name while it is not complete, if it is one.
fn of_partial(name: &str) -> Option<&str> {
    let (whole, id) = name.strip_prefix('.')?.strip_suffix(".partial")?.rsplit_once('.')?;
    id.bytes().all(|byte| byte.is_ascii_digit()).then_some(whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_what_is_not_complete() {
        assert_eq!(of_partial(".inverse.csv.123.partial"), Some("inverse.csv"));
        for other in ["inverse.csv", ".checkpoint.json.partial", ".a.12.part", "a.12.partial", ""] {
            assert_eq!(of_partial(other), None, "{other}");
        }
    }
}
