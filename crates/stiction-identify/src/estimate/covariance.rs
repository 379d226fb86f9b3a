//! Covariance of the right-hand side of the normal equations, which accounts for the autocorrelation (colour) of the
//! residuals.
//!
//! Equation (I5) of the book's theory.

use super::map::{Map, transposed_product};
use crate::block::Block;
use nalgebra::{DMatrix, DVector};

/// Smallest number of lags, in rows: several correlation times of the filter.
const LAGS: usize = 24;
/// Largest number of lags. Errors of the model that change more slowly count as constant.
const MOST_LAGS: usize = 1000;
/// Autocorrelation below which residuals count as uncorrelated.
const INDEPENDENT: f64 = 0.05;

/// Computes `sum over lags k of r(k) M_t^T M_(t+k)` over all efforts, in free coordinates. `r` is the autocovariance of
/// the residuals, tapered to zero at twice the lag at which they become uncorrelated. Weights are `1/noise^2` and the
/// independence of each block.
pub(crate) fn covariance(
    blocks: &[Block],
    map: &Map,
    values: &DVector<f64>,
    noise: &[f64],
    samples: f64,
) -> DMatrix<f64> {
    let size = map.size();
    let mut sum = DMatrix::zeros(size, size);
    // Residuals are smaller than errors by the degrees of freedom that the fit has used.
    let used = (size as f64).min(0.5 * samples);
    let inflation = samples / (samples - used).max(1.0);
    for (channel, noise) in noise.iter().enumerate() {
        let steps: Vec<&[usize]> =
            blocks.iter().map(|block| &block.channels[channel].steps[..]).collect();
        let residuals: Vec<DVector<f64>> =
            blocks.iter().map(|block| block.channels[channel].residuals(values)).collect();
        let autocovariance = autocovariance(&steps, &residuals);
        let lags = autocovariance.len();
        for block in blocks {
            let rows = &block.channels[channel];
            if rows.is_empty() {
                continue;
            }
            let scaled = map.columns(&rows.matrix, 0..rows.len());
            // For each lag the rows that it smooths with: one product of tall matrices in all.
            let mut smoothed: DMatrix<f64> = DMatrix::zeros(rows.len(), size);
            each_pair(&rows.steps, lags, |i, k, lag| {
                let taper = 1.0 - lag as f64 / lags as f64;
                let r = inflation * taper * autocovariance[lag];
                smoothed.row_mut(i).zip_apply(&scaled.row(k), |s, m| *s += r * m);
                if lag > 0 {
                    smoothed.row_mut(k).zip_apply(&scaled.row(i), |s, m| *s += r * m);
                }
            });
            let factor = (block.independence / (noise * noise)).powi(2);
            sum += transposed_product(&scaled, &smoothed) * factor;
        }
    }
    // Symmetric up to rounding.
    (&sum + sum.transpose()) * 0.5
}

/// Autocovariance of the residuals of one effort in all blocks, by lag; the number of lags depends on the
/// autocorrelation.
pub(super) fn autocovariance(steps: &[&[usize]], residuals: &[DVector<f64>]) -> Vec<f64> {
    let longest = residuals.iter().map(|r| r.len()).max().unwrap_or(0);
    let most = (longest / 4).clamp(LAGS, MOST_LAGS);
    let (mut sums, mut pairs) = (vec![0.0; most], vec![0.0; most]);
    for (steps, residuals) in steps.iter().zip(residuals) {
        each_pair(steps, most, |i, k, lag| {
            sums[lag] += residuals[i] * residuals[k];
            pairs[lag] += 1.0;
        });
    }
    let mut all: Vec<f64> = sums.iter().zip(&pairs).map(|(s, n)| s / f64::max(*n, 1.0)).collect();
    let first = all[0];
    // Correlations of independent residuals scatter by the root of the number of pairs.
    let is_independent = |lag: &usize| {
        all[*lag] < first * f64::max(INDEPENDENT, 2.0 / f64::max(pairs[*lag], 1.0).sqrt())
    };
    let colour = (1..most).find(is_independent).unwrap_or(most);
    all.truncate((2 * colour).clamp(LAGS, most));
    all
}

/// Calls `take` with each pair of rows whose lag in steps is below `lags`, and with that lag.
pub(super) fn each_pair(steps: &[usize], lags: usize, mut take: impl FnMut(usize, usize, usize)) {
    for i in 0..steps.len() {
        for k in i..steps.len() {
            let lag = steps[k] - steps[i];
            if lag >= lags {
                break;
            }
            take(i, k, lag);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_core::random::Random;

    /// White residuals need few lags, residuals that change every hundred rows more than these.
    #[test]
    fn lags_follow_the_colour_of_the_residuals() {
        let lags = |residual: &mut dyn FnMut(usize) -> f64| {
            let residuals = DVector::from_fn(4000, |k, _| residual(k));
            let steps: Vec<usize> = (0..4000).collect();
            autocovariance(&[&steps], &[residuals]).len()
        };
        let mut random = Random::new(3);
        assert_eq!(lags(&mut |_| random.number()), LAGS);
        let slow = lags(&mut |k| if (k / 100) % 2 == 0 { 1.0 } else { -1.0 });
        // Its autocorrelation falls linearly to zero at fifty rows; twice that is taken.
        assert!((90..=100).contains(&slow), "{slow}");
    }
}
