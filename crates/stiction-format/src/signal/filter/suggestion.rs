//! Suggests a cut-off frequency for the filter of a recording.

use super::{MAX_RATIO, MIN_PERIODS, Samples};

/// Weight of a parameter in the generalised cross-validation. Values above one avoid too little
/// smoothing (Kim and Gu, Smoothing spline Gaussian regression, 2004).
const PARAMETER_WEIGHT: f64 = 1.4;
/// Ratio of the suggestion to the cut-off frequency that suits the values best. It is greater than one because
/// accelerations at the ends of a motion have a larger bias than values.
const FOR_ACCELERATIONS: f64 = 1.4;
/// Number of cut-off frequencies per octave that the search tries.
const PER_OCTAVE: f64 = 4.0;

/// Suggests a cut-off frequency, Hz, for the filter of signals that are all sampled at `times`, s:
/// the lowest frequency that suits all signals. `None` for recordings that are too short.
///
/// For each signal, generalised cross-validation minimises the expected error of the filtered
/// values at omitted samples, so that noise and the spectrum of the motion determine the result.
pub(crate) fn suggest(times: &[f64], signals: &[Vec<f64>]) -> Option<f64> {
    let (&start, &end) = (times.first()?, times.last()?);
    let rate = (times.len() - 1) as f64 / (end - start);
    let (low, high) = (MIN_PERIODS / (end - start), 0.5 * MAX_RATIO * rate);
    let octaves = (high / low).log2();
    if !octaves.is_finite() || octaves < 1.0 {
        return None;
    }
    let mut best = vec![(f64::INFINITY, low); signals.len()];
    for step in 0..=(octaves * PER_OCTAVE).floor() as usize {
        let cutoff = low * (step as f64 / PER_OCTAVE).exp2();
        let scores = scores(cutoff, times, signals);
        for (best, score) in best.iter_mut().zip(scores) {
            if score < best.0 {
                *best = (score, cutoff);
            }
        }
    }
    let cutoff = best.into_iter().map(|(_, cutoff)| cutoff).fold(0.0, f64::max);
    let digits = format!("{:.1e}", FOR_ACCELERATIONS * cutoff);
    digits.parse().ok().filter(|rounded: &f64| *rounded > 0.0 && *rounded >= low)
}

/// Returns the generalised cross-validation score of each signal at a cut-off frequency, Hz; the
/// lower, the better.
fn scores(cutoff: f64, times: &[f64], signals: &[Vec<f64>]) -> Vec<f64> {
    let (Some(&start), Some(&end)) = (times.first(), times.last()) else { return Vec::new() };
    let mut samples = Samples::new(cutoff, (start, end), signals.len());
    let mut row = vec![0.0; signals.len()];
    for (k, &t) in times.iter().enumerate() {
        for (value, signal) in row.iter_mut().zip(signals) {
            *value = signal[k];
        }
        samples.push(t, &row);
    }
    let samples = samples.finish();
    let solution = samples.equations.solve();
    let count = times.len() as f64;
    let left = 1.0 - PARAMETER_WEIGHT * solution.parameters / count;
    let score = |signal: usize| {
        let c = solution.coefficients(signal);
        if left > 0.0 { solution.mean_square(signal, &c) / (left * left) } else { f64::INFINITY }
    };
    (0..signals.len()).map(score).collect()
}
