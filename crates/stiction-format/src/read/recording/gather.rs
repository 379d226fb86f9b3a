//! Reads a recording and fits a curve to the samples of each coordinate or effort. The curves of a
//! text in memory are computed at once; those of any other text are computed piece by piece, with
//! an index of the text.

use super::header::Header;
use super::input::Input;
use super::messages::Messages;
use super::plan::Plan;
use super::scan::{Scan, scan};
use crate::diagnostic::number;
use crate::signal::quality::gaps::{Gap, Gaps};
use crate::signal::quality::{Findings, Quality};
use crate::signal::recorded::lines::{Delimiter, Line};
use crate::signal::recorded::{IndexBuilder, Indexed, Layout};
use crate::signal::samples::SampleTimes;
use crate::signal::{Curve, Interpolation, Signal};
use crate::source::Source;
use std::ops::Range;
use std::sync::Arc;

/// Maximum size, in bytes, of a recording whose spline is solved for all samples at once; the
/// solution needs several times as much memory.
const MAX_GLOBAL_BYTES: u64 = 1 << 30;

/// Recording without errors in its header and rows: the header, the sample times, and a curve for
/// each coordinate or effort.
pub(super) struct Recording {
    pub(super) header: Header,
    /// Page (part of the text) that contains the header line.
    pub(super) header_page: Arc<Source>,
    pub(super) samples: SampleTimes,
    pub(super) curves: Vec<RecordedCurve>,
    /// Longest gap between samples; `None` without gaps.
    pub(super) gap: Option<Gap>,
}

/// Function that reads the header of a recording. Its arguments are the text, the byte range of the
/// header line, the column separator, and the list to which messages are added.
pub(super) type ReadHeader<'a> = &'a dyn Fn(&str, Line, Delimiter, &mut Messages) -> Header;

/// Curve through the samples of one coordinate or effort.
pub(super) struct RecordedCurve {
    /// Index of the column with the values of the coordinate or effort.
    pub(super) column: usize,
    pub(super) interpolation: Interpolation,
    pub(super) signal: Signal,
    /// Findings about the quality of the coordinate's samples; `None` for efforts.
    pub(super) findings: Option<Findings>,
    is_finite: bool,
    /// True if the recording is long, but its time steps are too unequal to solve the spline in
    /// parts, so that it is solved for all samples at once.
    pub(super) is_global: bool,
}

/// Collects the rows of a recording while they are read.
struct Collector {
    layout: Layout,
    /// Values of the current row that the curves need, in SI units, in the order of `layout`.
    row: Vec<f64>,
    /// Standard deviations of the rounding errors of the values in `row`, in SI units.
    rounding: Vec<f64>,
    /// Quality test of each curve, with the range of indices in `row` that belongs to the curve;
    /// `None` for efforts.
    tests: Vec<Option<(Quality, Range<usize>)>>,
    gaps: Gaps,
    /// Byte offset, in the file, of the end of the row read last.
    end: u64,
    sink: Sink,
}

enum Sink {
    Memory(Vec<Vec<f64>>),
    Index(IndexBuilder),
}

impl Collector {
    fn new(header: &Header, input: &Input) -> Self {
        let layout = Plan::of(header).layout;
        let sink = match input {
            Input::Whole(_) => Sink::Memory(vec![Vec::new(); layout.width()]),
            Input::Stored { .. } => Sink::Index(IndexBuilder::new(layout.clone())),
        };
        let tests = layout.curves().map(|(interpolation, places)| match interpolation {
            Interpolation::Spline(given) => Some((Quality::new(given), places)),
            Interpolation::Monotone => None,
        });
        let row = vec![0.0; layout.width()];
        let (tests, gaps) = (tests.collect(), Gaps::default());
        Self { rounding: row.clone(), row, tests, gaps, layout, end: 0, sink }
    }

    fn push(&mut self, row: &[f64], rounding: &[f64], line: Range<u64>) {
        self.layout.pick(row, &mut self.row);
        self.layout.pick(rounding, &mut self.rounding);
        let time = self.row.first().copied().zip(self.rounding.first().copied());
        for (test, places) in self.tests.iter_mut().flatten() {
            let numbers = self.row.get(places.clone()).zip(self.rounding.get(places.clone()));
            if let (Some(time), Some((numbers, rounding))) = (time, numbers) {
                test.push(time, numbers, rounding);
            }
        }
        if let Some((time, values)) = self.row.split_first() {
            self.gaps.push(*time, values);
        }
        self.end = line.end;
        match &mut self.sink {
            Sink::Index(index_builder) => index_builder.push(&self.row, line),
            Sink::Memory(columns) => {
                for (column, value) in columns.iter_mut().zip(&self.row) {
                    column.push(*value);
                }
            }
        }
    }
}

/// Reads a recording and fits its curves. Returns the messages, and the recording unless its header
/// or a row is invalid. `head` reads the header line; `example` is a column name for messages.
pub(super) fn gather(
    input: &Input,
    example: &str,
    head: ReadHeader<'_>,
) -> Result<(Option<Recording>, Messages), String> {
    let mut kept: Option<Collector> = None;
    let Scan { header, mut messages } =
        scan(input.pages(), example, head, |header, row, rounding, line| {
            kept.get_or_insert_with(|| Collector::new(header, input)).push(row, rounding, line);
        })?;
    // After an error in the header or a row, no curve is fitted. Unreadable rows are thus not
    // reported a second time as too few samples.
    let Some((header, page)) = header.filter(|_| !messages.out.has_errors()) else {
        return Ok((None, messages));
    };
    let plan = Plan::of(&header);
    let end = kept.as_ref().map_or(0, |kept| kept.end);
    let tests = kept.as_mut().map(|kept| std::mem::take(&mut kept.tests)).unwrap_or_default();
    let gap = kept.as_mut().and_then(|kept| std::mem::take(&mut kept.gaps).finish());
    let findings = tests.into_iter().map(|test| test.map(|(test, _)| test.finish()));
    let (samples, curves) = match (kept.map(|kept| kept.sink), input) {
        (Some(Sink::Memory(columns)), _) => at_once(&plan, columns),
        (Some(Sink::Index(index_builder)), Input::Stored { store, name }) => {
            match index_builder.finish(store, name) {
                Indexed::Pieces(recorded, finite) => {
                    let signal = |curve| Signal::recorded(&recorded, curve);
                    let curves = finite.into_iter().enumerate();
                    let curves = curves.map(|(curve, finite)| (signal(curve), finite, false));
                    (SampleTimes::recorded(&recorded), curves.collect())
                }
                Indexed::Global if end <= MAX_GLOBAL_BYTES => {
                    return gather(&input.in_memory()?, example, head);
                }
                Indexed::Global => {
                    messages.page = page;
                    refuse(&header, &mut messages, end);
                    return Ok((None, messages));
                }
            }
        }
        (None | Some(Sink::Index(_)), _) => (SampleTimes::from(Arc::from([])), Vec::new()),
    };
    let recorded_curve =
        |(((&column, &interpolation), (signal, is_finite, is_global)), findings)| RecordedCurve {
            column,
            interpolation,
            signal,
            findings,
            is_finite,
            is_global,
        };
    let curves = plan
        .columns
        .iter()
        .zip(&plan.layout.interpolations)
        .zip(curves)
        .zip(findings)
        .map(recorded_curve)
        .collect();
    let recording = Recording { header, header_page: Arc::clone(&page), samples, curves, gap };
    let last = std::mem::replace(&mut messages.page, page);
    recording.check(&mut messages);
    messages.page = last;
    Ok((Some(recording), messages))
}

impl RecordedCurve {
    /// Tests whether noise in the positions makes the accelerations uncertain. Rounding of the
    /// written numbers does not count as noise.
    pub(super) fn is_noisy(&self) -> bool {
        let noise = self.findings.as_ref().and_then(|findings| findings.noise.as_ref());
        noise.is_some_and(|noise| noise.order == 0 && !noise.is_rounding)
    }
}

impl Recording {
    /// Tests whether any coordinate of the recording has noisy positions.
    pub(super) fn is_noisy(&self) -> bool {
        self.curves.iter().any(RecordedCurve::is_noisy)
    }

    /// Reports each curve that contains infinite values or NaN. The current page of `messages` must
    /// be the page that contains the header.
    fn check(&self, messages: &mut Messages) {
        for curve in self.curves.iter().filter(|curve| !curve.is_finite) {
            let Some(column) = self.header.columns.get(curve.column) else { continue };
            let message =
                format!("the spline through the samples of `{}` is not finite", column.name);
            let label = "values too large, or samples too close in time";
            messages.push("samples", message, column.span.clone(), label);
        }
    }
}

/// Fits all curves to samples in memory. Returns the sample times, and for each curve its signal
/// and two flags. The first flag is true if the curve is finite, the second if its spline is long
/// and was solved for all samples at once.
fn at_once(plan: &Plan, mut columns: Vec<Vec<f64>>) -> (SampleTimes, Vec<(Signal, bool, bool)>) {
    let mut take = |place: usize| columns.get_mut(place).map(std::mem::take).unwrap_or_default();
    let times: Arc<[f64]> = take(0).into();
    let curves = plan.layout.curves().map(|(interpolation, places)| {
        let curve = Curve::through(interpolation, &times, places.map(&mut take).collect());
        let (is_finite, is_global) = (curve.is_finite(), curve.is_global());
        (Signal::curve(curve), is_finite, is_global)
    });
    let curves = curves.collect();
    (times.into(), curves)
}

/// Reports a recording that is too large to solve its spline for all samples at once, although its
/// time steps are too unequal to solve it in parts. `end` is the size of the recording in bytes.
/// The current page of `messages` must be the page that contains the header.
fn refuse(header: &Header, messages: &mut Messages, end: u64) {
    let Some(time) = header.time.and_then(|index| header.columns.get(index)) else { return };
    let message = format!(
        "the time steps are too unequal to compute the spline in parts, and the file of {} GB \
         is too large to compute it at once (maximum {} GB)",
        number(end as f64 / 1e9),
        number(MAX_GLOBAL_BYTES as f64 / 1e9)
    );
    let help = "resample the recording in equal steps, or also record velocities and \
                accelerations";
    let label = "time steps too unequal";
    messages.push_help("samples", message, time.span.clone(), label, Some(help.to_owned()));
}
