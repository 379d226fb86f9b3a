//! Spikes: single samples far from their neighbours, caused by lost packets, disturbed converters
//! or manual edits.

/// Number of neighbours on each side with which a sample is compared.
const SIDE: usize = 3;
/// Smallest distance of a spike from the median of its neighbourhood, in standard deviations of
/// this distance over all samples, as estimated by [`robust_deviation`].
const SIGMAS: f64 = 8.0;
/// Smallest distance of a spike from the median of its neighbourhood, relative to the range of its
/// neighbours without the farthest of them. A step, a peak of a fast motion, or sensor noise does
/// not reach this distance.
const RANGES: f64 = 3.0;
/// Largest fraction of the samples that can be spikes. If more samples are far from their
/// neighbours, the signal itself consists of such samples, for example of pulses, and no sample is
/// replaced.
const MOST: f64 = 0.1;
/// Number of passes of the search for spikes. A second spike in a neighbourhood becomes detectable
/// after the first one is replaced.
const PASSES: usize = 3;

/// Spikes that were found in a signal.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Spikes {
    /// Indices of the spikes among the samples, in increasing order.
    pub(super) samples: Vec<usize>,
    /// Largest distance of a spike from the median of its neighbourhood, in the unit of the signal.
    pub(super) largest: f64,
}

/// Replaces spikes in `values` by interpolation between their neighbours in time, within each
/// stretch of samples. A spike smaller than `least` times the standard deviation of the signal is
/// not replaced.
pub(super) fn replace(
    times: &[f64],
    values: &mut [f64],
    stretches: &[std::ops::Range<usize>],
    least: f64,
) -> Spikes {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let size = (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt();
    let floor = (least * size).max(quantum(values) * RANGES);
    let (mut is_spike, mut largest) = (vec![false; values.len()], 0.0);
    let mut clean = values.to_vec();
    for _ in 0..PASSES {
        let distances: Vec<f64> = stretches
            .iter()
            .flat_map(|own| own.clone().map(|k| distance(&clean, own, k).0))
            .collect();
        let limit = SIGMAS * robust_deviation(distances);
        let mut found = Vec::new();
        for own in stretches {
            for k in own.clone() {
                let (distance, range) = distance(&clean, own, k);
                if distance > limit.max(RANGES * range).max(floor) {
                    found.push(k);
                    largest = f64::max(largest, distance);
                }
            }
        }
        if found.is_empty() {
            break;
        }
        found.iter().for_each(|&k| is_spike[k] = true);
        for own in stretches {
            interpolate(times, &mut clean, &is_spike, own);
        }
    }
    let samples: Vec<usize> = (0..values.len()).filter(|&k| is_spike[k]).collect();
    if samples.len() as f64 > MOST * count {
        return Spikes::default();
    }
    values.copy_from_slice(&clean);
    Spikes { samples, largest }
}

/// Returns the distance of a sample from the median of its neighbourhood, and the range of the
/// sample's neighbours without the farthest one.
fn distance(values: &[f64], stretch: &std::ops::Range<usize>, k: usize) -> (f64, f64) {
    let from = k.saturating_sub(SIDE).max(stretch.start);
    let until = (k + SIDE + 1).min(stretch.end);
    let mut others = [0.0; 2 * SIDE];
    let mut count = 0;
    for i in (from..until).filter(|&i| i != k) {
        others[count] = values[i];
        count += 1;
    }
    if count < 2 * SIDE {
        // A sample near the end of a stretch has too few neighbours.
        return (0.0, f64::INFINITY);
    }
    others.sort_unstable_by(f64::total_cmp);
    let middle = 0.5 * (others[SIDE - 1] + others[SIDE]);
    // The range excludes the lowest or the highest neighbour, whichever is farther from the others.
    let range = (others[count - 1] - others[1]).min(others[count - 2] - others[0]);
    ((values[k] - middle).abs(), range)
}

/// Estimates the standard deviation of a normally distributed quantity with zero mean from the
/// median of its magnitudes, which is robust against outliers.
fn robust_deviation(mut magnitudes: Vec<f64>) -> f64 {
    if magnitudes.is_empty() {
        return 0.0;
    }
    let middle = magnitudes.len() / 2;
    let (_, median, _) = magnitudes.select_nth_unstable_by(middle, f64::total_cmp);
    *median / 0.6745
}

/// Returns the smallest nonzero difference between successive samples, which is the resolution of a
/// coarse signal.
fn quantum(values: &[f64]) -> f64 {
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0);
    steps.min_by(f64::total_cmp).unwrap_or(0.0)
}

/// Interpolates spikes between the nearest samples of a stretch that are not spikes.
fn interpolate(times: &[f64], values: &mut [f64], is_spike: &[bool], own: &std::ops::Range<usize>) {
    for k in own.clone().filter(|&k| is_spike[k]) {
        let before = (own.start..k).rev().find(|&i| !is_spike[i]);
        let after = (k + 1..own.end).find(|&i| !is_spike[i]);
        values[k] = match (before, after) {
            (Some(a), Some(b)) => {
                let part = (times[k] - times[a]) / (times[b] - times[a]);
                values[a] + part * (values[b] - values[a])
            }
            (Some(a), None) => values[a],
            (None, Some(b)) => values[b],
            (None, None) => values[k],
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_core::random::Random;

    /// Creates sample times, s, and values of an oscillating effort with friction steps and noise.
    fn effort(noise: f64, seed: u64) -> (Vec<f64>, Vec<f64>) {
        let mut random = Random::new(seed);
        let times: Vec<f64> = (0..4000).map(|k| 0.002 * f64::from(k)).collect();
        let value = |t: &f64| {
            let swing = (7.0 * t).sin();
            3.0 * swing + 2.0 * (5.0 * t).cos().signum() + noise * random.number()
        };
        let values = times.iter().map(value).collect();
        (times, values)
    }

    fn found(times: &[f64], values: &mut [f64]) -> Spikes {
        replace(times, values, std::slice::from_ref(&(0..times.len())), 0.05)
    }

    #[test]
    fn clean_efforts_have_no_spikes() {
        for seed in 1..=20 {
            for noise in [0.0, 0.01, 0.1, 1.0] {
                let (times, mut values) = effort(noise, seed);
                assert_eq!(found(&times, &mut values), Spikes::default(), "{seed} {noise}");
            }
        }
        // Efforts with the coarse resolution of a converter have no spikes either.
        let (times, mut values) = effort(0.02, 1);
        values.iter_mut().for_each(|x| *x = (*x / 0.5).round() * 0.5);
        assert_eq!(found(&times, &mut values), Spikes::default());
    }

    /// Tests that nearly all spikes, and no other samples, are found if one percent of the samples
    /// are spikes, some of them adjacent.
    #[test]
    fn spikes_are_replaced() {
        let (times, clean) = effort(0.05, 3);
        let mut values = clean.clone();
        let mut random = Random::new(8);
        let mut bad = Vec::new();
        for k in 10..values.len() - 10 {
            if random.number() > 0.98 {
                values[k] += if random.number() > 0.0 { 15.0 } else { -15.0 };
                bad.push(k);
            }
        }
        let spikes = found(&times, &mut values);
        assert!(spikes.samples.iter().all(|k| bad.contains(k)));
        // Spikes beside a friction step of the same size may remain.
        assert!(spikes.samples.len() as f64 > 0.95 * bad.len() as f64);
        let kept = spikes.samples.iter().map(|&k| (values[k] - clean[k]).abs());
        assert!(kept.fold(0.0, f64::max) < 4.2, "no farther off than a step of friction");
    }
}
