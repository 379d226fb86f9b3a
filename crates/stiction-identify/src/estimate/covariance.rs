//! Covariance of the right-hand side of the normal equations, which accounts for the autocorrelation (colour) of the
//! residuals.
//!
//! Equation (I5) of the book's theory.

use super::autocovariance::{Places, Sums, autocovariance, each_pair, residuals, series};
use super::map::{Map, transposed_product};
use crate::block::Block;
use crate::motions::motions;
use nalgebra::{DMatrix, DVector};

/// Largest number of corrections of the autocovariance. Each one multiplies the remaining error at a frequency by the part
/// of the errors at this frequency that the fit removes.
const CORRECTIONS: usize = 4;
/// A correction that enlarges the variance of the errors by less than this part is the last one.
const SMALL_CORRECTION: f64 = 0.005;

/// Covariance of the right-hand side of the normal equations.
pub(super) struct Covariance {
    /// `sum over lags k of r(k) M_t^T M_(t+k)` over all efforts, in free coordinates, with the estimated autocovariance
    /// `r` of the errors.
    pub(super) matrix: DMatrix<f64>,
    /// Mean ratio, over all efforts, of the variance of the errors to that of the residuals.
    pub(super) inflation: f64,
}

/// Computes the covariance of the right-hand side of the normal equations. `r` is the autocovariance of the errors,
/// tapered to zero at twice the lag at which the residuals become uncorrelated. Weights are `1/noise^2` and the
/// independence of each block. `M_t` is the row of `design` at the instant `t`; the residuals are those of `blocks`.
/// `inverse` is the inverse Hessian.
///
/// The fit removes from the residuals what the columns can explain of the errors, at low frequencies much more than on
/// average. With `S`, which turns measured into predicted efforts, the residuals have the covariance
/// `(1 - S) R (1 - S)^T` if the errors have `R`. The difference is averaged over each lag and added to the autocovariance of
/// the residuals; it depends on `R` itself, so this is repeated, first with the autocovariance of the residuals.
pub(super) fn covariance(
    (design, blocks): (&[Block], &[Block]),
    map: &Map,
    values: &DVector<f64>,
    noise: &[f64],
    inverse: &DMatrix<f64>,
) -> Covariance {
    let size = map.size();
    // Weighted rows `w M_t` of each block.
    let weighted = |channel: usize| -> Vec<DMatrix<f64>> {
        let rows = design.iter().map(|block| {
            let own = &block.channels[channel];
            let weight = block.independence / noise[channel].powi(2);
            map.columns(&own.matrix, 0..own.len()) * weight
        });
        rows.collect()
    };
    let all_smoothed = |channel: usize, rows: &[DMatrix<f64>], autocovariance: &[f64]| {
        let each = design
            .iter()
            .zip(rows)
            .map(|(block, rows)| smoothed(&block.channels[channel].steps, rows, autocovariance));
        each.collect::<Vec<DMatrix<f64>>>()
    };
    let of_residuals: Vec<Vec<f64>> = (0..noise.len())
        .map(|channel| {
            autocovariance(&series(blocks, channel, &residuals(blocks, channel, values)))
        })
        .collect();
    // Rows are computed again rather than kept, because those of all efforts would take much memory.
    let sum = |autocovariances: &[Vec<f64>]| {
        let mut matrix = DMatrix::zeros(size, size);
        for (channel, own) in autocovariances.iter().enumerate() {
            let rows = weighted(channel);
            for (rows, smoothed) in rows.iter().zip(all_smoothed(channel, &rows, own)) {
                let product = transposed_product(rows, &smoothed);
                // The product is symmetric up to rounding errors.
                matrix += (&product + product.transpose()) * 0.5;
            }
        }
        matrix
    };
    // Rows of steady motions are independent and have no order in time.
    let in_time = blocks.iter().any(|block| block.independence < 1.0);
    // Autocovariances of the errors, from those found last and their covariance `matrix`.
    let correct = |last: &[Vec<f64>], matrix: &DMatrix<f64>| -> Vec<Vec<f64>> {
        let each = of_residuals.iter().zip(last).enumerate().map(|(channel, (own, last))| {
            let smoothed = all_smoothed(channel, &weighted(channel), last);
            let parts = motions(blocks).into_iter().map(|members| {
                let each = members.iter().map(|&k| {
                    let own = &blocks[k].channels[channel];
                    let predicted = map.columns(&own.matrix, 0..own.len()) * inverse;
                    let rest = &smoothed[k] - &predicted * matrix * 0.5;
                    [predicted, rest]
                });
                (Places::of(blocks, &members, channel), stacked(each.collect()))
            });
            let lags = if in_time { own.len() } else { 1 };
            corrected(own, &missing(parts.collect(), lags))
        });
        each.collect()
    };
    let growth = |of_errors: &[Vec<f64>]| {
        let ratios = of_errors.iter().zip(&of_residuals).map(|(errors, residuals)| {
            // An effort without rows or residuals has no errors.
            if residuals[0] > 0.0 { errors[0] / residuals[0] } else { 1.0 }
        });
        ratios.sum::<f64>() / noise.len().max(1) as f64
    };
    let uncorrected = sum(&of_residuals);
    let (mut matrix, mut of_errors) = (uncorrected.clone(), of_residuals.clone());
    let mut inflation = 1.0;
    for _ in 0..CORRECTIONS {
        of_errors = correct(&of_errors, &matrix);
        matrix = sum(&of_errors);
        let last = std::mem::replace(&mut inflation, growth(&of_errors));
        if !in_time || inflation - last < SMALL_CORRECTION {
            break;
        }
    }
    // The correction is right on average only: with few rows it could remove most of a variance.
    let is_valid = (0..size).all(|k| matrix[(k, k)] >= 0.5 * uncorrected[(k, k)]);
    let matrix = if is_valid { matrix } else { uncorrected * inflation };
    Covariance { matrix, inflation }
}

/// Stacks the rows of the matrices of several blocks.
fn stacked(mut parts: Vec<[DMatrix<f64>; 2]>) -> [DMatrix<f64>; 2] {
    if let [_] = parts[..]
        && let Some(only) = parts.pop()
    {
        return only;
    }
    [0, 1].map(|which| {
        let (rows, columns) =
            (parts.iter().map(|own| own[which].nrows()).sum(), parts[0][which].ncols());
        let mut all = DMatrix::zeros(rows, columns);
        let mut from = 0;
        for own in &parts {
            let count = own[which].nrows();
            all.rows_mut(from, count).copy_from(&own[which]);
            from += count;
        }
        all
    })
}

/// Sums the rows of one block over all lags, so that one product of tall matrices suffices.
fn smoothed(steps: &[usize], rows: &DMatrix<f64>, autocovariance: &[f64]) -> DMatrix<f64> {
    let lags = autocovariance.len();
    let rows = rows.transpose();
    let mut sums: DMatrix<f64> = DMatrix::zeros(rows.nrows(), rows.ncols());
    each_pair(steps, lags, |i, k, lag| {
        let taper = 1.0 - lag as f64 / lags as f64;
        let r = taper * autocovariance[lag];
        sums.column_mut(i).axpy(r, &rows.column(k), 1.0);
        if lag > 0 {
            sums.column_mut(k).axpy(r, &rows.column(i), 1.0);
        }
    });
    sums.transpose()
}

/// Part of the errors' covariance that the fit removes from the residuals of one effort, as the mean over all pairs of
/// rows at each lag. In each block, this part is `U V^T + V U^T` for all pairs of rows. `parts` are the places of the rows
/// of each block, `U` and `V`.
fn missing(parts: Vec<(Places<'_>, [DMatrix<f64>; 2])>, lags: usize) -> Vec<f64> {
    let folded = parts.into_iter().map(|(places, both)| {
        let both = both.map(|matrix| places.folded(&matrix));
        (places, both)
    });
    let folded: Vec<(Places<'_>, [DMatrix<f64>; 2])> = folded.collect();
    let at = |lag: usize| {
        let of_block = |(places, [u, v]): &(Places<'_>, [DMatrix<f64>; 2])| {
            places.sums(lag, |i, k| u.column(i).dot(&v.column(k)) + v.column(i).dot(&u.column(k)))
        };
        folded.iter().map(of_block).fold(Sums::default(), Sums::plus).mean()
    };
    (0..lags).map(at).collect()
}

/// Autocovariance of the errors: that of the residuals and what the fit removed from it. The
/// variance grows at most to twice its value. If `missing` is known at lag zero only, the
/// autocovariance grows by the same factor at all lags.
fn corrected(autocovariance: &[f64], missing: &[f64]) -> Vec<f64> {
    let mut errors = autocovariance.to_vec();
    let share = missing[0] / autocovariance[0];
    if share.is_nan() || share <= 0.0 {
        return errors;
    }
    if missing.len() < errors.len() {
        // What is removed was computed from the residuals and is itself too small by this factor.
        errors.iter_mut().for_each(|r| *r /= 1.0 - share.min(0.5));
        return errors;
    }
    let part = share.min(1.0) / share;
    errors.iter_mut().zip(missing).for_each(|(r, missing)| *r += part * missing);
    errors
}

/// Number of samples of the residuals that together count as one independent sample, as the mean
/// over all efforts. For each effort, it is the sum of the autocorrelation of the residuals,
/// divided by the same sum for white noise after the filter; at least one.
pub(super) fn colour(blocks: &[Block], values: &DVector<f64>) -> f64 {
    let channels = blocks.first().map_or(0, |block| block.channels.len());
    let each = (0..channels).map(|channel| {
        let residuals = residuals(blocks, channel, values);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::{Options, Problem};
    use crate::parameter::{Kind, Parameter};
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

    /// Slow errors, of which slow columns explain much: the covariance of the right-hand side by random numbers.
    #[test]
    fn the_fit_removes_correlated_errors_from_the_residuals() {
        const ROWS: usize = 400;
        const SIZE: usize = 40;
        const INDEPENDENCE: f64 = 0.5;
        let mut random = Random::new(9);
        // Slow columns, as those of a slow motion.
        let matrix = DMatrix::from_fn(ROWS, SIZE, |row, k| {
            (0.05 * row as f64 * ((k / 2 + 1) as f64).powf(1.1) + f64::from(k as u8 % 2)).sin()
        });
        let data = matrix.tr_mul(&matrix);
        let inverse = (&data * INDEPENDENCE).try_inverse().unwrap();
        // First-order autoregressive errors with unit variance.
        let part: f64 = 0.5;
        let correlation = DMatrix::from_fn(ROWS, ROWS, |i, k| part.powi(i.abs_diff(k) as i32));
        let expected = matrix.tr_mul(&(&correlation * &matrix)) * INDEPENDENCE.powi(2);
        let options = Options {
            strength: None,
            prior_error: 0.1,
            radius: 0.01,
            held: vec![false; SIZE],
            tied: Vec::new(),
            bounds: Vec::new(),
            inequalities: Vec::new(),
        };
        let parameter = |k| Parameter {
            name: String::new(),
            unit: "",
            kind: Kind::Term(k),
            prior: 0.0,
            scale: 1.0,
        };
        let parameters: Vec<Parameter> = (0..SIZE).map(parameter).collect();
        let (mut found, mut inflation, mut squares) = (DMatrix::zeros(SIZE, SIZE), 0.0, 0.0);
        const RUNS: usize = 200;
        for _ in 0..RUNS {
            let mut last = 0.0;
            let errors = DVector::from_fn(ROWS, |row, _| {
                let next: f64 = (0..12).map(|_| 0.5 + 0.5 * random.number()).sum::<f64>() - 6.0;
                last =
                    if row == 0 { next } else { part * last + (1.0 - part * part).sqrt() * next };
                last
            });
            let values = &inverse * matrix.tr_mul(&errors) * INDEPENDENCE;
            let steps = (0..ROWS).collect();
            let (right, measured) = (errors.clone(), errors);
            let rows = Rows { matrix: matrix.clone(), right, measured, instruments: None, steps };
            squares += rows.residuals(&values).norm_squared() / ROWS as f64;
            let blocks = [Block::new(vec![rows], INDEPENDENCE)];
            let problem = Problem { parameters: &parameters, blocks: &blocks, options: &options };
            let own = covariance((&blocks, &blocks), &problem.map(), &values, &[1.0], &inverse);
            found += own.matrix / RUNS as f64;
            inflation += own.inflation / RUNS as f64;
        }
        let (expected_inflation, mean) =
            (RUNS as f64 / squares, |m: &DMatrix<f64>| (&inverse * m).trace());
        assert!(
            (inflation / expected_inflation - 1.0).abs() < 0.01,
            "{inflation} {expected_inflation}"
        );
        let ratio = mean(&found) / mean(&expected);
        assert!((0.96..1.02).contains(&ratio), "{ratio}");
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
}
