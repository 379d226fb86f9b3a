//! Splines through long recordings, window by window.
//!
//! A spline depends on all of its samples, but the influence of a sample decays with distance: for equal steps by a
//! factor of 0.43 per sample if values are given (the magnitude of the largest root of the quintic B-spline
//! polynomial `x^4 + 26 x^3 + 66 x^2 + 26 x + 1` within the unit circle), and by 0.17 if rates are given as well. At
//! a distance of ninety samples it is below double precision. A window with such a margin is therefore exact, and no
//! global system is needed. If steps vary strongly, the influence reaches further; this is detected by comparing
//! windows where they meet.

use std::ops::Range;
use stiction_core::kinematics::Target;

/// Number of samples in the core of a window.
const CORE: usize = 4096;
/// Number of margin samples on either side. Neighbouring windows overlap by twice this number.
const MARGIN: usize = 96;
/// Minimum number of samples for which several windows are used.
const LONG: usize = 2 * CORE;
/// Tolerance for the knots of two windows where the windows meet, in units of the rounding error of
/// a value. It applies to the difference of rates times the step, and to the difference of
/// accelerations times the square of the step. Rates and accelerations are differences of
/// neighbouring values. The solution magnifies their rounding errors about ten times, or about a
/// hundred times if a few steps are unequal.
const ROUNDINGS: f64 = 256.0;

/// Range of consecutive samples of a recording whose spline is solved at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    /// Core samples, whose knots this window determines.
    pub(crate) core: Range<usize>,
    /// Core and margin samples.
    pub(crate) known: Range<usize>,
}

impl Window {
    /// Returns the window whose core begins at sample `begin`, in a recording with `count` samples.
    /// If [`is_long`] holds for the number of samples from `begin` on, further samples do not
    /// change the window.
    pub(crate) fn at(begin: usize, count: usize) -> Self {
        // The last window includes a remainder that is too short for a separate window.
        let end = if is_long(count - begin) { begin + CORE } else { count };
        Self { core: begin..end, known: begin.saturating_sub(MARGIN)..(end + MARGIN).min(count) }
    }

    /// Index of the first core sample of a window.
    pub(crate) fn begin(index: usize) -> usize {
        index * CORE
    }

    /// Index of the window, of `windows` in total, whose core contains a sample.
    pub(crate) fn of(sample: usize, windows: usize) -> usize {
        (sample / CORE).min(windows.saturating_sub(1))
    }

    /// Number of margin samples before the core.
    pub(crate) fn skip(&self) -> usize {
        self.core.start - self.known.start
    }
}

/// Tests whether this number of samples needs more than one window.
pub(crate) fn is_long(count: usize) -> bool {
    count >= LONG
}

/// Computes value, rate and acceleration at all samples by calling `solve` for each window; `None` if the samples fit
/// into one window or neighbouring windows disagree.
pub(super) fn by_windows(
    times: &[f64],
    values: &[f64],
    mut solve: impl FnMut(Range<usize>) -> Vec<Target<f64>>,
) -> Option<Vec<Target<f64>>> {
    let count = times.len();
    if !is_long(count) {
        return None;
    }
    let mut knots: Vec<Target<f64>> = Vec::with_capacity(count);
    while knots.len() < count {
        let window = Window::at(knots.len(), count);
        let own = solve(window.known.clone());
        if let Some(last) = knots.last() {
            let (times, values) =
                (times.get(window.known.clone())?, values.get(window.known.clone())?);
            if !agrees(last, &own, window.skip(), times, values) {
                return None;
            }
        }
        knots.extend(own.get(window.skip()..window.skip() + window.core.len())?);
    }
    Some(knots)
}

/// Tests whether the knots of a window agree with `last`, the last core knot of the previous
/// window. `times` and `values` are the samples of the window, of which the first `skip` lie before
/// its core.
pub(crate) fn agrees(
    last: &Target<f64>,
    knots: &[Target<f64>],
    skip: usize,
    times: &[f64],
    values: &[f64],
) -> bool {
    let again = skip.checked_sub(1).and_then(|before| knots.get(before));
    let around = skip.checked_sub(2).and_then(|first| times.get(first..=skip));
    let (Some(again), Some(around)) = (again, around) else { return false };
    is_rounding([again.rate - last.rate, again.acceleration - last.acceleration], around, values)
}

/// Tests whether the differences of a rate and an acceleration at the middle of three samples are
/// within the rounding errors of `values`. `times` are the times of the three samples.
fn is_rounding([rate, acceleration]: [f64; 2], times: &[f64], values: &[f64]) -> bool {
    let step = times.windows(2).map(|pair| match pair {
        [a, b] => b - a,
        _ => 0.0,
    });
    let step = step.fold(f64::INFINITY, f64::min);
    let largest = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let least = ROUNDINGS * f64::EPSILON * largest;
    // Comparisons with NaN are false.
    (rate * step).abs() <= least && (acceleration * step * step).abs() <= least
}

#[cfg(test)]
mod tests {
    use super::super::hermite::{Samples, Spline};
    use super::*;
    use std::sync::Arc;

    fn times(count: usize, step: impl Fn(usize) -> f64) -> Arc<[f64]> {
        let mut t = 0.0;
        let later = |k| {
            t += step(k);
            t
        };
        (0..count).map(later).collect()
    }

    /// Irregular values at samples, so that the test detects a missing sample.
    fn rough(k: usize) -> f64 {
        ((k * k) as f64 * 0.618).sin()
    }

    /// Checks that the windowed spline equals the global quintic spline: rates times steps and
    /// accelerations times the squares of steps agree within the rounding of the values.
    #[test]
    fn windows_equal_the_whole() {
        let steps: [fn(usize) -> f64; 2] = [|_| 1e-3, |k| 1e-3 * [1.0, 0.4, 1.2, 0.7][k % 4]];
        for step in steps {
            let times = times(3 * CORE + 17, step);
            let values: Vec<f64> = (0..times.len()).map(rough).collect();
            let mut solved = 0;
            let found = by_windows(&times, &values, |window| {
                solved += 1;
                let part = |list: &[f64]| list[window.clone()].to_vec();
                Samples::new([part(&values)]).knots(&part(&times))
            });
            assert_eq!(solved, 3, "windows");
            let found = found.unwrap();
            let whole = Samples::new([values]).knots(&times);
            // Values are of order one; the solution magnifies their rounding some ten times.
            for k in 0..times.len() {
                let (h, unit) = (1e-3, 40.0 * f64::EPSILON);
                let rate = found[k].rate - whole[k].rate;
                let acceleration = found[k].acceleration - whole[k].acceleration;
                assert!(rate.abs() * h < unit, "{k}");
                assert!(acceleration.abs() * h * h < 10.0 * unit, "{k}");
            }
        }
    }

    /// Checks that the windowed spline with given rates equals the global spline.
    #[test]
    fn windows_with_rates_equal_the_whole() {
        let times = times(2 * CORE + 5, |k| 1e-3 * [1.0, 0.4, 1.2, 0.7][k % 4]);
        let values: Vec<f64> = (0..times.len()).map(rough).collect();
        let rates: Vec<f64> = (0..times.len()).map(|k| 1e3 * rough(k + 7)).collect();
        let spline = Spline::new(&times, Samples::new([values.clone(), rates.clone()]));
        let all = super::super::hermite::accelerations_for_rates(&times, &values, &rates);
        let largest = all.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
        for (t, expected) in times.iter().zip(&all) {
            let found = spline.at(*t).acceleration;
            // The tolerance is about four rounding errors, because elimination in a different order
            // changes the last digit.
            assert!((found - expected).abs() < 1e-15 * largest, "{t}: {found} {expected}");
        }
    }

    /// Checks that a disagreement between windows is detected, and that a short recording is not
    /// divided into windows.
    #[test]
    fn windows_that_disagree_are_refused() {
        let times = times(2 * CORE + 100, |_| 1e-3);
        let values: Vec<f64> = (0..times.len()).map(rough).collect();
        let mut part = 0.0;
        let found = by_windows(&times, &values, |window| {
            part += 1e-6;
            let knot = |x| Target { value: x, rate: x, acceleration: x };
            window.map(|k| knot(rough(k) + part)).collect()
        });
        assert!(found.is_none());
        let found = by_windows(&times[..100], &values[..100], |_| unreachable!());
        assert!(found.is_none());
    }
}
