//! Instants computed in pieces, on several threads.

use crate::ordered::in_order;
use std::convert::Infallible;
use std::num::NonZero;
use std::ops::Range;
use stiction_core::kinematics::State;

/// Number of instants after which a state of the mechanism is stored, from which a piece starts. It does
/// not depend on the number of threads, because each instant starts from the one before it: results are
/// the same on all machines.
pub(super) const PIECE: usize = 256;

/// Divides the instants at `times`, s, into pieces. Each piece except the first begins at the first instant that is
/// not earlier than one of the stored states `starts`, so it starts from a state of its own neighbourhood. A search
/// from a distant state can end in another assembly mode. Without states there is one piece.
pub(super) fn pieces(times: &[f64], starts: &[(f64, State<f64>)]) -> Vec<Range<usize>> {
    let mut cuts = vec![0];
    for (time, _) in starts {
        let next = times.partition_point(|own| own < time);
        // Additional states, such as those at the start of dwells, do not make the pieces short.
        if next >= cuts[cuts.len() - 1] + PIECE / 2 {
            cuts.push(next);
        }
    }
    cuts.retain(|cut| *cut < times.len());
    let ends = cuts.iter().skip(1).copied().chain([times.len()]);
    cuts.iter().zip(ends).map(|(from, end)| *from..end).collect()
}

/// Returns the state of the mechanism from which a piece that begins at `time`, s, starts: the last of
/// `starts` that is not later. `None` if all are later.
pub(super) fn starting(starts: &[(f64, State<f64>)], time: f64) -> Option<&State<f64>> {
    let next = starts.partition_point(|(own, _)| *own <= time);
    next.checked_sub(1).map(|k| &starts[k].1)
}

/// Computes the instants of `pieces` with `work`, which receives one piece at a time, on all cores. `receive` gets the
/// results of the instants in order.
pub(super) fn in_pieces<T: Send>(
    pieces: Vec<Range<usize>>,
    work: impl Fn(Range<usize>) -> Vec<T> + Sync,
    receive: impl FnMut(T),
) {
    let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
    in_pieces_on(threads, pieces, work, receive);
}

/// Computes the instants of `pieces` as [`in_pieces`] does, and collects the results.
pub(super) fn by_pieces<T: Send>(
    pieces: Vec<Range<usize>>,
    work: impl Fn(Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    let mut all = Vec::with_capacity(pieces.last().map_or(0, |last| last.end));
    in_pieces(pieces, work, |one| all.push(one));
    all
}

fn in_pieces_on<T: Send>(
    threads: usize,
    pieces: Vec<Range<usize>>,
    work: impl Fn(Range<usize>) -> Vec<T> + Sync,
    mut receive: impl FnMut(T),
) {
    let mut pieces = pieces.into_iter();
    let receive = |piece: Vec<T>| -> Result<bool, Infallible> {
        piece.into_iter().for_each(&mut receive);
        Ok(true)
    };
    let Ok(()) = in_order(threads, || pieces.next(), work, receive);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(value: f64) -> State<f64> {
        State { coordinates: vec![value], rates: vec![0.0], accelerations: vec![0.0] }
    }

    /// Every instant is computed once and in order, whatever the number of threads.
    #[test]
    fn pieces_do_not_depend_on_threads() {
        let work = |piece: Range<usize>| piece.clone().map(|k| (k, piece.start)).collect();
        let pieces = vec![0..250, 250..600, 600..601];
        let expected: Vec<_> =
            pieces.iter().flat_map(|piece| piece.clone().map(|k| (k, piece.start))).collect();
        for threads in [1, 2, 5] {
            let mut found = Vec::new();
            in_pieces_on(threads, pieces.clone(), work, |one| found.push(one));
            assert_eq!(found, expected);
        }
    }

    /// Instants may be inserted or left out after states are stored. Every piece still starts from the state of its first
    /// instant, or of the instant just before it.
    #[test]
    fn pieces_start_from_their_own_states() {
        let grid: Vec<f64> = (0..1000).map(f64::from).collect();
        let starts: Vec<_> = grid.iter().step_by(PIECE).map(|time| (*time, state(*time))).collect();
        // Instants are inserted at the beginning, and the instant of a stored state is left out.
        let mut times: Vec<f64> = (0..7).map(|k| 0.1 + 0.1 * f64::from(k)).chain(grid).collect();
        times.retain(|time| *time != 512.0);
        times.sort_by(f64::total_cmp);
        let found = pieces(&times, &starts);
        assert_eq!(found.len(), 4);
        assert_eq!((found[0].start, found[3].end), (0, times.len()));
        for (piece, next) in found.iter().zip(&found[1..]) {
            assert_eq!(piece.end, next.start);
        }
        for piece in &found {
            let begin = times[piece.start];
            let from = starting(&starts, begin).unwrap().coordinates[0];
            assert!(begin - from <= 1.0, "{from} for {begin}");
        }
        let whole = pieces(&times, &[]);
        assert_eq!((whole.len(), &whole[0]), (1, &(0..times.len())));
        // States just after one another do not make more pieces.
        let dense: Vec<_> = (0..1000).map(|k| (f64::from(k), state(0.0))).collect();
        let found = pieces(&times, &dense);
        let (last, others) = found.split_last().unwrap();
        assert_eq!((last.end, found.len()), (times.len(), times.len().div_ceil(PIECE / 2)));
        assert!(others.iter().all(|piece| piece.len() == PIECE / 2), "{found:?}");
    }
}
