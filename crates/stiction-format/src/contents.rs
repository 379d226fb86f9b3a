//! Contents of input files (models, logs, recorded motions): either a complete text, or a source of
//! bytes that can be read repeatedly.

use std::fmt::Debug;
use std::sync::Arc;

/// Contents of a file: a text in memory, or a stored text that is read on demand.
#[derive(Clone, Debug)]
pub enum Contents {
    /// Complete text in memory.
    Whole(String),
    /// UTF-8 text that is read piece by piece when needed. Only recorded motions (CSV) can have
    /// this form, which needs little memory even for a very long text.
    Stored(Arc<dyn Store>),
}

impl From<String> for Contents {
    fn from(text: String) -> Self {
        Self::Whole(text)
    }
}

impl From<&str> for Contents {
    fn from(text: &str) -> Self {
        Self::Whole(text.to_owned())
    }
}

impl Contents {
    /// Returns the complete text. Stored contents are an error, because only recorded motions (CSV)
    /// are read piece by piece.
    pub(crate) fn whole(self) -> Result<String, String> {
        match self {
            Self::Whole(text) => Ok(text),
            Self::Stored(_) => {
                Err("it is too long for a model or log; only recorded motions (CSV) can be this \
                    long"
                    .to_owned())
            }
        }
    }
}

/// Source of bytes with random access, usually a file.
///
/// The text of a recorded motion is read once from beginning to end. Parts of the text are read
/// again later, on any thread. The contents must not change between these reads; a change is
/// detected and reported.
pub trait Store: Debug + Send + Sync {
    /// Reads bytes, starting at byte `offset` of the contents, into `buffer`. Returns the number of
    /// bytes read, which is zero only at the end of the contents.
    ///
    /// # Errors
    /// Returns a reason that completes the sentence "the file cannot be read: ".
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> Result<usize, String>;
}

/// Explains why `bytes` are not UTF-8 text. `bytes` is the part of a text that begins at byte
/// `offset`, after `lines` lines; `at` is the index of the first invalid byte in `bytes`.
pub fn not_text(bytes: &[u8], at: usize, (offset, lines): (u64, usize)) -> String {
    let is_begin = offset == 0;
    if is_begin && (bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff])) {
        return "it is UTF-16 text; save it as UTF-8".to_owned();
    }
    let (before, rest) = bytes.split_at_checked(at).unwrap_or((bytes, &[]));
    let place = offset + before.len() as u64 + 1;
    if before.contains(&0) || rest.iter().take(1000).any(|byte| *byte == 0) {
        return format!("it is not a text file (byte {place} is not text)");
    }
    let line = 1 + lines + before.iter().filter(|byte| **byte == b'\n').count();
    format!(
        "it is not UTF-8 text: in line {line} byte {place} is 0x{:02x}; convert older encodings such as \
         Latin-1 to UTF-8",
        rest.first().copied().unwrap_or_default()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_text_is_reported_with_its_place() {
        let why = |bytes: &[u8]| {
            let error = std::str::from_utf8(bytes).unwrap_err();
            not_text(bytes, error.valid_up_to(), (0, 0))
        };
        assert!(why(b"a = 1\nb = 2 # \xe9 \nc").contains("line 2 byte 15 is 0xe9"));
        assert!(why(b"\x7fELF\x02\0\0\xff").contains("not a text file (byte 8"));
        for utf16 in [&b"\xff\xfea\0"[..], b"\xfe\xff\0a"] {
            assert!(why(utf16).contains("UTF-16"));
        }
        let later = not_text(b"ab\n\xff\xfe", 3, (1000, 20));
        assert!(later.contains("line 22 byte 1004 is 0xff"), "{later}");
    }
}
