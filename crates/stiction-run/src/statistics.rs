//! Statistics of sampled series: peaks, means, differences, integrals.

use serde_json::{Value, json};

/// Peak (largest magnitude, with its sign), root mean square and mean magnitude of a series of
/// equally weighted samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Size {
    pub(crate) peak: f64,
    pub(crate) peak_time: f64,
    count: usize,
    squares: f64,
    magnitudes: f64,
}

/// Relative difference below which two values count as equal, so that rounding does not move the
/// peak to a later instant.
const ROUNDING: f64 = 1e-12;

impl Size {
    pub(crate) fn add(&mut self, time: f64, value: f64) {
        if self.count == 0 || value.abs() > self.peak.abs() * (1.0 + ROUNDING) {
            (self.peak, self.peak_time) = (value, time);
        }
        self.count += 1;
        self.squares += value * value;
        self.magnitudes += value.abs();
    }

    pub(crate) fn rms(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }

    pub(crate) fn mean(&self) -> f64 {
        self.magnitudes / self.count.max(1) as f64
    }

    pub(crate) fn json(&self) -> Value {
        json!({
            "peak": self.peak,
            "peak_time": self.peak_time,
            "rms": self.rms(),
            "mean_magnitude": self.mean(),
        })
    }
}

/// Statistics of the force and the moment in each joint reaction.
#[derive(Clone, Debug)]
pub(crate) struct Reactions(pub(crate) Vec<(Size, Size)>);

impl Reactions {
    pub(crate) fn new(joints: usize) -> Self {
        Self(vec![Default::default(); joints])
    }

    /// Adds the magnitudes of force, N, and moment, N m, of all reactions at a time, s.
    pub(crate) fn add(&mut self, time: f64, sizes: impl Iterator<Item = (f64, f64)>) {
        for ((force, moment), (f, m)) in self.0.iter_mut().zip(sizes) {
            force.add(time, f);
            moment.add(time, m);
        }
    }

    pub(crate) fn json(&self, joints: &[String]) -> Value {
        let entry = |(name, (force, moment)): (&String, &(Size, Size))| {
            (name.clone(), json!({ "force": force.json(), "moment": moment.json() }))
        };
        Value::Object(joints.iter().zip(&self.0).map(entry).collect())
    }
}

/// Comparison of a series with friction to the same series without friction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Comparison {
    pub(crate) with: Size,
    pub(crate) without: Size,
    pub(crate) difference: Size,
    /// Largest ratio of the difference to the frictionless value at one instant, and the time of
    /// this instant, s.
    greatest: Option<(f64, f64)>,
}

impl Comparison {
    pub(crate) fn add(&mut self, time: f64, with: f64, without: f64) {
        self.with.add(time, with);
        self.without.add(time, without);
        self.difference.add(time, with - without);
        let ratio = ((with - without) / without).abs();
        // The ratio to a frictionless value near zero has no meaning.
        if ratio.is_finite() && self.greatest.is_none_or(|(greatest, _)| ratio > greatest) {
            self.greatest = Some((ratio, time));
        }
    }

    /// Returns the ratio of the difference to the frictionless series in four metrics. A metric is
    /// `None` if the frictionless series is zero up to rounding.
    pub(crate) fn metrics(&self) -> Metrics {
        let nothing = self.without.peak.abs() <= 1e-9 * self.with.peak.abs();
        let ratio = |a: f64, b: f64| Some(a / b).filter(|r| r.is_finite() && !nothing);
        Metrics {
            max_over_max: ratio(self.difference.peak.abs(), self.without.peak.abs()),
            rms_over_rms: ratio(self.difference.rms(), self.without.rms()),
            mean_over_mean: ratio(self.difference.mean(), self.without.mean()),
            at_one_time: self.greatest.filter(|_| !nothing),
        }
    }
}

/// Relative effect of friction on a series, compared with the frictionless series, in four metrics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Metrics {
    pub(crate) max_over_max: Option<f64>,
    pub(crate) rms_over_rms: Option<f64>,
    pub(crate) mean_over_mean: Option<f64>,
    pub(crate) at_one_time: Option<(f64, f64)>,
}

impl Metrics {
    pub(crate) fn json(&self) -> Value {
        json!({
            "max_over_max": self.max_over_max,
            "rms_over_rms": self.rms_over_rms,
            "mean_over_mean": self.mean_over_mean,
            "greatest_at_one_time": self.at_one_time.map(|(ratio, _)| ratio),
            "time_of_greatest": self.at_one_time.map(|(_, time)| time),
        })
    }
}

/// Least and greatest value of a series.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Range(Option<(f64, f64)>);

impl Range {
    /// Returns the least and the greatest value; `None` without values.
    pub(crate) fn ends(&self) -> Option<(f64, f64)> {
        self.0
    }

    pub(crate) fn add(&mut self, value: f64) {
        let (least, greatest) = self.0.unwrap_or((value, value));
        self.0 = Some((least.min(value), greatest.max(value)));
    }

    pub(crate) fn json(&self) -> Value {
        json!({ "least": self.0.map(|(least, _)| least), "greatest": self.0.map(|(_, greatest)| greatest) })
    }
}

/// Integral of a sampled series over time by the trapezoidal rule.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Integral {
    /// Time of the first sample, s.
    start: f64,
    last: Option<(f64, f64)>,
    pub(crate) value: f64,
}

impl Integral {
    pub(crate) fn add(&mut self, time: f64, value: f64) {
        match self.last {
            Some((before, last)) => self.value += 0.5 * (value + last) * (time - before),
            None => self.start = time,
        }
        self.last = Some((time, value));
    }

    /// Returns the mean of the series over time, or its last value if all samples are at one
    /// instant; zero without samples.
    pub(crate) fn mean(&self) -> f64 {
        let Some((end, last)) = self.last else { return 0.0 };
        let duration = end - self.start;
        if duration > 0.0 { self.value / duration } else { last }
    }

    /// Returns the value of the series at the last added sample; zero without samples.
    pub(crate) fn last(&self) -> f64 {
        self.last.map_or(0.0, |(_, value)| value)
    }
}

/// Least value of a series, and the time at which it occurs, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Least {
    pub(crate) value: f64,
    pub(crate) time: f64,
}

impl Default for Least {
    fn default() -> Self {
        Self { value: f64::INFINITY, time: 0.0 }
    }
}

impl Least {
    pub(crate) fn add(&mut self, time: f64, value: f64) {
        if value < self.value * (1.0 - ROUNDING) {
            (self.value, self.time) = (value, time);
        }
    }

    pub(crate) fn json(&self) -> Value {
        json!({ "least": self.value, "time": self.time })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metrics_of_a_sine_with_an_offset() {
        let mut comparison = Comparison::default();
        let n = 1000;
        for k in 0..n {
            let t = k as f64 / n as f64;
            let value = 2.0 + (std::f64::consts::TAU * t).sin();
            comparison.add(t, 1.1 * value, value);
        }
        let metrics = comparison.metrics();
        for ratio in [metrics.max_over_max, metrics.rms_over_rms, metrics.mean_over_mean] {
            assert!((ratio.unwrap() - 0.1).abs() < 1e-12);
        }
        assert!((metrics.at_one_time.unwrap().0 - 0.1).abs() < 1e-12);
        assert!((comparison.without.rms() - 4.5f64.sqrt()).abs() < 1e-12);
        assert!((comparison.without.peak - 3.0).abs() < 1e-9);
        assert_eq!(comparison.without.peak_time, 0.25);
    }

    #[test]
    fn nothing_to_compare_with() {
        let mut comparison = Comparison::default();
        comparison.add(0.0, 1.0, 0.0);
        assert_eq!(comparison.metrics().max_over_max, None);
        assert_eq!(comparison.metrics().at_one_time, None);
    }

    #[test]
    fn trapezoids() {
        let mut integral = Integral::default();
        for k in 0..=10 {
            integral.add(k as f64 * 0.1, k as f64 * 0.1);
        }
        assert!((integral.value - 0.5).abs() < 1e-15);
    }
}
