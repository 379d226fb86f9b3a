//! Axes: round ticks within the range of the data.

use crate::numbers::{significant, with_minus};

/// Values count as equal if half their range is at most this fraction of the greatest magnitude, so
/// that a plot does not enlarge rounding errors to curves.
const FLAT: f64 = 1e-9;

/// Range of an axis, and the distance between its ticks, which lie at round numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) low: f64,
    pub(super) high: f64,
    step: f64,
}

impl Axis {
    /// Creates an axis that extends exactly from the least to the greatest value.
    pub(super) fn exact(values: impl Iterator<Item = f64>, ticks: usize) -> Self {
        let (low, high) = extremes(values);
        let (low, high) = if high > low { (low, high) } else { around(low) };
        Self { low, high, step: round_step(high - low, ticks) }
    }

    /// Creates an axis with a margin below the least and above the greatest value.
    pub(super) fn padded(values: impl Iterator<Item = f64>, ticks: usize) -> Self {
        let (low, high) = extremes(values);
        // Halves are subtracted, so that the difference of the greatest doubles remains finite.
        let half = 0.5 * high - 0.5 * low;
        let (low, high) = match half > FLAT * low.abs().max(high.abs()) {
            true => (low - 0.12 * half, high + 0.12 * half),
            false => around(0.5 * low + 0.5 * high),
        };
        Self { low, high, step: round_step(high - low, ticks) }
    }

    /// Creates an axis of a given length about the middle of the values.
    pub(super) fn about(values: impl Iterator<Item = f64>, length: f64, ticks: usize) -> Self {
        let (low, high) = extremes(values);
        let middle = 0.5 * low + 0.5 * high;
        let (low, high) = (middle - 0.5 * length, middle + 0.5 * length);
        Self { low, high, step: round_step(length, ticks) }
    }

    /// Returns the axis with ticks at whole numbers only.
    pub(super) fn of_counts(self) -> Self {
        Self { step: self.step.max(1.0), ..self }
    }

    /// Returns the position of a value along the axis, from 0 at the low end to 1 at the high end.
    /// A value beyond an end, finite or infinite, has the position of this end.
    pub(super) fn place(&self, value: f64) -> f64 {
        ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    /// Values of the ticks, with their labels.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        let slack = 1e-9 * self.step;
        let first = ((self.low - slack) / self.step).ceil();
        let count = ((self.high + slack) / self.step).floor() - first;
        if !(count.is_finite() && (0.0..100.0).contains(&count)) {
            return vec![(self.low, label(self.low, 0.0)), (self.high, label(self.high, 0.0))];
        }
        let tick = |k: usize| {
            let value = (first + k as f64) * self.step;
            (value, label(value, self.step))
        };
        (0..=count as usize).map(tick).collect()
    }
}

pub(super) fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let finite = values.filter(|value| value.is_finite());
    let found = finite.fold(None, |known: Option<(f64, f64)>, x| {
        Some(known.map_or((x, x), |(low, high)| (low.min(x), high.max(x))))
    });
    found.unwrap_or((0.0, 0.0))
}

/// Range for an axis on which only a single value is shown.
fn around(value: f64) -> (f64, f64) {
    let half = if value == 0.0 { 1.0 } else { 0.1 * value.abs() };
    (value - half, value + half)
}

/// Returns a step of one, two or five times a power of ten such that about `ticks` steps fit into
/// `span`.
fn round_step(span: f64, ticks: usize) -> f64 {
    let raw = span / ticks.max(1) as f64;
    let power = 10f64.powf(raw.log10().floor());
    let step =
        [1.0, 2.0, 5.0].into_iter().map(|digit| digit * power).find(|step| *step >= 0.999 * raw);
    step.unwrap_or(10.0 * power)
}

/// Formats the label of a tick with as many decimals as the step needs, and with the same minus
/// sign as in tables.
fn label(value: f64, step: f64) -> String {
    let size = value.abs().max(step);
    let text = if value == 0.0 {
        "0".to_owned()
    } else if step > 0.0 && (1e-4..1e6).contains(&size) {
        let decimals = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
        format!("{value:.decimals$}")
    } else {
        significant(value, 3)
    };
    with_minus(&text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_and_within_the_axis() {
        let axis = Axis::exact([0.0, 1.0].into_iter(), 5);
        assert_eq!((axis.low, axis.high), (0.0, 1.0));
        assert_eq!(
            labels(&axis),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"].map(|t| t.replace("0.0", "0"))
        );
        for (low, high) in
            [(-3.0, 7.0), (1e-7, 5e-7), (120.0, 121.0), (-1e300, 1e300), (-2e9, -1e9)]
        {
            let axis = Axis::padded([low, high].into_iter(), 4);
            let ticks = axis.ticks();
            assert!((2..=8).contains(&ticks.len()), "{low} {high}: {ticks:?}");
            assert!(ticks.iter().all(|(t, _)| (axis.low..=axis.high).contains(t)), "{ticks:?}");
        }
    }

    #[test]
    fn rounding_errors_are_no_curve() {
        let axis = Axis::padded([5.0, 5.0 + 1e-14].into_iter(), 4);
        assert!(axis.high - axis.low > 0.5);
        let axis = Axis::padded(std::iter::empty(), 4);
        assert_eq!((axis.low, axis.high), (-1.0, 1.0));
    }
}
