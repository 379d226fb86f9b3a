//! The low-pass filter as a linear operator on signals of any kind, for measured efforts and the
//! columns from which the efforts are predicted.

use super::{Equations, Samples, filter, knots_needed, suggest};
use crate::signal::Signal;

/// Low-pass filter without phase shift, with a cut-off frequency (-3 dB), over an interval of time. All signals are
/// filtered in the same way, so linear relations between signals remain valid for the filtered signals.
#[derive(Clone, Copy, Debug)]
pub struct LowPass {
    cutoff: f64,
    ends: (f64, f64),
}

/// Filtered coordinate, and standard deviations of its noise.
#[derive(Clone, Debug)]
pub struct Smooth {
    /// Value, rate and acceleration as functions of time; exactly at rest where the samples are consistent with rest.
    pub signal: Signal,
    /// Standard deviation of the part that the filter removes, m or rad.
    pub removed: f64,
    /// Standard deviations of the noise that remains in value (m or rad) and rate (m/s or rad/s).
    pub noise: [f64; 2],
}

impl LowPass {
    /// Creates a filter with a cut-off frequency, Hz, for signals between the two times `ends`, s.
    pub fn new(cutoff: f64, ends: (f64, f64)) -> Self {
        Self { cutoff, ends }
    }

    /// Cut-off frequency, Hz, that suits signals sampled at `times`; `None` for short recordings.
    pub fn suggested(times: &[f64], signals: &[Vec<f64>]) -> Option<f64> {
        suggest(times, signals)
    }

    /// Number of equations for each signal, equal to the number of knots of the filter's spline.
    pub fn equations(&self) -> f64 {
        knots_needed(self.cutoff, self.ends.1 - self.ends.0)
    }

    /// Filters coordinates that are sampled at `times`, s, and computes their derivatives.
    pub fn smooth(&self, times: &[f64], signals: &[Vec<f64>]) -> Vec<Smooth> {
        let mut samples = Samples::new(self.cutoff, self.ends, signals.len());
        let mut row = vec![0.0; signals.len()];
        for (k, &time) in times.iter().enumerate() {
            for (value, signal) in row.iter_mut().zip(signals) {
                *value = signal[k];
            }
            samples.push(time, &row);
        }
        let filtered = filter(&samples.finish()).into_iter();
        let smooth = filtered.map(|filtered| Smooth {
            signal: Signal::curve(filtered.curve),
            removed: filtered.removed,
            noise: filtered.noise_left,
        });
        smooth.collect()
    }

    /// Filters signals and returns the values of the filtered signals at the times `at`, s, one row
    /// per time. `row(k, values)` writes the samples of all signals at `times[k]` into `values`.
    /// The memory needed does not depend on the number of samples.
    pub fn apply(
        &self,
        times: &[f64],
        signals: usize,
        mut row: impl FnMut(usize, &mut [f64]),
        at: &[f64],
    ) -> Vec<Vec<f64>> {
        let mut equations = Equations::new(self.cutoff, self.ends, signals);
        let mut values = vec![0.0; signals];
        for (k, &time) in times.iter().enumerate() {
            row(k, &mut values);
            let before = k.checked_sub(1).map_or(time, |k| times[k]);
            let after = times.get(k + 1).copied().unwrap_or(time);
            let ends = if k == 0 || k + 1 == times.len() { 1.0 } else { 0.5 };
            equations.push(time, &values, ends * (after - before));
        }
        let factored = equations.matrix().factor();
        let mut rights = std::mem::take(&mut equations.rights);
        rights.iter_mut().for_each(|right| factored.solve(right));
        let value = |t: f64| {
            let (first, splines) = equations.knots.splines_at(t);
            let one = |c: &Vec<f64>| c.iter().skip(first).zip(&splines).map(|(c, b)| c * b).sum();
            rights.iter().map(one).collect()
        };
        at.iter().map(|&t| value(t)).collect()
    }
}
