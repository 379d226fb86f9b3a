//! A part of a recording with its solved curves.

use super::{Mark, Recorded};
use crate::signal::{Curve, Window};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

/// The core samples of one window, and the first of the next.
#[derive(Debug)]
pub(super) struct Piece {
    /// Identifies the recording and the window.
    pub(super) owner: u64,
    pub(super) index: usize,
    /// Times of the samples, s.
    pub(super) times: Arc<[f64]>,
    /// Curves between the samples.
    pub(super) curves: Vec<Curve>,
}

/// Fingerprint of columns of numbers.
pub(super) fn fingerprint(columns: &[Vec<f64>]) -> u64 {
    let mut hasher = DefaultHasher::new();
    for column in columns {
        column.len().hash(&mut hasher);
        column.iter().for_each(|value| value.to_bits().hash(&mut hasher));
    }
    hasher.finish()
}

/// Reads the piece of a window; an error if the file has changed.
pub(super) fn read(recording: &Recorded, index: usize) -> Result<Piece, String> {
    let changed = || "it has changed since its begin was read".to_owned();
    let mark = recording.marks.get(index).ok_or_else(changed)?;
    let text = bytes(recording, mark)?;
    let text = String::from_utf8(text).map_err(|_| changed())?;
    let columns = recording.layout.read(text, mark.bytes.start).ok_or_else(changed)?;
    if fingerprint(&columns) != mark.fingerprint {
        return Err(changed());
    }
    let window = Window::at(Window::begin(index), recording.count);
    piece(recording, index, &window, columns).ok_or_else(changed)
}

fn bytes(recording: &Recorded, mark: &Mark) -> Result<Vec<u8>, String> {
    let length = mark.bytes.end.saturating_sub(mark.bytes.start);
    let mut bytes = vec![0; usize::try_from(length).unwrap_or(0)];
    let mut known = 0;
    while let Some(room) = bytes.get_mut(known..).filter(|room| !room.is_empty()) {
        let most = room.len();
        match recording.store.read_at(mark.bytes.start + known as u64, room)? {
            0 => return Err("it has become shorter since its begin was read".to_owned()),
            count => known += count.min(most),
        }
    }
    Ok(bytes)
}

fn piece(
    recording: &Recorded,
    index: usize,
    window: &Window,
    mut columns: Vec<Vec<f64>>,
) -> Option<Piece> {
    let next = recording.marks.get(index + 1);
    // The core ends at the first sample of the next window, whose knots this window contains.
    let own = window.skip()..window.skip() + window.asked.len() + usize::from(next.is_some());
    let known = std::mem::take(columns.first_mut()?);
    let times: Arc<[f64]> = known.get(own.clone())?.into();
    let mut curves = Vec::with_capacity(recording.layout.fills.len());
    for (curve, (fill, places)) in recording.layout.curves().enumerate() {
        let columns = columns.get_mut(places)?.iter_mut().map(std::mem::take).collect();
        let mut knots = fill.knots(&known, columns).get(own.clone())?.to_vec();
        if let Some(next) = next {
            *knots.last_mut()? = *next.knots.get(curve)?;
        }
        curves.push(Curve::of_knots(fill, &times, knots));
    }
    Some(Piece { owner: recording.id, index, times, curves })
}
