//! Values that a study assigns to a key of the model: `mu = 0.05..0.3 in 6`, `crank = [200 mm, 220 mm]`.

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::quantity::{Amount, decimal};
use crate::source::{Place, Source, Span};
use std::fmt;
use std::sync::Arc;

/// Key that a study varies, with the unit of its numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    /// Path of the key or name of the parameter, as in [`Source::with_changes`].
    pub path: String,
    /// Unit of the numbers; empty for SI units.
    pub unit: String,
}

impl Key {
    /// Reads the header of a column, `tool.mass [kg]` or `mu`.
    ///
    /// # Errors
    /// Returns the reason, in one line, if the name is missing or the unit is invalid.
    pub fn of_header(header: &str) -> Result<Self, String> {
        let header = header.trim();
        let (path, unit) = match header.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
            Some((path, unit)) => (path.trim(), unit.trim()),
            None => (header, ""),
        };
        let unit = if unit == "-" { "" } else { unit };
        Amount::parse(&format!("1 {unit}"))?;
        match path {
            "" => Err("a column has no name".to_owned()),
            _ => Ok(Self { path: path.to_owned(), unit: unit.to_owned() }),
        }
    }

    /// Returns the change of the model that assigns a value to the key, in the form that
    /// [`Source::with_changes`] reads. Returns `None` for an empty text, so that the model keeps
    /// its own value.
    pub fn change(&self, setting: &Setting) -> Option<String> {
        match setting {
            Setting::Text(text) if text.is_empty() => None,
            Setting::Number(_) if !self.unit.is_empty() => {
                Some(format!("{} = {setting} {}", self.path, self.unit))
            }
            _ => Some(format!("{} = {setting}", self.path)),
        }
    }
}

impl fmt::Display for Key {
    /// Writes the header of the key's column.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.unit.as_str() {
            "" => f.write_str(&self.path),
            unit => write!(f, "{} [{unit}]", self.path),
        }
    }
}

/// A value of a varied key.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    /// A number in the key's unit.
    Number(f64),
    /// Any other value, as written: a formula, a word, a list.
    Text(String),
}

impl Setting {
    /// Reads a value from a cell of a table.
    pub fn of_cell(cell: &str) -> Self {
        let cell = cell.trim();
        match cell.parse::<f64>() {
            Ok(number) if number.is_finite() => Self::Number(number),
            _ => Self::Text(cell.to_owned()),
        }
    }
}

impl fmt::Display for Setting {
    /// Formats the value with all digits that are needed to read back the same value.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) if *number == 0.0 || (1e-5..1e16).contains(&number.abs()) => {
                write!(f, "{number}")
            }
            Self::Number(number) => write!(f, "{number:e}"),
            Self::Text(text) => f.write_str(text),
        }
    }
}

/// A varied key and its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Variation {
    /// Key that is varied.
    pub key: Key,
    /// Values that the key assumes.
    pub values: Values,
}

/// Values of a varied key.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Interval from which values are taken.
    Range {
        /// First value, in the key's unit.
        from: f64,
        /// Last value, in the key's unit.
        to: f64,
        /// Number of equidistant values; `None` for an interval to be sampled.
        count: Option<u64>,
        /// True for values in geometric progression instead of arithmetic progression.
        is_logarithmic: bool,
    },
    /// List of single values.
    List(Vec<Setting>),
}

impl Variation {
    /// Parses `KEY = FROM..TO in COUNT`, `KEY = FROM..TO in COUNT log`, `KEY = FROM..TO` for an interval to be
    /// sampled, or `KEY = [VALUE, …]`.
    ///
    /// # Errors
    /// Returns a diagnostic with the place of the mistake if the text does not parse.
    pub fn parse(text: &str) -> Result<Self, Diagnostics> {
        let source = Arc::new(Source::new("--vary", text));
        Reader { source: &source, text }.read().map_err(Diagnostics::from)
    }

    /// Number of values; `None` for an interval to be sampled.
    pub fn count(&self) -> Option<u64> {
        match &self.values {
            Values::Range { count, .. } => *count,
            Values::List(list) => Some(list.len() as u64),
        }
    }

    /// Returns value `k`, counted from 0, or the last value if `k` is too large. For an interval to
    /// be sampled, returns the first value.
    pub fn at(&self, k: u64) -> Setting {
        match &self.values {
            Values::Range { count, .. } => {
                let last = count.unwrap_or(1).saturating_sub(1);
                let k = k.min(last);
                self.within(if last == 0 { 0.0 } else { k as f64 / last as f64 })
            }
            Values::List(list) => {
                let last = list.len().saturating_sub(1) as u64;
                list.get(k.min(last) as usize).cloned().unwrap_or(Setting::Text(String::new()))
            }
        }
    }

    /// Value at a fraction, from 0 to 1, of the interval or of the list of values.
    pub fn within(&self, part: f64) -> Setting {
        match &self.values {
            Values::Range { from, to, is_logarithmic, .. } => Setting::Number(match part {
                // The ends are exact.
                _ if part <= 0.0 => *from,
                _ if part >= 1.0 => *to,
                _ if *is_logarithmic => decimal(from * (to / from).powf(part)),
                // Rounded to remove errors in the last bits, so that 0.05..0.3 in 6 contains exactly 0.15.
                _ => decimal(from * (1.0 - part) + to * part),
            }),
            Values::List(list) => self.at((part * list.len() as f64) as u64),
        }
    }
}

const FORM: &str =
    "write `mu = 0.05..0.3 in 6`, `crank = [200 mm, 220 mm]` or, to be sampled, `mu = 0.05..0.3`";

struct Reader<'a> {
    source: &'a Arc<Source>,
    text: &'a str,
}

impl Reader<'_> {
    fn fault(&self, span: Span, message: impl Into<String>, label: &str) -> Diagnostic {
        Diagnostic::error("variation", message).at(Place::new(self.source, span), label).help(FORM)
    }

    /// Range of the text without white space at its ends.
    fn trimmed(&self, span: Span) -> Span {
        let content = self.text.get(span.clone()).unwrap_or_default();
        let start = span.start + content.len() - content.trim_start().len();
        start..start + content.trim().len()
    }

    fn read(&self) -> Result<Variation, Diagnostic> {
        let whole = self.trimmed(0..self.text.len());
        let Some(equals) = self.text.find('=') else {
            return Err(self.fault(
                whole,
                "a variation needs a key and values",
                "expected KEY = VALUES",
            ));
        };
        let key = self.trimmed(0..equals);
        let values = self.trimmed(equals + 1..self.text.len());
        let path = &self.text[key.clone()];
        if path.is_empty() {
            return Err(self.fault(whole, "the key is missing", "expected KEY = VALUES"));
        }
        let content = &self.text[values.clone()];
        let (unit, values) = match content.strip_prefix('[') {
            Some(rest) if rest.ends_with(']') => self.list(values.start + 1..values.end - 1)?,
            Some(_) => return Err(self.fault(values, "this list is not closed", "expected `]`")),
            None if content.contains("..") => self.range(values)?,
            None => {
                let message = match content {
                    "" => "the values are missing",
                    _ => "this is neither a range nor a list",
                };
                return Err(self.fault(
                    values,
                    message,
                    "expected FROM..TO in COUNT, or [VALUE, …]",
                ));
            }
        };
        Ok(Variation { key: Key { path: path.to_owned(), unit }, values })
    }

    fn range(&self, span: Span) -> Result<(String, Values), Diagnostic> {
        let content = &self.text[span.clone()];
        let dots = span.start + content.find("..").unwrap_or_default();
        let first = self.trimmed(span.start..dots);
        let rest = self.trimmed(dots + 2..span.end);
        // The last ` in ` before a number is the separator, because `in` is also a unit.
        let of_count = |(at, _): (usize, &str)| {
            let words: Vec<&str> =
                self.text[rest.start + at + 4..rest.end].split_whitespace().collect();
            let is_number =
                words.first().is_some_and(|word| !word.starts_with(char::is_alphabetic));
            is_number.then_some((at, words))
        };
        let counted = self.text[rest.clone()].rmatch_indices(" in ").find_map(of_count);
        let (end, words) = match counted {
            Some((at, words)) => (rest.start + at, words),
            None => (rest.end, Vec::new()),
        };
        let last = self.trimmed(rest.start..end);
        let tail = self.trimmed(end..rest.end);
        let (count, is_logarithmic) = match words.as_slice() {
            [] => (None, false),
            [count] => (Some(*count), false),
            [count, "log"] => (Some(*count), true),
            _ => {
                return Err(self.fault(
                    tail,
                    "invalid number of values",
                    "expected `in 6` or `in 6 log`",
                ));
            }
        };
        let count = count.map(|count| count.parse::<u64>().ok().filter(|count| *count > 0));
        if count == Some(None) {
            return Err(self.fault(
                tail,
                "invalid number of values",
                "expected a whole number above 0",
            ));
        }
        let amount = |span: &Span| {
            Amount::parse(&self.text[span.clone()]).map_err(|why| {
                self.fault(
                    span.clone(),
                    format!("the ends of a range must be numbers with units: {why}"),
                    "no number",
                )
            })
        };
        let (from, to) = (amount(&first)?, amount(&last)?);
        // Zero needs no unit.
        let unit = if from.unit.is_empty() && from.number == 0.0 { &to.unit } else { &from.unit };
        let convert = |amount: &Amount, span: &Span| {
            amount.to_unit(unit).map_err(|why| {
                let fault = self.fault(
                    span.clone(),
                    why,
                    "either both ends have a unit, or \
                    neither has one",
                );
                let named = [&from, &to].into_iter().find(|amount| !amount.unit.is_empty());
                match named.filter(|_| from.unit.is_empty() || to.unit.is_empty()) {
                    Some(Amount { unit, .. }) => {
                        fault.help(format!("write {} {unit}..{} {unit}", from.number, to.number))
                    }
                    None => fault,
                }
            })
        };
        let (from, to) = (convert(&from, &first)?, convert(&to, &last)?);
        if is_logarithmic && (from * to).partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return Err(self.fault(
                span,
                "a logarithmic range cannot contain zero",
                "contains zero",
            ));
        }
        let count = count.flatten();
        Ok((unit.clone(), Values::Range { from, to, count, is_logarithmic }))
    }

    fn list(&self, span: Span) -> Result<(String, Values), Diagnostic> {
        let mut items: Vec<Span> = Vec::new();
        let (mut start, mut depth, mut quote) = (span.start, 0_i32, None);
        for (at, c) in self.text[span.clone()].char_indices() {
            let at = span.start + at;
            match (quote, c) {
                (Some(open), c) if open == c => quote = None,
                (None, '"' | '\'') => quote = Some(c),
                (None, '[' | '{' | '(') => depth += 1,
                (None, ']' | '}' | ')') => depth -= 1,
                (None, ',') if depth == 0 => {
                    items.push(self.trimmed(start..at));
                    start = at + 1;
                }
                _ => {}
            }
        }
        items.push(self.trimmed(start..span.end));
        if items.last().is_some_and(Span::is_empty) {
            items.pop();
        }
        if items.is_empty() {
            return Err(self.fault(span, "this list has no values", "empty"));
        }
        if let Some(empty) = items.iter().find(|item| item.is_empty()) {
            return Err(self.fault(empty.clone(), "a value is missing", "nothing between commas"));
        }
        let amounts: Option<Vec<(Amount, &Span)>> = items
            .iter()
            .map(|item| Some((Amount::parse(unquoted(&self.text[item.clone()])).ok()?, item)))
            .collect();
        let Some(amounts) = amounts else {
            let text = |item: &Span| Setting::Text(self.text[item.clone()].to_owned());
            return Ok((String::new(), Values::List(items.iter().map(text).collect())));
        };
        let named = amounts.iter().find(|(amount, _)| !amount.unit.is_empty());
        let unit = named.map_or("", |(amount, _)| amount.unit.as_str());
        let number = |(amount, span): &(Amount, &Span)| {
            let number = amount.to_unit(unit);
            let number = number
                .map_err(|why| self.fault((*span).clone(), why, "all values need the same unit"));
            number.map(Setting::Number)
        };
        let list = amounts.iter().map(number).collect::<Result<_, _>>()?;
        Ok((unit.to_owned(), Values::List(list)))
    }
}

/// Removes the quotes around a text, if there are any.
fn unquoted(text: &str) -> &str {
    let quote = text.chars().next().filter(|c| matches!(c, '"' | '\''));
    quote.and_then(|quote| text.strip_prefix(quote)?.strip_suffix(quote)).unwrap_or(text)
}
