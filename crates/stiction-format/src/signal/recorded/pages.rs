//! A stored text as pages of whole lines.

use super::lines::unify_line_ends;
use crate::contents::{Store, not_text};
use crate::source::{Begin, Source};
use std::sync::Arc;

/// Number of bytes read at a time.
const PAGE: usize = 1 << 18;
/// Maximum length of a line, bytes; a file with a longer line is not a recording.
const LONGEST_LINE: usize = 1 << 20;

/// Iterator over the pages of a stored text, each of which consists of whole lines; an empty text
/// has one empty page.
pub(crate) struct Pages<'a> {
    store: &'a dyn Store,
    name: &'a str,
    /// Position of the next page in the text.
    begin: Begin,
    /// Bytes read but not yet returned.
    rest: Vec<u8>,
    has_ended: bool,
}

impl<'a> Pages<'a> {
    pub(crate) fn new(store: &'a dyn Store, name: &'a str) -> Self {
        Self { store, name, begin: Begin::default(), rest: Vec::new(), has_ended: false }
    }

    /// Reads more bytes, at least to the end of a line; returns all complete lines and keeps the
    /// incomplete one.
    fn read(&mut self) -> Result<Vec<u8>, String> {
        loop {
            let known = self.rest.len();
            self.rest.resize(known + PAGE, 0);
            let offset = self.begin.bytes + known as u64;
            let buffer = self.rest.get_mut(known..).unwrap_or_default();
            let count = self.store.read_at(offset, buffer)?.min(PAGE);
            self.rest.truncate(known + count);
            if count == 0 {
                self.has_ended = true;
                return Ok(std::mem::take(&mut self.rest));
            }
            let ends_line = |at: &usize| match self.rest.get(*at) {
                Some(b'\n') => true,
                // A carriage return alone, not followed by a line feed.
                Some(b'\r') => self.rest.get(at + 1).is_some_and(|next| *next != b'\n'),
                _ => false,
            };
            let end = (known.saturating_sub(1)..self.rest.len()).rev().find(ends_line);
            if let Some(end) = end {
                let rest = self.rest.split_off(end + 1);
                return Ok(std::mem::replace(&mut self.rest, rest));
            }
            if self.rest.len() > LONGEST_LINE {
                let line = self.begin.lines + 1;
                return Err(format!(
                    "line {line} has more than {LONGEST_LINE} bytes; a recording has one sample per line"
                ));
            }
        }
    }
}

impl Iterator for Pages<'_> {
    type Item = Result<Arc<Source>, String>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.has_ended {
            return None;
        }
        let begin = self.begin;
        let bytes = match self.read() {
            Ok(bytes) if bytes.is_empty() && begin.bytes > 0 => return None,
            Ok(bytes) => bytes,
            Err(why) => {
                self.has_ended = true;
                return Some(Err(why));
            }
        };
        self.begin.bytes += bytes.len() as u64;
        let page = String::from_utf8(bytes).map(unify_line_ends).map_err(|error| {
            let at = error.utf8_error().valid_up_to();
            not_text(error.as_bytes(), at, (begin.bytes, begin.lines))
        });
        let lines = page.as_ref().map_or(0, |text| text.bytes().filter(|b| *b == b'\n').count());
        self.begin.lines += lines;
        self.has_ended |= page.is_err();
        Some(page.map(|text| Arc::new(Source::piece(self.name, text, begin))))
    }
}
