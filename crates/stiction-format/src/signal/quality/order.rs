//! Detects rows in a wrong order, and values that are repeated because a sensor is slower than the
//! log.

use std::ops::Range;

/// Largest distance, in rows, between two exchanged rows.
const FARTHEST: usize = 3;
/// Fraction of an irregularity of the acceleration that may remain after two rows have been
/// exchanged back.
const REMAINDER: f64 = 0.25;
/// Minimum ratio of an irregularity of the acceleration to the differences among the neighbouring
/// accelerations.
const IRREGULAR: f64 = 4.0;
/// Number of standard deviations of rounding that an irregularity of the acceleration, or a change
/// between held values, must exceed.
const SIGMAS: f64 = 16.0;
/// Maximum number of equal successive values that count as held. [`FEWEST_HELD`] is the minimum
/// number of such runs in a block.
const LONGEST_HELD: usize = 16;
const FEWEST_HELD: usize = 4;
/// Minimum ratio of the largest to the smallest change between held values.
const VARIED: f64 = 1.2;

/// Computes the accelerations at the samples `range` by second divided differences of the values
/// `y`.
fn accelerations(t: &[f64], y: impl Fn(usize) -> f64, range: Range<usize>) -> Vec<f64> {
    let at = |i: usize| {
        let (before, after) = (t[i] - t[i - 1], t[i + 1] - t[i]);
        2.0 * ((y(i + 1) - y(i)) / after - (y(i) - y(i - 1)) / before) / (before + after)
    };
    range.map(at).collect()
}

/// Returns the error of the acceleration at sample `i` if the value of this sample and that of one
/// of the next samples are exchanged; otherwise `None`. Two values count as exchanged if exchanging
/// them back makes the accelerations like the neighbouring ones. `found` are the accelerations at
/// all samples, each with the standard deviation of its rounding error.
pub(super) fn exchanged(
    t: &[f64],
    y: &[f64],
    found: &[Option<(f64, f64)>],
    i: usize,
) -> Option<f64> {
    (1..=FARTHEST).find_map(|distance| {
        let other = i + distance;
        let first = i.checked_sub(3)?;
        let beside = [first, first + 1, other + 2, other + 3];
        let own = found.get(i - 1..=other + 1)?;
        let mut near = [0.0; 4];
        for (value, at) in near.iter_mut().zip(beside) {
            *value = (*found.get(at)?)?.0;
        }
        let mean = near.iter().sum::<f64>() / 4.0;
        let spread = near.iter().fold(0.0_f64, |most, a| most.max((a - mean).abs()));
        let sigma = own.iter().flatten().fold(0.0_f64, |most, (_, sigma)| most.max(*sigma));
        let size = own.iter().flatten().fold(0.0_f64, |most, (a, _)| most.max((a - mean).abs()));
        if size <= IRREGULAR * spread || size <= SIGMAS * sigma {
            return None;
        }
        let back = |k: usize| match k {
            k if k == i => y[other],
            k if k == other => y[i],
            k => y[k],
        };
        let left = accelerations(t, back, i - 1..other + 2);
        let left = left.iter().fold(0.0_f64, |most, a| most.max((a - mean).abs()));
        (left <= REMAINDER * size).then_some(size)
    })
}

/// Returns the number of samples for which each value of a range is held, if most of the values are
/// held; otherwise `None`. Values count as held if, between changes in the same direction, each
/// value is repeated about equally often, and the changes differ in size. `sigmas` are the standard
/// deviations of the rounding errors of the values `y`.
///
/// Values that repeat because the sensor has a coarse resolution are not held values: their changes
/// are equal, and they are repeated for different numbers of samples.
pub(super) fn held(y: &[f64], sigmas: &[f64], samples: Range<usize>) -> Option<usize> {
    let (mut runs, mut single) = (0, 0);
    let (mut shortest, mut longest) = (usize::MAX, 0);
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    let mut i = samples.start.max(1);
    while i + 1 < samples.end {
        let length = 1 + y[i + 1..].iter().take_while(|next| **next == y[i]).count();
        let Some(next) = y.get(i + length) else { break };
        let (before, after) = (y[i] - y[i - 1], next - y[i]);
        let moves = before * after > 0.0 && before.abs().min(after.abs()) > SIGMAS * sigmas[i];
        match (moves, length) {
            (true, 1) => single += 1,
            (true, 2..=LONGEST_HELD) => {
                runs += 1;
                (shortest, longest) = (shortest.min(length), longest.max(length));
                (least, most) = (least.min(after.abs()), most.max(after.abs()));
            }
            _ => {}
        }
        i += length;
    }
    let is_held = runs >= FEWEST_HELD && runs > single;
    (is_held && longest <= shortest + 1 && most > VARIED * least).then_some(longest)
}
