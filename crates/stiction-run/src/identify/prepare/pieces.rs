//! Instants computed in pieces, on several threads.

use crate::ordered::in_order;
use std::convert::Infallible;
use std::num::NonZero;
use std::ops::Range;
use stiction_core::kinematics::State;

/// Number of successive instants that one thread computes. It does not depend on the number of
/// threads, because each instant starts from the one before it: results are the same on all
/// machines.
pub(super) const PIECE: usize = 256;

/// Returns the state of the mechanism from which a piece that begins at `time`, s, starts: the last of
/// `starts` that is not later. `None` if all are later.
pub(super) fn starting(starts: &[(f64, State<f64>)], time: f64) -> Option<&State<f64>> {
    let next = starts.partition_point(|(own, _)| *own <= time);
    next.checked_sub(1).map(|k| &starts[k].1)
}

/// Computes `count` instants with `work`, which receives the pieces, on all cores. `receive` gets the
/// results of the instants in order.
pub(super) fn in_pieces<T: Send>(
    count: usize,
    work: impl Fn(Range<usize>) -> Vec<T> + Sync,
    receive: impl FnMut(T),
) {
    let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
    in_pieces_on(threads, count, work, receive);
}

/// Computes `count` instants as [`in_pieces`] does, and collects the results.
pub(super) fn by_pieces<T: Send>(
    count: usize,
    work: impl Fn(Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    let mut all = Vec::with_capacity(count);
    in_pieces(count, work, |one| all.push(one));
    all
}

fn in_pieces_on<T: Send>(
    threads: usize,
    count: usize,
    work: impl Fn(Range<usize>) -> Vec<T> + Sync,
    mut receive: impl FnMut(T),
) {
    let mut pieces = (0..count).step_by(PIECE).map(|from| from..count.min(from + PIECE));
    let receive = |piece: Vec<T>| -> Result<bool, Infallible> {
        piece.into_iter().for_each(&mut receive);
        Ok(true)
    };
    let Ok(()) = in_order(threads, || pieces.next(), work, receive);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every instant is computed once and in order, and the pieces are those of one thread.
    #[test]
    fn pieces_do_not_depend_on_threads() {
        for count in [0, 1, PIECE - 1, PIECE, PIECE + 1, 7 * PIECE + 3] {
            let work = |piece: Range<usize>| piece.clone().map(|k| (k, piece.start)).collect();
            let expected: Vec<_> = (0..count).map(|k| (k, k / PIECE * PIECE)).collect();
            for threads in [1, 2, 5] {
                let mut found = Vec::new();
                in_pieces_on(threads, count, work, |one| found.push(one));
                assert_eq!(found, expected);
            }
        }
    }
}
