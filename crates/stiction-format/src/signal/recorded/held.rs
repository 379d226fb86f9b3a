//! The piece that a thread looks at.
//!
//! A motion is evaluated many times at instants close to each other. Each thread holds on to the piece that
//! it looked at last, so that it need not ask others for it: there is no lock between threads that follow
//! the same recording. One piece for each thread stays in memory until the thread ends or looks elsewhere.

use super::piece::Piece;
use std::cell::RefCell;
use std::sync::Arc;

thread_local! {
    static HELD: RefCell<Option<Arc<Piece>>> = const { RefCell::new(None) };
}

/// Looks at a piece, which is fetched if this thread holds another; nothing if it cannot be.
pub(super) fn with<T>(
    owner: u64,
    index: usize,
    fetch: impl FnOnce() -> Option<Arc<Piece>>,
    look: impl Fn(&Piece) -> T,
) -> Option<T> {
    // A thread that ends may have let go already.
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
    // Where it cannot be held it is fetched again.
    let _ = HELD.try_with(|held| held.try_borrow_mut().map(|mut held| *held = Some(piece)));
    Some(found)
}
