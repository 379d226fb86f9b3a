//! Recordings that exceed the available memory.
//!
//! A recording is read once from beginning to end ([`IndexBuilder`]): each row is checked and the
//! curves are solved window by window (a window is a range of samples), but only an index with a
//! few numbers per window is kept. When a window is needed, its text is read and solved again by
//! the same operations, so that results are bit-identical to those of a recording in memory.

mod index_builder;
mod layout;
pub(crate) mod lines;
mod pages;
mod piece;
mod thread_cache;

pub(crate) use index_builder::{IndexBuilder, Indexed};
pub(crate) use layout::Layout;
pub(crate) use pages::Pages;

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

/// Number of recently used pieces of a recording that are kept in memory, in addition to the caches
/// of the threads.
const KEPT: usize = 4;

/// Identifier of the next recording that is indexed.
static NEXT: AtomicU64 = AtomicU64::new(0);

/// Index of a recording, and its recently used pieces.
#[derive(Debug)]
pub(crate) struct Recorded {
    id: u64,
    store: Arc<dyn Store>,
    name: String,
    layout: Layout,
    entries: Vec<WindowEntry>,
    count: usize,
    /// Time of the last sample, s.
    end: f64,
    /// Recently used pieces of the recording, the most recent one last.
    pieces: Mutex<Vec<Arc<Piece>>>,
    /// Diagnostic of the first failed read. All later reads fail as well, so that results from
    /// changed data are never used.
    fault: OnceLock<Diagnostic>,
}

/// Index entry of a window.
#[derive(Debug)]
struct WindowEntry {
    /// Time, s, of the first sample in the core of the window, that is, in the window without its
    /// margins.
    time: f64,
    /// Value, rate and acceleration of all curves at the first sample in the core of the window.
    knots: Vec<Target<f64>>,
    /// Byte range, in the file, of the lines of all samples of the window.
    bytes: Range<u64>,
    /// Fingerprint of the numbers in the lines of the window, which shows whether the file has
    /// changed.
    fingerprint: u64,
}

impl Recorded {
    fn new(
        store: Arc<dyn Store>,
        name: &str,
        layout: Layout,
        entries: Vec<WindowEntry>,
        (count, end): (usize, f64),
    ) -> Self {
        Self {
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            store,
            name: name.to_owned(),
            layout,
            entries,
            count,
            end,
            pieces: Mutex::default(),
            fault: OnceLock::new(),
        }
    }

    /// Number of samples.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Times of the first and last sample, s.
    pub(crate) fn ends(&self) -> Option<(f64, f64)> {
        self.entries.first().map(|entry| (entry.time, self.end))
    }

    /// Evaluates a curve at `t`, s; NaN after a failed read.
    pub(crate) fn at(&self, curve: usize, t: f64) -> Target<f64> {
        let read = |piece: &Piece| piece.curves.get(curve).map(|curve| curve.at(t));
        let nothing = Target { value: f64::NAN, rate: f64::NAN, acceleration: f64::NAN };
        self.with(self.window_at(t), read).flatten().unwrap_or(nothing)
    }

    /// Time of a sample, s; for an index beyond the last sample, the time of the last one; NaN after a failed read.
    pub(crate) fn instant(&self, sample: usize) -> f64 {
        if sample + 1 >= self.count {
            return self.end;
        }
        let index = Window::of(sample, self.entries.len());
        let read = |piece: &Piece| piece.times.get(sample - Window::begin(index)).copied();
        self.with(index, read).flatten().unwrap_or(f64::NAN)
    }

    /// Time of the first sample after `t`, s; `None` if no sample follows.
    pub(crate) fn after(&self, t: f64) -> Option<f64> {
        self.with(self.window_at(t), |piece| first_after(&piece.times, t)).flatten()
    }

    /// Reads the piece that contains the time `t`, s, if it is not in memory. Returns the
    /// diagnostic of the failed read if this or an earlier read failed.
    pub(crate) fn fault_at(&self, t: f64) -> Option<Diagnostic> {
        self.with(self.window_at(t), |_| ());
        self.fault.get().cloned()
    }

    /// Index of the window that contains the time `t`, s.
    fn window_at(&self, t: f64) -> usize {
        self.entries.partition_point(|entry| entry.time <= t).saturating_sub(1)
    }

    fn with<T>(&self, index: usize, read: impl Fn(&Piece) -> T) -> Option<T> {
        if self.fault.get().is_some() {
            return None;
        }
        thread_cache::with(self.id, index, || self.fetch(index), read)
    }

    /// Returns the piece of a window, shared between threads, and reads it if it is not in memory.
    /// Other threads wait meanwhile, because they usually need the same piece.
    fn fetch(&self, index: usize) -> Option<Arc<Piece>> {
        // After a panic on another thread, the list contains only complete pieces.
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
        let time = self.entries.get(index).map_or(f64::NAN, |entry| entry.time);
        let message = format!(
            "the recording cannot be read again at t = {} s: {why}",
            crate::diagnostic::number(time)
        );
        let place = Place::new(&Arc::new(Source::new(self.name.as_str(), "")), 0..0);
        Diagnostic::error("file", message).at(place, "").help(
            "a long recording is read again while it is in use: keep the file unchanged, or \
             use a copy",
        )
    }
}
