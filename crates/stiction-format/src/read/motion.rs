//! Reads motions.

use super::context::{Context, Record, of_the_top};
use super::kinks::warn_of_jumps;
use super::names::Names;
use super::path::{Leaf, Meaning, Orders, Unresolved, coordinate, leaves, resolve};
use super::recording::{self, Cutoff, Input};
use super::waypoints;
use crate::contents::Contents;
use crate::diagnostic::{Diagnostic, Diagnostics, number};
use crate::document::{Table, Value};
use crate::expression::Measure;
use crate::fields::tables::{MOTION, ORDERS};
use crate::model_file::Motion;
use crate::signal::Signal;
use crate::source::Span;
use stiction_core::kinematics::{AngleOrder, Coordinate};
use stiction_core::mechanism::{BodyId, Mechanism};
use stiction_core::spatial::Pose;

/// Function that returns the contents of a file from its name as written in a text.
pub(crate) type Files<'a> = &'a dyn Fn(&str) -> Result<Contents, String>;

/// Default time step of the results of a motion, s.
pub(crate) const STEP: f64 = 0.01;
/// Maximum number of samples of a motion.
const MAX_SAMPLES: f64 = 1e8;
/// Maximum number of intervals at whose ends formulas are evaluated in advance.
const TRIALS: f64 = 10_000.0;

/// Reads a motion; `None` if it is invalid.
pub(crate) fn read(
    context: &Context<'_>,
    (names, assembly): (&Names, Option<Assembly<'_>>),
    table: &Table,
    files: Files<'_>,
) -> Option<Motion> {
    let record = Record::open(context, table, MOTION, "a motion");
    let title = record.line("title");
    let refuse = |key: &str, value: f64, expected: &str| {
        let message = format!("`{key}` is {} s, but must {expected}", number(value));
        context.push(
            Diagnostic::error("range", message)
                .at(context.place(&record.span(key)), "out of range"),
        );
    };
    let step = record.quantity("step").filter(|&step| {
        if step <= 0.0 {
            refuse("step", step, "be greater than 0");
        }
        step > 0.0
    });
    let mut reader = Reader { context, names, assembly, orders: Orders::new(), labels: Vec::new() };
    let instead = ["file", "waypoints"].into_iter().find_map(|key| Some((key, record.value(key)?)));
    let coordinates = reader.coordinates(table, instead);
    if let Some(file) = record.value("file") {
        for key in ["start", "waypoints", "law", "limits"] {
            if let Some(value) = record.value(key) {
                context.push(
                    Diagnostic::error(
                        "motion",
                        format!("a motion from a file cannot have `{key}`"),
                    )
                    .at(context.place(&value.span), "the samples determine the time")
                    .help(format!("delete `{key}`")),
                );
            }
        }
        let own = record
            .quantity("filter")
            .map(|hertz| Cutoff { hertz, place: Some(context.place(&record.span("filter"))) });
        if record.value("filter").is_some() && own.is_none() {
            return None;
        }
        let motion = reader.recorded(title, step, (file, own), files)?;
        return is_as_stated(&record, &motion).then_some(motion);
    }
    let only_of_files = [
        (
            "rate",
            "only a motion from a file has a `rate` of its samples",
            "delete `rate`; `step` is the time between samples of the result",
        ),
        (
            "filter",
            "only a motion from a file has noise that a `filter` can remove",
            "delete `filter`",
        ),
    ];
    for (key, message, help) in only_of_files {
        if let Some(value) = record.value(key) {
            context.push(
                Diagnostic::error("motion", message)
                    .at(context.place(&value.span), "no file")
                    .help(help),
            );
        }
    }
    let start = record.quantity("start").unwrap_or(0.0);
    let through = match record.value("waypoints") {
        Some(value) => Some(waypoints::read(&reader, &record, value, start)?),
        None => None,
    };
    for key in ["law", "limits"].into_iter().filter(|_| through.is_none()) {
        if let Some(value) = record.value(key) {
            context.push(
                Diagnostic::error("motion", format!("`{key}` needs `waypoints`"))
                    .at(context.place(&value.span), "there are no moves"),
            );
        }
    }
    let duration = match (&through, record.value("duration")) {
        (Some(through), None) => through.duration,
        (Some(_), Some(value)) => {
            context.push(
                Diagnostic::error("motion", "a motion through waypoints cannot have `duration`")
                    .at(context.place(&value.span), "the waypoints determine the time")
                    .help("delete it, or write the duration of a move at its waypoint"),
            );
            return None;
        }
        (None, Some(_)) => record.quantity("duration")?,
        (None, None) => 1.0,
    };
    let (coordinates, interpolation) = match through {
        Some(through) => (through.coordinates, Some(through.description)),
        None => (coordinates, None),
    };
    if duration < 0.0 {
        refuse("duration", duration, "not be negative; 0 means a single pose");
        return None;
    }
    let mut motion = Motion {
        title,
        start,
        duration,
        step,
        samples: None,
        coordinates,
        interpolation,
        notes: Vec::new(),
        warnings: Diagnostics::new(),
    };
    let count = duration / step.unwrap_or(STEP);
    if !(start + duration).is_finite() || count > MAX_SAMPLES {
        let key = if step.is_some() { "step" } else { "duration" };
        let message = format!("the motion would have {} samples", number(count.round()));
        context.push(
            Diagnostic::error("range", message)
                .at(context.place(&record.span(key)), "too many samples")
                .help(format!("increase `step`; the maximum is {} samples", number(MAX_SAMPLES))),
        );
        motion.coordinates.clear();
        return None;
    }
    // Sample times are the sum of `start` and a fraction of `duration`, which rounding removes if
    // `start` is too large.
    if duration > 0.0 && start.abs() * f64::EPSILON > 1e-3 * step.unwrap_or(STEP) {
        let message = "the start time is so large that consecutive samples round to the same time";
        context.push(
            Diagnostic::error("range", message)
                .at(context.place(&record.span("start")), "too far from 0")
                .help("let the motion start at 0"),
        );
        return None;
    }
    let signals = motion.coordinates.iter().map(|(_, signal)| signal);
    check_signals(context, signals, start, duration, step);
    warn_of_jumps(&mut motion, &reader.labels);
    Some(motion)
}

/// Compares the time column of a recording with the stated `rate` and `duration`; reports
/// contradictions and returns true if both agree. A time column with another unit or clock
/// would scale all speeds.
fn is_as_stated(record: &Record<'_>, motion: &Motion) -> bool {
    /// Relative difference of durations at which accelerations are wrong by two percent.
    const TOLERANCE: f64 = 0.01;
    let intervals = motion.samples.as_ref().map_or(0, |samples| samples.count()).max(2) - 1;
    let step = motion.duration / intervals as f64;
    // Some loggers count the interval after the last sample.
    let stated = [("rate", "Hz", 1.0 / step, 0.0), ("duration", "s", motion.duration, 1.5 * step)];
    let mut agrees = true;
    for (key, unit, found, least) in stated {
        let Some(value) = record.value(key) else { continue };
        let Some(stated) = record.quantity(key) else {
            agrees = false;
            continue;
        };
        // If the stated value is not a number, the comparison is false and the value is reported.
        let difference = (stated - found).abs();
        if difference <= least.max(TOLERANCE * found) {
            continue;
        }
        agrees = false;
        let message = format!(
            "the time column contradicts `{key}`: it gives {found:.4} {unit}, but `{key}` is {stated:.4} {unit}"
        );
        record.context.push(
            Diagnostic::error("recording", message)
                .at(record.context.place(&value.span), format!("{:.4} times", stated / found))
                .help(format!(
                    "check the unit of the time column and look for missing samples, or delete `{key}`"
                )),
        );
    }
    agrees
}

/// Reports formulas whose value or derivatives are not finite at one of the instants checked from
/// `start` to `start + duration`, s.
pub(crate) fn check_signals<'a>(
    context: &Context<'_>,
    signals: impl IntoIterator<Item = &'a Signal>,
    start: f64,
    duration: f64,
    step: Option<f64>,
) {
    let count = (duration / step.unwrap_or(STEP)).round().clamp(1.0, TRIALS);
    for signal in signals.into_iter().filter(|signal| signal.as_constant().is_none()) {
        let instants = (0..=count as usize).map(|k| start + duration * k as f64 / count);
        if let Some(fault) =
            instants.filter(|&t| !is_finite(signal, t)).find_map(|t| signal.fault_at(t))
        {
            context.push(fault);
        }
    }
}

fn is_finite(signal: &Signal, t: f64) -> bool {
    let target = signal.at(t);
    target.value.is_finite() && target.rate.is_finite() && target.acceleration.is_finite()
}

/// Mechanism whose motion is read, with initial guesses for the poses of its bodies.
#[derive(Clone, Copy)]
pub(crate) struct Assembly<'a> {
    pub(crate) mechanism: &'a Mechanism,
    pub(crate) initial_poses: &'a [(BodyId, Pose<f64>)],
}

pub(super) struct Reader<'a> {
    pub(super) context: &'a Context<'a>,
    pub(super) names: &'a Names,
    /// Mechanism of the motion; `None` if it has defects.
    pub(super) assembly: Option<Assembly<'a>>,
    pub(super) orders: Orders,
    /// Name and kind of each coordinate that an expression prescribes.
    labels: Vec<(String, Measure)>,
}

impl Reader<'_> {
    /// Reads the coordinates in the table. If the motion has a file or waypoints, the table may
    /// contain only rotation orders.
    fn coordinates(
        &mut self,
        table: &Table,
        instead: Option<(&str, &Value)>,
    ) -> Vec<(Coordinate, Signal)> {
        let context = self.context;
        let mut meanings = Vec::new();
        let found = leaves(table, MOTION);
        for leaf in &found {
            if context.is_full() {
                break;
            }
            let path = match leaf.value {
                Some(_) => leaf.path.clone(),
                // An empty table is resolved under the name of an example coordinate, so that an
                // unknown body or joint is reported.
                None => format!("{}.x", leaf.path),
            };
            match resolve(self.names, &path) {
                Err(unresolved) => {
                    self.unresolved(leaf, unresolved);
                    leaf.value.into_iter().for_each(|value| self.check_values(value));
                }
                Ok(Meaning::Body(body, "order")) => {
                    let order = leaf.value.and_then(|value| context.choice(value, ORDERS));
                    if let Some(order) = order.and_then(AngleOrder::from_name) {
                        self.orders.insert(body, order);
                    }
                }
                Ok(_) => meanings.extend(leaf.value.map(|value| (leaf, value))),
            }
        }
        let mut coordinates: Vec<(Coordinate, Signal)> = Vec::new();
        let mut places: Vec<(Coordinate, Span)> = Vec::new();
        for (leaf, value) in meanings {
            if let Some((key, other)) = instead {
                let (what, label) = match key {
                    "file" => ("a file", "a file"),
                    _ => ("waypoints", "waypoints"),
                };
                let message = format!("a motion cannot have both {what} and expressions");
                context.push(
                    Diagnostic::error("motion", message)
                        .at(context.place(&leaf.key), "an expression")
                        .also(context.place(&other.span), label),
                );
                break;
            }
            let meant = resolve(self.names, &leaf.path).and_then(|m| coordinate(m, &self.orders));
            let (coordinate, measure) = match meant {
                Ok(meant) => meant,
                Err(unresolved) => {
                    self.unresolved(leaf, unresolved);
                    self.check_values(value);
                    continue;
                }
            };
            if let Some((_, first)) = places.iter().find(|(known, _)| *known == coordinate) {
                context.push(
                    Diagnostic::error("duplicate", "this coordinate is prescribed twice")
                        .at(context.place(&leaf.key), "again here")
                        .also(context.place(first), "first here"),
                );
                continue;
            }
            places.push((coordinate, leaf.key.clone()));
            if let Some(signal) = context.signal(value, measure) {
                coordinates.push((coordinate, signal));
                self.labels.push((leaf.path.clone(), measure));
            }
        }
        coordinates
    }

    /// Checks the units of an expression whose coordinate is unknown.
    fn check_values(&self, value: &Value) {
        if value.as_text().is_some() {
            self.context.signal(value, Measure::Any);
        }
    }

    pub(super) fn unresolved(&self, leaf: &Leaf<'_>, unresolved: Unresolved) {
        // In a text with syntax errors, an unknown name may be defined in a broken line.
        if !self.context.broken.is_empty() {
            return;
        }
        let Some((message, help, in_owner)) = unresolved.explain(self.names, MOTION, &leaf.path)
        else {
            return;
        };
        let (span, label) = match in_owner {
            true => (&leaf.owner, "unknown name"),
            false => (&leaf.key, "not a coordinate"),
        };
        self.context.push(
            Diagnostic::error("unknown-name", message)
                .at(self.context.place(span), label)
                .maybe_help(of_the_top(&leaf.path).or(help)),
        );
    }

    fn recorded(
        &self,
        title: String,
        step: Option<f64>,
        (value, filter): (&Value, Option<Cutoff>),
        files: Files<'_>,
    ) -> Option<Motion> {
        let name = self.context.text(value, "a quoted name of a CSV file")?;
        let motion = files(name).and_then(|contents| {
            let input = Input::new(name, contents);
            recording::read(&input, self.names, &self.orders, self.context, filter)
        });
        match motion {
            Ok(motion) => motion.map(|motion| Motion { title, step, ..motion }),
            Err(reason) => {
                self.context.push(
                    Diagnostic::error("file", format!("the file cannot be read: {reason}"))
                        .at(self.context.place(&value.span), "this file")
                        .help(
                            "a motion is a CSV file in UTF-8; its name is relative to the folder of \
                             the model",
                        ),
                );
                None
            }
        }
    }
}

/// Reports formulas of a load that are not finite at one of the instants checked during a motion.
pub(crate) fn check_load(
    context: &Context<'_>,
    load: &crate::model_file::LoadCase,
    motion: &Motion,
) {
    for wrench in &load.wrenches {
        let signals = wrench.force.iter().chain(&wrench.moment);
        check_signals(context, signals, motion.start, motion.duration, motion.step);
    }
}
