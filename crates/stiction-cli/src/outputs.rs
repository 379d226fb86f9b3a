//! Files that appear complete or not at all.

use crate::failure::Failure;
use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

/// Files being written into a folder, each under a name of its own until all are complete. What is
/// not completed is removed; what stood there before stays until then.
#[derive(Debug)]
pub(crate) struct Outputs {
    folder: PathBuf,
    pending: Vec<(PathBuf, PathBuf)>,
    /// Whether the folder was not there before.
    is_new: bool,
}

impl Outputs {
    /// Makes the folder if need be.
    pub(crate) fn new(folder: &Path) -> Result<Self, Failure> {
        let is_new = !folder.exists();
        // What stands where a folder is wanted, itself or above.
        let blocks = |at: &&Path| at.exists() && !at.is_dir();
        if let Some(file) = folder.ancestors().find(blocks) {
            return Err(Failure::input(format!(
                "-o wants a folder, but {} is a file",
                file.display()
            ))
            .help("give the name of a folder, which may be new"));
        }
        fs::create_dir_all(folder).map_err(|error| {
            Failure::input(format!("cannot make the folder {}: {error}", folder.display()))
                .help("give another folder with -o")
        })?;
        Ok(Self { folder: folder.to_owned(), pending: Vec::new(), is_new })
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
        let from = File::open(self.folder.join(other)).map_err(|e| self.trouble(other, e))?;
        let copied =
            io::copy(&mut from.take(bytes), &mut file).map_err(|e| self.trouble(name, e))?;
        if copied != bytes {
            return Err(self.trouble(other, "what was kept is not there any more"));
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
        let partial = self.folder.join(format!(".{name}.partial"));
        fs::write(&partial, content)
            .and_then(|()| fs::rename(&partial, self.folder.join(name)))
            .map_err(|error| self.trouble(name, error))
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

    /// Gives all files their names; returns these. Those of `possible` that were not written this
    /// time would be taken for results of this run, and are removed.
    pub(crate) fn complete(mut self, possible: &[&str]) -> Result<Vec<PathBuf>, Failure> {
        for (partial, complete) in &self.pending {
            fs::rename(partial, complete).map_err(|error| {
                Failure::input(format!("cannot write {}: {error}", complete.display()))
                    .help("give another folder with -o")
            })?;
        }
        for name in possible {
            let stale = self.folder.join(name);
            if self.pending.iter().all(|(_, complete)| *complete != stale) {
                // Mostly there is none.
                let _ = fs::remove_file(stale);
            }
        }
        Ok(std::mem::take(&mut self.pending).into_iter().map(|(_, complete)| complete).collect())
    }

    /// A failure about one of the files.
    pub(crate) fn trouble(&self, name: &str, error: impl std::fmt::Display) -> Failure {
        Failure::input(format!("cannot write {}: {error}", self.folder.join(name).display()))
            .help("nothing was changed in the folder; give another one with -o")
    }
}

impl Drop for Outputs {
    fn drop(&mut self) {
        for (partial, _) in &self.pending {
            // It may be gone already; there is nobody to tell.
            let _ = fs::remove_file(partial);
        }
        if self.is_new {
            // Only one that is still empty goes.
            let _ = fs::remove_dir(&self.folder);
        }
    }
}
