//! Period of a repeated motion, found from the columns of the regression.
//!
//! Parts of a repeated motion resemble each other. A part that is left out is therefore predicted as well as a part
//! that is fitted, whatever the errors of the model, and errors of the model do not average out with the number of
//! repetitions. Both the choice of the prior and the standard deviations hence treat the repetitions of a motion as
//! one.

use crate::rows::Rows;
use nalgebra::DVector;

/// A motion repeats itself if the mean squared change of the columns over one period is less than this fraction of
/// that of unrelated instants. Rows are a quarter of the period of the filter apart, so a period that is no whole number
/// of rows leaves a change.
pub(crate) const REPEATED: f64 = 0.15;
/// Lags below a period must reach this fraction, so that a slow motion does not seem to repeat itself.
const CHANGED: f64 = 0.5;
/// Least period, in instants.
const SHORTEST: usize = 16;
/// Largest number of instants that are compared at one lag.
const INSTANTS: usize = 1000;
/// Largest number of lags that are compared.
const LAGS: usize = 4000;

/// Period of a repeated motion, in instants of the log; it need not be a whole number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Period(f64);

impl Period {
    /// Returns the part of the period in which an instant lies, if the period is divided into `count`
    /// equal parts; the parts are counted from 0.
    pub(crate) fn part(self, step: usize, count: usize) -> usize {
        let phase = (step as f64 / self.0).fract();
        ((phase * count as f64) as usize).min(count - 1)
    }

    /// Number of whole instants in one repetition.
    pub(crate) fn instants(self) -> usize {
        (self.0.round() as usize).max(1)
    }

    /// Finds the period of the motion of a log from the rows of its actuators; `None` unless at least two repetitions
    /// are contained.
    pub(crate) fn of(channels: &[Rows]) -> Option<Self> {
        let length = instants(channels);
        let signals: Vec<Signal> =
            channels.iter().filter_map(|rows| Signal::of(rows, length)).collect();
        if signals.is_empty() {
            return None;
        }
        let own = (&signals[..], length);
        let change = |lag: usize| change_between(own, own, lag as isize);
        let stride = length.div_ceil(2 * LAGS).max(1);
        let lags: Vec<usize> = (stride..=length / 2).step_by(stride).collect();
        let changes: Vec<f64> = lags.iter().map(|&lag| change(lag)).collect();
        let from = changes.iter().position(|own| *own > CHANGED)?;
        // The coarse lags may miss the period by half a stride, hence each local minimum is refined.
        let is_minimum = |k: &usize| {
            let next = changes.get(k + 1).copied().unwrap_or(f64::INFINITY);
            changes[*k] < CHANGED && changes[*k] <= changes[k - 1] && changes[*k] <= next
        };
        let refined = |center: usize, reach: usize| {
            let around = center.saturating_sub(reach).max(1)..=(center + reach).min(length - 1);
            around.map(|lag| (lag, change(lag))).min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let candidates = (from + 1..lags.len()).filter(is_minimum);
        let mut candidates = candidates.filter_map(|k| refined(lags[k], stride));
        candidates.find_map(|(lag, change)| {
            let mut period = (lag >= SHORTEST && change < REPEATED).then_some(lag as f64)?;
            // Later repetitions determine the fraction of an instant, and rule out a motion that
            // only nearly repeats itself. An error of half an instant after some repetitions is
            // one instant after twice as many.
            let mut count = 2;
            while count as f64 * period < 0.8 * length as f64 {
                let center = (count as f64 * period).round() as usize;
                let (lag, change) = refined(center, 2)?;
                if change > REPEATED {
                    return None;
                }
                period = lag as f64 / count as f64;
                count *= 2;
            }
            Some(Self(period))
        })
    }
}

/// Returns the number of instants of a log from the rows of its actuators.
pub(crate) fn instants(channels: &[Rows]) -> usize {
    let last = channels.iter().filter_map(|rows| rows.steps.last()).max();
    last.map_or(0, |last| last + 1)
}

/// Returns the signals of the actuators of two logs: weighted sums of their columns with the same weights for both logs and
/// all actuators, without their common mean. `None` if the logs have different columns.
pub(crate) fn signals_of_both(logs: [&[Rows]; 2]) -> Option<[Vec<Signal>; 2]> {
    let width = logs[0].first()?.matrix.ncols();
    let has_width = |rows: &Rows| rows.matrix.ncols() == width;
    if logs[0].len() != logs[1].len() || !logs.iter().all(|log| log.iter().all(has_width)) {
        return None;
    }
    let size = |k: usize| {
        let all = logs.iter().flat_map(|log| log.iter());
        all.map(|rows| rows.matrix.column(k).norm_squared()).sum::<f64>().sqrt()
    };
    let sizes: Vec<f64> = (0..width).map(size).collect();
    let mut signals = logs.map(|_| Vec::new());
    for (first, second) in logs[0].iter().zip(logs[1]) {
        let sums = [first, second].map(|rows| weighted_sum(rows, |k| sizes[k]));
        let count = (first.len() + second.len()).max(1) as f64;
        let mean = sums.iter().map(|sum| sum.sum()).sum::<f64>() / count;
        for (which, (rows, sum)) in [first, second].into_iter().zip(&sums).enumerate() {
            let length = instants(logs[which]);
            signals[which].push(Signal::at_steps(rows, length, sum.iter().map(|x| x - mean)));
        }
    }
    Some(signals)
}

/// Returns the weighted sum of the columns of one actuator, each divided by its size. Weights differ, so that columns of equal
/// shape do not cancel.
fn weighted_sum(rows: &Rows, size: impl Fn(usize) -> f64) -> DVector<f64> {
    let mut sum = DVector::zeros(rows.len());
    for (k, column) in rows.matrix.column_iter().enumerate() {
        let size = size(k);
        if size > 0.0 {
            let weight = 0.5 + (0.618_034 * k as f64).fract();
            sum.axpy(weight / size, &column, 1.0);
        }
    }
    sum
}

/// Weighted sum of the columns of one actuator, without its mean and with a mean square of one, at
/// all instants; not a number where rows are missing.
pub(crate) struct Signal(Vec<f64>);

impl Signal {
    /// Computes the signal of one actuator; `None` if the columns are constant.
    fn of(rows: &Rows, length: usize) -> Option<Self> {
        let count = rows.len().max(1) as f64;
        let mut sum = weighted_sum(rows, |k| rows.matrix.column(k).norm());
        sum.add_scalar_mut(-sum.sum() / count);
        let size = (sum.norm_squared() / count).sqrt();
        let largest = rows.matrix.column_iter().map(|column| column.norm()).fold(0.0, f64::max);
        if largest == 0.0 || size * count.sqrt() < 1e-9 {
            return None;
        }
        Some(Self::at_steps(rows, length, sum.iter().map(|x| x / size)))
    }

    /// Places one number for each row at the instant of the row.
    fn at_steps(rows: &Rows, length: usize, numbers: impl Iterator<Item = f64>) -> Self {
        let mut values = vec![f64::NAN; length];
        rows.steps.iter().zip(numbers).for_each(|(step, x)| values[*step] = x);
        Self(values)
    }
}

/// Mean squared difference of the signals of two logs, as a fraction of that of unrelated instants, if the second log begins
/// `shift` instants after the first one. Each log consists of its signals and its number of instants.
pub(crate) fn change_between(
    (first, n): (&[Signal], usize),
    (second, m): (&[Signal], usize),
    shift: isize,
) -> f64 {
    let (n, m) = (n as isize, m as isize);
    let (from, until) = (0.max(-shift), m.min(n - shift));
    let stride = ((until - from).max(0) as usize).div_ceil(INSTANTS).max(1);
    let (mut sum, mut size) = (0.0, 0.0);
    for (Signal(first), Signal(second)) in first.iter().zip(second) {
        for step in (from..until).step_by(stride) {
            let (a, b) = (first[(step + shift) as usize], second[step as usize]);
            if !a.is_nan() && !b.is_nan() {
                sum += (a - b) * (a - b);
                size += a * a + b * b;
            }
        }
    }
    if size > 0.0 { sum / size } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(length: usize, motion: impl Fn(f64) -> f64) -> [Rows; 1] {
        [Rows::of_motion(length, motion)]
    }

    #[test]
    fn periods_are_those_of_the_motion() {
        let tau = std::f64::consts::TAU;
        for (period, length) in [(123.4, 1000), (123.4, 20_000), (400.0, 801)] {
            let motion =
                |t: f64| (tau * t / period).sin() + 0.6 * (3.0 * tau * t / period + 1.0).cos();
            let Period(found) = Period::of(&rows(length, motion)).unwrap();
            let error = (found - period).abs() * length as f64 / period;
            assert!(error < 1.0, "{found} instead of {period}: off by {error} at the end");
        }
        // Frequencies without a common multiple, a single ramp, and less than two periods.
        assert_eq!(Period::of(&rows(1000, |t| (0.05 * t).sin() + (0.0811 * t).cos())), None);
        assert_eq!(Period::of(&rows(1000, |t| t)), None);
        assert_eq!(Period::of(&rows(1000, |t| (tau * t / 600.0).sin())), None);
        assert_eq!(Period::of(&rows(1000, |_| 1.0)), None);
        // Steady motions forth and back in turn.
        let turns = |t: f64| if t % 2.0 == 0.0 { 1.0 } else { -1.0 };
        assert_eq!(Period::of(&rows(60, |t| turns(t) * (1.0 + (0.1 * t).floor()))), None);
    }
}
