//! Reading of a whole recording, from the header line to the last row.

use super::header::Header;
use super::messages::Messages;
use super::rows::Rows;
use crate::diagnostic::Diagnostics;
use crate::signal::recorded::lines::{Cells, Delimiter, Line, lines, parse_number};
use crate::source::{Begin, Source};
use std::ops::Range;
use std::sync::Arc;

/// Result of reading a whole recording: the header, and the messages.
pub(super) struct Scan {
    /// Header, and the page that contains the header line; `None` if the file is empty, is not a
    /// text, or begins with numbers.
    pub(super) header: Option<(Header, Arc<Source>)>,
    /// Messages about the recording; their current page is the page read last.
    pub(super) messages: Messages,
}

/// Reads all pages of a recording. `example` is a column name for messages; `head` reads the header
/// line. Until the first error, `take` is called for each row with the header, the values in SI
/// units, the standard deviations of their rounding errors, and the byte range of the row's line in
/// the file.
pub(super) fn scan(
    pages: impl Iterator<Item = Result<Arc<Source>, String>>,
    example: &str,
    head: impl Fn(&str, Line, Delimiter, &mut Messages) -> Header,
    mut take: impl FnMut(&Header, &[f64], &[f64], Range<u64>),
) -> Result<Scan, String> {
    let mut messages = Messages::new(Arc::new(Source::new("", "")));
    let mut open: Option<(Rows, Arc<Source>)> = None;
    for page in pages {
        let page = page?;
        messages.page = Arc::clone(&page);
        let text = page.text.as_str();
        if let Some(at) = text.find('\0') {
            // Discard the messages about earlier pages, as the file is not a text.
            messages.out = Diagnostics::new();
            let message = "this is not a text file".to_owned();
            messages.push("syntax", message, at..at + 1, "a zero byte");
            return Ok(Scan { header: None, messages });
        }
        let mut lines = lines(&page);
        if open.is_none() {
            let Some(mut first) = lines.next() else { continue };
            let declared = Delimiter::declared(text.get(first.clone()).unwrap_or_default());
            if declared.is_some() {
                let Some(next) = lines.next() else { continue };
                first = next;
            }
            let header = text.get(first.clone()).unwrap_or_default();
            let delimiter = declared.unwrap_or_else(|| Delimiter::of(header));
            if is_numbers(text, &first, delimiter) {
                let help = format!("name the columns in the first line: time [s], {example}, …");
                let message = "the header with the column names is missing".to_owned();
                messages.push_help(
                    "syntax",
                    message,
                    first,
                    "numbers instead of names",
                    Some(help),
                );
                return Ok(Scan { header: None, messages });
            }
            let mut rows = Rows::new(head(text, first, delimiter, &mut messages));
            rows.count_digits(text, lines.clone());
            open = Some((rows, Arc::clone(&page)));
        }
        let Some((rows, _)) = &mut open else { continue };
        for line in lines {
            let Begin { bytes, .. } = page.begin();
            let place = bytes + line.start as u64..bytes + line.end as u64;
            let was_read = rows.read(text, line, &mut messages);
            if was_read && !messages.out.has_errors() {
                take(rows.header(), rows.row(), rows.rounding(), place);
            }
        }
    }
    if open.is_none() {
        let help = format!("the first line names the columns: time [s], {example}, …");
        let message = "the file is empty".to_owned();
        // An empty file has no line for an excerpt.
        messages.page = Arc::new(Source::new(messages.page.name.as_str(), ""));
        messages.push_help("syntax", message, 0..0, "", Some(help));
    }
    Ok(Scan { header: open.map(|(rows, page)| (rows.into_header(), page)), messages })
}

fn is_numbers(text: &str, line: &Line, delimiter: Delimiter) -> bool {
    let mut cells = Cells::new(delimiter);
    let mut all = cells.split(text, line.clone(), usize::MAX).iter();
    all.all(|cell| text.get(cell.clone()).is_some_and(|cell| parse_number(cell).is_some()))
}
