//! First pass through a recording, window by window, which builds the index.

use super::piece::fingerprint;
use super::{Layout, Recorded, WindowEntry};
use crate::contents::Store;
use crate::signal::{Window, agrees, is_long};
use std::ops::Range;
use std::sync::Arc;
use stiction_core::kinematics::Target;

/// Builds the index of a recording from its rows.
pub(crate) struct IndexBuilder {
    layout: Layout,
    /// Columns of the values that the curves need, from the rows of the next window. `lines`
    /// contains the byte ranges of these rows in the file.
    columns: Vec<Vec<f64>>,
    lines: Vec<Range<u64>>,
    /// Index, in the recording, of the first row in `columns`. `begin` is the index of the first
    /// core sample of the next window.
    first: usize,
    begin: usize,
    entries: Vec<WindowEntry>,
    /// Knots of all curves at the last core sample of the previous window.
    last: Vec<Target<f64>>,
    /// Flag for each curve; true if value, rate and acceleration are finite at all samples.
    finite: Vec<bool>,
    /// True if the knots of a window disagreed with those of the previous window.
    is_global: bool,
}

/// Result of the first pass through a recording.
pub(crate) enum Indexed {
    /// The recording can be read in pieces. The flags, one for each curve, are true if value, rate
    /// and acceleration are finite at all samples.
    Pieces(Arc<Recorded>, Vec<bool>),
    /// The spline of the recording must be solved for all samples at once.
    Global,
}

impl IndexBuilder {
    pub(crate) fn new(layout: Layout) -> Self {
        Self {
            columns: vec![Vec::new(); layout.width()],
            lines: Vec::new(),
            first: 0,
            begin: 0,
            entries: Vec::new(),
            last: Vec::new(),
            finite: vec![true; layout.interpolations.len()],
            is_global: false,
            layout,
        }
    }

    fn count(&self) -> usize {
        self.first + self.lines.len()
    }

    /// Adds a row: the values that the curves need, and the byte range of the row's line in the
    /// file.
    pub(crate) fn push(&mut self, row: &[f64], line: Range<u64>) {
        if self.is_global {
            return;
        }
        for (column, value) in self.columns.iter_mut().zip(row) {
            column.push(*value);
        }
        self.lines.push(line);
        if is_long(self.count() - self.begin) {
            self.close(&Window::at(self.begin, self.count()));
        }
    }

    /// Completes the index after the last row.
    pub(crate) fn finish(mut self, store: &Arc<dyn Store>, name: &str) -> Indexed {
        let count = self.count();
        let end = self.columns.first().and_then(|times| times.last()).copied();
        if self.begin < count && !self.is_global {
            self.close(&Window::at(self.begin, count));
        }
        if self.is_global {
            return Indexed::Global;
        }
        let ends = (count, end.unwrap_or(f64::NAN));
        let recorded = Recorded::new(Arc::clone(store), name, self.layout, self.entries, ends);
        Indexed::Pieces(Arc::new(recorded), self.finite)
    }

    /// Solves a window, adds it to the index, and discards rows that no later window needs.
    fn close(&mut self, window: &Window) {
        if self.entry(window).is_none() {
            self.is_global = true;
            return;
        }
        self.begin = window.core.end;
        let done = Window::at(self.begin, self.count().max(self.begin)).known.start - self.first;
        for column in &mut self.columns {
            column.drain(..done.min(column.len()));
        }
        self.lines.drain(..done.min(self.lines.len()));
        self.first += done;
    }

    /// Computes the index entry of a window and appends it to the index. Returns `None` if the
    /// knots of the window disagree with those of the previous window.
    fn entry(&mut self, window: &Window) -> Option<()> {
        let known = 0..window.known.len();
        let columns: Vec<Vec<f64>> = self
            .columns
            .iter()
            .map(|column| Some(column.get(known.clone())?.to_vec()))
            .collect::<Option<_>>()?;
        let fingerprint = fingerprint(&columns);
        let times = columns.first()?;
        let skip = window.skip();
        let (mut first, mut last) = (Vec::new(), Vec::new());
        for (curve, (interpolation, places)) in self.layout.curves().enumerate() {
            let own = columns.get(places)?;
            let knots = interpolation.knots(times, own.to_vec());
            if let Some(before) = self.last.get(curve)
                && interpolation.reaches_far()
                && !agrees(before, &knots, skip, times, own.first()?)
            {
                return None;
            }
            let asked = knots.get(skip..skip + window.core.len())?;
            let is_finite = |k: &Target<f64>| (k.value + k.rate + k.acceleration).is_finite();
            if let Some(finite) = self.finite.get_mut(curve) {
                *finite &= asked.iter().all(is_finite);
            }
            first.push(*asked.first()?);
            last.push(*asked.last()?);
        }
        let bytes = self.lines.first()?.start..self.lines.get(known.end - 1)?.end;
        self.entries.push(WindowEntry {
            time: *times.get(skip)?,
            knots: first,
            bytes,
            fingerprint,
        });
        self.last = last;
        Some(())
    }
}
