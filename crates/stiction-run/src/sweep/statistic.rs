//! Statistics of a sampled series, which serve as functions in objectives.

use crate::statistics::{Integral, Size};

/// Statistic of a series of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    /// Largest magnitude.
    Peak,
    /// Root mean square: of the samples, or over time for columns that heat a motor.
    Rms,
    /// Arithmetic mean of the samples.
    Mean,
    /// Least value.
    Min,
    /// Greatest value.
    Max,
    /// Greatest value minus least value.
    Range,
    /// Value at the last sample.
    Final,
    /// Integral over time by the trapezoidal rule.
    Work,
}

impl Function {
    pub(super) const ALL: [Self; 8] = [
        Self::Peak,
        Self::Rms,
        Self::Mean,
        Self::Min,
        Self::Max,
        Self::Range,
        Self::Final,
        Self::Work,
    ];

    /// Returns the name of the statistic in the text of an objective.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Peak => "peak",
            Self::Rms => "rms",
            Self::Mean => "mean",
            Self::Min => "min",
            Self::Max => "max",
            Self::Range => "range",
            Self::Final => "final",
            Self::Work => "work",
        }
    }
}

/// One statistic of a series, accumulated sample by sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Statistic {
    function: Function,
    count: usize,
    least: f64,
    greatest: f64,
    sum: f64,
    last: f64,
    size: Size,
    integral: Integral,
    /// Integral of the squares over time, for a mean square over time; `None` if samples have equal
    /// weights.
    squares: Option<Integral>,
    /// True if any sample so far was not a number; the statistic then has no value.
    is_lost: bool,
}

impl Statistic {
    /// Creates a statistic before the first sample. The root mean square is taken over time if
    /// `over_time`.
    pub(super) fn new(function: Function, over_time: bool) -> Self {
        Self {
            function,
            count: 0,
            least: f64::INFINITY,
            greatest: f64::NEG_INFINITY,
            sum: 0.0,
            last: 0.0,
            size: Size::default(),
            integral: Integral::default(),
            squares: over_time.then(Integral::default),
            is_lost: false,
        }
    }

    /// Adds a sample at a time, s.
    pub(super) fn add(&mut self, time: f64, value: f64) {
        self.is_lost |= value.is_nan();
        self.count += 1;
        (self.least, self.greatest) = (self.least.min(value), self.greatest.max(value));
        self.sum += value;
        self.last = value;
        self.size.add(time, value);
        self.integral.add(time, value);
        if let Some(squares) = &mut self.squares {
            squares.add(time, value * value);
        }
    }

    /// Returns the statistic; `None` without samples, or if a sample was not a number.
    pub(super) fn value(&self) -> Option<f64> {
        let value = match self.function {
            Function::Peak => self.least.abs().max(self.greatest.abs()),
            Function::Rms => match &self.squares {
                Some(squares) => squares.mean().sqrt(),
                None => self.size.rms(),
            },
            Function::Mean => self.sum / self.count as f64,
            Function::Min => self.least,
            Function::Max => self.greatest,
            Function::Range => self.greatest - self.least,
            Function::Final => self.last,
            Function::Work => self.integral.value,
        };
        // Adding zero turns a negative zero into a positive one.
        (self.count > 0 && !self.is_lost && !value.is_nan()).then_some(value + 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests all statistics of the samples 3, -4, 1 at the times 0, 1, 3 s against values computed
    /// by hand.
    #[test]
    fn statistics_of_three_samples() {
        let value = |function| {
            let mut statistic = Statistic::new(function, false);
            for (time, value) in [(0.0, 3.0), (1.0, -4.0), (3.0, 1.0)] {
                statistic.add(time, value);
            }
            statistic.value().unwrap()
        };
        let expected = [4.0, (26.0_f64 / 3.0).sqrt(), 0.0, -4.0, 3.0, 7.0, 1.0, -0.5 - 3.0];
        for (function, expected) in Function::ALL.into_iter().zip(expected) {
            // Sums of small integers are exact; the square root is rounded once more.
            assert!((value(function) - expected).abs() <= 1e-15 * expected.abs(), "{function:?}");
        }
    }

    /// The squares 9, 16, 1 have the integral 12.5 + 17 over 3 s.
    #[test]
    fn the_root_mean_square_over_time_weights_intervals() {
        let mut statistic = Statistic::new(Function::Rms, true);
        for (time, value) in [(0.0, 3.0), (1.0, -4.0), (3.0, 1.0)] {
            statistic.add(time, value);
        }
        assert_eq!(statistic.value(), Some((29.5_f64 / 3.0).sqrt()));
    }

    #[test]
    fn there_is_no_value_without_numbers() {
        for function in Function::ALL {
            assert_eq!(Statistic::new(function, false).value(), None, "{function:?}");
            let mut statistic = Statistic::new(function, false);
            statistic.add(0.0, f64::NAN);
            statistic.add(1.0, 2.0);
            assert_eq!(statistic.value(), None, "{function:?}");
        }
    }

    /// Tests that series with infinite values have a peak and a minimum, but no mean if infinities
    /// of both signs occur.
    #[test]
    fn infinite_samples_have_a_peak_and_no_mean() {
        let value = |function| {
            let mut statistic = Statistic::new(function, false);
            statistic.add(0.0, f64::INFINITY);
            statistic.add(1.0, f64::NEG_INFINITY);
            statistic.value()
        };
        assert_eq!(value(Function::Peak), Some(f64::INFINITY));
        assert_eq!(value(Function::Min), Some(f64::NEG_INFINITY));
        assert_eq!(value(Function::Mean), None);
    }
}
