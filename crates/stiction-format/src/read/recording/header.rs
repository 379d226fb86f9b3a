//! Reader of the header line of a recording, which determines the meaning and the unit of each
//! column.

use super::super::actuators::Actuators;
use super::super::names::Names;
use super::super::path::{Meaning, Orders, coordinate, resolve};
use super::super::time_column::time_hint;
use super::messages::Messages;
use crate::diagnostic::quoted;
use crate::expression::Measure;
use crate::expression::unit::Scale;
use crate::expression::{Dimension, unit_of};
use crate::signal::recorded::lines::{Cells, Delimiter, Digits, Line};
use crate::source::Span;
use stiction_core::kinematics::Coordinate;

/// Help text of the message about two columns with the same meaning.
const TWICE: &str = "remove one of the columns, or rename it if it has another meaning";

/// Meaning of a column of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Role {
    Time,
    /// Coordinate (`order` 0), or its first or second time derivative (`order` 1 or 2).
    Coordinate {
        coordinate: Coordinate,
        order: u8,
    },
    /// Effort (force or torque) of the actuator with this index.
    Effort(usize),
    /// Column that is not used, or an invalid column, which has been reported.
    Unknown,
}

/// Column of a recording.
pub(super) struct Column {
    pub(super) role: Role,
    pub(super) scale: Scale,
    /// True if the values of the column are angles; false for their derivatives and for all other
    /// quantities.
    pub(super) is_angle: bool,
    /// Name in the header cell, without the unit, `d()` or `dd()`, and the suffix `.drive`.
    pub(super) name: String,
    pub(super) span: Span,
    /// Number of digits with which the values are written.
    pub(super) digits: Digits,
}

/// Header of a recording: all columns, their separator, and the index of the time column.
pub(super) struct Header {
    /// Separator between columns.
    pub(super) delimiter: Delimiter,
    pub(super) columns: Vec<Column>,
    /// Index of the time column; `None` if it is missing.
    pub(super) time: Option<usize>,
}

impl Header {
    /// Reads the header of a recorded motion.
    pub(super) fn read(
        text: &str,
        line: Line,
        delimiter: Delimiter,
        names: &Names,
        orders: &Orders,
        messages: &mut Messages,
    ) -> Self {
        if let Some(message) = separated_by_blanks(text, &line, delimiter) {
            let help = "separate columns by commas, semicolons or tabs".to_owned();
            messages.push_help("syntax", message, line, "blanks between columns", Some(help));
            return Self { delimiter, columns: Vec::new(), time: None };
        }
        let mut columns: Vec<Column> = Vec::new();
        for cell in header_cells(text, &line, delimiter) {
            let column = read_column(text, cell, names, orders, messages);
            let again = columns
                .iter()
                .any(|known| known.role == column.role && column.role != Role::Unknown);
            if again {
                let message = format!("the column {} occurs twice", quoted(&column.name));
                let help = Some(TWICE.to_owned());
                messages.push_help("duplicate", message, column.span.clone(), "again here", help);
            }
            columns.push(column);
        }
        let header =
            Self { delimiter, time: columns.iter().position(|c| c.role == Role::Time), columns };
        header.check(line, messages);
        header
    }

    fn check(&self, line: Line, messages: &mut Messages) {
        let unknown = self.columns.iter().any(|column| column.role == Role::Unknown);
        if self.time.is_none() {
            let help = Some("name the time column `time [s]`".to_owned());
            let message = "the column `time` is missing".to_owned();
            messages.push_help("missing-key", message, line.clone(), "the columns", help);
        } else if self.columns.len() == 1 {
            let help = Some("for example: time [s], platform.x [mm]".to_owned());
            let message = "a column with a coordinate is missing".to_owned();
            messages.push_help("missing-key", message, line, "only the time", help);
        }
        for column in &self.columns {
            let Role::Coordinate { coordinate, order: order @ 1.. } = column.role else { continue };
            let below = Role::Coordinate { coordinate, order: order - 1 };
            if !unknown && !self.columns.iter().any(|other| other.role == below) {
                let (name, what) = (&column.name, ["positions", "velocities"]);
                let what = what.get(usize::from(order - 1)).copied().unwrap_or_default();
                let expected = if order == 1 { name.clone() } else { format!("d({name})") };
                let message = format!("the {what} that belong to this column are missing");
                let help = Some(format!("add a column `{expected}`"));
                messages.push_help("missing-key", message, column.span.clone(), "alone", help);
            }
        }
    }
}

impl Header {
    /// Reads the header of a file of efforts, with columns such as `leg1.P [N]`. If some names end
    /// in `.drive`, only these columns and the time are used.
    pub(super) fn of_drives(
        text: &str,
        line: Line,
        delimiter: Delimiter,
        actuators: &Actuators,
        messages: &mut Messages,
    ) -> Self {
        let label = |cell: &Span| {
            let content = text.get(cell.clone()).unwrap_or_default();
            content.split_once('[').map_or(content, |(label, _)| label).trim_end()
        };
        let cells = header_cells(text, &line, delimiter);
        let results = cells.iter().any(|cell| label(cell).ends_with(".drive"));
        let mut columns: Vec<Column> = Vec::new();
        for cell in cells {
            let label = label(&cell);
            let drive = label.strip_suffix(".drive");
            let name = if results { drive.unwrap_or(label) } else { label };
            let mut column = Column {
                role: Role::Unknown,
                scale: Scale::ONE,
                is_angle: false,
                name: name.to_owned(),
                span: cell.clone(),
                digits: Digits::default(),
            };
            let measure = if name == "time" || name == "t" {
                column.role = Role::Time;
                Measure::Time
            } else if results && drive.is_none() {
                // In a result file, a column whose name does not end in `.drive` is not an effort.
                if actuators.find(name).is_some() {
                    let message = format!(
                        "the column {} is ambiguous: it is named after an actuator, \
                         but the columns of efforts in this file end in `.drive`",
                        quoted(name)
                    );
                    messages.push("duplicate", message, cell, "delete this column");
                }
                columns.push(column);
                continue;
            } else if let Some(actuator) = actuators.find(name) {
                column.role = Role::Effort(actuator);
                actuators.measure(actuator, Measure::Force, Measure::Moment)
            } else {
                let (message, help) = actuators.unknown(name);
                let help = time_hint(name).or(help);
                messages.push_help("unknown-name", message, cell, "unknown column", help);
                columns.push(column);
                continue;
            };
            if let Some((_, unit)) = text.get(cell.clone()).unwrap_or_default().split_once('[') {
                let at = cell.end - unit.len();
                column.scale = read_unit(unit, at, measure, 0, messages).unwrap_or(Scale::ONE);
            }
            let again = columns.iter().any(|known| known.role == column.role);
            if again {
                let message = format!("the column {} occurs twice", quoted(name));
                let help = Some(TWICE.to_owned());
                messages.push_help("duplicate", message, cell, "again here", help);
            }
            columns.push(column);
        }
        let header =
            Self { delimiter, time: columns.iter().position(|c| c.role == Role::Time), columns };
        if header.time.is_none() {
            let help = Some("name the time column `time [s]`".to_owned());
            let message = "the column `time` is missing".to_owned();
            messages.push_help("missing-key", message, line, "the columns", help);
        } else if !header.columns.iter().any(|c| matches!(c.role, Role::Effort(_))) {
            let help = Some("for example: time [s], leg1.P [N]".to_owned());
            let message = "a column with an effort is missing".to_owned();
            messages.push_help("missing-key", message, line, "the columns", help);
        }
        header
    }
}

/// Splits a header line into its cells.
fn header_cells(text: &str, line: &Line, delimiter: Delimiter) -> Vec<Span> {
    let count = Cells::new(delimiter).split(text, line.clone(), usize::MAX).len();
    // Some programs end each line with a separator. The empty cell after it is not a column.
    Cells::new(delimiter).split(text, line.clone(), count.saturating_sub(1).max(1)).to_vec()
}

/// Returns an error message for a header with several names but no separator between them; `None`
/// for any other header.
fn separated_by_blanks(text: &str, line: &Line, delimiter: Delimiter) -> Option<String> {
    let header = text.get(line.clone())?;
    let is_alone = header_cells(text, line, delimiter).len() == 1;
    (is_alone && header.matches('[').count() > 1)
        .then(|| "the columns are separated by blanks".to_owned())
}

fn read_column(
    text: &str,
    cell: Span,
    names: &Names,
    orders: &Orders,
    messages: &mut Messages,
) -> Column {
    let content = text.get(cell.clone()).unwrap_or_default();
    let (label, unit) = match content.split_once('[') {
        Some((label, unit)) => (label.trim_end(), Some(unit)),
        None => (content, None),
    };
    let (name, order) = derivative(label);
    let name_span = {
        let start = cell.start + content.find(name).unwrap_or(0);
        start..start + name.len()
    };
    let mut column = Column {
        role: Role::Unknown,
        scale: Scale::ONE,
        is_angle: false,
        name: name.to_owned(),
        span: cell.clone(),
        digits: Digits::default(),
    };
    if name.is_empty() {
        let message = "a column has no name".to_owned();
        messages.push("syntax", message, cell, "expected a name");
        return column;
    }
    let measure = if name == "time" || name == "t" {
        column.role = Role::Time;
        Measure::Time
    } else {
        let meaning = match resolve(names, name) {
            Ok(Meaning::Body(_, "order")) => {
                let help = Some(
                    "set it in the model, beside `file`: `platform.order = \"zyx\"`".to_owned(),
                );
                let message = "the order of rotations cannot be given as a column".to_owned();
                messages.push_help("unknown-name", message, name_span, "not a coordinate", help);
                return column;
            }
            other => other.and_then(|meaning| coordinate(meaning, orders)),
        };
        match meaning {
            Ok((coordinate, measure)) => {
                column.role = Role::Coordinate { coordinate, order };
                column.is_angle = measure == Measure::Angle && order == 0;
                measure
            }
            Err(unresolved) => {
                let explained =
                    (!messages.is_full()).then(|| unresolved.explain(names, &[], name)).flatten();
                if let Some((message, help, _)) = explained {
                    let help = time_hint(label).or(help);
                    let label = "unknown column";
                    messages.push_help("unknown-name", message, name_span, label, help);
                }
                return column;
            }
        }
    };
    if let Some(unit) = unit {
        let at = cell.start + content.len() - unit.len();
        // The scale is irrelevant if the unit is invalid, because the motion is rejected.
        column.scale = read_unit(unit, at, measure, order, messages).unwrap_or(Scale::ONE);
    }
    column
}

/// Splits `d(NAME)` or `dd(NAME)` into the name and the order of the derivative.
fn derivative(label: &str) -> (&str, u8) {
    let within =
        |open: &str| label.strip_prefix(open)?.trim_start().strip_prefix('(')?.strip_suffix(')');
    match (within("dd"), within("d")) {
        (Some(name), _) => (name.trim(), 2),
        (_, Some(name)) => (name.trim(), 1),
        _ => (label, 0),
    }
}

fn read_unit(
    unit: &str,
    at: usize,
    measure: Measure,
    order: u8,
    messages: &mut Messages,
) -> Option<Scale> {
    let Some(inner) = unit.trim_end().strip_suffix(']') else {
        let message = "this bracket is not closed".to_owned();
        messages.push("syntax", message, at - 1..at, "opened here");
        return None;
    };
    let (scale, found) = match unit_of(inner) {
        Ok(unit) => unit,
        Err(fault) => {
            let span = at + fault.span.start..at + fault.span.end;
            messages.push_help(fault.code, fault.message, span, &fault.label, fault.help);
            return None;
        }
    };
    let per_time = Dimension::TIME.power(f64::from(order)).unwrap_or(Dimension::NONE);
    let expected = measure.dimension().over(per_time).unwrap_or(Dimension::NONE);
    if expected.same(found) && !found.is_ratio() && (!found.is_angle() || expected.is_angle()) {
        return Some(scale);
    }
    let message =
        format!("the unit of this column should be one of {}", expected_unit(measure, order));
    let label = format!("this is the unit of {}", found.describe());
    let span = at..at + inner.len();
    messages.push("dimension", message, span, &label);
    None
}

fn expected_unit(measure: Measure, order: u8) -> &'static str {
    match (measure, order) {
        (Measure::Time, _) => "s, ms, …",
        (Measure::Force, _) => "N, kN, …",
        (Measure::Moment, _) => "N m, …",
        (Measure::Angle, 0) => "rad, deg, …",
        (Measure::Angle, 1) => "rad/s, deg/s, …",
        (Measure::Angle, _) => "rad/s^2, deg/s^2, …",
        (_, 0) => "m, mm, …",
        (_, 1) => "m/s, mm/s, …",
        (_, _) => "m/s^2, mm/s^2, …",
    }
}
