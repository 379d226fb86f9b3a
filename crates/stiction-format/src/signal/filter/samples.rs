//! Collection of the samples of a recording for the filter.

use super::{Equations, MAX_RATIO, knots_needed};

/// Ratio of the cut-off frequency of a second filter, with which the main filter is compared, to
/// that of the main filter.
const FINER: f64 = 1.5;

/// Samples of several signals at the same times, accumulated in the equations of the filter.
pub(crate) struct Samples {
    pub(super) equations: Equations,
    /// Equations for a higher cut-off frequency, from which the filter's loss of acceleration is
    /// estimated; `None` if this estimate is not needed or not possible.
    pub(super) finer: Option<Equations>,
    /// First value of each signal; it is subtracted so that squares lose no digits.
    offsets: Option<Vec<f64>>,
    /// Sample added last: its time, s, its values, and the time since the sample before it, s.
    last: Option<(f64, Vec<f64>, Option<f64>)>,
    /// Last four values of each signal, and the sum of squares of its third differences.
    recent: Vec<([f64; 4], f64)>,
    count: usize,
}

impl Samples {
    /// Begins a collection for a cut-off frequency, Hz; `ends` are the times of the first and the last sample, s.
    pub(crate) fn new(cutoff: f64, ends: (f64, f64), signals: usize) -> Self {
        Self {
            equations: Equations::new(cutoff, ends, signals),
            finer: None,
            offsets: None,
            last: None,
            recent: vec![([0.0; 4], 0.0); signals],
            count: 0,
        }
    }

    /// Also collects the equations for a higher cut-off frequency, if the sampling rate, Hz, and the maximum number
    /// of knots permit it.
    pub(crate) fn with_finer(mut self, rate: f64, most_knots: f64) -> Self {
        let Equations { cutoff, knots, rights, .. } = &self.equations;
        let finer = FINER * cutoff;
        let knots_needed = knots_needed(finer, knots.end - knots.start);
        if finer <= MAX_RATIO * rate && knots_needed <= most_knots {
            self.finer = Some(Equations::new(finer, (knots.start, knots.end), rights.len()));
        }
        self
    }

    fn take(&mut self, time: f64, values: &[f64], weight: f64) {
        self.equations.push(time, values, weight);
        if let Some(finer) = &mut self.finer {
            finer.push(time, values, weight);
        }
    }

    /// Adds a sample: its time, s, and the value of each signal.
    pub(crate) fn push(&mut self, time: f64, values: &[f64]) {
        let offsets = self.offsets.get_or_insert_with(|| values.to_vec());
        let values: Vec<f64> = values.iter().zip(&*offsets).map(|(y, first)| y - first).collect();
        self.count += 1;
        for ((recent, squares), value) in self.recent.iter_mut().zip(&values) {
            recent.rotate_left(1);
            recent[3] = *value;
            if self.count >= recent.len() {
                let [a, b, c, d] = *recent;
                *squares += (d - 3.0 * c + 3.0 * b - a).powi(2);
            }
        }
        let mut gap = None;
        if let Some((before, values, last_gap)) = self.last.take() {
            let next = time - before;
            let weight = 0.5 * (last_gap.unwrap_or(next) + next);
            self.take(before, &values, weight);
            gap = Some(next);
        }
        self.last = Some((time, values, gap));
    }

    /// Adds the last sample to the equations, which completes them.
    pub(crate) fn finish(mut self) -> Self {
        if let Some((time, values, gap)) = self.last.take() {
            self.take(time, &values, gap.unwrap_or(0.0));
        }
        self
    }

    /// Value that was subtracted from all samples of a signal.
    pub(super) fn offset(&self, signal: usize) -> f64 {
        self.offsets.as_ref().and_then(|all| all.get(signal)).copied().unwrap_or(0.0)
    }

    /// Estimates the standard deviation of a signal's noise from third differences of its values,
    /// on the assumption that the noise is white.
    pub(super) fn roughness(&self, signal: usize) -> f64 {
        /// Variance of the third difference of white noise: 1 + 9 + 9 + 1.
        const GAIN: f64 = 20.0;
        let squares = self.recent.get(signal).map_or(0.0, |(_, squares)| *squares);
        (squares / (GAIN * (self.count.max(4) - 3) as f64)).sqrt()
    }
}
