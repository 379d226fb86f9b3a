//! Covariance of the right-hand side of the normal equations, which accounts for the autocorrelation (colour) of the
//! residuals.
//!
//! Equation (I5) of the book's theory.

use super::map::{Map, transposed_product};
use crate::block::Block;
use crate::period::Period;
use nalgebra::{DMatrix, DVector};

/// Minimum number of lags of the autocovariance, in rows. It covers several correlation times of
/// the filter.
const LAGS: usize = 24;
/// Maximum number of lags of the autocovariance, in rows. Model errors that stay correlated over
/// more rows than this count as constant.
const MOST_LAGS: usize = 1000;
/// Residuals count as uncorrelated at a lag if their autocorrelation is below this value.
const INDEPENDENT: f64 = 0.05;

/// Computes `sum over lags k of r(k) M_t^T M_(t+k)` over all efforts, in free coordinates. `r` is
/// the autocovariance of the residuals, tapered to zero at twice the lag at which they become
/// uncorrelated. Weights are `1/noise^2` and the independence of each block. `M_t` is the row of
/// `design` at the instant `t`; the residuals are those of `blocks`. The second result is the same sum
/// for residuals with the variance `noise^2` and the same autocorrelation.
pub(crate) fn covariance(
    (design, blocks): (&[Block], &[Block]),
    map: &Map,
    values: &DVector<f64>,
    noise: &[f64],
) -> [DMatrix<f64>; 2] {
    let size = map.size();
    let mut sums = [DMatrix::zeros(size, size), DMatrix::zeros(size, size)];
    for (channel, noise) in noise.iter().enumerate() {
        let residuals: Vec<DVector<f64>> =
            blocks.iter().map(|block| block.channels[channel].residuals(values)).collect();
        let autocovariance = autocovariance(&series(blocks, channel, &residuals));
        let lags = autocovariance.len();
        let count = residuals.iter().map(DVector::len).sum::<usize>().max(1);
        let variance = residuals.iter().map(DVector::norm_squared).sum::<f64>() / count as f64;
        for block in design {
            let rows = &block.channels[channel];
            if rows.is_empty() {
                continue;
            }
            let scaled = map.columns(&rows.matrix, 0..rows.len());
            // The rows are first summed over all lags, so that one product of tall matrices
            // suffices.
            let mut smoothed: DMatrix<f64> = DMatrix::zeros(rows.len(), size);
            each_pair(&rows.steps, lags, |i, k, lag| {
                let taper = 1.0 - lag as f64 / lags as f64;
                let r = taper * autocovariance[lag];
                smoothed.row_mut(i).zip_apply(&scaled.row(k), |s, m| *s += r * m);
                if lag > 0 {
                    smoothed.row_mut(k).zip_apply(&scaled.row(i), |s, m| *s += r * m);
                }
            });
            let factor = (block.independence / (noise * noise)).powi(2);
            let own = transposed_product(&scaled, &smoothed) * factor;
            // The autocovariance of a repeated motion contains the covariance between its repetitions, so its first value
            // exceeds the variance.
            if variance > 0.0 {
                sums[1] += &own * (noise * noise / variance);
            }
            sums[0] += own;
        }
    }
    // The sums are symmetric up to rounding errors.
    sums.map(|sum| (&sum + sum.transpose()) * 0.5)
}

/// Factor by which residuals underestimate the variance of the errors, because the fit uses up degrees of freedom:
/// `n/(n - tr(2 S R - S R S^T))` for `n` independent samples, the matrix `S` that turns measured into predicted efforts,
/// and the correlation matrix `R` of the errors, estimated from the residuals. Correlated errors use more degrees of freedom
/// than independent ones, because slow errors correlate with the columns. Parameters that only the prior determines use no degrees of freedom. `data` is the part of the
/// Hessian that the data contribute, `coloured` the second result of [`covariance`], which equals `data` for
/// independent samples, and `inverse` the inverse Hessian.
///
/// Source: Hastie, Tibshirani, *Generalized additive models*, Chapman and Hall (1990), section 3.5; with correlated
/// errors, the expectation of the squared residuals.
pub(super) fn inflation(
    samples: f64,
    (data, coloured): (&DMatrix<f64>, &DMatrix<f64>),
    inverse: &DMatrix<f64>,
) -> f64 {
    let (share, spread) = (inverse * data, inverse * coloured);
    let used = 2.0 * spread.trace() - spread.dot(&share.transpose());
    samples / (samples - used.clamp(0.0, 0.5 * samples)).max(1.0)
}

/// Number of samples of the residuals that together count as one independent sample, as the mean
/// over all efforts. For each effort, it is the sum of the autocorrelation of the residuals,
/// divided by the same sum for white noise after the filter; at least one.
pub(super) fn colour(blocks: &[Block], values: &DVector<f64>) -> f64 {
    let channels = blocks.first().map_or(0, |block| block.channels.len());
    let each = (0..channels).map(|channel| {
        let residuals: Vec<DVector<f64>> =
            blocks.iter().map(|block| block.channels[channel].residuals(values)).collect();
        let all = autocovariance(&series(blocks, channel, &residuals));
        let (mut squares, mut count, mut white) = (0.0, 0.0, 0.0);
        for (block, own) in blocks.iter().zip(&residuals) {
            squares += own.norm_squared();
            count += own.len() as f64;
            // White noise after the filter has this sum of autocorrelations in each row.
            white += own.len() as f64 / block.independence;
        }
        let taper = |lag: usize| 1.0 - lag as f64 / all.len() as f64;
        let later: f64 = (1..all.len()).map(|lag| taper(lag) * all[lag]).sum();
        let variance = squares / f64::max(count, 1.0);
        (all[0] + 2.0 * later) / variance * count / white
    });
    let finite = each.map(|samples| if samples > 1.0 { samples } else { 1.0 });
    finite.sum::<f64>() / channels.max(1) as f64
}

/// Residuals of one effort in one block.
pub(super) struct Series<'a> {
    pub(super) steps: &'a [usize],
    pub(super) residuals: &'a DVector<f64>,
    /// Period of the motion if it is repeated.
    pub(super) period: Option<Period>,
}

/// Residuals of one effort in all blocks.
pub(super) fn series<'a>(
    blocks: &'a [Block],
    channel: usize,
    residuals: &'a [DVector<f64>],
) -> Vec<Series<'a>> {
    let each = blocks.iter().zip(residuals).map(|(block, residuals)| Series {
        steps: &block.channels[channel].steps,
        residuals,
        period: block.period(),
    });
    each.collect()
}

/// Autocovariance of the residuals of one effort in all blocks, by lag, up to twice the lag at
/// which the residuals become uncorrelated. The residuals of a repeated motion are summed over its
/// repetitions first: the columns repeat themselves, so the products of residuals in different
/// repetitions count like those in one. Errors of the model are the same in all repetitions.
pub(super) fn autocovariance(all: &[Series<'_>]) -> Vec<f64> {
    let all: Vec<Summed<'_>> = all.iter().map(Summed::of).collect();
    let longest = all.iter().map(Summed::len).max().unwrap_or(0);
    let most = (longest / 4).clamp(LAGS, MOST_LAGS);
    let mut found: Vec<f64> = Vec::new();
    let mut wanted = most;
    // Most residuals become uncorrelated at short lags, so few lags are computed.
    while found.len() < wanted {
        let lag = found.len();
        let sums = all.iter().map(|own| own.at(lag)).fold(Sums::default(), Sums::plus);
        found.push(sums.products / f64::max(sums.pairs, 1.0));
        // The correlations of independent residuals scatter by the inverse root of the number of
        // products.
        let least = f64::max(INDEPENDENT, 2.0 / f64::max(sums.count, 1.0).sqrt());
        if wanted == most && lag > 0 && found[lag] < found[0] * least {
            wanted = (2 * lag).clamp(LAGS, most);
        }
    }
    found
}

/// Sums of the products of residuals at one lag.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    products: f64,
    /// Number of pairs of rows.
    pairs: f64,
    /// Number of independent products.
    count: f64,
}

impl Sums {
    fn plus(self, other: Self) -> Self {
        Self {
            products: self.products + other.products,
            pairs: self.pairs + other.pairs,
            count: self.count + other.count,
        }
    }
}

/// Residuals of one effort in one block, those of a repeated motion summed over its repetitions.
enum Summed<'a> {
    Once {
        steps: &'a [usize],
        residuals: &'a DVector<f64>,
    },
    /// Sums and numbers of the residuals at each instant of the period.
    Repeated {
        sums: Vec<f64>,
        numbers: Vec<f64>,
    },
}

impl<'a> Summed<'a> {
    fn of(series: &Series<'a>) -> Self {
        let Series { steps, residuals, period } = *series;
        let Some(period) = period else { return Self::Once { steps, residuals } };
        let count = period.instants();
        let (mut sums, mut numbers) = (vec![0.0; count], vec![0.0; count]);
        for (step, residual) in steps.iter().zip(residuals.iter()) {
            let place = period.part(*step, count);
            sums[place] += residual;
            numbers[place] += 1.0;
        }
        Self::Repeated { sums, numbers }
    }

    /// Number of rows; of instants in the period of a repeated motion.
    fn len(&self) -> usize {
        match self {
            Self::Once { residuals, .. } => residuals.len(),
            Self::Repeated { sums, .. } => sums.len(),
        }
    }

    fn at(&self, lag: usize) -> Sums {
        let mut all = Sums::default();
        match self {
            Self::Once { steps, residuals } => {
                let mut k = 0;
                for (i, step) in steps.iter().enumerate() {
                    while k < steps.len() && steps[k] < step + lag {
                        k += 1;
                    }
                    if steps.get(k) == Some(&(step + lag)) {
                        all.products += residuals[i] * residuals[k];
                        all.pairs += 1.0;
                    }
                }
                all.count = all.pairs;
            }
            // Lags beyond half a period are lags of the next repetition.
            Self::Repeated { sums, .. } if lag >= sums.len() / 2 => {}
            Self::Repeated { sums, numbers } => {
                for i in 0..sums.len() {
                    let k = (i + lag) % sums.len();
                    if numbers[i] > 0.0 && numbers[k] > 0.0 {
                        all.products += sums[i] * sums[k];
                        all.pairs += (numbers[i] * numbers[k]).sqrt();
                        all.count += 1.0;
                    }
                }
            }
        }
        all
    }
}

/// Computes the covariance of the errors if some values lie at their bounds, from a normal
/// distribution that is truncated at the bounds. `at_bounds` lists the directions along which
/// values lie at their bounds, each with the distance by which the values would exceed the bound if
/// it did not exist.
///
/// The bounds are applied one after the other; the variance along a bounded direction becomes the
/// second moment about its bound.
pub(super) fn bounded<'a>(
    mut covariance: DMatrix<f64>,
    at_bounds: impl IntoIterator<Item = (&'a DVector<f64>, f64)>,
) -> DMatrix<f64> {
    for (direction, distance) in at_bounds {
        let column = &covariance * direction;
        let variance = direction.dot(&column);
        if variance <= 0.0 {
            continue;
        }
        let beyond = distance / variance.sqrt();
        let left = 1.0 - beyond * (inverse_mills(beyond) - beyond);
        covariance.ger((left.clamp(0.0, 1.0) - 1.0) / variance, &column, &column, 1.0);
    }
    covariance
}

/// Computes the ratio of the density of the normal distribution at `x` >= 0 to the probability of
/// larger values, accurate to one percent.
///
/// Source: A. V. Boyd, *Inequalities for Mills' ratio*, Rep. Stat. Appl. Res. JUSE 6 (1959).
fn inverse_mills(x: f64) -> f64 {
    let pi = std::f64::consts::PI;
    ((pi - 1.0) * x + (x * x + 2.0 * pi).sqrt()) / pi
}

/// Calls `take` with the indices of each pair of rows whose lag is below `lags`, and with this lag,
/// in steps of the time grid.
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
    use crate::rows::Rows;
    use stiction_core::random::Random;

    /// Checks the errors of a value at its bound, and of a second value correlated with the first
    /// value, against pairs of random numbers whose first number is not negative.
    #[test]
    fn values_at_their_bound_have_smaller_errors() {
        let mut random = Random::new(5);
        let mut normal = || (0..12).map(|_| 0.5 + 0.5 * random.number()).sum::<f64>() - 6.0;
        for beyond in [0.0, 1.0, 2.0] {
            let (mut sums, mut count) = ([0.0; 2], 0.0);
            for _ in 0..200_000 {
                // The correlation is 0.8; the first number has the mean -beyond, the second the
                // mean zero.
                let (a, b) = (normal(), normal());
                let (x, y) = (a - beyond, 0.8 * a + 0.6 * b);
                if x >= 0.0 {
                    // Errors about the mode, which lies at the bound: x = 0 and y = 0.8 beyond.
                    sums[0] += x * x;
                    sums[1] += (y - 0.8 * beyond).powi(2);
                    count += 1.0;
                }
            }
            let full = DMatrix::from_row_slice(2, 2, &[1.0, 0.8, 0.8, 1.0]);
            let found = bounded(full, [(&DVector::from_column_slice(&[1.0, 0.0]), beyond)]);
            for k in 0..2 {
                let expected = sums[k] / count;
                assert!(
                    (found[(k, k)] / expected - 1.0).abs() < 0.08,
                    "{beyond} {k}: {found} {sums:?}"
                );
            }
        }
    }

    /// A value that the data determine uses one degree of freedom, one that the prior determines uses none, and one that
    /// both determine alike uses three quarters.
    #[test]
    fn data_use_degrees_of_freedom() {
        let data = DMatrix::from_diagonal(&DVector::from_column_slice(&[1e9, 1e-9, 1.0]));
        // The Hessian of the prior is the identity.
        let inverse = DMatrix::from_diagonal(&data.diagonal().map(|own| 1.0 / (own + 1.0)));
        let found = inflation(10.0, (&data, &data), &inverse);
        assert!((found - 10.0 / 8.25).abs() < 1e-6, "{found}");
        // Errors of which two samples count as one use twice as many.
        let found = inflation(10.0, (&data, &(&data * 2.0)), &inverse);
        assert!((found - 10.0 / 6.5).abs() < 1e-6, "{found}");
    }

    /// The expected square of the residuals of a fit to correlated errors, by random numbers.
    #[test]
    fn correlated_errors_use_more_degrees_of_freedom() {
        const ROWS: usize = 200;
        let mut random = Random::new(9);
        // Slow columns, as those of a slow motion.
        let matrix = DMatrix::from_fn(ROWS, 6, |row, k| {
            (0.03 * row as f64 * (k / 2 + 1) as f64 + f64::from(k as u8 % 2)).sin()
        });
        let data = matrix.tr_mul(&matrix);
        let inverse = data.clone().try_inverse().unwrap();
        // First-order autoregressive errors with unit variance.
        let part: f64 = 0.8;
        let correlation = DMatrix::from_fn(ROWS, ROWS, |i, k| part.powi(i.abs_diff(k) as i32));
        let coloured = matrix.tr_mul(&(&correlation * &matrix));
        let expected = inflation(ROWS as f64, (&data, &coloured), &inverse);
        let (mut sum, mut count) = (0.0, 0.0);
        for _ in 0..1000 {
            let mut last = 0.0;
            let errors = DVector::from_fn(ROWS, |row, _| {
                let next: f64 = (0..12).map(|_| 0.5 + 0.5 * random.number()).sum::<f64>() - 6.0;
                last =
                    if row == 0 { next } else { part * last + (1.0 - part * part).sqrt() * next };
                last
            });
            let residuals = &errors - &matrix * (&inverse * matrix.tr_mul(&errors));
            sum += residuals.norm_squared();
            count += ROWS as f64;
        }
        let found = count / sum;
        assert!((found / expected - 1.0).abs() < 0.03, "{found} {expected}");
        let independent = inflation(ROWS as f64, (&data, &data), &inverse);
        assert!(independent < 0.9 * expected, "{independent} {expected}");
    }

    /// Noise that is white before the filter has the colour one in logs with different filters, whatever their order.
    #[test]
    fn filters_of_all_logs_count() {
        let mut random = Random::new(4);
        let mut rows = |is_filtered: bool| {
            let white: Vec<f64> = (0..8000).map(|_| random.number()).collect();
            let right = DVector::from_fn(white.len(), |k, _| match is_filtered {
                true if k > 0 => 0.5_f64.sqrt() * (white[k] + white[k - 1]),
                _ => white[k],
            });
            let (matrix, steps) = (DMatrix::zeros(right.len(), 1), (0..right.len()).collect());
            Rows { matrix, measured: right.clone(), right, instruments: None, steps }
        };
        let table = Block::new(vec![rows(false)], 1.0);
        // Two neighbouring rows share half of their noise, so two rows count as one sample.
        let recorded = Block::new(vec![rows(true)], 0.5);
        for blocks in [[table.clone(), recorded.clone()], [recorded, table]] {
            let found = colour(&blocks, &DVector::zeros(1));
            assert!((1.0..1.15).contains(&found), "{found}");
        }
    }

    /// Checks that white residuals need few lags, and that residuals which change every hundred
    /// rows need more lags.
    #[test]
    fn lags_follow_the_colour_of_the_residuals() {
        let lags = |residual: &mut dyn FnMut(usize) -> f64| {
            let residuals = DVector::from_fn(4000, |k, _| residual(k));
            let steps: Vec<usize> = (0..4000).collect();
            autocovariance(&[Series { steps: &steps, residuals: &residuals, period: None }]).len()
        };
        let mut random = Random::new(3);
        assert_eq!(lags(&mut |_| random.number()), LAGS);
        let slow = lags(&mut |k| if (k / 100) % 2 == 0 { 1.0 } else { -1.0 });
        // The autocorrelation falls linearly to zero at fifty rows; the lags reach twice as far.
        assert!((90..=100).contains(&slow), "{slow}");
    }
}
