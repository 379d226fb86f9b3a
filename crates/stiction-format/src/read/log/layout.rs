//! Converts logs whose columns are separated by blanks, or whose header is written as a comment, to
//! the usual layout.

use super::clock;
use super::preamble::SEARCHED;
use crate::signal::recorded::lines::{Delimiter, parse_number};

/// Replaces blanks between columns by tabs if the table has no other separator, and removes the
/// comment mark before a header. The length of the text and all positions in it stay the same.
pub(super) fn with_separators(text: String) -> String {
    let content = |line: &str| -> Option<String> {
        let line = line.trim();
        (!line.is_empty()).then(|| line.to_owned())
    };
    let lines: Vec<String> = text.lines().filter_map(content).take(SEARCHED).collect();
    let numbers = |line: &String| {
        let words = line.split_whitespace();
        // A comma at the end of a word separates columns.
        let number = |word: &str| parse_number(word).filter(|_| !word.ends_with(','));
        let all: Option<Vec<f64>> = words.map(number).collect();
        all.map_or(0, |all| all.len())
    };
    let is_blank = lines.iter().any(|line| numbers(line) > 1)
        && !lines.iter().any(|line| line.contains(['\t', ';']));
    let mut bytes = text.into_bytes();
    if is_blank {
        let (mut begins, mut is_quoted) = (true, false);
        for at in 0..bytes.len() {
            let is_blank = bytes[at] == b' ';
            // An unmatched quote ends at the end of its line.
            is_quoted = bytes[at] != b'\n' && (is_quoted ^ (bytes[at] == b'"'));
            let ends = bytes.get(at + 1).is_none_or(|next| [b' ', b'\r', b'\n'].contains(next));
            // Of several consecutive blanks, only the last becomes a tab; blanks at the ends of a
            // line are kept.
            if is_blank && !begins && !ends && !is_quoted {
                bytes[at] = b'\t';
            }
            begins = bytes[at] == b'\n' || begins && (is_blank || bytes[at] == b'#');
        }
    }
    uncomment(&mut bytes);
    // Only ASCII characters have changed.
    String::from_utf8(bytes).unwrap_or_default()
}

/// Replaces the mark `#` of the last comment above the first row by a blank, if this row has as
/// many cells as the comment and consists of numbers, dates or times of day.
fn uncomment(bytes: &mut [u8]) {
    let (mut at, mut comment) = (0, None);
    while at < bytes.len() {
        let length = bytes[at..].iter().position(|b| *b == b'\n').unwrap_or(bytes.len() - at);
        let line = String::from_utf8_lossy(&bytes[at..at + length]).into_owned();
        let line = line.trim();
        if line.starts_with('#') {
            // The header determines the separator, because commas in the rows may be decimal
            // commas.
            let delimiter = Delimiter::of(line);
            comment = Some((at, delimiter, delimiter.divide(line).count()));
        } else if !line.is_empty() {
            let is_value = |cell: &str| parse_number(cell).is_some() || clock::is_time(cell);
            if let Some((start, delimiter, count)) = comment
                && delimiter.divide(line).all(|cell| is_value(cell.trim()))
                && count == delimiter.divide(line).count()
                && count > 1
                && let Some(mark) = bytes[start..].iter().position(|b| *b == b'#')
            {
                bytes[start + mark] = b' ';
            }
            return;
        }
        at += length + 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(text: &str) -> String {
        with_separators(text.to_owned())
    }

    #[test]
    fn blanks_between_columns_become_separators() {
        assert_eq!(changed("  1.0   2.0 3\n 4 5  6 \r\n"), "  1.0  \t2.0\t3\n 4\t5 \t6 \r\n");
        assert_eq!(changed("t q\n0 1\n"), "t\tq\n0\t1\n");
        for text in ["time [s],q\n0, 1\n", "time [s]\tq\n0\t1\n", "t [s];q\n0; 1 2\n"] {
            assert_eq!(changed(text), text);
        }
    }

    #[test]
    fn a_comment_with_the_names_of_columns_is_the_header() {
        assert_eq!(changed("# mine\n# t,q\n0,1\n# end,x\n"), "# mine\n  t,q\n0,1\n# end,x\n");
        assert_eq!(changed("# t q\n0 1\n"), "  t\tq\n0\t1\n");
        // Rows with decimal commas.
        assert_eq!(changed("# t;q\n0,5;1,5\n"), "  t;q\n0,5;1,5\n");
        assert_eq!(changed("# t\tq\n0,5\t1,5\n"), "  t\tq\n0,5\t1,5\n");
        for text in ["# t,q,r\n0,1\n", "# t,q\nt,q\n0,1\n", "# t\n0\n"] {
            assert_eq!(changed(text), text);
        }
    }
}
