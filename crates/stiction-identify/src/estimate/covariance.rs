//! Covariance of the right-hand side of the normal equations, from the colour of the residuals.
//!
//! Equation (I5) of the book's theory.

use super::Map;
use crate::block::Block;
use nalgebra::{DMatrix, DVector};

/// Longest lag, in rows: several correlation times of the filter.
const LAGS: usize = 24;

/// `sum over lags k of r(k) M_t^T M_(t+k)` over all efforts, with the autocovariance `r` of their
/// residuals, tapered to zero at the longest lag; in free coordinates, for weights `1/noise^2` and the
/// independence of each block.
pub(crate) fn covariance(
    blocks: &[Block],
    map: &Map,
    values: &DVector<f64>,
    noise: &[f64],
    samples: f64,
) -> DMatrix<f64> {
    let size = map.matrix.ncols();
    let mut sum = DMatrix::zeros(size, size);
    // Residuals are smaller than errors by the degrees of freedom that the fit has used.
    let used = (size as f64).min(0.5 * samples);
    let inflation = samples / (samples - used).max(1.0);
    for (channel, noise) in noise.iter().enumerate() {
        let mut autocovariance = [0.0; LAGS];
        let mut pairs = [0.0; LAGS];
        for block in blocks {
            let rows = &block.channels[channel];
            let residuals = rows.residuals(values);
            each_pair(&rows.steps, |i, k, lag| {
                autocovariance[lag] += residuals[i] * residuals[k];
                pairs[lag] += 1.0;
            });
        }
        for block in blocks {
            let rows = &block.channels[channel];
            if rows.is_empty() {
                continue;
            }
            let scaled = &rows.matrix * &map.matrix;
            // For each lag the rows that it smooths with: one product of tall matrices in all.
            let mut smoothed: DMatrix<f64> = DMatrix::zeros(rows.len(), size);
            each_pair(&rows.steps, |i, k, lag| {
                let taper = 1.0 - lag as f64 / LAGS as f64;
                let r = inflation * taper * autocovariance[lag] / f64::max(pairs[lag], 1.0);
                smoothed.row_mut(i).zip_apply(&scaled.row(k), |s, m| *s += r * m);
                if lag > 0 {
                    smoothed.row_mut(k).zip_apply(&scaled.row(i), |s, m| *s += r * m);
                }
            });
            let factor = (block.independence / (noise * noise)).powi(2);
            sum += scaled.tr_mul(&smoothed) * factor;
        }
    }
    // Symmetric up to rounding.
    (&sum + sum.transpose()) * 0.5
}

/// Pairs of rows with their lag in steps, below [`LAGS`].
fn each_pair(steps: &[usize], mut take: impl FnMut(usize, usize, usize)) {
    for i in 0..steps.len() {
        for k in i..steps.len() {
            let lag = steps[k] - steps[i];
            if lag >= LAGS {
                break;
            }
            take(i, k, lag);
        }
    }
}
