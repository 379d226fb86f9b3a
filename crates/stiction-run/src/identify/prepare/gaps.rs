//! Gaps in a log: intervals without samples.

use super::motion::Used;

/// Time between two successive samples, as a multiple of the sampling interval, above which samples
/// count as missing.
pub(super) const SAMPLES: f64 = 5.0;
/// Duration of the shortest gap-free piece of a log that the filter can process, in periods of the
/// cut-off frequency.
pub(super) const PERIODS: f64 = 4.0;

/// Largest fraction of the intervals between successive samples that can be gaps. If more intervals
/// are longer than [`SAMPLES`] allows, the samples are assumed to arrive in bursts, and the log
/// counts as free of gaps.
const LONG: f64 = 0.05;

/// Returns whether a gap-free piece of a log is long enough for the filter. A piece of exactly the
/// shortest length is accepted, because the cut-off frequency may have been chosen for its length.
pub(super) fn is_long((start, end): (f64, f64), cutoff: f64) -> bool {
    (end - start) * cutoff >= PERIODS * (1.0 - 1e-9)
}

/// Returns the sampling rate outside gaps, 1/s.
pub(super) fn rate(times: &[f64]) -> f64 {
    let steps = || times.windows(2).map(|pair| pair[1] - pair[0]);
    let mut sorted: Vec<f64> = steps().collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let most = SAMPLES * sorted[sorted.len() / 2];
    let (count, sum) = steps()
        .filter(|step| *step <= most)
        .fold((0.0, 0.0), |(n, sum), step| (n + 1.0, sum + step));
    if count < (1.0 - LONG) * sorted.len() as f64 {
        return sorted.len() as f64 / (times[times.len() - 1] - times[0]);
    }
    count / sum
}

/// Returns the start and the end, s, of each gap-free piece of a log. A gap is a time between
/// successive samples that exceeds `gap`, s.
pub(super) fn pieces(times: &[f64], gap: f64) -> Vec<(f64, f64)> {
    times
        .chunk_by(|before, after| after - before <= gap)
        .map(|piece| (piece[0], piece[piece.len() - 1]))
        .collect()
}

/// Returns the duration of the longest gap-free piece, s.
pub(super) fn longest(pieces: &[(f64, f64)]) -> f64 {
    pieces.iter().map(|(start, end)| end - start).fold(0.0, f64::max)
}

/// Returns a caution that names the longest gap and the number of pieces that are too short and
/// therefore left out; `None` if there is no gap.
pub(super) fn caution(used: &Used<'_>, pieces: &[(f64, f64)], cutoff: f64) -> Option<String> {
    let gaps = || pieces.windows(2).map(|pair| (pair[0].1, pair[1].0));
    let (from, until) = gaps().max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))?;
    let row = used.times.partition_point(|t| *t < until);
    let mut text = format!(
        "{}: samples are missing for {:.4} s from {from:.4} s, before line {}",
        used.log.name,
        until - from,
        used.log.log.lines[used.rows[row]]
    );
    match pieces.len() - 2 {
        0 => {}
        1 => text += ", and at one more place",
        others => text += &format!(", and at {others} more places"),
    }
    text += "; nothing is interpolated there";
    let is_short = |piece: &&(f64, f64)| !is_long(**piece, cutoff);
    let short = pieces.iter().filter(is_short).count();
    if short > 0 {
        text += &format!(
            ", and {short} of {} pieces are left out, since they are shorter than {:.4} s",
            pieces.len(),
            PERIODS / cutoff
        );
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_step_is_a_gap_and_does_not_change_the_rate() {
        let mut times: Vec<f64> = (0..100).map(|k| 0.01 * f64::from(k)).collect();
        times.extend((0..100).map(|k| 50.0 + 0.01 * f64::from(k)));
        assert!((rate(&times) - 100.0).abs() < 1e-6);
        // The rate of samples that arrive in bursts of ten is the mean rate.
        let burst = |k: u32| 0.01 * f64::from(k / 10) + 1e-4 * f64::from(k % 10);
        let bursts: Vec<f64> = (0..1000).map(burst).collect();
        assert!((rate(&bursts) - 1000.0).abs() < 10.0, "{}", rate(&bursts));
        let found = pieces(&times, SAMPLES / rate(&times));
        assert_eq!(found, [(0.0, times[99]), (50.0, times[199])]);
    }
}
