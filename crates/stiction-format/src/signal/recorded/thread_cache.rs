//! Cache of one piece of a recording per thread.
//!
//! A motion is evaluated many times at nearby instants. Each thread keeps the piece that it used last, so that
//! threads which follow the same recording need no common lock. A piece remains in memory until the thread ends or
//! needs another piece.

use super::piece::Piece;
use std::cell::RefCell;
use std::sync::Arc;

thread_local! {
    static CACHED: RefCell<Option<Arc<Piece>>> = const { RefCell::new(None) };
}

/// Calls `read` with the piece of the recording `owner` and the window `index`. The piece is
/// fetched if the thread caches another one; returns `None` if it cannot be fetched.
pub(super) fn with<T>(
    owner: u64,
    index: usize,
    fetch: impl FnOnce() -> Option<Arc<Piece>>,
    read: impl Fn(&Piece) -> T,
) -> Option<T> {
    // The thread-local cache may already be destroyed at the end of a thread.
    let cached = CACHED.try_with(|cached| {
        let cached = cached.try_borrow().ok()?;
        let piece = cached.as_deref()?;
        (piece.owner == owner && piece.index == index).then(|| read(piece))
    });
    if let Ok(Some(found)) = cached {
        return Some(found);
    }
    let piece = fetch()?;
    let found = read(&piece);
    // If the piece cannot be cached, the next call fetches it again.
    let _ =
        CACHED.try_with(|cached| cached.try_borrow_mut().map(|mut cached| *cached = Some(piece)));
    Some(found)
}
