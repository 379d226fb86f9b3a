//! Tests whether a regression lacks a column: coefficient of the column, and improvement in the
//! prediction of left-out data.
//!
//! Equation (I7) of the book's theory.

use super::autocovariance::{autocovariance, each_pair, series};
use super::{Estimate, FOLDS, HUBER, Problem};
use crate::block::Block;
use crate::folds::Folds;
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;

/// Column that the regression may lack: a signal in the rows of one actuator.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Index of the actuator.
    pub channel: usize,
    /// Values of the signal in the rows of that actuator, for each block.
    pub signal: Vec<DVector<f64>>,
}

/// Result of adding a column to a fit.
#[derive(Clone, Debug)]
pub struct Extension {
    /// Coefficient of the column.
    pub value: f64,
    /// Standard deviation of the coefficient, which accounts for the autocorrelation of the residuals.
    pub sigma: f64,
    /// Fraction by which the column reduces the actuator's squared residuals, when each fifth of
    /// the logs is predicted by a fit to the other fifths. The fraction is negative if the squared
    /// residuals increase.
    pub gain: f64,
    /// Standard error of the gain, from its scatter between the fifths.
    pub gain_sigma: f64,
    /// Change of each parameter when the column is added to the fit, SI units.
    pub changes: DVector<f64>,
}

/// A column is tested only if the parameters leave more than this fraction of its squared length
/// unexplained.
const DISTINCT: f64 = 1e-6;

/// Weighted residuals of a fit, for the test of columns that the fit may lack.
#[derive(Debug)]
pub struct Residuals<'a> {
    problem: &'a Problem<'a>,
    /// Blocks with the columns of the normal equations.
    design: Cow<'a, [Block]>,
    inverse: &'a DMatrix<f64>,
    /// Residuals and weights of the rows for each block and actuator.
    rows: Vec<Vec<[DVector<f64>; 2]>>,
    /// Factor by which the residuals underestimate the variance of the errors, because the fit uses
    /// up degrees of freedom.
    inflation: f64,
}

impl Problem<'_> {
    /// Computes the residuals of an estimate.
    pub fn residuals<'a>(&'a self, estimate: &'a Estimate) -> Residuals<'a> {
        let at = DVector::from_column_slice(&estimate.values) - self.shift();
        let rows = self.blocks.iter().map(|block| {
            let channels = block.channels.iter().zip(&estimate.noise).map(|(rows, noise)| {
                let residuals = rows.residuals(&at);
                let weights = residuals.map(|r| {
                    (HUBER * noise / r.abs()).min(1.0) * block.independence / (noise * noise)
                });
                [residuals, weights]
            });
            channels.collect()
        });
        Residuals {
            problem: self,
            design: self.design(estimate.projection.as_ref()),
            inverse: &estimate.inverse[0],
            rows: rows.collect(),
            inflation: estimate.inflation,
        }
    }
}

impl Residuals<'_> {
    /// Returns the change of each parameter, SI units, if `efforts` are added to the measured
    /// efforts of each block and actuator.
    pub fn response(&self, efforts: &[Vec<DVector<f64>>]) -> DVector<f64> {
        let mut product = DVector::zeros(self.problem.parameters.len());
        for ((block, rows), efforts) in self.design.iter().zip(&self.rows).zip(efforts) {
            for ((channel, [_, weights]), effort) in block.channels.iter().zip(rows).zip(efforts) {
                product.gemv_tr(1.0, &channel.matrix, &effort.component_mul(weights), 1.0);
            }
        }
        self.inverse * product
    }

    /// Tests a column that is added to the fit. Returns `None` if the parameters explain the
    /// column, or if the column is zero in all rows.
    pub fn extension(&self, candidate: &Candidate) -> Option<Extension> {
        let (blocks, own) = (&self.design[..], candidate.channel);
        // Part of the column that the parameters explain.
        let mut product = DVector::zeros(self.problem.parameters.len());
        let (mut square, mut along) = (0.0, 0.0);
        for ((block, rows), signal) in blocks.iter().zip(&self.rows).zip(&candidate.signal) {
            let [residuals, weights] = &rows[own];
            let weighted = signal.component_mul(weights);
            product.gemv_tr(1.0, &block.channels[own].matrix, &weighted, 1.0);
            square += weighted.dot(signal);
            along += weighted.dot(residuals);
        }
        let explained = self.inverse * &product;
        let rest = square - product.dot(&explained);
        if square.is_nan() || rest.is_nan() || rest <= DISTINCT * square {
            return None;
        }
        let value = along / rest;
        let mut left: Vec<Vec<DVector<f64>>> = Vec::with_capacity(blocks.len());
        for (block, signal) in blocks.iter().zip(&candidate.signal) {
            let each = block.channels.iter().enumerate().map(|(channel, rows)| {
                let mut left = &rows.matrix * &explained * -1.0;
                if channel == own {
                    left += signal;
                }
                left
            });
            left.push(each.collect());
        }
        let (gain, gain_sigma) = self.gain(own, &left);
        let sigma = self.variance(value, &left).sqrt() / rest;
        let changes = explained * -value;
        Some(Extension { value, sigma, gain, gain_sigma, changes })
    }

    /// Computes [`Extension::gain`] for the actuator `own`, and its standard error. `left` is the
    /// part of the column that the parameters do not explain, for each block and actuator.
    fn gain(&self, own: usize, left: &[Vec<DVector<f64>>]) -> (f64, f64) {
        let mut sums = [[0.0; 2]; FOLDS];
        let mut size = 0.0;
        for ((block, rows), left) in self.problem.blocks.iter().zip(&self.rows).zip(left) {
            let folds = Folds::new(block, FOLDS);
            for (channel, ([residuals, weights], left)) in rows.iter().zip(left).enumerate() {
                for (row, step) in block.channels[channel].steps.iter().enumerate() {
                    let fold = folds.of(*step);
                    sums[fold][0] += weights[row] * left[row] * residuals[row];
                    sums[fold][1] += weights[row] * left[row] * left[row];
                    if channel == own {
                        size += weights[row] * residuals[row] * residuals[row];
                    }
                }
            }
        }
        let total = sums.iter().fold([0.0; 2], |all, own| [all[0] + own[0], all[1] + own[1]]);
        let gains = sums.map(|[along, square]| {
            let rest = total[1] - square;
            let value = if rest > 0.0 { (total[0] - along) / rest } else { 0.0 };
            (2.0 * value * along - value * value * square) / size.max(1e-300)
        });
        let count = FOLDS as f64;
        let sum: f64 = gains.iter().sum();
        let scatter: f64 = gains.iter().map(|gain| (gain - sum / count).powi(2)).sum();
        (sum, (scatter * count / (count - 1.0)).sqrt())
    }

    /// Computes the variance of the weighted sum of residuals along the column. The result is the
    /// larger of two estimates: from the mean autocorrelation of the residuals, and from the
    /// residuals' own products, which are larger if residuals are large in the same rows as the
    /// column.
    fn variance(&self, value: f64, left: &[Vec<DVector<f64>>]) -> f64 {
        let blocks = self.problem.blocks;
        let channels = blocks.first().map_or(0, |block| block.channels.len());
        let mut sums = [0.0; 2];
        for channel in 0..channels {
            let pairs = || self.rows.iter().zip(left);
            let residuals: Vec<DVector<f64>> =
                pairs().map(|(rows, left)| &rows[channel][0] - &left[channel] * value).collect();
            let autocovariance = autocovariance(&series(blocks, channel, &residuals));
            let lags = autocovariance.len();
            for (((rows, left), block), own) in pairs().zip(blocks).zip(&residuals) {
                let steps = &block.channels[channel].steps;
                let scaled = rows[channel][1].component_mul(&left[channel]);
                each_pair(steps, lags, |i, k, lag| {
                    let taper = 1.0 - lag as f64 / lags as f64;
                    let twice = if lag > 0 { 2.0 } else { 1.0 };
                    let product = twice * taper * scaled[i] * scaled[k];
                    sums[0] += product * autocovariance[lag];
                    sums[1] += product * own[i] * own[k];
                });
            }
        }
        self.inflation * sums[0].max(sums[1]).max(0.0)
    }
}
