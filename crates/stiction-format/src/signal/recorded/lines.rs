//! Lines, cells and numbers of a CSV file.

use crate::source::{Source, Span};
use csv_core::{ReadFieldResult, Reader, ReaderBuilder};

/// Byte range of a line.
pub(crate) type Line = Span;

/// Replaces line ends that are a single carriage return by line feeds; all positions remain valid.
pub(crate) fn unify_line_ends(text: String) -> String {
    let is_lone = |at: usize, bytes: &[u8]| bytes.get(at + 1) != Some(&b'\n');
    if !text.bytes().enumerate().any(|(at, b)| b == b'\r' && is_lone(at, text.as_bytes())) {
        return text;
    }
    let mut bytes = text.into_bytes();
    for at in 0..bytes.len() {
        if bytes.get(at) == Some(&b'\r') && is_lone(at, &bytes) {
            bytes[at] = b'\n';
        }
    }
    // Replacing one ASCII character by another preserves UTF-8.
    String::from_utf8(bytes).unwrap_or_default()
}

/// Returns the byte ranges, without line ends, of all lines that are neither empty nor comments.
pub(crate) fn lines(source: &Source) -> impl Iterator<Item = Line> + Clone + '_ {
    let text = source.text.as_str();
    let is_begin = source.begin().bytes == 0;
    let is_marked = is_begin && text.starts_with('\u{feff}');
    let mut at = if is_marked { '\u{feff}'.len_utf8() } else { 0 };
    std::iter::from_fn(move || {
        while at < text.len() {
            let rest = text.get(at..).unwrap_or_default();
            let length = rest.find('\n').unwrap_or(rest.len());
            let line = at..at + length;
            at += length + 1;
            let content = text.get(line.clone()).unwrap_or_default().trim();
            if !content.is_empty() && !content.starts_with('#') {
                return Some(line);
            }
        }
        None
    })
}

/// Separator of the columns: comma, semicolon or tab.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Delimiter(u8);

impl Delimiter {
    pub(crate) const COMMA: Self = Self(b',');
    /// All separators. The comma comes last, because it may also be a decimal comma.
    pub(crate) const ALL: [Self; 3] = [Self(b'\t'), Self(b';'), Self::COMMA];

    /// Separator declared by a first line `sep=;`, which some spreadsheets write.
    pub(crate) fn declared(line: &str) -> Option<Self> {
        match line.trim().trim_matches('"').strip_prefix("sep=")?.as_bytes() {
            [delimiter @ (b',' | b';' | b'\t')] => Some(Self(*delimiter)),
            // The tab itself may have been trimmed.
            [] => Some(Self(b'\t')),
            _ => None,
        }
    }

    /// Returns the separator that divides a header into the most cells. If several separators do, a
    /// semicolon is preferred to a tab, and a comma to both.
    pub(crate) fn of(header: &str) -> Self {
        let count = |delimiter: u8| {
            let is_quoted = |quoted: &mut bool, byte: u8| {
                *quoted ^= byte == b'"';
                Some((*quoted, byte))
            };
            let bytes = header.bytes().scan(false, is_quoted);
            bytes.filter(|&(quoted, byte)| !quoted && byte == delimiter).count()
        };
        let all = [b'\t', b';', b','];
        Self(all.into_iter().max_by_key(|&delimiter| count(delimiter)).unwrap_or(b','))
    }

    /// Divides a line without quoted cells at the separator.
    pub(crate) fn divide(self, line: &str) -> impl Iterator<Item = &str> {
        line.split(char::from(self.0))
    }

    /// Tests if the separator is a comma.
    pub(crate) fn is_comma(self) -> bool {
        self == Self::COMMA
    }
}

/// Splits lines into cells.
pub(crate) struct Cells {
    reader: Reader,
    spans: Vec<Span>,
}

impl Cells {
    pub(crate) fn new(Delimiter(delimiter): Delimiter) -> Self {
        Self { reader: ReaderBuilder::new().delimiter(delimiter).build(), spans: Vec::new() }
    }

    /// Returns the byte ranges of the cells of a line, without surrounding white space and quotes.
    /// If there are more than `width` cells, an empty cell after the last separator is omitted.
    pub(crate) fn split(&mut self, text: &str, line: Line, width: usize) -> &[Span] {
        self.spans.clear();
        self.reader.reset();
        let mut input = text.get(line.clone()).unwrap_or_default().as_bytes();
        let (mut start, mut at) = (line.start, line.start);
        loop {
            let (result, count, _) = self.reader.read_field(input, &mut [0; 64]);
            at += count;
            let is_last = input.is_empty();
            input = input.get(count..).unwrap_or_default();
            match result {
                ReadFieldResult::InputEmpty if is_last => break,
                ReadFieldResult::InputEmpty | ReadFieldResult::OutputFull => {}
                ReadFieldResult::Field { record_end } => {
                    let end = if record_end { at } else { at - 1 };
                    self.spans.push(content(text, start..end));
                    start = at;
                    if record_end {
                        break;
                    }
                }
                ReadFieldResult::End => break,
            }
        }
        if self.spans.len() > width && self.spans.last().is_some_and(|cell| cell.is_empty()) {
            self.spans.pop();
        }
        &self.spans
    }
}

/// Returns the byte range of a cell without the white space and quotes around it.
fn content(text: &str, cell: Span) -> Span {
    let raw = text.get(cell.clone()).unwrap_or_default();
    let start = cell.start + raw.len() - raw.trim_start().len();
    let cell = raw.trim();
    match cell.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')) {
        Some(inner) => start + 1..start + 1 + inner.len(),
        None => start..start + cell.len(),
    }
}

/// Parses a number with a decimal point or a decimal comma.
pub(crate) fn parse_number(cell: &str) -> Option<f64> {
    match cell.split_once(',') {
        None => cell.parse().ok(),
        Some((whole, rest)) if !whole.contains('.') && !rest.contains([',', '.']) => {
            format!("{whole}.{rest}").parse().ok()
        }
        Some(_) => None,
    }
}

/// Digits with which the numbers of a column are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Digits {
    /// Largest number of significant digits.
    pub(crate) significant: i32,
    /// Largest number of digits after the decimal mark.
    pub(crate) decimals: i32,
}

/// Minimum number of significant digits of a number that counts as having full double precision.
const FULL_PRECISION: i32 = 15;

impl Digits {
    /// Updates the numbers of digits with a cell of the column.
    pub(crate) fn add(&mut self, cell: &str) {
        let (mantissa, exponent) = match cell.find(['e', 'E']) {
            Some(at) => (cell.get(..at), cell.get(at + 1..).and_then(|e| e.parse().ok())),
            None => (Some(cell), None),
        };
        let (mut significant, mut decimals, mut is_fraction) = (0, 0, false);
        for byte in mantissa.unwrap_or_default().bytes() {
            match byte {
                b'.' | b',' => is_fraction = true,
                b'0'..=b'9' => {
                    significant += i32::from(significant > 0 || byte != b'0');
                    decimals += i32::from(is_fraction);
                }
                _ => {}
            }
        }
        self.significant = self.significant.max(significant);
        self.decimals = self.decimals.max(decimals.saturating_sub(exponent.unwrap_or(0)));
    }

    /// Tests whether the numbers have full double precision.
    pub(crate) fn is_full(self) -> bool {
        self.significant >= FULL_PRECISION
    }

    /// Standard deviation of the rounding error of a number that is written with these digits.
    pub(crate) fn rounding(self, value: f64) -> f64 {
        if self.is_full() {
            return value.abs() * f64::EPSILON / 4.0;
        }
        let magnitude = value.abs().max(f64::MIN_POSITIVE).log10().floor() as i32;
        let unit = (magnitude + 1 - self.significant).max(-self.decimals);
        // Standard deviation of a uniform distribution over one unit of the last digit.
        10f64.powi(unit) / 12f64.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(text: &str) -> Vec<&str> {
        let mut cells = Cells::new(Delimiter::of(text));
        cells.split(text, 0..text.len(), 2).iter().map(|cell| &text[cell.clone()]).collect()
    }

    #[test]
    fn separators_and_quotes() {
        assert_eq!(cells("time [s], \"x [mm]\""), ["time [s]", "x [mm]"]);
        assert_eq!(cells("t;x;y"), ["t", "x", "y"]);
        assert_eq!(cells("t\tx"), ["t", "x"]);
        assert_eq!(cells("t,\tx"), ["t", "x"]);
        assert_eq!(cells("\"0,5\",\"1,5\","), ["0,5", "1,5"]);
        assert_eq!(cells("1,,3"), ["1", "", "3"]);
        assert_eq!(cells("alone"), ["alone"]);
        assert_eq!(Delimiter::declared("sep=;"), Some(Delimiter(b';')));
    }

    #[test]
    fn numbers_and_their_digits() {
        assert_eq!(parse_number("-1,5e3"), Some(-1500.0));
        assert_eq!(parse_number("1,234,567"), None);
        assert_eq!(parse_number("1,234.5"), None);
        for (cell, significant, decimals) in
            [("0.012300", 5, 6), ("-1.25e-4", 3, 6), ("1200", 4, 0), ("12,5", 3, 1)]
        {
            let mut digits = Digits::default();
            digits.add(cell);
            assert_eq!(digits, Digits { significant, decimals }, "{cell}");
        }
        let digits = Digits { significant: 4, decimals: 6 };
        // 0.5 with four digits is rounded to 1e-4, 0.0005 with six decimals to 1e-6.
        assert!((digits.rounding(0.5) - 1e-4 / 12f64.sqrt()).abs() < 1e-18);
        assert!((digits.rounding(0.0005) - 1e-6 / 12f64.sqrt()).abs() < 1e-18);
    }

    #[test]
    fn single_carriage_returns_end_lines() {
        assert_eq!(unify_line_ends("a\rb\r\nc\n\r".into()), "a\nb\r\nc\n\n");
    }
}
