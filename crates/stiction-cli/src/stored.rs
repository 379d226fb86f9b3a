//! Long recordings: files of which little is in memory at any time.

use crate::failure::describe;
use crate::progress::Progress;
use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use stiction_format::Store;

/// A file that is read again and again.
#[derive(Debug)]
pub(crate) struct StoredFile {
    name: String,
    /// When it was opened, bytes.
    length: u64,
    state: Mutex<State>,
}

struct State {
    file: File,
    /// While it is read for the first time.
    progress: Option<Progress>,
}

impl std::fmt::Debug for State {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.file.fmt(f)
    }
}

impl StoredFile {
    /// Opens a file of so many bytes.
    pub(crate) fn open(path: &Path, length: u64) -> std::io::Result<Self> {
        let state = State { file: File::open(path)?, progress: Some(Progress::new()) };
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        Ok(Self { name: name.into_owned(), length, state: Mutex::new(state) })
    }
}

impl Store for StoredFile {
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> Result<usize, String> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let State { file, progress } = &mut *state;
        if let Some(progress) = progress {
            progress.tell_bytes(&self.name, offset, self.length);
        }
        file.seek(SeekFrom::Start(offset)).map_err(|error| describe(&error))?;
        let count = loop {
            match file.read(buffer) {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                other => break other.map_err(|error| describe(&error))?,
            }
        };
        // The end was seen: from now on parts are read again.
        if count == 0
            && let Some(mut progress) = progress.take()
        {
            progress.clear();
        }
        Ok(count)
    }
}
