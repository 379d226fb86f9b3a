//! Recordings that are too long for the memory.
//!
//! A recording is read once from its begin to its end ([`Survey`]): every row is checked, every window solved,
//! and of all that only an index is kept, some numbers for each window. Later the text of a window is
//! read again when it is asked for, and solved again, by the same operations: so results are those of a
//! recording that is kept as a whole, to the last bit.

mod held;
mod layout;
pub(crate) mod lines;
mod pages;
mod piece;
mod survey;

pub(crate) use layout::Layout;
pub(crate) use pages::Pages;
pub(crate) use survey::{Found, Survey};

use crate::contents::Store;
use crate::diagnostic::Diagnostic;
use crate::signal::Window;
use crate::signal::samples::first_after;
use crate::source::{Place, Source};
use piece::Piece;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use stiction_core::kinematics::Target;

/// So many pieces are kept beside those that threads hold: neighbours of what is being looked at.
const KEPT: usize = 4;

/// Tells recordings from each other.
static NEXT: AtomicU64 = AtomicU64::new(0);

/// The index of a recording, and the pieces of it that are being looked at.
#[derive(Debug)]
pub(crate) struct Recorded {
    id: u64,
    store: Arc<dyn Store>,
    name: String,
    layout: Layout,
    marks: Vec<Mark>,
    count: usize,
    /// The last instant, s.
    end: f64,
    /// The piece that was fetched last at the end.
    pieces: Mutex<Vec<Arc<Piece>>>,
    /// Why it cannot be read any more. It stays: nothing is made of what was read later.
    fault: OnceLock<Diagnostic>,
}

/// Where a window is, and what else must be known of it.
#[derive(Debug)]
struct Mark {
    /// The instant of the first sample that it is asked for, s.
    time: f64,
    /// The knots of all curves there.
    knots: Vec<Target<f64>>,
    /// The lines of all samples that it knows.
    bytes: Range<u64>,
    /// Of the numbers in these lines.
    fingerprint: u64,
}

impl Recorded {
    fn new(
        store: Arc<dyn Store>,
        name: &str,
        layout: Layout,
        marks: Vec<Mark>,
        (count, end): (usize, f64),
    ) -> Self {
        Self {
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            store,
            name: name.to_owned(),
            layout,
            marks,
            count,
            end,
            pieces: Mutex::default(),
            fault: OnceLock::new(),
        }
    }

    /// How many samples there are.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The first and the last instant, s.
    pub(crate) fn ends(&self) -> Option<(f64, f64)> {
        self.marks.first().map(|mark| (mark.time, self.end))
    }

    /// The value of a curve at `t`; NaN if the recording cannot be read any more.
    pub(crate) fn at(&self, curve: usize, t: f64) -> Target<f64> {
        let look = |piece: &Piece| piece.curves.get(curve).map(|curve| curve.at(t));
        let nothing = Target { value: f64::NAN, rate: f64::NAN, acceleration: f64::NAN };
        self.with(self.window_at(t), look).flatten().unwrap_or(nothing)
    }

    /// The instant of a sample, s; that of the last for any beyond, NaN if the recording cannot be read
    /// any more.
    pub(crate) fn instant(&self, sample: usize) -> f64 {
        if sample + 1 >= self.count {
            return self.end;
        }
        let index = Window::of(sample, self.marks.len());
        let look = |piece: &Piece| piece.times.get(sample - Window::begin(index)).copied();
        self.with(index, look).flatten().unwrap_or(f64::NAN)
    }

    /// The first instant of a sample after `t`, s; nothing after the last.
    pub(crate) fn after(&self, t: f64) -> Option<f64> {
        self.with(self.window_at(t), |piece| first_after(&piece.times, t)).flatten()
    }

    /// Why there is no value at `t`, or was none elsewhere, if the recording cannot be read any more.
    pub(crate) fn fault_at(&self, t: f64) -> Option<Diagnostic> {
        self.with(self.window_at(t), |_| ());
        self.fault.get().cloned()
    }

    /// The window whose samples surround an instant.
    fn window_at(&self, t: f64) -> usize {
        self.marks.partition_point(|mark| mark.time <= t).saturating_sub(1)
    }

    fn with<T>(&self, index: usize, look: impl Fn(&Piece) -> T) -> Option<T> {
        if self.fault.get().is_some() {
            return None;
        }
        held::with(self.id, index, || self.fetch(index), look)
    }

    /// A piece that others have, or that is read now. Others wait, as they most likely want the same.
    fn fetch(&self, index: usize) -> Option<Arc<Piece>> {
        // A thread that panicked has left whole pieces.
        let mut pieces = self.pieces.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = pieces.iter().position(|piece| piece.index == index) {
            let piece = pieces.remove(known);
            pieces.push(Arc::clone(&piece));
            return Some(piece);
        }
        if self.fault.get().is_some() {
            return None;
        }
        match piece::read(self, index) {
            Ok(piece) => {
                let piece = Arc::new(piece);
                if pieces.len() >= KEPT {
                    pieces.remove(0);
                }
                pieces.push(Arc::clone(&piece));
                Some(piece)
            }
            Err(why) => {
                self.fault.get_or_init(|| self.explain(index, &why));
                None
            }
        }
    }

    fn explain(&self, index: usize, why: &str) -> Diagnostic {
        let time = self.marks.get(index).map_or(f64::NAN, |mark| mark.time);
        let message = format!(
            "the recording cannot be read again at t = {} s: {why}",
            crate::diagnostic::number(time)
        );
        let place = Place::new(&Arc::new(Source::new(self.name.as_str(), "")), 0..0);
        Diagnostic::error("file", message).at(place, "").help(
            "a long recording is read piece by piece as it is followed: leave the file as it is \
             meanwhile, or work with a copy",
        )
    }
}
