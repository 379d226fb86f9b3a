//! Estimation by weighted, robust least squares, with a prior at the values of the model and physical constraints.
//!
//! Equations (I3) and (I4) of the book's theory.

mod autocovariance;
mod constraint;
mod covariance;
mod extension;
mod instruments;
mod left_out;
mod limit;
mod map;
mod minimum;
mod strength;

use crate::block::Block;
use crate::folds::Folds;
use crate::parameter::Parameter;
use crate::rows::Rows;
use constraint::Held;
pub use constraint::Inequality;
use covariance::{bounded, colour, covariance};
pub use extension::{Candidate, Extension, Residuals};
pub use left_out::LeftOut;
use limit::HalfSpace;
use map::{Map, transposed_product};
use minimum::{Prior, inverse_positive};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;

/// Settings of the estimation.
#[derive(Clone, Debug)]
pub struct Options {
    /// Strength of the prior on inertias, in equivalent independent samples; `None` to choose the most probable one for
    /// the data.
    pub strength: Option<f64>,
    /// Relative error of the model's inertias that is expected before the data are seen; positive. It sets the
    /// expected strength of the prior, and the standard deviations allow for at least this error.
    pub prior_error: f64,
    /// Radius of gyration that is added to the priors of thin bodies, so that their pseudo-inertias are positive
    /// definite, m.
    pub radius: f64,
    /// Flag for each parameter, true if the parameter keeps its prior value.
    pub held: Vec<bool>,
    /// Groups of indices of parameters that have one common value.
    pub tied: Vec<Vec<usize>>,
    /// Indices of parameters with bounds, each with the least and the greatest permitted value, SI
    /// units. Bounds of parameters of bodies are inequalities.
    pub bounds: Vec<(usize, [f64; 2])>,
    /// Inequalities for parameters of bodies. [`Problem::initial`] must satisfy them.
    pub inequalities: Vec<Inequality>,
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
    /// Standard deviations, which include the autocorrelated noise of the data, the uncertainty that the prior leaves,
    /// and the change of the values with the strength of the prior, which is known to a factor of e.
    pub sigmas: Vec<f64>,
    /// Fraction of each value, from 0 to 1, that the data determine; the prior determines the rest.
    pub resolution: Vec<f64>,
    /// Change of each value if the strength of the prior grew by the factor e, SI units.
    pub pull: Vec<f64>,
    /// Correlation matrix of the errors of the values.
    pub correlation: DMatrix<f64>,
    /// Covariance matrix of the errors of the values, SI units.
    pub covariance: DMatrix<f64>,
    /// Coefficients with which the instruments explain the columns; `None` for least squares.
    projection: Option<DMatrix<f64>>,
    /// Inverse Hessian `H^-1` of the objective, and `H^-1 D H^-1`, where `D` is the part of the
    /// Hessian that the data contribute; both for all parameters.
    inverse: [DMatrix<f64>; 2],
    /// Factor by which the residuals underestimate the variance of the errors.
    inflation: f64,
    /// Strength of the prior, in equivalent independent samples.
    pub strength: f64,
    /// Relative error of the model's inertias for which the standard deviations allow.
    prior_error: f64,
    /// Standard deviation of the residuals of each actuator, N or N m.
    pub noise: Vec<f64>,
    /// Number of independent samples in all rows.
    pub samples: f64,
}

/// Number of pieces into which each log is divided; each piece is left out once.
const FOLDS: usize = 5;
/// Largest strength of the prior with which the noise is estimated initially.
const WEAK: f64 = 1.0;
/// Residual, in standard deviations, beyond which a row loses weight (Huber).
const HUBER: f64 = 2.5;

/// Sums over the rows of one piece of the data: `sum w M^T M`, `sum w M^T y`, `sum w y^2`, and the
/// number of independent rows. `M` is a row in free coordinates, `y` its right-hand side, `w` its
/// weight. `limits` are the half-spaces of the efforts at rest.
#[derive(Clone, Debug)]
pub(crate) struct Normal {
    pub(crate) matrix: DMatrix<f64>,
    pub(crate) right: DVector<f64>,
    pub(crate) square: f64,
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

    /// Adds a multiple of other sums; the number of rows changes by theirs.
    fn add(&mut self, other: &Self, factor: f64) {
        self.matrix += &other.matrix * factor;
        self.right += &other.right * factor;
        self.square += factor * other.square;
        self.rows += other.rows.copysign(factor);
    }

    /// Returns the weighted sum of squared residuals at the free coordinates `x`.
    pub(crate) fn cost(&self, x: &DVector<f64>) -> f64 {
        self.square - 2.0 * self.right.dot(x) + x.dot(&(&self.matrix * x))
    }
}

impl Estimate {
    /// Variance of a combination of parameters, the fraction of its value, from 0 to 1, that the data determine, and
    /// its change if the strength of the prior grew by the factor e.
    pub fn combined(&self, members: &[(usize, f64)]) -> (f64, f64, f64) {
        let product = |matrix: &DMatrix<f64>| -> f64 {
            let each = members
                .iter()
                .flat_map(|(i, a)| members.iter().map(move |(k, b)| a * b * matrix[(*i, *k)]));
            each.sum::<f64>().max(0.0)
        };
        let [all, data] = self.inverse.each_ref().map(product);
        let resolution = if all > 0.0 { (data / all).clamp(0.0, 1.0) } else { 0.0 };
        let pull = members.iter().map(|(k, a)| a * self.pull[*k]).sum();
        (product(&self.covariance), resolution, pull)
    }
}

impl Problem<'_> {
    /// Estimates all parameters.
    pub fn solve(&self) -> Estimate {
        self.solve_with(self.options.prior_error)
    }

    fn solve_with(&self, mut error: f64) -> Estimate {
        let map = self.map();
        let bodies = self.priors();
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
        // The floor keeps exact data finite.
        let largest = |channel: usize| {
            let measured = self.blocks.iter().flat_map(|b| b.channels[channel].measured.iter());
            measured.fold(0.0, |max: f64, y| y.abs().max(max))
        };
        let least: Vec<f64> =
            (0..channels).map(|channel| (1e-10 * largest(channel)).max(1e-300)).collect();
        // If the noise is too large, a strong prior causes errors that confirm it. The noise is
        // therefore estimated first with a weak prior.
        let mut strength = self.options.strength.map_or(WEAK, |own| own.min(WEAK));
        let mut values =
            DVector::from_iterator(self.parameters.len(), self.parameters.iter().map(|p| p.prior));
        const ROUNDS: usize = 5;
        for round in 0..ROUNDS {
            let projection = self.projection(&noise, &weights);
            let design = self.design(projection.as_ref());
            let pieces = pieces(&design, &map, &shift, (&noise, &weights));
            let is_last = round + 1 == ROUNDS;
            let z = if self.options.strength.is_none() && !is_last {
                // The first round knows no residuals yet.
                let samples = match round {
                    0 => 1.0,
                    _ => colour(self.blocks, &(&values - &shift)),
                };
                let least: Vec<f64> = noise.iter().zip(&least).map(|(s, l)| l / s).collect();
                let choice = self.choice(&map, &pieces.channels, &least, samples, &bodies);
                strength = choice.strength;
                let least = self.options.prior_error;
                error = (samples / strength).sqrt().clamp(least, least.max(1.0));
                choice.z
            } else {
                let total = self.total(&map, &shift, &noise, &pieces.folds);
                if round + 2 >= ROUNDS {
                    strength = self.options.strength.unwrap_or(strength);
                }
                self.minimum(&map, &total, &self.prior(&bodies, strength))
            };
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
                *noise = median.max(0.05 * rms).max(least[channel]);
            }
            weights = self.weights(&at, &noise);
        }
        let prior = self.prior(&bodies, strength);
        self.described(&map, &shift, values, (&prior, error), noise, &weights)
    }

    /// Computes an estimate with the prior strength of the estimate `before`, instead of choosing
    /// the strength anew.
    pub fn solve_fixed(&self, before: &Estimate) -> Estimate {
        let options = Options { strength: Some(before.strength), ..self.options.clone() };
        Problem { options: &options, ..self.clone() }.solve_with(before.prior_error)
    }

    /// Estimates with a weak prior, so that the residuals contain no error of the prior.
    pub fn solve_weakly(&self) -> Estimate {
        let strength = Some(self.options.strength.map_or(WEAK, |own| own.min(WEAK)));
        let options = Options { strength, ..self.options.clone() };
        Problem { options: &options, ..self.clone() }.solve_with(self.options.prior_error)
    }

    /// Returns the reference values of all parameters; the unknowns of the fit are differences from
    /// these values. The known efforts contain the inertias of the model, so the reference values
    /// of inertial parameters are the values of the model. All other reference values are zero.
    fn shift(&self) -> DVector<f64> {
        let each = self.parameters.iter().map(|p| if p.body().is_some() { p.prior } else { 0.0 });
        DVector::from_iterator(self.parameters.len(), each)
    }

    /// Weights of all rows of each block and actuator: one, or less for residuals that are large compared with
    /// `noise` (Huber). `at` are differences from [`Self::shift`].
    fn weights(&self, at: &DVector<f64>, noise: &[f64]) -> Vec<Vec<Vec<f64>>> {
        let of_rows = |rows: &Rows, noise: &f64| {
            let residuals = rows.residuals(at);
            residuals.iter().map(|residual| (HUBER * noise / residual.abs()).min(1.0)).collect()
        };
        let of_block = |block: &Block| {
            block.channels.iter().zip(noise).map(|(rows, noise)| of_rows(rows, noise)).collect()
        };
        self.blocks.iter().map(of_block).collect()
    }

    /// Sums over all pieces, with the bounds of efforts at rest.
    fn total(&self, map: &Map, shift: &DVector<f64>, noise: &[f64], pieces: &[Normal]) -> Normal {
        let mut total = Normal::zero(map.size());
        pieces.iter().for_each(|piece| total.add(piece, 1.0));
        total.limits = self.limits(map, shift, noise);
        total
    }

    fn described(
        &self,
        map: &Map,
        shift: &DVector<f64>,
        values: DVector<f64>,
        (prior, error): (&Prior<'_>, f64),
        noise: Vec<f64>,
        weights: &[Vec<Vec<f64>>],
    ) -> Estimate {
        let projection = self.projection(&noise, weights);
        let design = self.design(projection.as_ref());
        let pieces = pieces(&design, map, shift, (&noise, weights));
        let total = self.total(map, shift, &noise, &pieces.folds);
        let z = self.minimum(map, &total, prior);
        let size = z.len();
        let (gradient, hessian) = self.objective(map, &total, prior, &z).map_or_else(
            || (DVector::zeros(size), total.matrix.clone()),
            |(_, gradient, hessian)| (gradient, hessian),
        );
        let inverse = inverse_positive(&hessian).unwrap_or_else(|| DMatrix::zeros(size, size));
        let data = (&design[..], self.blocks);
        let errors = covariance(data, map, &(&values - shift), &noise, &inverse);
        let open = self.prior_errors(map, &values, prior, error);
        let slope = self.strength_slope(map, &values, prior);
        let free = &inverse
            * (errors.matrix + open + total.limit_errors(&z) + &slope * slope.transpose())
            * &inverse;
        let unbounded = &inverse * gradient;
        let unit = |k: usize| DVector::from_fn(size, |i, _| f64::from(u8::from(i == k)));
        let at_bounds: Vec<DVector<f64>> = (0..size)
            .filter(|&k| self.interval(map, k).contains(&z[k]))
            .map(unit)
            .chain(
                self.constraints(map)
                    .into_iter()
                    .filter(|own| own.is_active(&z))
                    .map(|own| own.direction),
            )
            .collect();
        let beyond = at_bounds.iter().map(|own| (own, own.dot(&unbounded).abs()));
        let free = bounded(free, beyond);
        // Values at their bounds stay there if the strength changes.
        let bounds: Vec<&DVector<f64>> = at_bounds.iter().collect();
        let pull = Held::of(&inverse * &slope, &bounds, |own| &inverse * own);
        let pull = map.changes(&pull.step) * -1.0;
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
            pull: pull.as_slice().to_vec(),
            sigmas,
            correlation,
            covariance: full,
            projection,
            inverse: [&inverse, &by_data].map(|free| map.spread(free)),
            inflation: errors.inflation,
            strength: prior.strength,
            prior_error: error,
            noise,
            samples: total.rows,
        }
    }
}

/// Sums over the rows.
struct Pieces {
    /// Sums over each piece of each log, over all actuators: [`FOLDS`] pieces for each log, of which some may have no
    /// rows.
    folds: Vec<Normal>,
    /// Sums for each actuator, over all logs.
    channels: Vec<Normal>,
}

/// Computes the sums over each piece of all logs, and those for each actuator, in free coordinates. The right-hand side is that
/// of the differences from `shift`. Rows without instruments do not count.
fn pieces(
    blocks: &[Block],
    map: &Map,
    shift: &DVector<f64>,
    (noise, weights): (&[f64], &[Vec<Vec<f64>>]),
) -> Pieces {
    let size = map.size();
    let offset = &map.base - shift;
    let mut pieces = Pieces { folds: Vec::new(), channels: vec![Normal::zero(size); noise.len()] };
    for (block, weights) in blocks.iter().zip(weights) {
        let folds = Folds::new(block, FOLDS);
        let mut own = vec![Normal::zero(size); FOLDS];
        let channels = block.channels.iter().zip(&mut pieces.channels);
        for (((rows, channel), weights), noise) in channels.zip(weights).zip(noise) {
            let mut from = 0;
            let empty: BTreeSet<usize> = rows.rows_without_instruments().into_iter().collect();
            while from < rows.len() {
                let fold = folds.of(rows.steps[from]);
                let more = rows.steps[from..].iter().take_while(|step| folds.of(**step) == fold);
                let until = from + more.count();
                let matrix = rows.matrix.rows(from, until - from);
                let mut right = rows.right.rows(from, until - from) - matrix * &offset;
                let mut scaled = map.columns(&rows.matrix, from..until);
                let span = from..until;
                let left_out = empty.iter().filter(|row| span.contains(row)).count();
                for (row, weight) in weights[span].iter().enumerate() {
                    let weight = if empty.contains(&(from + row)) { 0.0 } else { *weight };
                    let factor = (weight * block.independence).sqrt() / noise;
                    scaled.row_mut(row).scale_mut(factor);
                    right[row] *= factor;
                }
                let piece = Normal {
                    matrix: transposed_product(&scaled, &scaled),
                    right: scaled.tr_mul(&right),
                    square: right.norm_squared(),
                    rows: (until - from - left_out) as f64 * block.independence,
                    limits: Vec::new(),
                };
                own[fold].add(&piece, 1.0);
                channel.add(&piece, 1.0);
                from = until;
            }
        }
        pieces.folds.extend(own);
    }
    pieces
}
