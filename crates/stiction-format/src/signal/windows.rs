//! Splines through long recordings, window by window.
//!
//! A spline depends on all of its samples, but what a sample does to it fades with the distance: for equal
//! steps by 0.43 from one sample to the next where values are given (the greatest root of the quintic
//! B-spline's polynomial `x^4 + 26 x^3 + 66 x^2 + 26 x + 1` within the unit circle, but for its sign), by 0.17
//! where rates are given as well. Some ninety samples away nothing is left of it in sixteen digits. So a
//! window that reaches that far beyond what is asked of it knows all it needs, and the system of equations
//! need not be kept for more. Steps that vary wildly may carry further; that shows where windows meet.

use std::ops::Range;
use stiction_core::kinematics::Target;

/// Samples that a window is asked for.
const ASKED: usize = 4096;
/// Samples that it knows beyond these on both sides. Neighbours overlap by twice as many.
const MARGIN: usize = 96;
/// So many samples are worth more than one window.
const LONG: usize = 2 * ASKED;
/// How many roundings of a value neighbours may differ by in a rate times the step, or in an acceleration times
/// its square, where they meet. Both are differences of the values around, magnified some ten times by
/// solving; a few unequal steps make that a hundred.
const ROUNDINGS: f64 = 256.0;

/// One of the windows through which a recording is seen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    /// The samples that it is asked for.
    pub(crate) asked: Range<usize>,
    /// Those that it knows.
    pub(crate) known: Range<usize>,
}

impl Window {
    /// The window whose first sample is `begin`, of `count`. Whether there are more than so many does not
    /// matter if [`is_long`] says so of those from `begin` on.
    pub(crate) fn at(begin: usize, count: usize) -> Self {
        // The last window takes what would be too little for another.
        let end = if is_long(count - begin) { begin + ASKED } else { count };
        Self { asked: begin..end, known: begin.saturating_sub(MARGIN)..(end + MARGIN).min(count) }
    }

    /// The first sample that a window is asked for, by the window's number.
    pub(crate) fn begin(index: usize) -> usize {
        index * ASKED
    }

    /// The number of the window that is asked for a sample, if there are so many windows.
    pub(crate) fn of(sample: usize, windows: usize) -> usize {
        (sample / ASKED).min(windows.saturating_sub(1))
    }

    /// How many of the known samples come before those that are asked for.
    pub(crate) fn skip(&self) -> usize {
        self.asked.start - self.known.start
    }
}

/// Whether so many samples are seen through more than one window.
pub(crate) fn is_long(count: usize) -> bool {
    count >= LONG
}

/// Value, rate and acceleration at all samples, found by `solve` for windows of them; none where there are too
/// few samples to be worth it, or where windows do not agree.
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
        knots.extend(own.get(window.skip()..window.skip() + window.asked.len())?);
    }
    Some(knots)
}

/// Whether a window's knots agree with `last`, the last one that the window before was asked for. Times and
/// values are the window's own, and `skip` of its samples belong to the window before.
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

/// Whether changes of a rate and an acceleration amid three samples are no more than the rounding of values
/// explains.
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

    /// Rough values, so that a sample that were overlooked would show.
    fn rough(k: usize) -> f64 {
        ((k * k) as f64 * 0.618).sin()
    }

    /// The quintic spline through all samples is that of the windows: rates times steps and accelerations times
    /// their squares within the rounding of values.
    #[test]
    fn windows_are_the_whole() {
        let steps: [fn(usize) -> f64; 2] = [|_| 1e-3, |k| 1e-3 * [1.0, 0.4, 1.2, 0.7][k % 4]];
        for step in steps {
            let times = times(3 * ASKED + 17, step);
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
            // Values are of order one; roundings of them are magnified some ten times in solving.
            for k in 0..times.len() {
                let (h, unit) = (1e-3, 40.0 * f64::EPSILON);
                let rate = found[k].rate - whole[k].rate;
                let acceleration = found[k].acceleration - whole[k].acceleration;
                assert!(rate.abs() * h < unit, "{k}");
                assert!(acceleration.abs() * h * h < 10.0 * unit, "{k}");
            }
        }
    }

    /// With rates, too.
    #[test]
    fn splines_with_rates_are_the_whole() {
        let times = times(2 * ASKED + 5, |k| 1e-3 * [1.0, 0.4, 1.2, 0.7][k % 4]);
        let values: Vec<f64> = (0..times.len()).map(rough).collect();
        let rates: Vec<f64> = (0..times.len()).map(|k| 1e3 * rough(k + 7)).collect();
        let spline = Spline::new(&times, Samples::new([values.clone(), rates.clone()]));
        let all = super::super::hermite::accelerations_for_rates(&times, &values, &rates);
        let largest = all.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
        for (t, expected) in times.iter().zip(&all) {
            let found = spline.at(*t).acceleration;
            // Four roundings: elimination comes to the same numbers but for their last digit.
            assert!((found - expected).abs() < 1e-15 * largest, "{t}: {found} {expected}");
        }
    }

    /// What carries further than a window knows is seen where windows meet.
    #[test]
    fn windows_that_disagree_are_refused() {
        let times = times(2 * ASKED + 100, |_| 1e-3);
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
