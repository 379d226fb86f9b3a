//! A part of a recording with its solved curves.

use super::{Recorded, WindowEntry};
use crate::signal::{Curve, Window};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

/// Part of a recording that is in memory: the core samples of one window and the first core sample
/// of the next window.
#[derive(Debug)]
pub(super) struct Piece {
    /// Identifier of the recording. `index` is the index of the window.
    pub(super) owner: u64,
    pub(super) index: usize,
    /// Times of the samples, s.
    pub(super) times: Arc<[f64]>,
    /// Curves through the samples of the piece.
    pub(super) curves: Vec<Curve>,
}

/// Computes a fingerprint of the numbers in the columns of a window.
pub(super) fn fingerprint(columns: &[Vec<f64>]) -> u64 {
    let mut hasher = DefaultHasher::new();
    for column in columns {
        column.len().hash(&mut hasher);
        column.iter().for_each(|value| value.to_bits().hash(&mut hasher));
    }
    hasher.finish()
}

/// Reads the samples of the window number `index` and computes the piece of the spline in this
/// window. Returns an error if the file cannot be read or has changed.
pub(super) fn read(recording: &Recorded, index: usize) -> Result<Piece, String> {
    let changed = || "it has changed since it was first read".to_owned();
    let entry = recording.entries.get(index).ok_or_else(changed)?;
    let text = bytes(recording, entry)?;
    let text = String::from_utf8(text).map_err(|_| changed())?;
    let columns = recording.layout.read(text, entry.bytes.start).ok_or_else(changed)?;
    if fingerprint(&columns) != entry.fingerprint {
        return Err(changed());
    }
    let window = Window::at(Window::begin(index), recording.count);
    piece(recording, index, &window, columns).ok_or_else(changed)
}

fn bytes(recording: &Recorded, entry: &WindowEntry) -> Result<Vec<u8>, String> {
    let length = entry.bytes.end.saturating_sub(entry.bytes.start);
    let mut bytes = vec![0; usize::try_from(length).unwrap_or(0)];
    let mut known = 0;
    while let Some(buffer) = bytes.get_mut(known..).filter(|buffer| !buffer.is_empty()) {
        let most = buffer.len();
        match recording.store.read_at(entry.bytes.start + known as u64, buffer)? {
            0 => return Err("it has become shorter since it was first read".to_owned()),
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
    let next = recording.entries.get(index + 1);
    // The piece ends with the first core sample of the next window, which belongs to the margin of
    // this window.
    let own = window.skip()..window.skip() + window.core.len() + usize::from(next.is_some());
    let known = std::mem::take(columns.first_mut()?);
    let times: Arc<[f64]> = known.get(own.clone())?.into();
    let mut curves = Vec::with_capacity(recording.layout.interpolations.len());
    for (curve, (interpolation, places)) in recording.layout.curves().enumerate() {
        let columns = columns.get_mut(places)?.iter_mut().map(std::mem::take).collect();
        let mut knots = interpolation.knots(&known, columns).get(own.clone())?.to_vec();
        if let Some(next) = next {
            *knots.last_mut()? = *next.knots.get(curve)?;
        }
        curves.push(Curve::of_knots(interpolation, &times, knots));
    }
    Some(Piece { owner: recording.id, index, times, curves })
}
