//! Recorded motions: CSV files with a header such as `time [s], platform.x [mm], d(platform.x) [mm/s]`.

mod header;
mod rows;

use super::actuators::Actuators;
use super::context::Context;
use super::names::Names;
use super::path::Orders;
use crate::course::{Course, Monotone, Samples, Spline};
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::model::{Drives, Motion};
use crate::source::{Place, Source};
use header::{Column, Header, Role};
use std::sync::Arc;
use stiction::kinematics::Coordinate;

/// So many messages about one file are shown.
const MOST_MESSAGES: usize = 20;
/// A spline needs two samples, whatever they contain.
const LEAST_SAMPLES: usize = 2;

/// Messages about a file, the first few of them.
struct Messages<'a> {
    source: &'a Arc<Source>,
    out: Diagnostics,
}

impl Messages<'_> {
    fn push(
        &mut self,
        code: &'static str,
        message: String,
        span: std::ops::Range<usize>,
        label: &str,
    ) {
        self.push_help(code, message, span, label, None);
    }

    fn push_help(
        &mut self,
        code: &'static str,
        message: String,
        span: std::ops::Range<usize>,
        label: &str,
        help: Option<String>,
    ) {
        if self.is_full() {
            self.out.add_untold_errors(1);
            return;
        }
        let place = Place::new(self.source, span);
        self.out.push(Diagnostic::error(code, message).at(place, label).maybe_help(help));
    }

    /// Whether what follows is only counted.
    fn is_full(&self) -> bool {
        self.out.len() >= MOST_MESSAGES
    }
}

/// Reads a recorded motion; what is wrong with the file goes to `context`.
pub(crate) fn read(
    source: &Arc<Source>,
    names: &Names,
    orders: &Orders,
    context: &Context<'_>,
) -> Option<Motion> {
    let mut messages = Messages { source, out: Diagnostics::new() };
    let motion = read_text(source, names, orders, &mut messages);
    let failed = messages.out.has_errors();
    context.out.borrow_mut().append(messages.out);
    motion.filter(|_| !failed)
}

fn read_text(
    source: &Arc<Source>,
    names: &Names,
    orders: &Orders,
    messages: &mut Messages<'_>,
) -> Option<Motion> {
    let text = source.text.as_str();
    let mut lines = rows::lines(text);
    let first = first_line(text, &mut lines, "platform.x [mm]", messages)?;
    let header = Header::read(text, first, names, orders, messages);
    let mut columns = rows::read(text, lines, &header, messages);
    let times = std::mem::take(columns.get_mut(header.time?)?);
    // Rows that could not be read are not missing.
    if messages.out.has_errors() {
        return None;
    }
    if times.len() < LEAST_SAMPLES {
        let message = format!(
            "the file has {}; a motion needs at least {LEAST_SAMPLES} samples",
            match times.len() {
                0 => "no sample".to_owned(),
                n => format!("{n} sample"),
            }
        );
        let pose = (times.len() == 1).then(|| {
            "for a single pose give the motion `duration = 0` and coordinates instead".to_owned()
        });
        messages.push_help("samples", message, text.len()..text.len(), "the end", pose);
        return None;
    }
    let times: Arc<[f64]> = times.into();
    let (coordinates, interpolation) = splines(&times, &header, columns, messages);
    let (start, end) = (times.first().copied()?, times.last().copied()?);
    Some(Motion {
        title: String::new(),
        start,
        duration: end - start,
        step: None,
        samples: Some(times.to_vec()),
        coordinates,
        interpolation: Some(interpolation),
    })
}

/// The first line, if it names columns; `example` is one.
fn first_line(
    text: &str,
    lines: &mut impl Iterator<Item = rows::Line>,
    example: &str,
    messages: &mut Messages<'_>,
) -> Option<rows::Line> {
    if let Some(at) = text.find('\0') {
        let message = "this is not a text file".to_owned();
        messages.push("syntax", message, at..at + 1, "a zero byte");
        return None;
    }
    let Some(first) = lines.next() else {
        let help = format!("the first line names the columns: time [s], {example}, …");
        messages.push_help("syntax", "the file is empty".to_owned(), 0..0, "", Some(help));
        return None;
    };
    if rows::cells(text, first.clone())
        .all(|cell| text.get(cell).is_some_and(|cell| cell.parse::<f64>().is_ok()))
    {
        let help = format!("name the columns above them: time [s], {example}, …");
        let message = "the columns have no names".to_owned();
        messages.push_help("syntax", message, first, "numbers already", Some(help));
        return None;
    }
    Some(first)
}

/// Reads recorded efforts; what is wrong with the file goes to `context`.
pub(crate) fn read_drives(
    source: &Arc<Source>,
    actuators: &Actuators,
    context: &Context<'_>,
) -> Option<Drives> {
    let mut messages = Messages { source, out: Diagnostics::new() };
    let drives = read_efforts(source.text.as_str(), actuators, &mut messages);
    let failed = messages.out.has_errors();
    context.out.borrow_mut().append(messages.out);
    drives.filter(|_| !failed)
}

fn read_efforts(text: &str, actuators: &Actuators, messages: &mut Messages<'_>) -> Option<Drives> {
    let mut lines = rows::lines(text);
    let first = first_line(text, &mut lines, "leg1.P [N]", messages)?;
    let header = Header::of_drives(text, first, actuators, messages);
    let columns = rows::read(text, lines, &header, messages);
    let times: Arc<[f64]> = columns.get(header.time?)?.as_slice().into();
    if messages.out.has_errors() {
        return None;
    }
    if times.is_empty() {
        let message = "the file has no sample".to_owned();
        messages.push("samples", message, text.len()..text.len(), "the end");
        return None;
    }
    let columns = header.columns.iter().zip(columns);
    let efforts = columns.filter_map(|(column, values)| match column.role {
        Role::Effort(actuator) => Some((actuator, Course::monotone(Monotone::new(&times, values)))),
        _ => None,
    });
    Some(Drives {
        title: String::new(),
        efforts: efforts.collect(),
        samples: Some(times.to_vec()),
        interpolation: Some(Monotone::WORDS.to_owned()),
    })
}

/// A spline for every coordinate, and what kind it is.
fn splines(
    times: &Arc<[f64]>,
    header: &Header,
    mut columns: Vec<Vec<f64>>,
    messages: &mut Messages<'_>,
) -> (Vec<(Coordinate, Course)>, String) {
    let mut take = |role: Role| {
        let index = header.columns.iter().position(|column| column.role == role)?;
        columns.get_mut(index).map(std::mem::take)
    };
    let mut coordinates = Vec::new();
    let mut kinds: Vec<(String, Vec<String>)> = Vec::new();
    for Column { role, name, span, .. } in &header.columns {
        let &Role::Coordinate { coordinate, order: 0 } = role else { continue };
        let part = |order| Role::Coordinate { coordinate, order };
        let (values, rates, accelerations) = (take(part(0)), take(part(1)), take(part(2)));
        let samples = match (values, rates, accelerations) {
            (Some(values), None, _) => Samples::Values(values),
            (Some(values), Some(rates), None) => Samples::Rates(values, rates),
            (Some(values), Some(rates), Some(accelerations)) => {
                Samples::Accelerations(values, rates, accelerations)
            }
            (None, ..) => continue,
        };
        let kind = samples.describe(times.len());
        match kinds.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, names)) => names.push(name.clone()),
            None => kinds.push((kind, vec![name.clone()])),
        }
        let spline = Spline::new(times, samples);
        if !spline.is_finite() {
            let message = format!("no spline goes through the samples of `{name}`");
            let label = "the samples are too large, or too close in time";
            messages.push("samples", message, span.clone(), label);
        }
        coordinates.push((coordinate, Course::spline(spline)));
    }
    let interpolation = match kinds.as_slice() {
        [(kind, _)] => kind.clone(),
        _ => {
            let each =
                |(kind, names): &(String, Vec<String>)| format!("{}: {kind}", names.join(", "));
            kinds.iter().map(each).collect::<Vec<_>>().join("; ")
        }
    };
    (coordinates, interpolation)
}
