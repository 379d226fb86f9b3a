//! Determines the meaning of the columns of a log.

use super::{LogRole, Meaning, Reader, Renamed};
use crate::diagnostic::{Diagnostic, Diagnostics, did_you_mean, quoted};
use crate::document::key;
use crate::expression::{Dimension, Measure, unit_of};
use crate::pattern::fits;
use crate::read::path::{Orders, coordinate, resolve};
use crate::read::time_column::time_hint;
use crate::source::Span;

/// Tests if a column is a computed quantity in the tables of `stiction inverse` or `stiction forward` that a log does not
/// need or that cannot be measured.
fn is_result(label: &str) -> bool {
    let ends = [
        ".acceleration",
        ".speed",
        ".power",
        ".drive_frictionless",
        ".drive_low",
        ".drive_high",
        ".motor_speed",
        ".motor_torque_low",
        ".motor_torque_high",
    ];
    ends.iter().any(|end| label.ends_with(end))
        || ["closure", "power.residual"].contains(&label)
        || label.starts_with("distance.")
}

impl Reader<'_> {
    /// Determines the meaning of a column from its header, and from the unit that a line below the
    /// header may contain.
    pub(super) fn meaning(
        &self,
        span: Span,
        below: Option<&str>,
        out: &mut Diagnostics,
    ) -> Meaning {
        let written = self.header.text.get(span.clone()).unwrap_or_default();
        let bare = written.split_once('[').map_or(written, |(label, _)| label.trim_end());
        let below = below.filter(|unit| !unit.is_empty());
        let all = || self.format.renamed.iter();
        let is_unused =
            |r: &&Renamed| r.meaning.is_empty() && r.column.contains('*') && fits(&r.column, bare);
        let renamed = all().find(|r| r.column == written || r.column == bare);
        let renamed = renamed.or_else(|| all().find(is_unused));
        let is_time = |unit: &str| {
            unit_of(unit).is_ok_and(|(_, found)| Measure::Time.dimension().same(found))
        };
        let header = match renamed {
            Some(renamed) => renamed.meaning.as_str(),
            // Some recorders give the time column no name, only a unit.
            None if written.is_empty() && below.is_some_and(is_time) => "time",
            None => written,
        };
        let (label, unit) = match header.split_once('[') {
            Some((label, unit)) => (label.trim_end(), Some(unit.trim_end().trim_end_matches(']'))),
            None => (header, below),
        };
        let mut meaning =
            Meaning { name: bare.to_owned(), role: LogRole::Unused, factor: 1.0, offset: 0.0 };
        if label.is_empty() || label.starts_with("dd(") || is_result(label) {
            return meaning;
        }
        let rate = label.strip_prefix("d(").and_then(|rest| rest.strip_suffix(')')).map(str::trim);
        let rate = rate.or_else(|| label.strip_suffix(".rate"));
        let label = label.strip_suffix(".position").unwrap_or(label);
        let reference = label.strip_suffix(".reference");
        let Some((role, measure)) = self.role(rate.or(reference).unwrap_or(label), &span, out)
        else {
            return meaning;
        };
        let (role, measure) = match (rate, role) {
            (None, LogRole::Coordinate(coordinate)) if reference.is_some() => {
                (LogRole::Reference(coordinate), measure)
            }
            // Commanded values are supported for positions only.
            (None, _) if reference.is_some() => return meaning,
            (None, role) => (role, measure),
            (Some(_), LogRole::Coordinate(coordinate)) => {
                let is_length = measure == Some(Measure::Length);
                let measure = if is_length { Measure::Speed } else { Measure::AngularSpeed };
                (LogRole::Rate(coordinate), Some(measure))
            }
            // Rates of efforts and of the time are not used.
            (Some(_), _) => return meaning,
        };
        if self.format.is_steady && role == LogRole::Time {
            return meaning;
        }
        meaning.role = role;
        let expected = match measure {
            Some(measure) => measure.dimension(),
            None => Dimension::NONE.with_current(1),
        };
        if let Some(unit) = unit {
            match unit_of(unit) {
                Ok((scale, found)) if expected.same(found) && !found.is_ratio() => {
                    meaning.factor = scale.apply(1.0);
                }
                Ok((_, found)) => {
                    let message = format!("{} has the unit of {}", quoted(label), found.describe());
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
                        Diagnostic::error(fault.code, message)
                            .at(self.place(span), fault.label)
                            .maybe_help(fault.help),
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
                // In tables of `stiction forward`, this is the torque of the motor of a drive train times the
                // transmission. It is not used, because the table has the columns of the motors.
                let is_of_motor = suffix == ".drive" && !self.trains.is_empty();
                if is_of_motor && self.header.text.contains(&format!("{name}.acceleration")) {
                    return None;
                }
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
                    let more = "if the column is not used, write `NAME = \"\"` under [columns] in the options; \
                                `\"NA*\" = \"\"` does so for all columns whose names begin with NA";
                    let help = match time_hint(label) {
                        Some(time) => format!(
                            "{time}; without a change of the file, write `{} = \"time [s]\"` under \
                             [columns] in the options",
                            key(label)
                        ),
                        None => {
                            help.map_or_else(|| more.to_owned(), |help| format!("{help}; {more}"))
                        }
                    };
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
