//! Reader of recorded motions: CSV files with a header such as `time [s], platform.x [mm],
//! d(platform.x) [mm/s]`.

mod gather;
mod header;
mod input;
mod messages;
mod plan;
mod report;
mod rows;
mod scan;

pub(crate) use input::Input;

use super::actuators::Actuators;
use super::context::Context;
use super::names::Names;
use super::path::Orders;
use crate::model_file::{Drives, Motion};
use gather::{Recording, gather};
use header::{Header, Role};
use messages::Messages;
use report::Report;

/// Minimum number of samples of a spline.
const MIN_SAMPLES: usize = 2;

/// Reads a recorded motion and reports its errors to `context`.
///
/// # Errors
/// A reason if the file cannot be read.
pub(crate) fn read(
    input: &Input,
    names: &Names,
    orders: &Orders,
    context: &Context<'_>,
) -> Result<Option<Motion>, String> {
    let (recording, mut messages) =
        gather(input, "platform.x [mm]", &|text, line, delimiter, messages| {
            Header::read(text, line, delimiter, names, orders, messages)
        })?;
    let motion = recording.and_then(|recording| motion(recording, &mut messages));
    let failed = messages.out.has_errors();
    context.out.borrow_mut().append(messages.out);
    Ok(motion.filter(|_| !failed))
}

fn motion(recording: Recording, messages: &mut Messages) -> Option<Motion> {
    let Recording { header, header_page, samples, curves } = recording;
    if samples.count() < MIN_SAMPLES {
        too_few(samples.count(), messages);
        return None;
    }
    let (start, end) = samples.ends()?;
    let (mut coordinates, mut kinds) = (Vec::new(), Kinds::default());
    let mut report = Report::new(&header, header_page);
    for curve in curves {
        let column = header.columns.get(curve.column)?;
        let Role::Coordinate { coordinate, .. } = column.role else { continue };
        let mut kind = curve.interpolation.describe(samples.count());
        if curve.is_global {
            kind += "; computed for all samples at once, as the time steps are too unequal to do it in \
                     parts";
        }
        kinds.add(kind, &column.name);
        if let Some(findings) = &curve.findings {
            report.add(coordinate, curve.column, findings);
        }
        coordinates.push((coordinate, curve.signal));
    }
    let (notes, warnings, errors) = report.finish();
    messages.out.append(errors);
    Some(Motion {
        title: String::new(),
        start,
        duration: end - start,
        step: None,
        samples: Some(samples),
        coordinates,
        interpolation: Some(kinds.describe()),
        notes,
        warnings,
    })
}

/// Reports a recording with too few samples. The page of `messages` must be the last.
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

/// Reads recorded efforts and reports their errors to `context`.
///
/// # Errors
/// A reason if the file cannot be read.
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
    Some(Drives { title: String::new(), efforts, samples: Some(samples), interpolation })
}

/// Description of the interpolation: each kind with its coordinates.
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
