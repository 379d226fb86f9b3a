//! Curves from rows: solved at once for a text in memory, otherwise through an index.

use super::header::Header;
use super::messages::Messages;
use super::plan::Plan;
use super::scan::{Scan, scan};
use super::tape::Tape;
use crate::diagnostic::number;
use crate::signal::recorded::lines::Line;
use crate::signal::recorded::{Found, Layout, Survey};
use crate::signal::samples::SampleTimes;
use crate::signal::{Curve, Fill, Signal};
use std::ops::Range;
use std::sync::Arc;

/// Maximum size of a recording whose spline is solved globally, bytes; the solution needs several
/// times as much memory.
const MOST_AT_ONCE: u64 = 1 << 30;

/// A valid recording.
pub(super) struct Gathered {
    pub(super) header: Header,
    pub(super) samples: SampleTimes,
    pub(super) curves: Vec<Curved>,
}

/// A curve of a recording.
pub(super) struct Curved {
    /// Column of its values.
    pub(super) column: usize,
    pub(super) fill: Fill,
    pub(super) signal: Signal,
    is_finite: bool,
    /// True if it is long and nevertheless needed one global solution.
    pub(super) is_stiff: bool,
}

/// Collector of the rows while they are read.
struct Kept {
    layout: Layout,
    /// Kept numbers of one row.
    row: Vec<f64>,
    /// End of its line in the file.
    end: u64,
    sink: Sink,
}

enum Sink {
    Memory(Vec<Vec<f64>>),
    Index(Survey),
}

impl Kept {
    fn new(header: &Header, tape: &Tape) -> Self {
        let layout = Plan::of(header).layout;
        let sink = match tape {
            Tape::Whole(_) => Sink::Memory(vec![Vec::new(); layout.width()]),
            Tape::Stored { .. } => Sink::Index(Survey::new(layout.clone())),
        };
        Self { row: vec![0.0; layout.width()], layout, end: 0, sink }
    }

    fn push(&mut self, row: &[f64], line: Range<u64>) {
        self.layout.pick(row, &mut self.row);
        self.end = line.end;
        match &mut self.sink {
            Sink::Index(survey) => survey.push(&self.row, line),
            Sink::Memory(columns) => {
                for (column, value) in columns.iter_mut().zip(&self.row) {
                    column.push(*value);
                }
            }
        }
    }
}

/// Reads a recording; of an invalid one only the messages are returned.
pub(super) fn gather(
    tape: &Tape,
    example: &str,
    head: &dyn Fn(&str, Line, &mut Messages) -> Header,
) -> Result<(Option<Gathered>, Messages), String> {
    let mut kept: Option<Kept> = None;
    let Scan { header, mut messages } = scan(tape.pages(), example, head, |header, row, line| {
        kept.get_or_insert_with(|| Kept::new(header, tape)).push(row, line);
    })?;
    // Rows that could not be read do not count as missing.
    let Some((header, page)) = header.filter(|_| !messages.out.has_errors()) else {
        return Ok((None, messages));
    };
    let plan = Plan::of(&header);
    let end = kept.as_ref().map_or(0, |kept| kept.end);
    let (samples, curves) = match (kept.map(|kept| kept.sink), tape) {
        (Some(Sink::Memory(columns)), _) => at_once(&plan, columns),
        (Some(Sink::Index(survey)), Tape::Stored { store, name }) => {
            match survey.finish(store, name) {
                Found::Pieces(recorded, finite) => {
                    let signal = |curve| Signal::recorded(&recorded, curve);
                    let curves = finite.into_iter().enumerate();
                    let curves = curves.map(|(curve, finite)| (signal(curve), finite, false));
                    (SampleTimes::recorded(&recorded), curves.collect())
                }
                Found::Stiff if end <= MOST_AT_ONCE => {
                    return gather(&tape.in_memory()?, example, head);
                }
                Found::Stiff => {
                    messages.page = page;
                    refuse(&header, &mut messages, end);
                    return Ok((None, messages));
                }
            }
        }
        (None | Some(Sink::Index(_)), _) => (SampleTimes::from(Arc::from([])), Vec::new()),
    };
    let curved = |((&column, &fill), (signal, is_finite, is_stiff))| Curved {
        column,
        fill,
        signal,
        is_finite,
        is_stiff,
    };
    let curves = plan.columns.iter().zip(&plan.layout.fills).zip(curves).map(curved).collect();
    let gathered = Gathered { header, samples, curves };
    let last = std::mem::replace(&mut messages.page, page);
    gathered.check(&mut messages);
    messages.page = last;
    Ok((Some(gathered), messages))
}

impl Gathered {
    /// Reports curves that are not finite. The page is that of the header.
    fn check(&self, messages: &mut Messages) {
        for curve in self.curves.iter().filter(|curve| !curve.is_finite) {
            let Some(column) = self.header.columns.get(curve.column) else { continue };
            let message = format!("no spline goes through the samples of `{}`", column.name);
            let label = "the samples are too large, or too close in time";
            messages.push("samples", message, column.span.clone(), label);
        }
    }
}

/// The samples' times, and for each curve two flags: finite, and solved globally.
fn at_once(plan: &Plan, mut columns: Vec<Vec<f64>>) -> (SampleTimes, Vec<(Signal, bool, bool)>) {
    let mut take = |place: usize| columns.get_mut(place).map(std::mem::take).unwrap_or_default();
    let times: Arc<[f64]> = take(0).into();
    let curves = plan.layout.curves().map(|(fill, places)| {
        let curve = Curve::through(fill, &times, places.map(&mut take).collect());
        let (is_finite, is_stiff) = (curve.is_finite(), curve.is_stiff());
        (Signal::curve(curve), is_finite, is_stiff)
    });
    let curves = curves.collect();
    (times.into(), curves)
}

/// The page is that of the header.
fn refuse(header: &Header, messages: &mut Messages, end: u64) {
    let Some(time) = header.time.and_then(|index| header.columns.get(index)) else { return };
    let message = format!(
        "the steps are so unequal that the spline must be solved at once, for which {} GB are too much; \
         the most is {} GB",
        number(end as f64 / 1e9),
        number(MOST_AT_ONCE as f64 / 1e9)
    );
    let help = "record velocities and accelerations, too, which leaves nothing to solve, or resample the \
                recording in even steps";
    let label = "neighbouring samples are too unequally apart";
    messages.push_help("samples", message, time.span.clone(), label, Some(help.to_owned()));
}
