//! Saturation of measured efforts at the limit of a drive, and the white noise of measured efforts.

/// Number of successive samples with the same extreme value that indicate saturation.
const SATURATED: usize = 5;

/// Sets `marks` to true for saturated samples: at least [`SATURATED`] successive samples that all
/// have the largest or the smallest value of the signal. Returns the index of the first marked
/// sample and the number of marked samples; `None` without saturation. A signal that is also
/// constant at other values is coarsely resolved or piecewise constant, not saturated. A value of
/// zero is never a limit.
pub(super) fn mark(values: &[f64], marks: &mut [bool]) -> Option<(usize, usize)> {
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let (mut at_limit, mut elsewhere): (Vec<(usize, usize)>, usize) = (Vec::new(), 0);
    let mut from = 0;
    for k in 0..=values.len() {
        let goes_on = k > 0 && k < values.len() && values[k] == values[k - 1];
        if goes_on {
            continue;
        }
        if k - from >= SATURATED {
            match values[from] {
                0.0 => {}
                x if x == high || x == low => at_limit.push((from, k)),
                _ => elsewhere += k - from,
            }
        }
        from = k;
    }
    let count: usize = at_limit.iter().map(|(from, until)| until - from).sum();
    if 2 * elsewhere >= count {
        return None;
    }
    for &(from, until) in &at_limit {
        marks[from..until].iter_mut().for_each(|mark| *mark = true);
    }
    at_limit.first().map(|(first, _)| (*first, count))
}

/// Estimates the standard deviation of white noise in a signal from third differences.
pub(super) fn roughness(values: &[f64]) -> f64 {
    let sum: f64 = values.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2)).sum();
    (sum / (20.0 * values.len().max(4) as f64 - 60.0).max(1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marked(values: &[f64]) -> (Option<(usize, usize)>, usize) {
        let mut marks = vec![false; values.len()];
        let found = mark(values, &mut marks);
        (found, marks.iter().filter(|mark| **mark).count())
    }

    #[test]
    fn only_runs_at_the_extremes_are_saturated() {
        let values = [0.0, 1.0, 5.0, 5.0, 5.0, 5.0, 5.0, 2.0, 2.0, 2.0, 2.0, 5.0, 1.0];
        assert_eq!(marked(&values), (Some((2, 5)), 5));
        assert_eq!(marked(&[1.0, 2.0, 1.0]), (None, 0));
    }

    /// Tests that a piecewise constant effort, and an effort that is often zero and never negative,
    /// are not saturated.
    #[test]
    fn plateaus_and_zeros_are_not_saturated() {
        let plateaus = [[3.0; 8], [1.0; 8], [-1.0; 8]].concat();
        assert_eq!(marked(&plateaus), (None, 0));
        let zeros = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 3.0, 2.0, 1.0, 0.5, 0.0];
        assert_eq!(marked(&zeros), (None, 0));
    }

    /// Tests that a standstill at the beginning, with zero effort, does not hide saturation.
    #[test]
    fn a_standstill_hides_no_saturation() {
        let mut values = vec![0.0; 40];
        values.extend([1.0, 3.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 2.0]);
        assert_eq!(marked(&values), (Some((42, 6)), 6));
    }

    /// Tests that the third differences of a slow signal with white noise yield the standard
    /// deviation of the noise.
    #[test]
    fn roughness_of_noise_on_a_slow_signal() {
        let mut random = stiction_core::random::Random::new(2);
        // The noise is uniform from -1 to 1, so its standard deviation is 1/sqrt(3).
        let values: Vec<f64> =
            (0..20_000).map(|k| (1e-3 * k as f64).sin() * 50.0 + random.number()).collect();
        assert!((roughness(&values) * 3f64.sqrt() - 1.0).abs() < 0.03);
    }
}
