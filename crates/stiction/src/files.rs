//! Reads model files, motions and recordings, with limits on their size.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use stiction_format::{Contents, Store, not_text};

/// Progress callback for reading a long recording: the name of the recording, the number of bytes
/// read, and its length in bytes.
pub type ReadProgress = dyn Fn(&str, u64, u64) + Send + Sync;

/// Maximum size of a file that is read as a whole, bytes.
const LARGEST: u64 = 1 << 30;
/// Recordings longer than this number of bytes are read piece by piece, because they would need
/// five times as much memory if read as a whole.
const LONG: u64 = 8 << 20;
/// Maximum number of bytes read from a device or a pipe. Models and recordings from a pipe are
/// expected to be shorter, and an endless device is rejected quickly.
const LARGEST_STREAM: u64 = 256 << 20;

/// Reads files for a robot and stores their paths.
#[derive(Clone, Default)]
pub(crate) struct Files {
    read: Arc<Mutex<Vec<PathBuf>>>,
    /// Paths of the files that models and options name, spelled as in the model or option.
    named: Arc<Mutex<Vec<PathBuf>>>,
    /// Packed files: the path by which the model names each file, and its path on disk. Other files
    /// cannot be read. `None` if any file on disk may be read.
    packed: Option<Arc<Vec<(PathBuf, PathBuf)>>>,
    progress: Option<Arc<ReadProgress>>,
}

impl std::fmt::Debug for Files {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Files").field("read", &self.paths()).finish_non_exhaustive()
    }
}

impl Files {
    pub(crate) fn with_progress(progress: Option<Arc<ReadProgress>>) -> Self {
        Self { progress, ..Self::default() }
    }

    /// Creates a reader that reads only packed files. Each file is given by the path by which the
    /// model names it, and by its path on disk.
    pub(crate) fn packed(places: Vec<(PathBuf, PathBuf)>) -> Self {
        Self { packed: Some(Arc::new(places)), ..Self::default() }
    }

    /// True if only packed files can be read.
    pub(crate) fn is_packed(&self) -> bool {
        self.packed.is_some()
    }

    /// Paths of the files that models and options have named so far, spelled as in the model or
    /// option.
    pub(crate) fn named(&self) -> Vec<PathBuf> {
        self.named.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Full paths of all files read so far.
    pub(crate) fn paths(&self) -> Vec<PathBuf> {
        self.read.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn note(&self, path: &Path) {
        if let Ok(path) = path.canonicalize() {
            let mut read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
            // The rows of a study may read the same file; its path is stored only once.
            if !read.contains(&path) {
                read.push(path);
            }
        }
    }

    /// Reads a file that a model or an option names: a short file as text, a long recording as a
    /// [`Contents::Stored`].
    ///
    /// # Errors
    /// The reason, as the end of the sentence "cannot read FILE: ".
    pub(crate) fn contents(&self, path: &Path) -> Result<Contents, String> {
        let place = match &self.packed {
            None => path,
            Some(places) => {
                let place = places.iter().find(|(name, _)| name == path);
                &place.ok_or("it was not packed with the model")?.1
            }
        };
        let contents = self.contents_at(place)?;
        let mut named = self.named.lock().unwrap_or_else(PoisonError::into_inner);
        if !named.iter().any(|known| known == path) {
            named.push(path.to_owned());
        }
        Ok(contents)
    }

    fn contents_at(&self, path: &Path) -> Result<Contents, String> {
        let has_ending = |ending: &str| {
            path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(ending))
        };
        #[cfg(not(target_arch = "wasm32"))]
        if has_ending("npz") {
            return stiction_format::csv_of_npz(&self.bytes(path)?).map(Contents::Whole);
        }
        if has_ending("mcap") {
            return self.joint_states(path, false);
        }
        let metadata = fs::metadata(path).map_err(|error| describe(&error))?;
        let is_table = has_ending("toml");
        // A pipe cannot be read twice, so it is always read as a whole.
        if metadata.is_file() && metadata.len() > LONG && !is_table {
            let stored = StoredFile::open(path, metadata.len(), self.progress.clone())
                .map_err(|error| describe(&error))?;
            self.note(path);
            return Ok(Contents::Stored(Arc::new(stored)));
        }
        self.text(path).map(Contents::Whole)
    }

    /// Reads a measured log. From an MCAP log, efforts are read in addition to positions.
    ///
    /// # Errors
    /// The reason, as the end of the sentence "cannot read FILE: ".
    pub(crate) fn log(&self, path: &Path) -> Result<Contents, String> {
        match path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap")) {
            true => self.joint_states(path, true),
            false => self.contents(path),
        }
    }

    /// Returns the joint states of an MCAP log as a CSV table, with efforts if `efforts` is true.
    #[cfg(feature = "mcap")]
    fn joint_states(&self, path: &Path, efforts: bool) -> Result<Contents, String> {
        stiction_format::csv_of_mcap(&self.bytes(path)?, efforts).map(Contents::Whole)
    }

    #[cfg(not(feature = "mcap"))]
    fn joint_states(&self, _: &Path, _: bool) -> Result<Contents, String> {
        Err("this program was built without MCAP support; build it with `--features mcap`, or save the positions of \
             its JointState messages as CSV or as NPZ (numpy.savez), with an array `time` and one array for each joint"
            .to_owned())
    }

    /// Reads the bytes of a file that is not text, such as a mesh or an archive.
    ///
    /// # Errors
    /// The reason, as the end of the sentence "cannot read FILE: ".
    pub(crate) fn bytes(&self, path: &Path) -> Result<Vec<u8>, String> {
        let metadata = fs::metadata(path).map_err(|error| describe(&error))?;
        if !metadata.is_file() {
            return Err("it is not a file".to_owned());
        }
        if metadata.len() > LARGEST {
            let size = metadata.len() as f64 / 1e9;
            return Err(format!("it has {size:.1} GB; at most 1 GB is read"));
        }
        let mut bytes = Vec::new();
        let file = File::open(path).map_err(|error| describe(&error))?;
        file.take(LARGEST).read_to_end(&mut bytes).map_err(|error| describe(&error))?;
        self.note(path);
        Ok(bytes)
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// The reason, as the end of the sentence "cannot read FILE: ".
    pub(crate) fn text(&self, path: &Path) -> Result<String, String> {
        let metadata = fs::metadata(path).map_err(|error| describe(&error))?;
        if metadata.is_dir() {
            return Err("it is a folder".to_owned());
        }
        let limit = if metadata.is_file() { LARGEST } else { LARGEST_STREAM };
        if metadata.len() > limit {
            let size = metadata.len() as f64 / 1e9;
            return Err(format!("it has {size:.1} GB; at most 1 GB is read"));
        }
        let text = bounded(File::open(path).map_err(|error| describe(&error))?, limit)?;
        self.note(path);
        Ok(text)
    }
}

/// Reads text from standard input.
///
/// # Errors
/// The reason, as the end of the sentence "cannot read standard input: ".
pub(crate) fn standard_input() -> Result<String, String> {
    bounded(io::stdin().lock(), LARGEST_STREAM)
}

/// Reads text of at most `limit` bytes. At most one byte more is read from the source, to detect
/// longer text.
fn bounded(from: impl Read, limit: u64) -> Result<String, String> {
    let mut bytes = Vec::new();
    let mut from = from.take(limit + 1);
    let mut checked = 0;
    // The text is read piece by piece, so that content that is not text is rejected early,
    // regardless of its length.
    loop {
        let piece = (&mut from).take(PIECE).read_to_end(&mut bytes).map_err(|e| describe(&e))?;
        if piece == 0 {
            break;
        }
        if let Some(place) = bytes[checked..].iter().position(|byte| *byte == 0) {
            let lines = (0, 0);
            return Err(not_text(&bytes, checked + place, lines));
        }
        checked = bytes.len();
        if checked as u64 > limit {
            let size = limit as f64 / 1e9;
            return Err(format!("it is longer than the maximum of {size:.2} GB"));
        }
    }
    String::from_utf8(bytes)
        .map_err(|error| not_text(error.as_bytes(), error.utf8_error().valid_up_to(), (0, 0)))
}

/// Number of bytes read between two checks that the content is text.
const PIECE: u64 = 1 << 20;

/// Describes in plain words why a file cannot be read.
fn describe(error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => "there is no such file".to_owned(),
        ErrorKind::PermissionDenied => "permission denied".to_owned(),
        _ => error.to_string(),
    }
}

/// A long recording on disk, read piece by piece.
struct StoredFile {
    name: String,
    /// Length of the file when it was opened, bytes.
    length: u64,
    state: Mutex<StoredState>,
}

struct StoredState {
    file: File,
    /// Callback for progress reports; `None` if not requested, or after the recording has been read
    /// to its end.
    progress: Option<Arc<ReadProgress>>,
}

impl std::fmt::Debug for StoredFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("StoredFile").field("name", &self.name).finish_non_exhaustive()
    }
}

impl StoredFile {
    fn open(path: &Path, length: u64, progress: Option<Arc<ReadProgress>>) -> io::Result<Self> {
        let state = StoredState { file: File::open(path)?, progress };
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        Ok(Self { name: name.into_owned(), length, state: Mutex::new(state) })
    }
}

impl Store for StoredFile {
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> Result<usize, String> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let StoredState { file, progress } = &mut *state;
        file.seek(SeekFrom::Start(offset)).map_err(|error| describe(&error))?;
        let count = loop {
            match file.read(buffer) {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                other => break other.map_err(|error| describe(&error))?,
            }
        };
        if let Some(report) = progress {
            let done = if count == 0 { self.length } else { offset + count as u64 };
            report(&self.name, done, self.length);
        }
        if count == 0 {
            *progress = None;
        }
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Endless source of one byte value, which counts the bytes that were read.
    struct Endless(u8, u64);

    impl Read for &mut Endless {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            buffer.fill(self.0);
            self.1 += buffer.len() as u64;
            Ok(buffer.len())
        }
    }

    #[test]
    fn an_endless_text_is_refused_after_the_limit_and_one_byte() {
        let mut endless = Endless(b'x', 0);
        let why = bounded(&mut endless, 100_000_000).unwrap_err();
        assert_eq!(why, "it is longer than the maximum of 0.10 GB");
        assert_eq!(endless.1, 100_000_001);
    }

    #[test]
    fn an_endless_device_of_zeros_is_refused_after_its_first_piece() {
        let mut endless = Endless(0, 0);
        let why = bounded(&mut endless, LARGEST).unwrap_err();
        assert!(why.contains("not a text file"), "{why}");
        assert!(endless.1 <= 2 * PIECE, "{}", endless.1);
    }

    #[test]
    fn a_text_as_long_as_the_limit_is_read() {
        assert_eq!(bounded(&b"abc"[..], 3).as_deref(), Ok("abc"));
        assert!(bounded(&b"abcd"[..], 3).is_err());
    }
}
