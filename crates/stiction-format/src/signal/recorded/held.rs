//! Cache of one piece per thread.
//!
//! A motion is evaluated many times at nearby instants. Each thread keeps the piece it used last,
//! so that threads which follow the same recording share no lock. A piece stays in memory until its
//! thread ends or needs another piece.

use super::piece::Piece;
use std::cell::RefCell;
use std::sync::Arc;

thread_local! {
    static HELD: RefCell<Option<Arc<Piece>>> = const { RefCell::new(None) };
}

/// Calls `f` with a piece, which is fetched if the thread caches another; `None` if it cannot be
/// fetched.
pub(super) fn with<T>(
    owner: u64,
    index: usize,
    fetch: impl FnOnce() -> Option<Arc<Piece>>,
    look: impl Fn(&Piece) -> T,
) -> Option<T> {
    // The cache of a thread that ends may be gone already.
    let held = HELD.try_with(|held| {
        let held = held.try_borrow().ok()?;
        let piece = held.as_deref()?;
        (piece.owner == owner && piece.index == index).then(|| look(piece))
    });
    if let Ok(Some(found)) = held {
        return Some(found);
    }
    let piece = fetch()?;
    let found = look(&piece);
    // Without a cache the piece is fetched again.
    let _ = HELD.try_with(|held| held.try_borrow_mut().map(|mut held| *held = Some(piece)));
    Some(found)
}
