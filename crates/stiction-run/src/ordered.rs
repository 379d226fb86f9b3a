//! Parallel execution of independent pieces of work, with results in the order of the pieces.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Computes pieces of work in parallel and returns their results in order. `next` returns one piece
/// after another until it returns `None`. Each piece is computed by `work` on one of `threads`
/// threads, and `receive` gets the results on the caller's thread, in the order of the pieces. The
/// function ends early if `receive` returns false or an error.
///
/// At most one finished result per thread waits for earlier results, which bounds the memory use.
///
/// # Errors
/// Returns the error of `receive`.
pub fn in_order<I: Send, T: Send, E>(
    threads: usize,
    mut next: impl FnMut() -> Option<I> + Send,
    work: impl Fn(I) -> T + Sync,
    mut receive: impl FnMut(T) -> Result<bool, E>,
) -> Result<(), E> {
    if threads <= 1 {
        while let Some(piece) = next() {
            if !receive(work(piece))? {
                break;
            }
        }
        return Ok(());
    }
    let board = Board::new(threads);
    // Number of pieces that the threads have started so far, and the source of the pieces.
    let pieces = Mutex::new((0, next));
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                // Waiting threads are notified when this thread ends early.
                let _leaving = Leaving(&board);
                while board.has_room() {
                    let (place, piece) = {
                        let (taken, next) = &mut *lock(&pieces);
                        let Some(piece) = next() else { break };
                        *taken += 1;
                        (*taken - 1, piece)
                    };
                    board.put(place, work(piece));
                }
            });
        }
        // All threads are released on every exit path.
        let _closing = Closing(&board);
        let mut place = 0;
        while let Some(done) = board.take(place) {
            if !receive(done)? {
                break;
            }
            place += 1;
        }
        Ok(())
    })
}

/// Exchange of results between the worker threads and the receiving thread.
struct Board<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
    is_closed: AtomicBool,
    most: usize,
}

struct State<T> {
    done: BTreeMap<usize, T>,
    /// Number of pieces that are in progress, or finished and waiting for `receive`.
    under_way: usize,
    workers: usize,
}

/// Locks a mutex even if another thread panicked while it held the lock. This is safe, because no
/// thread leaves the data partially changed.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<T> Board<T> {
    fn new(workers: usize) -> Self {
        Self {
            state: Mutex::new(State { done: BTreeMap::new(), under_way: 0, workers }),
            changed: Condvar::new(),
            is_closed: AtomicBool::new(false),
            // Each thread may have one piece in progress and one waiting.
            most: 2 * workers + 1,
        }
    }

    /// Waits until another piece may start. Returns false if no more pieces are needed.
    fn has_room(&self) -> bool {
        let mut state = lock(&self.state);
        while state.under_way >= self.most && !self.is_closed.load(Ordering::Relaxed) {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        state.under_way += 1;
        !self.is_closed.load(Ordering::Relaxed)
    }

    fn put(&self, place: usize, done: T) {
        lock(&self.state).done.insert(place, done);
        self.changed.notify_all();
    }

    /// Waits for the result of the piece with index `place`; `None` if this result cannot arrive
    /// any more.
    fn take(&self, place: usize) -> Option<T> {
        let mut state = lock(&self.state);
        loop {
            if let Some(done) = state.done.remove(&place) {
                state.under_way -= 1;
                self.changed.notify_all();
                return Some(done);
            }
            if state.workers == 0 {
                return None;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Guard that registers the end of a worker thread when the guard is dropped.
struct Leaving<'b, T>(&'b Board<T>);

impl<T> Drop for Leaving<'_, T> {
    fn drop(&mut self) {
        lock(&self.0.state).workers -= 1;
        self.0.changed.notify_all();
    }
}

/// Guard that stops all worker threads when the guard is dropped.
struct Closing<'b, T>(&'b Board<T>);

impl<T> Drop for Closing<'_, T> {
    fn drop(&mut self) {
        // While the lock is held, no thread can begin to wait and miss the notification.
        let _state = lock(&self.0.state);
        self.0.is_closed.store(true, Ordering::Relaxed);
        self.0.changed.notify_all();
    }
}
