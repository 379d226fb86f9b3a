//! Estimation by weighted, robust least squares, with a prior at the values of the model and physical constraints.
//!
//! Equations (I3) and (I4) of the book's theory.

mod covariance;
mod extension;
mod instruments;
mod limit;
mod map;
mod minimum;

use crate::block::Block;
use crate::parameter::Parameter;
use covariance::{bounded, colour, covariance};
pub use extension::{Candidate, Extension, Residuals};
use limit::HalfSpace;
use map::{Map, transposed_product};
use minimum::{PRIOR_ERROR, inverse_positive};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;

/// Settings of the estimation.
#[derive(Clone, Debug)]
pub struct Options {
    /// Strength of the prior on inertias, in equivalent independent samples; `None` to choose the
    /// strength by the prediction of left-out pieces of the data.
    pub strength: Option<f64>,
    /// Radius of gyration that is added to the priors of thin bodies, so that their pseudo-inertias are positive
    /// definite, m.
    pub radius: f64,
    /// Flag for each parameter, true if the parameter keeps its prior value.
    pub held: Vec<bool>,
    /// Groups of indices of parameters that have one common value.
    pub tied: Vec<Vec<usize>>,
    /// Indices of parameters with bounds, each with the least and the greatest permitted value, SI
    /// units. Parameters of bodies have no bounds.
    pub bounds: Vec<(usize, [f64; 2])>,
}

/// Regression problem: parameters with their priors, rows of all fitted logs, and settings.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    /// Parameters of the regression.
    pub parameters: &'a [Parameter],
    /// Rows of each log.
    pub blocks: &'a [Block],
    /// Settings of the estimation.
    pub options: &'a Options,
}

/// Estimated values and their uncertainties.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Values, in the order of the parameters, SI units.
    pub values: Vec<f64>,
    /// Standard deviations, which include the autocorrelated noise of the data and the uncertainty that the prior
    /// leaves.
    pub sigmas: Vec<f64>,
    /// Fraction of each value, from 0 to 1, that the data determine; the prior determines the rest.
    pub resolution: Vec<f64>,
    /// Correlation matrix of the errors of the values.
    pub correlation: DMatrix<f64>,
    /// Covariance matrix of the errors of the values, SI units.
    pub covariance: DMatrix<f64>,
    /// Coefficients with which the instruments explain the columns; `None` for least squares.
    projection: Option<DMatrix<f64>>,
    /// Inverse Hessian `H^-1` of the objective, and `H^-1 D H^-1`, where `D` is the part of the
    /// Hessian that the data contribute; both for all parameters.
    inverse: [DMatrix<f64>; 2],
    /// Strength of the prior, in equivalent independent samples.
    pub strength: f64,
    /// Standard deviation of the residuals of each actuator, N or N m.
    pub noise: Vec<f64>,
    /// Mean squared weighted residual of left-out pieces of the data, relative to the mean squared
    /// weighted residual of the fit; one if no data were left out.
    pub left_out_ratio: f64,
    /// Ratio `left_out_ratio` for an estimate with the weakest prior that was compared; infinite if
    /// no data were left out.
    pub left_out_ratio_plain: f64,
    /// Number of independent samples in all rows.
    pub samples: f64,
}

/// Number of pieces into which each log is divided; each piece is left out once.
const FOLDS: usize = 5;
/// Strengths of the prior that are compared by the prediction of left-out data.
const STRENGTHS: [f64; 13] =
    [1e-4, 1e-3, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 1e4];
/// Largest strength of the prior with which the noise is estimated initially.
const WEAK: f64 = 1.0;
/// Relative increase of the squared left-out residuals up to which strengths of the prior count as
/// equally good. Such an increase does less harm than an unnecessarily strong prior, whose standard
/// deviations follow from the errors of the model and not from the data.
const LITTLE: f64 = 0.1;
/// Residual, in standard deviations, beyond which a row loses weight (Huber).
const HUBER: f64 = 2.5;

/// Sums over the rows of one piece of the data: `sum w M^T M`, `sum w M^T y`, `sum w y^2`, and the
/// number of independent rows. `M` is a row in free coordinates, `y` its right-hand side, `w` its
/// weight. `limits` are the half-spaces of the efforts at rest.
#[derive(Clone, Debug)]
pub(crate) struct Normal {
    pub(crate) matrix: DMatrix<f64>,
    pub(crate) right: DVector<f64>,
    square: f64,
    rows: f64,
    limits: Vec<HalfSpace>,
}

impl Normal {
    fn zero(size: usize) -> Self {
        Self {
            matrix: DMatrix::zeros(size, size),
            right: DVector::zeros(size),
            square: 0.0,
            rows: 0.0,
            limits: Vec::new(),
        }
    }

    fn add(&mut self, other: &Self, sign: f64) {
        self.matrix += &other.matrix * sign;
        self.right += &other.right * sign;
        self.square += sign * other.square;
        self.rows += sign * other.rows;
    }

    /// Returns the weighted sum of squared residuals at the free coordinates `x`.
    pub(crate) fn cost(&self, x: &DVector<f64>) -> f64 {
        self.square - 2.0 * self.right.dot(x) + x.dot(&(&self.matrix * x))
    }
}

impl Estimate {
    /// Returns the variance of a linear combination of parameters, and the fraction of its value,
    /// from 0 to 1, that the data determine. `members` are the indices and coefficients of the
    /// parameters.
    pub fn combined(&self, members: &[(usize, f64)]) -> (f64, f64) {
        let product = |matrix: &DMatrix<f64>| -> f64 {
            let each = members
                .iter()
                .flat_map(|(i, a)| members.iter().map(move |(k, b)| a * b * matrix[(*i, *k)]));
            each.sum::<f64>().max(0.0)
        };
        let [all, data] = self.inverse.each_ref().map(product);
        let resolution = if all > 0.0 { (data / all).clamp(0.0, 1.0) } else { 0.0 };
        (product(&self.covariance), resolution)
    }
}

impl Problem<'_> {
    /// Estimates all parameters.
    pub fn solve(&self) -> Estimate {
        self.solve_with(true)
    }

    fn solve_with(&self, compares: bool) -> Estimate {
        let map = self.map();
        let shift = self.shift();
        let channels = self.blocks.first().map_or(0, |block| block.channels.len());
        let mut noise = vec![1.0; channels];
        let mut weights: Vec<Vec<Vec<f64>>> = self
            .blocks
            .iter()
            .map(|block| block.channels.iter().map(|rows| vec![1.0; rows.len()]).collect())
            .collect();
        for (channel, noise) in noise.iter_mut().enumerate() {
            let all = self.blocks.iter().map(|block| &block.channels[channel]);
            let (sum, count) =
                all.fold((0.0, 0), |(s, n), rows| (s + rows.right.norm_squared(), n + rows.len()));
            *noise = (sum / count.max(1) as f64).sqrt().max(1e-300);
        }
        // If the noise is overestimated, a strong prior causes large residuals, which confirm the
        // wrong estimate. The noise is therefore estimated first with a weak prior.
        let mut strength = self.options.strength.map_or(WEAK, |own| own.min(WEAK));
        let mut values =
            DVector::from_iterator(self.parameters.len(), self.parameters.iter().map(|p| p.prior));
        let mut ratios = (1.0, f64::INFINITY);
        const ROUNDS: usize = 5;
        for round in 0..ROUNDS {
            let projection = self.projection(&noise, &weights);
            let design = self.design(projection.as_ref());
            let pieces_of = |blocks| pieces(blocks, &map, &shift, (&noise, &weights));
            let pieces = pieces_of(&design);
            let total = self.total(&map, &shift, &noise, &pieces);
            if round + 2 == ROUNDS {
                let mut chosen = self.options.strength;
                if compares {
                    // Strength of a prior whose errors are those that the confidence intervals take
                    // into account.
                    let samples = colour(self.blocks, &(&values - &shift));
                    let own = samples / (PRIOR_ERROR * PRIOR_ERROR);
                    // The fit uses the columns that the instruments explain; predictions use the
                    // complete columns.
                    let judged = projection.as_ref().map(|_| pieces_of(self.blocks));
                    let judged = judged.as_ref().unwrap_or(&pieces);
                    let (best, ratio, plain) =
                        self.chosen_strength(&map, (&pieces, judged, &total), own);
                    chosen = chosen.or(Some(best));
                    ratios = (ratio, plain);
                }
                strength = chosen.unwrap_or(strength);
            }
            let z = self.minimum(&map, &total, strength);
            values = map.values(&z);
            let at = &values - &shift;
            for (channel, noise) in noise.iter_mut().enumerate() {
                let mut squares = Vec::new();
                for block in self.blocks {
                    let residuals = block.channels[channel].residuals(&at);
                    squares.extend(residuals.iter().map(|r| r.abs()));
                }
                if squares.is_empty() {
                    continue;
                }
                // The median resists outliers. The lower limits keep the weights of exact data
                // finite.
                squares.sort_by(f64::total_cmp);
                let median = squares[squares.len() / 2] / 0.6745;
                let rms =
                    (squares.iter().map(|r| r * r).sum::<f64>() / squares.len() as f64).sqrt();
                let largest: f64 = self
                    .blocks
                    .iter()
                    .flat_map(|block| block.channels[channel].measured.iter())
                    .fold(0.0, |max, y| y.abs().max(max));
                *noise = median.max(0.05 * rms).max(1e-10 * largest).max(1e-300);
            }
            for (block, weights) in self.blocks.iter().zip(&mut weights) {
                for ((rows, weights), noise) in block.channels.iter().zip(weights).zip(&noise) {
                    let residuals = rows.residuals(&at);
                    for (weight, residual) in weights.iter_mut().zip(residuals.iter()) {
                        *weight = (HUBER * noise / residual.abs()).min(1.0);
                    }
                }
            }
        }
        self.described(&map, &shift, values, strength, noise, &weights, ratios)
    }

    /// Computes an estimate with the prior strength of the estimate `before`, instead of choosing
    /// the strength anew.
    pub fn solve_fixed(&self, before: &Estimate) -> Estimate {
        let options = Options { strength: Some(before.strength), ..self.options.clone() };
        Problem { options: &options, ..self.clone() }.solve_with(false)
    }

    /// Estimates with a weak prior, so that the residuals contain no error of the prior.
    pub fn solve_weakly(&self) -> Estimate {
        let strength = Some(self.options.strength.map_or(WEAK, |own| own.min(WEAK)));
        let options = Options { strength, ..self.options.clone() };
        Problem { options: &options, ..self.clone() }.solve_with(false)
    }

    /// Returns the reference values of all parameters; the unknowns of the fit are differences from
    /// these values. The known efforts contain the inertias of the model, so the reference values
    /// of inertial parameters are the values of the model. All other reference values are zero.
    fn shift(&self) -> DVector<f64> {
        let each = self.parameters.iter().map(|p| if p.body().is_some() { p.prior } else { 0.0 });
        DVector::from_iterator(self.parameters.len(), each)
    }

    /// Adds the sums of all pieces, and includes the half-spaces of the efforts at rest.
    fn total(&self, map: &Map, shift: &DVector<f64>, noise: &[f64], pieces: &[Normal]) -> Normal {
        let mut total = Normal::zero(map.size());
        pieces.iter().for_each(|piece| total.add(piece, 1.0));
        total.limits = self.limits(map, shift, noise);
        total
    }

    /// Chooses the strength of the prior. Candidates are the strengths whose fits predict left-out
    /// pieces as well as the best strength, within two standard errors or [`LITTLE`]; the candidate
    /// closest to `prior` is chosen. Also returns the mean square of the left-out residuals
    /// relative to the mean square of the fit's residuals, for the chosen and for the weakest
    /// strength.
    fn chosen_strength(
        &self,
        map: &Map,
        (pieces, judged, total): (&[Normal], &[Normal], &Normal),
        prior: f64,
    ) -> (f64, f64, f64) {
        let scored = |strength: f64| -> Vec<f64> {
            let folds = pieces.len().clamp(1, FOLDS);
            // Pieces at the same place in all logs are left out together.
            (0..folds)
                .map(|fold| {
                    let mut rest = total.clone();
                    let mut out = Normal::zero(map.size());
                    for (piece, judged) in pieces.iter().zip(judged).skip(fold).step_by(folds) {
                        rest.add(piece, -1.0);
                        out.add(judged, 1.0);
                    }
                    let z = self.minimum(map, &rest, strength);
                    out.cost(&z).max(0.0) / out.rows.max(1.0)
                })
                .collect()
        };
        let mean = |scores: &[f64]| scores.iter().sum::<f64>() / scores.len().max(1) as f64;
        let mut whole = Normal::zero(map.size());
        judged.iter().for_each(|piece| whole.add(piece, 1.0));
        let fitted = |strength: f64| {
            let z = self.minimum(map, total, strength);
            whole.cost(&z).max(1e-30) / whole.rows.max(1.0)
        };
        let all: Vec<(f64, Vec<f64>)> = match self.options.strength {
            Some(strength) => {
                vec![(strength, scored(strength)), (STRENGTHS[0], scored(STRENGTHS[0]))]
            }
            None => STRENGTHS.iter().map(|&s| (s, scored(s))).collect(),
        };
        let weakest =
            mean(&all.iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(vec![], |a| a.1.clone()));
        let chosen = match self.options.strength {
            Some(_) => 0,
            None => {
                let best = (0..all.len())
                    .min_by(|&a, &b| mean(&all[a].1).total_cmp(&mean(&all[b].1)))
                    .unwrap_or(0);
                // The strengths are compared piece by piece, so that the scatter between pieces has
                // no influence.
                let is_as_good = |k: usize| {
                    let d: Vec<f64> =
                        all[k].1.iter().zip(&all[best].1).map(|(a, b)| a - b).collect();
                    let m = mean(&d);
                    let spread = d.iter().map(|x| (x - m).powi(2)).sum::<f64>();
                    let n = d.len() as f64;
                    let error = (spread / (n * (n - 1.0).max(1.0))).sqrt();
                    m <= (2.0 * error).max(LITTLE * mean(&all[best].1))
                };
                let away = |k: usize| (all[k].0 / prior).ln().abs();
                let as_good = (0..all.len()).filter(|&k| is_as_good(k));
                as_good.min_by(|&a, &b| away(a).total_cmp(&away(b))).unwrap_or(best)
            }
        };
        let strength = all[chosen].0;
        let ratio = mean(&all[chosen].1) / fitted(strength);
        (strength, ratio, weakest / fitted(STRENGTHS[0]))
    }

    #[expect(clippy::too_many_arguments, reason = "results of the last round")]
    fn described(
        &self,
        map: &Map,
        shift: &DVector<f64>,
        values: DVector<f64>,
        strength: f64,
        noise: Vec<f64>,
        weights: &[Vec<Vec<f64>>],
        (left_out_ratio, left_out_ratio_plain): (f64, f64),
    ) -> Estimate {
        let projection = self.projection(&noise, weights);
        let design = self.design(projection.as_ref());
        let pieces = pieces(&design, map, shift, (&noise, weights));
        let total = self.total(map, shift, &noise, &pieces);
        let z = self.minimum(map, &total, strength);
        let (priors, precision) = (self.priors(), self.precision(strength));
        let size = z.len();
        let (gradient, hessian) =
            self.objective(map, &total, strength, &priors, &precision, &z).map_or_else(
                || (DVector::zeros(size), total.matrix.clone()),
                |(_, gradient, hessian)| (gradient, hessian),
            );
        let inverse = inverse_positive(&hessian).unwrap_or_else(|| DMatrix::zeros(size, size));
        let meat = covariance((&design, self.blocks), map, &(&values - shift), &noise, total.rows);
        let open = self.prior_errors(map, &values, strength, &priors, &precision);
        let free = &inverse * (meat + open + total.limit_errors(&z)) * &inverse;
        let unbounded = &z - &inverse * gradient;
        let beyond = (0..size).filter_map(|k| {
            let is_at = self.interval(map, k).contains(&z[k]);
            is_at.then(|| (k, (unbounded[k] - z[k]).abs()))
        });
        let free = bounded(free, beyond);
        let by_data = &inverse * &total.matrix * &inverse;
        let full = map.spread(&free);
        let count = self.parameters.len();
        let sigmas: Vec<f64> = (0..count).map(|k| full[(k, k)].max(0.0).sqrt()).collect();
        let correlation = DMatrix::from_fn(count, count, |i, k| {
            let size = sigmas[i] * sigmas[k];
            if size > 0.0 { full[(i, k)] / size } else { 0.0 }
        });
        let resolution = (0..count).map(|k| {
            map.entry(k).map_or(0.0, |(column, _)| {
                let place = (column, column);
                (by_data[place] / inverse[place].max(1e-300)).clamp(0.0, 1.0)
            })
        });
        Estimate {
            resolution: resolution.collect(),
            values: values.as_slice().to_vec(),
            sigmas,
            correlation,
            covariance: full,
            projection,
            inverse: [&inverse, &by_data].map(|free| map.spread(free)),
            strength,
            noise,
            left_out_ratio,
            left_out_ratio_plain,
            samples: total.rows,
        }
    }
}

/// Computes the sums over each piece of all logs, in free coordinates. The unknowns are differences
/// of the parameters from `shift`. Rows without instruments do not count.
fn pieces(
    blocks: &[Block],
    map: &Map,
    shift: &DVector<f64>,
    (noise, weights): (&[f64], &[Vec<Vec<f64>>]),
) -> Vec<Normal> {
    let size = map.size();
    let offset = &map.base - shift;
    let mut pieces = Vec::new();
    for (block, weights) in blocks.iter().zip(weights) {
        let length = block.fold_length(FOLDS);
        let mut own = vec![Normal::zero(size); FOLDS];
        for ((rows, weights), noise) in block.channels.iter().zip(weights).zip(noise) {
            let mut from = 0;
            let empty: BTreeSet<usize> = rows.rows_without_instruments().into_iter().collect();
            for (fold, piece) in own.iter_mut().enumerate() {
                let end = (fold + 1) * length;
                let until = rows.steps.partition_point(|step| *step < end);
                if until > from {
                    let matrix = rows.matrix.rows(from, until - from);
                    let mut right = rows.right.rows(from, until - from) - matrix * &offset;
                    let mut scaled = map.columns(&rows.matrix, from..until);
                    let own = from..until;
                    let left_out = empty.iter().filter(|row| own.contains(row)).count();
                    for (row, weight) in weights[own].iter().enumerate() {
                        let weight = if empty.contains(&(from + row)) { 0.0 } else { *weight };
                        let factor = (weight * block.independence).sqrt() / noise;
                        scaled.row_mut(row).scale_mut(factor);
                        right[row] *= factor;
                    }
                    piece.matrix += transposed_product(&scaled, &scaled);
                    piece.right += scaled.tr_mul(&right);
                    piece.square += right.norm_squared();
                    piece.rows += (until - from - left_out) as f64 * block.independence;
                }
                from = until;
            }
        }
        pieces.extend(own.into_iter().filter(|piece| piece.rows > 0.0));
    }
    pieces
}
