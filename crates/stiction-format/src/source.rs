//! Texts and places in them.

use std::ops::Range;
use std::sync::Arc;

/// A range of bytes in a text.
pub(crate) type Span = Range<usize>;

/// Text with the name that messages use for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// File name, or an option such as `--motion`.
    pub name: String,
    /// The whole text or, if the text is read in pieces, one piece of whole lines.
    pub text: String,
    /// Position of the piece in the whole text.
    begin: Begin,
    /// Changes of single values of the model, one per line, as [`Self::with_changes`] describes
    /// them.
    changes: Option<Arc<Source>>,
    /// Cut-off frequency, Hz, of the filter for all recordings that the text names; `None` if each
    /// motion determines its own filter.
    filter: Option<f64>,
}

/// Numbers of bytes and lines of a text that precede one of its pieces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Begin {
    pub(crate) bytes: u64,
    pub(crate) lines: usize,
}

impl Source {
    /// Creates a source from a name and a text.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        let (name, text) = (name.into(), text.into());
        Self { name, text, begin: Begin::default(), changes: None, filter: None }
    }

    /// Creates a source for a piece of whole lines of a text.
    pub(crate) fn piece(name: impl Into<String>, text: String, begin: Begin) -> Self {
        Self { name: name.into(), text, begin, changes: None, filter: None }
    }

    /// Numbers of bytes and lines of the text before the piece.
    pub(crate) fn begin(&self) -> Begin {
        self.begin
    }

    /// Adds changes of single values to the text of a model, each written as `bodies.platform.mass = 2 kg`: the path
    /// of a key, or the name of a parameter, and the new value.
    ///
    /// The name of a joint or body alone stands for its table (`platform.mass`). A key below `legs` changes all legs
    /// that have it; bodies and joints of legs can be named directly (`legs.rod.mass`), and `legs.2` is the second of
    /// several tables of legs. The text is not rewritten: the changes are applied when it is read.
    pub fn with_changes<S: AsRef<str>>(self, changes: impl IntoIterator<Item = S>) -> Self {
        let lines: Vec<String> =
            changes.into_iter().map(|change| change.as_ref().replace(['\n', '\r'], " ")).collect();
        let changes = (!lines.is_empty()).then(|| Arc::new(Self::new("--set", lines.join("\n"))));
        Self { changes, ..self }
    }

    /// Sets the cut-off frequency, Hz, of the low-pass filter for all recorded motions that the
    /// text names. The frequency replaces the `filter` of each motion; `None` leaves it unchanged.
    pub fn with_filter(self, cutoff: Option<f64>) -> Self {
        Self { filter: cutoff, ..self }
    }

    /// Cut-off frequency of the filter for recorded motions, Hz.
    pub(crate) fn filter(&self) -> Option<f64> {
        self.filter
    }

    /// Changes of single values as one text, with one change per line; `None` without changes.
    pub(crate) fn changes(&self) -> Option<&Arc<Self>> {
        self.changes.as_ref()
    }

    /// Byte offset that is added to places in the changes, so that they lie beyond all places in
    /// the text.
    pub(crate) fn begin_of_changes(&self) -> usize {
        self.text.len() + 2
    }
}

/// A place in a text.
#[derive(Clone, Debug)]
pub struct Place {
    /// Text that contains the place.
    pub source: Arc<Source>,
    /// Byte range. May be empty or lie beyond the end of the text; no method panics.
    pub span: Range<usize>,
}

impl Place {
    pub(crate) fn new(source: &Arc<Source>, span: Span) -> Self {
        let begin = source.begin_of_changes();
        match source.changes() {
            Some(changes) if span.start >= begin => Self {
                source: Arc::clone(changes),
                span: span.start - begin..span.end.saturating_sub(begin),
            },
            _ => Self { source: Arc::clone(source), span },
        }
    }

    /// Tests if the place refers to the whole text; it is then an empty range at the start.
    pub(crate) fn is_whole(&self) -> bool {
        self.span == (0..0) && self.source.begin.bytes == 0
    }

    /// Line and column of the first character of the place, counted from 1; columns are counted in
    /// characters.
    pub fn line_column(&self) -> (usize, usize) {
        self.source.line_column(self.span.start)
    }

    /// Line and column after the last character of the place, counted in the same way as
    /// [`Self::line_column`] counts them.
    pub fn end_line_column(&self) -> (usize, usize) {
        self.source.line_column(self.span.end.max(self.span.start))
    }
}

/// Byte offset of the last character boundary at or before `at`.
pub(crate) fn boundary(text: &str, at: usize) -> usize {
    let mut at = at.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

impl Source {
    fn line_column(&self, at: usize) -> (usize, usize) {
        let before = self.text.get(..boundary(&self.text, at)).unwrap_or_default();
        let line = before.bytes().filter(|&b| b == b'\n').count() + 1;
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let column = before.get(start..).unwrap_or_default().trim_start_matches('\u{feff}');
        (self.begin.lines + line, column.chars().count() + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_count_characters_from_one() {
        let source = Arc::new(Source::new("a", "\u{feff}äb\nc\r\nd"));
        let at = |start: usize| Place::new(&source, start..start).line_column();
        assert_eq!(at(3), (1, 1));
        assert_eq!(at(4), (1, 1)); // amid the two bytes of ä
        assert_eq!(at(5), (1, 2));
        assert_eq!(at(7), (2, 1));
        assert_eq!(at(10), (3, 1));
        assert_eq!(at(999), (3, 2));
    }
}
