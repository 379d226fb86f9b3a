//! Reader of measured logs: CSV files with the coordinates and efforts of a robot.
//!
//! Unlike a prescribed motion, a log may have bad rows: they are named and left out.

use super::actuators::Actuators;
use super::names::Names;
use super::path::{Orders, coordinate, resolve};
use crate::contents::Contents;
use crate::diagnostic::{Diagnostic, Diagnostics, did_you_mean, quoted};
use crate::expression::{Dimension, Measure, unit_of};
use crate::model_file::ModelFile;
use crate::signal::recorded::lines::{Cells, Delimiter, lines, parse_number, unify_line_ends};
use crate::source::{Place, Source, Span};
use std::sync::Arc;
use stiction_core::kinematics::Coordinate;

/// Meaning of a column of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LogRole {
    /// Time.
    Time,
    /// Position of a coordinate.
    Coordinate(Coordinate),
    /// Effort of an actuated degree of freedom at its joint, by index of the actuator.
    Effort(usize),
    /// Torque of the motor of a drive train, by index.
    MotorTorque(usize),
    /// Current of the motor of a drive train, by index.
    Current(usize),
    /// Not used: a rate, a commanded value, or a column that is declared as unused.
    Unused,
}

/// Column of a log.
#[derive(Clone, Debug)]
pub struct LogColumn {
    /// Name as written in the log, without the unit.
    pub name: String,
    /// Meaning.
    pub role: LogRole,
    /// Values, SI units.
    pub values: Vec<f64>,
}

/// Rows of a log that were left out.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// The first of them: line and reason.
    pub named: Vec<(usize, String)>,
    /// Number of all of them.
    pub count: usize,
}

/// A measured log.
#[derive(Clone, Debug)]
pub struct Log {
    /// Times, s, increasing.
    pub times: Vec<f64>,
    /// Line of the file of each time.
    pub lines: Vec<usize>,
    /// All columns but the time.
    pub columns: Vec<LogColumn>,
    /// Rows left out.
    pub bad_rows: Rows,
}

/// Meaning of a column of a log whose header does not say it.
#[derive(Clone, Debug, PartialEq)]
pub struct Renamed {
    /// Header of the column in the log.
    pub column: String,
    /// Header that states its meaning, such as `axis1 [deg]` or `A1.current [A]`; empty for a column that
    /// is not used.
    pub meaning: String,
    /// Factor of its values, before the unit.
    pub factor: f64,
    /// Number added after the factor, in the unit.
    pub offset: f64,
}

/// Bad rows that are named.
const NAMED: usize = 20;

impl ModelFile {
    /// Reads a log. Cells that are no numbers and times that do not increase make a row bad: it is named
    /// and left out.
    ///
    /// # Errors
    /// Columns that are missing or not understood, or too few good rows, each with its place.
    pub fn read_log(
        &self,
        name: &str,
        contents: Contents,
        renamed: &[Renamed],
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
        let source = Arc::new(Source::new(name, unify_line_ends(text)));
        let reader = Reader {
            names: Names::of(&self.mechanism),
            actuators: Actuators::of(&self.mechanism),
            trains: self.mechanism.drive_trains().iter().map(|train| train.name.clone()).collect(),
            renamed,
            source: &source,
        };
        reader.read()
    }
}

/// True for columns of the tables of `stiction inverse` that no log measures.
fn is_result(label: &str) -> bool {
    let ends =
        [".speed", ".power", ".drive_frictionless", ".drive_low", ".drive_high", ".motor_speed"];
    ends.iter().any(|end| label.ends_with(end))
        || ["closure", "power.residual"].contains(&label)
        || label.starts_with("distance.")
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
    renamed: &'a [Renamed],
    source: &'a Arc<Source>,
}

/// Meaning of a column with the conversion of its numbers.
struct Meaning {
    name: String,
    role: LogRole,
    /// Whole factor to SI units, and the number added before it.
    factor: f64,
    offset: f64,
}

impl Reader<'_> {
    fn place(&self, span: Span) -> Place {
        Place::new(self.source, span)
    }

    fn read(&self) -> Result<Log, Diagnostics> {
        let text = self.source.text.as_str();
        let mut all = lines(self.source);
        let Some(mut header) = all.next() else {
            return Err(Diagnostic::error("samples", format!("{} is empty", self.source.name))
                .help("a log begins with a header such as `time [s],leg1.P [m],leg1.P.effort [N]`")
                .into());
        };
        let mut delimiter = Delimiter::declared(&text[header.clone()]);
        if delimiter.is_some() {
            header = all.next().unwrap_or(header);
        }
        let delimiter = *delimiter.get_or_insert_with(|| Delimiter::of(&text[header.clone()]));
        let mut out = Diagnostics::new();
        let mut cells = Cells::new(delimiter);
        let spans: Vec<Span> = cells.split(text, header.clone(), usize::MAX).to_vec();
        let mut meanings: Vec<Meaning> = Vec::new();
        for span in &spans {
            let meaning = self.meaning(span.clone(), &mut out);
            let again = meanings
                .iter()
                .find(|known| known.role == meaning.role && meaning.role != LogRole::Unused);
            if let Some(known) = again {
                let message = format!(
                    "{} and {} are the same quantity",
                    quoted(&known.name),
                    quoted(&meaning.name)
                );
                out.push(
                    Diagnostic::error("duplicate", message)
                        .at(self.place(span.clone()), "again here")
                        .help("declare one of them as unused in the options: `NAME = \"\"` below [columns]"),
                );
            }
            meanings.push(meaning);
        }
        let time = meanings.iter().position(|m| m.role == LogRole::Time);
        if time.is_none() {
            out.push(
                Diagnostic::error("missing-key", "the column `time` is missing")
                    .at(self.place(header), "the columns")
                    .help("name the time column `time [s]`"),
            );
        }
        let (Some(time), false) = (time, out.has_errors()) else { return Err(out) };
        self.rows(all, &mut cells, &meanings, time)
    }

    fn rows(
        &self,
        all: impl Iterator<Item = Span>,
        cells: &mut Cells,
        meanings: &[Meaning],
        time: usize,
    ) -> Result<Log, Diagnostics> {
        let text = self.source.text.as_str();
        let mut log = Log {
            times: Vec::new(),
            lines: Vec::new(),
            columns: Vec::new(),
            bad_rows: Rows::default(),
        };
        let mut columns: Vec<LogColumn> = meanings
            .iter()
            .map(|m| LogColumn { name: m.name.clone(), role: m.role, values: Vec::new() })
            .collect();
        let (mut line, mut counted) = (1, 0);
        let mut row = vec![0.0; meanings.len()];
        for span in all {
            line += text[counted..span.start].bytes().filter(|byte| *byte == b'\n').count();
            counted = span.start;
            let split = cells.split(text, span, meanings.len());
            let mut fault = (split.len() != meanings.len())
                .then(|| format!("{} cells instead of {}", split.len(), meanings.len()));
            for ((value, cell), meaning) in row.iter_mut().zip(split).zip(meanings) {
                let content = &text[cell.clone()];
                if meaning.role == LogRole::Unused {
                    continue;
                }
                match parse_number(content).filter(|x| x.is_finite()) {
                    // Denormal numbers are zeros of a damaged conversion.
                    Some(x) => *value = meaning.factor * (x + meaning.offset),
                    None => {
                        fault.get_or_insert_with(|| {
                            let shown: String = content.chars().take(30).collect();
                            match shown.is_empty() {
                                true => format!("`{}` is empty", meaning.name),
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
            if fault.is_none()
                && let Some(last) = last
                && row[time] <= last
            {
                fault = Some(format!("the time {} s does not follow {last} s", row[time]));
            }
            match fault {
                Some(reason) => {
                    log.bad_rows.count += 1;
                    if log.bad_rows.named.len() < NAMED {
                        log.bad_rows.named.push((line, reason));
                    }
                }
                None => {
                    log.times.push(row[time]);
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
        if good < 20 || bad * 5 > good {
            let first = log.bad_rows.named.first();
            let first = first.map_or(String::new(), |(line, why)| format!("; line {line}: {why}"));
            let message =
                format!("{} has {good} good rows and {bad} bad ones{first}", self.source.name);
            return Err(Diagnostic::error("samples", message)
                .help(
                    "a log needs at least 20 good rows, and at most one bad row in five good ones",
                )
                .into());
        }
        columns.retain(|column| column.role != LogRole::Time);
        log.columns = columns;
        Ok(log)
    }

    fn meaning(&self, span: Span, out: &mut Diagnostics) -> Meaning {
        let written = self.source.text.get(span.clone()).unwrap_or_default();
        let bare = written.split_once('[').map_or(written, |(label, _)| label.trim_end());
        let renamed = self.renamed.iter().find(|r| r.column == written || r.column == bare);
        let header = renamed.map_or(written, |renamed| renamed.meaning.as_str());
        let (label, unit) = match header.split_once('[') {
            Some((label, unit)) => (label.trim_end(), Some(unit.trim_end().trim_end_matches(']'))),
            None => (header, None),
        };
        let mut meaning =
            Meaning { name: bare.to_owned(), role: LogRole::Unused, factor: 1.0, offset: 0.0 };
        let is_rate = label.starts_with("d(") || label.starts_with("dd(");
        if label.is_empty() || is_rate || is_result(label) {
            return meaning;
        }
        let label = label.strip_suffix(".position").unwrap_or(label);
        let Some((role, measure)) = self.role(label, &span, out) else { return meaning };
        meaning.role = role;
        let expected = match measure {
            Some(measure) => measure.dimension(),
            None => Dimension::NONE.with_current(1),
        };
        if let Some(unit) = unit {
            match unit_of(unit) {
                Ok((scale, found)) if expected.same(found) => meaning.factor = scale.apply(1.0),
                Ok((_, found)) => {
                    let message =
                        format!("the unit of {} is that of {}", quoted(label), found.describe());
                    let label = format!("expected {}", expected.describe());
                    out.push(Diagnostic::error("dimension", message).at(self.place(span), label));
                }
                Err(fault) => {
                    let message = format!(
                        "the unit of {} is not understood: {}",
                        quoted(label),
                        fault.message
                    );
                    out.push(
                        Diagnostic::error(fault.code, message).at(self.place(span), fault.label),
                    );
                }
            }
        }
        if let Some(renamed) = renamed {
            let safe = if renamed.factor == 0.0 { 1.0 } else { renamed.factor };
            meaning.factor *= safe;
            meaning.offset = renamed.offset / safe;
        }
        meaning
    }

    fn role(
        &self,
        label: &str,
        span: &Span,
        out: &mut Diagnostics,
    ) -> Option<(LogRole, Option<Measure>)> {
        if label == "time" || label == "t" {
            return Some((LogRole::Time, Some(Measure::Time)));
        }
        for suffix in [".effort", ".drive"] {
            let Some(name) = label.strip_suffix(suffix) else { continue };
            if let Some(index) = self.actuators.find(name) {
                let measure = self.actuators.measure(index, Measure::Force, Measure::Moment);
                return Some((LogRole::Effort(index), Some(measure)));
            }
            let (message, help) = self.actuators.unknown(name);
            let unknown = Diagnostic::error("unknown-name", message).maybe_help(help);
            out.push(unknown.at(self.place(span.clone()), "unknown actuator"));
            return None;
        }
        for suffix in [".motor_torque", ".current"] {
            let Some(name) = label.strip_suffix(suffix) else { continue };
            if let Some(index) = self.trains.iter().position(|train| train == name) {
                return Some(match suffix {
                    ".current" => (LogRole::Current(index), None),
                    _ => (LogRole::MotorTorque(index), Some(Measure::Moment)),
                });
            }
            let message = format!("there is no drive train {}", quoted(name));
            let help = did_you_mean(name, "drive trains", self.trains.iter().map(String::as_str))
                .unwrap_or_else(|| {
                    "the model has no drive trains: add [actuators.NAME], or give efforts as `JOINT.effort`"
                        .to_owned()
                });
            out.push(
                Diagnostic::error("unknown-name", message)
                    .at(self.place(span.clone()), "unknown motor")
                    .help(help),
            );
            return None;
        }
        match resolve(&self.names, label).and_then(|meaning| coordinate(meaning, &Orders::new())) {
            Ok((coordinate, measure)) => Some((LogRole::Coordinate(coordinate), Some(measure))),
            Err(unresolved) => {
                if let Some((message, help, _)) = unresolved.explain(&self.names, &[], label) {
                    let more = "for a column that is not used write `NAME = \"\"` below [columns] of the options";
                    let help =
                        help.map_or_else(|| more.to_owned(), |help| format!("{help}; {more}"));
                    out.push(
                        Diagnostic::error("unknown-name", message)
                            .at(self.place(span.clone()), "unknown column")
                            .help(help),
                    );
                }
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{gallery, read};

    fn model() -> ModelFile {
        let text = gallery::get("five-bar").unwrap();
        read(&Source::new("five-bar.toml", text), &|_| Err("no files".into())).unwrap()
    }

    fn log(header: &str, rows: &[&str], renamed: &[Renamed]) -> Result<Log, Diagnostics> {
        let mut text = format!("{header}\n");
        for k in 0..30 {
            text += &format!("{},1,{k},3\n", 0.01 * f64::from(k));
        }
        for row in rows {
            text += row;
            text.push('\n');
        }
        model().read_log("log.csv", Contents::Whole(text), renamed)
    }

    #[test]
    fn units_and_renamed_columns() {
        let renamed = [
            Renamed {
                column: "q2".into(),
                meaning: "right_motor [deg]".into(),
                factor: -2.0,
                offset: 90.0,
            },
            Renamed { column: "spare".into(), meaning: String::new(), factor: 1.0, offset: 0.0 },
        ];
        let found = log("time [ms],left_motor.effort [mN m],q2,spare", &[], &renamed).unwrap();
        assert!((found.times[2] - 2e-5).abs() < 1e-18);
        assert_eq!(found.columns[0].role, LogRole::Effort(0));
        assert!((found.columns[0].values[0] - 1e-3).abs() < 1e-18);
        // 90 - 2 * 5 degrees.
        assert!((found.columns[1].values[5] - 80f64.to_radians()).abs() < 1e-15);
        assert_eq!(found.columns[2].role, LogRole::Unused);
    }

    #[test]
    fn bad_rows_have_a_line_and_a_reason() {
        let header = "time [s],left_motor.effort,left_motor,right_motor";
        let rows = ["0.3,,was -8.9,1", "0.31,1,1e999,2", "0.32,1", "0.1,1,1,1", "0.33,1,5.3e-43,1"];
        let found = log(header, &rows, &[]).unwrap();
        assert_eq!((found.times.len(), found.bad_rows.count), (31, 4));
        let lines: Vec<usize> = found.bad_rows.named.iter().map(|(line, _)| *line).collect();
        assert_eq!(lines, [32, 33, 34, 35]);
        assert!(found.bad_rows.named[0].1.contains("is empty"));
        assert!(found.bad_rows.named[3].1.contains("does not follow"));
        assert!(log(header, &["x,1,1,1"; 40], &[]).is_err());
    }
}
