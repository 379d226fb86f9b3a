//! Instants computed in pieces, on several threads.

use crate::ordered::in_order;
use std::convert::Infallible;
use std::num::NonZero;
use std::ops::Range;

/// Number of successive instants that one thread computes. It does not depend on the number of
/// threads, because each instant starts from the one before it: results are the same on all
/// machines.
pub(super) const PIECE: usize = 256;

/// Computes `count` instants with `work`, which receives the pieces, on all cores.
pub(super) fn by_pieces<T: Send>(
    count: usize,
    work: impl Fn(Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    by_pieces_on(std::thread::available_parallelism().map_or(1, NonZero::get), count, work)
}

fn by_pieces_on<T: Send>(
    threads: usize,
    count: usize,
    work: impl Fn(Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    let mut pieces = (0..count).step_by(PIECE).map(|from| from..count.min(from + PIECE));
    let mut all = Vec::with_capacity(count);
    let receive = |piece: Vec<T>| -> Result<bool, Infallible> {
        all.extend(piece);
        Ok(true)
    };
    let Ok(()) = in_order(threads, || pieces.next(), work, receive);
    all
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
                assert_eq!(by_pieces_on(threads, count, work), expected);
            }
        }
    }
}
