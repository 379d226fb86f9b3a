//! Reads measured logs: CSV files with the coordinates and efforts of a robot.
//!
//! Unlike a prescribed motion, a log may contain bad rows, which are reported and omitted.

mod clock;
mod columns;
mod layout;
mod preamble;

use super::actuators::Actuators;
use super::context::LARGEST;
use super::names::Names;
use crate::contents::Contents;
use crate::diagnostic::{Diagnostic, Diagnostics, number, quoted};
use crate::model_file::ModelFile;
use crate::signal::recorded::lines::{Cells, Delimiter, lines, parse_number, unify_line_ends};
use crate::source::{Place, Source, Span};
use preamble::Head;
use std::sync::Arc;
use stiction_core::kinematics::Coordinate;

/// Meaning of a column of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LogRole {
    /// Time of the row.
    Time,
    /// Position of a coordinate.
    Coordinate(Coordinate),
    /// Rate of a coordinate, for logs that do not contain its position.
    Rate(Coordinate),
    /// Commanded position of a coordinate.
    Reference(Coordinate),
    /// Effort of an actuated degree of freedom at its joint, by index of the actuator.
    Effort(usize),
    /// Torque of a drive train's motor, by index of the drive train.
    MotorTorque(usize),
    /// Current of a drive train's motor, by index of the drive train.
    Current(usize),
    /// The column is not used, for example because it is an acceleration or is declared as unused.
    Unused,
}

/// Column of a log.
#[derive(Clone, Debug)]
pub struct LogColumn {
    /// Name as written in the log, without the unit.
    pub name: String,
    /// Meaning of the column.
    pub role: LogRole,
    /// Values of the column in SI units, one for each time; empty if the column is not used.
    pub values: Vec<f64>,
}

/// Rows of a log that were omitted because they are invalid.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// The first omitted rows, each with its line number in the file and the reason.
    pub named: Vec<(usize, String)>,
    /// Total number of omitted rows.
    pub count: usize,
}

/// Measured log: times, and the columns of measured values.
#[derive(Clone, Debug)]
pub struct Log {
    /// Times, s, strictly increasing; for a table of steady motions, row numbers from 0.
    pub times: Vec<f64>,
    /// Line number in the file for each time.
    pub lines: Vec<usize>,
    /// All columns except the time.
    pub columns: Vec<LogColumn>,
    /// Rows that were omitted because they are invalid.
    pub bad_rows: Rows,
    /// True for a table of steady motions: each row is a motion of constant rate, not an instant.
    pub is_steady: bool,
}

/// Information about a log that its text does not contain.
#[derive(Clone, Debug, Default)]
pub struct LogFormat<'a> {
    /// Meanings of columns whose headers do not state them.
    pub renamed: &'a [Renamed],
    /// True for a table of steady motions, which needs no time column.
    pub is_steady: bool,
    /// Names of the columns of a log without a header; empty if it has one.
    pub header: &'a [String],
    /// Time from one row to the next, s, for a log without a time column.
    pub step: Option<f64>,
}

/// Meaning of a log column whose header does not state it.
#[derive(Clone, Debug, PartialEq)]
pub struct Renamed {
    /// Header of the column in the log.
    pub column: String,
    /// Header that states the meaning of the column, such as `axis1 [deg]` or `A1.current [A]`;
    /// empty for a column that is not used.
    pub meaning: String,
    /// Factor by which the values are multiplied before the conversion from the unit in `meaning`.
    pub factor: f64,
    /// Number added after the multiplication by `factor`, in the unit of `meaning`.
    pub offset: f64,
}

/// Maximum number of bad rows that are reported individually.
const NAMED: usize = 20;
/// Largest ratio of a time step to the previous time step at which the step counts as regular.
const JUMP: f64 = 3.0;

impl Rows {
    fn add(&mut self, line: usize, reason: String) {
        self.count += 1;
        if self.named.len() < NAMED {
            self.named.push((line, reason));
        }
    }
}

impl Log {
    /// Tests if the time of the last accepted row is wrong, rather than the time `now`, s, of the
    /// current row: without the last accepted row, `now` would follow after a regular step.
    fn has_jumped_before(&self, now: f64) -> bool {
        let [.., first, before, last] = self.times[..] else { return false };
        last > now && now > before && now - before <= JUMP * (before - first)
    }
}
/// Number of rows from which the meaning of a column without a name is determined.
const SURVEYED: usize = 20;
/// Minimum number of valid rows: first of a log over time, then of a table of steady motions.
const LEAST: [usize; 2] = [20, 4];

impl ModelFile {
    /// Reads a log. Rows with a cell that is not a number, or with a time that does not increase,
    /// are reported and omitted.
    ///
    /// # Errors
    /// Columns that are missing or not understood, or too few good rows, each with its place.
    pub fn read_log(
        &self,
        name: &str,
        contents: Contents,
        format: LogFormat<'_>,
    ) -> Result<Log, Diagnostics> {
        let text = match contents {
            Contents::Whole(text) => text,
            Contents::Stored(store) => stored_text(&*store).map_err(|reason| {
                Diagnostics::from(Diagnostic::error(
                    "file",
                    format!("cannot read {name}: {reason}"),
                ))
            })?,
        };
        let source = Arc::new(Source::new(name, layout::with_separators(unify_line_ends(text))));
        // Errors in names from an option are shown in the option's text.
        let names = format.header.join(",");
        let header = match names.is_empty() {
            true => Arc::clone(&source),
            false => Arc::new(Source::new("header", names)),
        };
        let reader = Reader {
            header: &header,
            names: Names::of(&self.mechanism),
            actuators: Actuators::of(&self.mechanism),
            trains: self.mechanism.drive_trains().iter().map(|train| train.name.clone()).collect(),
            format,
            source: &source,
        };
        reader.read()
    }
}

fn stored_text(store: &dyn crate::contents::Store) -> Result<String, String> {
    let mut bytes = Vec::new();
    let mut piece = vec![0; 1 << 20];
    loop {
        match store.read_at(bytes.len() as u64, &mut piece)? {
            0 => break,
            count => bytes.extend_from_slice(&piece[..count]),
        }
    }
    String::from_utf8(bytes).map_err(|_| "it is not UTF-8 text".to_owned())
}

struct Reader<'a> {
    names: Names,
    actuators: Actuators,
    trains: Vec<String>,
    format: LogFormat<'a>,
    source: &'a Arc<Source>,
    /// Text that contains the names of the columns: the log, or the names given by an option.
    header: &'a Arc<Source>,
}

/// Meaning of a column, with the conversion of its numbers to SI units.
struct Meaning {
    name: String,
    role: LogRole,
    /// Factor that converts the numbers to SI units; `offset` is added to a number before the
    /// multiplication.
    factor: f64,
    offset: f64,
}

impl Reader<'_> {
    /// Returns the place for a range of the text that contains the names of the columns.
    fn place(&self, span: Span) -> Place {
        Place::new(self.header, span)
    }

    fn read(&self) -> Result<Log, Diagnostics> {
        let text = self.source.text.as_str();
        let searched: Vec<Span> = lines(self.source).take(preamble::SEARCHED).collect();
        let is_known = |name: &str| {
            let bare = name.split_once('[').map_or(name, |(label, _)| label.trim_end());
            let is_renamed = |r: &Renamed| r.column == name || r.column == bare;
            ["time", "t"].contains(&bare) || self.format.renamed.iter().any(is_renamed)
        };
        let found = match self.format.header.is_empty() {
            true => preamble::find(text, &searched, is_known),
            false => preamble::none(text, &searched, self.format.header.len()),
        };
        let Some(head) = found else {
            return Err(Diagnostic::error("samples", format!("{} is empty", self.source.name))
                .help("a log begins with a header such as `time [s],leg1.P [m],leg1.P.effort [N]`")
                .into());
        };
        let mut out = Diagnostics::new();
        let mut cells = Cells::new(head.delimiter);
        let units: Vec<Span> = head
            .units
            .clone()
            .map_or(Vec::new(), |units| cells.split(text, units, usize::MAX).to_vec());
        let spans: Vec<Span> = match self.format.header.is_empty() {
            true => cells.split(text, head.names.clone(), usize::MAX).to_vec(),
            false => {
                let names = self.header.text.as_str();
                Cells::new(Delimiter::COMMA).split(names, 0..names.len(), usize::MAX).to_vec()
            }
        };
        let is_number = |span: &Span| parse_number(&self.header.text[span.clone()]).is_some();
        let is_named = |span: &Span| {
            let name = self.header.text[span.clone()].trim();
            self.format.renamed.iter().any(|renamed| renamed.column == name)
        };
        if !spans.is_empty() && spans.iter().all(is_number) && !spans.iter().any(is_named) {
            let message = format!("{} has no column names", self.source.name);
            let label = "expected a header such as `time [s],leg1.P [m],leg1.P.effort [N]`";
            return Err(Diagnostic::error("samples", message)
                .at(self.place(head.names), label)
                .help("give the names of the columns in the options, for example `header = [\"time [s]\", \"leg1.P [m]\"]`")
                .into());
        }
        let mut meanings: Vec<Meaning> = Vec::new();
        for (index, span) in spans.iter().enumerate() {
            let below = units.get(index).map(|unit| &text[unit.clone()]);
            let meaning = self.meaning(span.clone(), below, &mut out);
            let again = meanings
                .iter()
                .find(|known| known.role == meaning.role && meaning.role != LogRole::Unused);
            if let Some(known) = again {
                let message = format!(
                    "{} and {} are the same quantity",
                    quoted(&known.name),
                    quoted(&meaning.name)
                );
                // An option applies to all columns of a name.
                let help = match known.name == meaning.name {
                    true => "delete or rename one of these columns in the file",
                    false => {
                        "declare one of them as unused in the options: `NAME = \"\"` under [columns]"
                    }
                };
                out.push(
                    Diagnostic::error("duplicate", message)
                        .at(self.place(span.clone()), "again here")
                        .help(help),
                );
            }
            meanings.push(meaning);
        }
        if self.format.step.is_some() {
            let times = meanings.iter_mut().filter(|m| m.role == LogRole::Time);
            times.for_each(|meaning| meaning.role = LogRole::Unused);
        }
        let time = meanings.iter().position(|m| m.role == LogRole::Time);
        let time = time.or_else(|| self.unnamed_time(&mut meanings, &head));
        if time.is_none() && !self.format.is_steady && self.format.step.is_none() {
            out.push(
                Diagnostic::error("missing-key", "the column `time` is missing")
                    .at(self.place(head.names.clone()), "the columns")
                    .help(
                        "name the time column `time [s]`; if there is none, set the time between rows in the \
                         options, such as `step = \"1 ms\"`; for a table of steady motions, write `steady = true` \
                         under [[logs]] in the options",
                    ),
            );
        }
        if out.has_errors() {
            return Err(out);
        }
        let rows = lines(self.source).skip(head.lines).map(|line| head.content(text, &line));
        self.rows(rows, &mut cells, &meanings, time)
    }

    /// Lets the first column be the time, in s, if it has no name and does not number the rows;
    /// programs write the index of a table in this way. Returns the index of the column; `None` if
    /// the time is not needed or the column is not the time.
    fn unnamed_time(&self, meanings: &mut [Meaning], head: &Head) -> Option<usize> {
        let is_needed = !self.format.is_steady && self.format.step.is_none();
        let is_renamed = || self.format.renamed.iter().any(|renamed| renamed.column.is_empty());
        let first = meanings.first_mut().filter(|first| first.name.is_empty())?;
        if !is_needed || is_renamed() {
            return None;
        }
        let text = self.source.text.as_str();
        let mut cells = Cells::new(head.delimiter);
        let all = lines(self.source).skip(head.lines).take(SURVEYED);
        let values = all.map(|line| {
            let row = cells.split(text, head.content(text, &line), usize::MAX);
            row.first().and_then(|cell| parse_number(&text[cell.clone()]))
        });
        let values: Vec<f64> = values.collect::<Option<_>>()?;
        let is_time = values.windows(2).any(|pair| pair[1] - pair[0] != 1.0);
        is_time.then(|| {
            first.role = LogRole::Time;
            0
        })
    }

    fn rows(
        &self,
        all: impl Iterator<Item = Span>,
        cells: &mut Cells,
        meanings: &[Meaning],
        time: Option<usize>,
    ) -> Result<Log, Diagnostics> {
        let text = self.source.text.as_str();
        let mut log = Log {
            times: Vec::new(),
            lines: Vec::new(),
            columns: Vec::new(),
            bad_rows: Rows::default(),
            is_steady: self.format.is_steady,
        };
        let mut columns: Vec<LogColumn> = meanings
            .iter()
            .map(|m| LogColumn { name: m.name.clone(), role: m.role, values: Vec::new() })
            .collect();
        let (mut line, mut counted, mut index) = (1, 0, 0);
        let (mut has_ambiguous_times, mut has_repeated_times) = (false, false);
        let mut row = vec![0.0; meanings.len()];
        let mut midnights = clock::Midnights::default();
        for span in all {
            line += text[counted..span.start].bytes().filter(|byte| *byte == b'\n').count();
            counted = span.start;
            let split = cells.split(text, span, meanings.len());
            let mut fault = (split.len() != meanings.len()).then(|| {
                format!(
                    "the row has {} cells, but the log has {} columns",
                    split.len(),
                    meanings.len()
                )
            });
            for ((value, cell), meaning) in row.iter_mut().zip(split).zip(meanings) {
                let content = &text[cell.clone()];
                if meaning.role == LogRole::Unused {
                    continue;
                }
                let read = match meaning.role {
                    // Times of day are in seconds, whatever the unit of the column.
                    LogRole::Time => parse_number(content).or_else(|| {
                        let seconds = midnights.count(content, clock::seconds(content)?);
                        Some(seconds / meaning.factor - meaning.offset)
                    }),
                    _ => parse_number(content),
                };
                match read.filter(|x| x.is_finite()) {
                    // Denormal numbers come from faulty conversions. They are accepted, and are
                    // practically zero.
                    Some(x) => {
                        *value = meaning.factor * (x + meaning.offset);
                        // Squares of larger numbers in the regression would overflow.
                        if meaning.role != LogRole::Time && value.abs() > LARGEST {
                            fault.get_or_insert_with(|| {
                                format!(
                                    "`{}` is {}, but the maximum magnitude in SI units is {LARGEST:e}",
                                    meaning.name,
                                    number(x)
                                )
                            });
                        }
                    }
                    None => {
                        fault.get_or_insert_with(|| {
                            let shown: String = content.chars().take(30).collect();
                            let is_time = meaning.role == LogRole::Time;
                            match shown.is_empty() {
                                true => format!("`{}` is empty", meaning.name),
                                false if is_time && clock::is_ambiguous(content) => {
                                    has_ambiguous_times = true;
                                    format!(
                                        "`{}` is {}, which can mean hours and minutes or minutes and seconds",
                                        meaning.name,
                                        quoted(&shown)
                                    )
                                }
                                false => format!(
                                    "`{}` is {}, not a number",
                                    meaning.name,
                                    quoted(&shown)
                                ),
                            }
                        });
                    }
                }
            }
            let last = log.times.last().copied();
            let now = match (time, self.format.step) {
                (Some(time), _) => row[time],
                (None, Some(step)) => step * f64::from(index),
                (None, None) => log.times.len() as f64,
            };
            index += 1;
            if fault.is_none() && log.has_jumped_before(now) {
                let jump = format!(
                    "the time {} s is not earlier than the time of the next row, {now} s",
                    log.times[log.times.len() - 1]
                );
                log.times.pop();
                log.bad_rows.add(log.lines.pop().unwrap_or(line), jump);
                for column in &mut columns {
                    column.values.pop();
                }
            } else if fault.is_none()
                && let Some(last) = last
                && now <= last
            {
                has_repeated_times = true;
                fault = Some(format!(
                    "the time {now} s is not later than the time of the previous row, {last} s"
                ));
            }
            match fault {
                Some(reason) => log.bad_rows.add(line, reason),
                None => {
                    log.times.push(now);
                    log.lines.push(line);
                    for (column, value) in columns.iter_mut().zip(&row) {
                        if column.role != LogRole::Unused && column.role != LogRole::Time {
                            column.values.push(*value);
                        }
                    }
                }
            }
        }
        let good = log.times.len();
        let bad = log.bad_rows.count;
        let least = LEAST[usize::from(self.format.is_steady)];
        if good < least || bad * 5 > good {
            let first = log.bad_rows.named.first();
            let first = first.map_or(String::new(), |(line, why)| format!("; line {line}: {why}"));
            let message =
                format!("{} has {good} good rows and {bad} bad ones{first}", self.source.name);
            let mut help = format!(
                "a log needs at least {least} good rows, and at most one bad row for every five good rows"
            );
            if has_ambiguous_times {
                help += "; write times of day as hh:mm:ss and minutes with seconds as 05:12.0, or set the time \
                         between rows in the options, such as `step = \"1 s\"`";
            }
            if has_repeated_times {
                help += "; if time stamps repeat, set the time between rows in the options, such as \
                         `step = \"1 ms\"`; if the time starts again, split the log there";
            }
            return Err(Diagnostic::error("samples", message).help(help).into());
        }
        columns.retain(|column| column.role != LogRole::Time);
        log.columns = columns;
        Ok(log)
    }
}

#[cfg(test)]
mod tests;
