//! Placement of instants at reversals of friction, so that the regression columns change their sign
//! between the same two samples as the measured efforts.
//!
//! A sampled signal does not show where between two samples it jumps. On an independent time grid,
//! the columns would jump at other instants than the measured efforts, with the same error in all
//! logs of one motion. This error would be a bias that the standard deviations do not contain. If
//! the efforts lag behind the positions by an unknown delay, the jumps are placed at the reversals
//! themselves. Jumps between samples would otherwise pull the estimated delay to a whole number of
//! samples.

use super::filter::{RowFilter, within};
use super::motion::Motion;
use super::pieces::PIECE;
use stiction_core::kinematics::{State, Target};
use stiction_identify::Regressor;

/// Distance between two instants, as a fraction of the interval between successive instants, below
/// which both count as one instant.
const SAME: f64 = 1e-3;

/// Returns the common delay of the efforts of all channels, s; `None` if the delays are unknown, or
/// if they differ by more than a quarter of a sample.
pub(super) fn common_delay(delays: Option<&[f64]>, rate: f64) -> Option<f64> {
    let delays = delays?;
    let (low, high) = delays
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(*d), high.max(*d)));
    (high - low <= 0.25 / rate).then_some(0.5 * (low + high))
}

/// Replaces the instants of a motion near each reversal of a joint by two times: the last effort
/// sample before the reversal and the first effort sample after it. If the delay of the efforts is
/// unknown, the times are immediately before and after the reversal instead. Returns times, s, and
/// states of the mechanism at some instants, none for a table of steady motions.
pub(super) fn refine(
    regressor: &Regressor,
    motion: &mut Motion,
    (samples, delay): (&[f64], Option<f64>),
) -> Vec<(f64, State<f64>)> {
    let mut starts = Vec::new();
    let RowFilter::LowPass(pieces) = &motion.filter else { return starts };
    let mut found = Vec::new();
    let mut from = regressor.clone();
    for (_, ends) in pieces {
        let own = within(&motion.times, *ends);
        let sliding: Vec<Option<Vec<[f64; 3]>>> = own
            .clone()
            .map(|k| {
                let [q, v, a] = split(&motion.targets[k]);
                let sliding = from.sliding(&q, &v, &a);
                if k % PIECE == 0 && sliding.is_some() {
                    starts.push((motion.times[k], from.state().clone()));
                }
                sliding
            })
            .collect();
        for (k, pair) in sliding.windows(2).enumerate() {
            let [Some(before), Some(after)] = pair else { continue };
            let [start, end] = [0, 1].map(|next| motion.times[own.start + k + next]);
            for (a, b) in before.iter().zip(after) {
                let Some(part) = reversal(a, b) else { continue };
                let time = start + part * (end - start);
                let (last, next) = match delay {
                    Some(delay) => {
                        let next = samples.partition_point(|sample| sample - delay <= time);
                        let last = next.checked_sub(1).and_then(|k| samples.get(k));
                        let (Some(last), Some(next)) = (last, samples.get(next)) else { continue };
                        (last - delay, next - delay)
                    }
                    None => {
                        let near = 2.0 * SAME * (end - start);
                        (time - near, time + near)
                    }
                };
                if ends.0 <= last && next <= ends.1 {
                    found.push((last, next));
                }
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.dedup();
    insert(motion, &found);
    starts
}

/// Returns the fraction of the way from the velocity `before` to the velocity `after` at which the
/// motion reverses; `None` if the motion does not reverse.
fn reversal(before: &[f64; 3], after: &[f64; 3]) -> Option<f64> {
    let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    if dot(before, after) >= 0.0 {
        return None;
    }
    let change = std::array::from_fn(|k| before[k] - after[k]);
    // Instant of least speed if the velocity changes linearly with time.
    Some((dot(before, &change) / dot(&change, &change)).clamp(0.0, 1.0))
}

/// Replaces the instants inside each bracket, a pair of times in s, by the two ends of the bracket.
fn insert(motion: &mut Motion, brackets: &[(f64, f64)]) {
    let times = std::mem::take(&mut motion.times);
    let targets = std::mem::take(&mut motion.targets);
    let mut all: Vec<(f64, Vec<Target<f64>>)> = Vec::with_capacity(times.len());
    // Instants within a rounding error of an end of a bracket do not count as inside, so the ends
    // themselves remain.
    let is_within = |time: f64| {
        let next = brackets.partition_point(|(start, _)| *start < time);
        next.checked_sub(1).is_some_and(|k| {
            let (start, end) = brackets[k];
            let near = SAME * (end - start);
            time > start + near && time < end - near
        })
    };
    for &time in brackets.iter().flat_map(|(start, end)| [start, end]) {
        let next = times.partition_point(|t| *t < time);
        let Some(before) = next.checked_sub(1) else { continue };
        let Some(&end) = times.get(next) else { continue };
        let ends = [times[before], end];
        let near = SAME * (end - ends[0]);
        if !is_within(time) && ends.iter().all(|t| (t - time).abs() > near) {
            let each = targets[before].iter().zip(&targets[next]);
            all.push((time, each.map(|(a, b)| between(ends, [a, b], time)).collect()));
        }
    }
    all.extend(times.into_iter().zip(targets).filter(|(time, _)| !is_within(*time)));
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.dedup_by(|a, b| a.0 == b.0);
    (motion.times, motion.targets) = all.into_iter().unzip();
}

/// Interpolates the motion between two instants by the polynomial of fifth degree that matches
/// position, rate and acceleration at both instants. All times are in s.
fn between([start, end]: [f64; 2], [a, b]: [&Target<f64>; 2], time: f64) -> Target<f64> {
    let h = end - start;
    let u = (time - start) / h;
    // Rates and accelerations in units of the interval between the instants.
    let (v0, v1) = (a.rate * h, b.rate * h);
    let (a0, a1) = (a.acceleration * h * h, b.acceleration * h * h);
    let d = b.value - a.value;
    let c3 = 10.0 * d - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1;
    let c4 = -15.0 * d + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1;
    let c5 = 6.0 * d - 3.0 * (v0 + v1) - 0.5 * (a0 - a1);
    Target {
        value: a.value + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5)))),
        rate: (v0 + u * (a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h,
        acceleration: (a0 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (h * h),
    }
}

/// Splits the motions of all coordinates into positions, rates and accelerations.
pub(super) fn split(targets: &[Target<f64>]) -> [Vec<f64>; 3] {
    [
        targets.iter().map(|t| t.value).collect(),
        targets.iter().map(|t| t.rate).collect(),
        targets.iter().map(|t| t.acceleration).collect(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target(t: f64) -> Target<f64> {
        Target { value: t.powi(5), rate: 5.0 * t.powi(4), acceleration: 20.0 * t.powi(3) }
    }

    /// Tests that a polynomial of fifth degree is interpolated exactly, and that instants inside a
    /// bracket are removed.
    #[test]
    fn instants_between_the_samples_of_a_reversal_give_way() {
        let times: Vec<f64> = (0..=10).map(|k| 0.1 * f64::from(k)).collect();
        let mut motion = Motion {
            targets: times.iter().map(|t| vec![target(*t)]).collect(),
            times,
            rate_noise: Vec::new(),
            filter: RowFilter::Unfiltered,
            cutoff: None,
            rows: Vec::new(),
        };
        // The second bracket begins at an instant of the grid.
        insert(&mut motion, &[(0.28, 0.34), (0.7 - 1e-15, 0.75)]);
        let expected = [0.0, 0.1, 0.2, 0.28, 0.34, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.9, 1.0];
        assert_eq!(motion.times.len(), expected.len(), "{:?}", motion.times);
        for ((time, targets), expected) in motion.times.iter().zip(&motion.targets).zip(expected) {
            assert!((time - expected).abs() < 1e-12, "{:?}", motion.times);
            let (found, exact) = (targets[0], target(*time));
            for (a, b) in [
                (found.value, exact.value),
                (found.rate, exact.rate),
                (found.acceleration, exact.acceleration),
            ] {
                assert!((a - b).abs() < 1e-10, "{time}: {found:?} {exact:?}");
            }
        }
    }

    #[test]
    fn delays_are_common_within_a_quarter_of_a_sample() {
        assert_eq!(common_delay(None, 100.0), None);
        assert_eq!(common_delay(Some(&[0.0, 0.0]), 100.0), Some(0.0));
        assert_eq!(common_delay(Some(&[0.010, 0.012]), 100.0), Some(0.011));
        assert_eq!(common_delay(Some(&[0.010, 0.013]), 100.0), None);
    }

    #[test]
    fn a_velocity_reverses_where_it_is_least() {
        assert_eq!(reversal(&[1.0, 0.0, 0.0], &[-3.0, 0.0, 0.0]), Some(0.25));
        assert_eq!(reversal(&[1.0, 0.0, 0.0], &[0.5, 5.0, 0.0]), None);
    }
}
