//! Reader of recordings: motions in CSV files with a header such as `time [s], platform.x [mm],
//! d(platform.x) [mm/s]`, and efforts of actuators.

mod filtering;
mod gather;
mod header;
mod input;
mod messages;
mod plan;
mod report;
mod rows;
mod scan;

pub(crate) use filtering::Cutoff;
pub(crate) use input::Input;

use super::actuators::Actuators;
use super::context::Context;
use super::names::Names;
use super::path::Orders;
use crate::model_file::{Drives, Motion};
use crate::signal::Signal;
use filtering::filtered;
use gather::{ReadHeader, Recording, gather};
use header::{Header, Role};
use messages::Messages;
use report::Report;

/// Column name shown as an example in messages.
const EXAMPLE: &str = "platform.x [mm]";
/// Minimum number of samples of a recorded motion.
const MIN_SAMPLES: usize = 2;

/// Reads a recorded motion and reports its errors to `context`. Returns `None` for an invalid
/// motion. `filter` is the cut-off frequency in the text of the motion; a cut-off frequency set by
/// [`Source::with_filter`](crate::Source::with_filter) takes precedence.
///
/// # Errors
/// Returns the reason if the file cannot be read.
pub(crate) fn read(
    input: &Input,
    names: &Names,
    orders: &Orders,
    context: &Context<'_>,
    filter: Option<Cutoff>,
) -> Result<Option<Motion>, String> {
    let filter = context.source.filter().map(Cutoff::from).or(filter);
    let head: ReadHeader<'_> = &|text, line, delimiter, messages| {
        Header::read(text, line, delimiter, names, orders, messages)
    };
    let (recording, mut messages) = gather(input, EXAMPLE, head)?;
    let motion = match recording {
        Some(recording) => motion(recording, (input, head), filter, &mut messages)?,
        None => None,
    };
    let failed = messages.out.has_errors();
    context.out.borrow_mut().append(messages.out);
    Ok(motion.filter(|_| !failed))
}

fn motion(
    recording: Recording,
    (input, head): (&Input, ReadHeader<'_>),
    filter: Option<Cutoff>,
    messages: &mut Messages,
) -> Result<Option<Motion>, String> {
    if recording.samples.count() < MIN_SAMPLES {
        too_few(recording.samples.count(), messages);
        return Ok(None);
    }
    let Some((start, end)) = recording.samples.ends() else { return Ok(None) };
    let filtered = match filter {
        Some(cutoff) => match filtered(&recording, (input, head), &cutoff)? {
            Ok(filtered) => Some((cutoff.hertz, filtered)),
            Err(refused) => {
                messages.out.push(refused);
                return Ok(None);
            }
        },
        None => None,
    };
    let suggestion = match &filtered {
        None if recording.is_noisy() => filtering::suggestion(&recording, (input, head))?,
        _ => None,
    };
    let Recording { header, header_page, samples, curves, gap } = recording;
    let (mut coordinates, mut kinds) = (Vec::new(), Kinds::default());
    let mut report = Report::new(&header, header_page, suggestion);
    if let Some(gap) = gap {
        report.gap(gap);
    }
    for (index, curve) in curves.into_iter().enumerate() {
        let Some(column) = header.columns.get(curve.column) else { continue };
        let Role::Coordinate { coordinate, .. } = column.role else { continue };
        let of_curve = filtered.as_ref().and_then(|(hertz, all)| Some((*hertz, all.get(index)?)));
        let (kind, signal) = match of_curve {
            Some((cutoff, filtered)) => {
                let findings = curve.findings.as_ref();
                report.filtered(coordinate, curve.column, (cutoff, filtered), findings);
                (filtering::describe(cutoff), Signal::curve(filtered.curve.clone()))
            }
            None => {
                let mut kind = curve.interpolation.describe(samples.count());
                if curve.is_global {
                    kind += "; computed for all samples at once, as the time steps are too unequal to do \
                             it in parts";
                }
                if let Some(findings) = &curve.findings {
                    report.add(coordinate, curve.column, findings);
                }
                (kind, curve.signal)
            }
        };
        kinds.add(kind, &column.name);
        coordinates.push((coordinate, signal));
    }
    let (notes, warnings, errors) = report.finish();
    messages.out.append(errors);
    Ok(Some(Motion {
        title: String::new(),
        start,
        duration: end - start,
        step: None,
        samples: Some(samples),
        coordinates,
        interpolation: Some(kinds.describe()),
        notes,
        warnings,
    }))
}

/// Reports a recording with `count` samples, too few for a motion. The current page of `messages`
/// must be the last page of the file.
fn too_few(count: usize, messages: &mut Messages) {
    let message = format!(
        "the file has {}, but a motion needs at least {MIN_SAMPLES} samples",
        match count {
            0 => "no sample".to_owned(),
            n => format!("{n} sample"),
        }
    );
    let pose = (count == 1).then(|| {
        "for a single pose, use a motion with `duration = 0` and coordinates instead".to_owned()
    });
    let end = messages.page.text.len();
    messages.push_help("samples", message, end..end, "the end", pose);
}

/// Reads recorded efforts and reports their errors to `context`. Returns `None` for an invalid
/// recording.
///
/// # Errors
/// Returns the reason if the file cannot be read.
pub(crate) fn read_drives(
    input: &Input,
    actuators: &Actuators,
    context: &Context<'_>,
) -> Result<Option<Drives>, String> {
    let (recording, mut messages) =
        gather(input, "leg1.P [N]", &|text, line, delimiter, messages| {
            Header::of_drives(text, line, delimiter, actuators, messages)
        })?;
    let drives = recording.and_then(|recording| drives(recording, &mut messages));
    let failed = messages.out.has_errors();
    context.out.borrow_mut().append(messages.out);
    Ok(drives.filter(|_| !failed))
}

fn drives(recording: Recording, messages: &mut Messages) -> Option<Drives> {
    let Recording { header, samples, curves, .. } = recording;
    if samples.count() == 0 {
        let end = messages.page.text.len();
        messages.push("samples", "the file has no sample".to_owned(), end..end, "the end");
        return None;
    }
    let interpolation = curves.first().map(|curve| curve.interpolation.describe(samples.count()));
    let efforts =
        curves.into_iter().filter_map(|curve| match header.columns.get(curve.column)?.role {
            Role::Effort(actuator) => Some((actuator, curve.signal)),
            _ => None,
        });
    let efforts = efforts.collect();
    Some(Drives { efforts, samples: Some(samples), interpolation, ..Drives::default() })
}

/// Kinds of interpolation, each with the names of the coordinates to which it applies.
#[derive(Default)]
struct Kinds(Vec<(String, Vec<String>)>);

impl Kinds {
    fn add(&mut self, kind: String, name: &str) {
        match self.0.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, names)) => names.push(name.to_owned()),
            None => self.0.push((kind, vec![name.to_owned()])),
        }
    }

    fn describe(&self) -> String {
        match self.0.as_slice() {
            [(kind, _)] => kind.clone(),
            all => {
                let each =
                    |(kind, names): &(String, Vec<String>)| format!("{}: {kind}", names.join(", "));
                all.iter().map(each).collect::<Vec<_>>().join("; ")
            }
        }
    }
}
