//! Autocovariance of the residuals by lag.

use crate::block::Block;
use crate::period::Period;
use nalgebra::{DMatrix, DVector, Dim, Dyn, Matrix, Storage};

/// Minimum number of lags of the autocovariance, in rows. It covers several correlation times of
/// the filter.
const LAGS: usize = 24;
/// Maximum number of lags of the autocovariance, in rows. Model errors that stay correlated over
/// more rows than this count as constant.
const MOST_LAGS: usize = 1000;
/// Residuals count as uncorrelated at a lag if their autocorrelation is below this value.
const INDEPENDENT: f64 = 0.05;

/// Residuals of one effort in each block.
pub(super) fn residuals(
    blocks: &[Block],
    channel: usize,
    values: &DVector<f64>,
) -> Vec<DVector<f64>> {
    blocks.iter().map(|block| block.channels[channel].residuals(values)).collect()
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
    let all = all.iter().map(|own| {
        let places = Places::of(own.steps, own.period);
        let folded = places.folded(own.residuals);
        (places, folded)
    });
    let all: Vec<(Places<'_>, DMatrix<f64>)> = all.collect();
    let longest = all.iter().map(|(places, _)| places.len()).max().unwrap_or(0);
    let most = (longest / 4).clamp(LAGS, MOST_LAGS);
    let mut found: Vec<f64> = Vec::new();
    let mut wanted = most;
    // Most residuals become uncorrelated at short lags, so few lags are computed.
    while found.len() < wanted {
        let lag = found.len();
        let each = all.iter().map(|(places, own)| places.sums(lag, |i, k| own[i] * own[k]));
        let sums = each.fold(Sums::default(), Sums::plus);
        found.push(sums.mean());
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
pub(super) struct Sums {
    products: f64,
    /// Number of pairs of rows.
    pairs: f64,
    /// Number of independent products.
    count: f64,
}

impl Sums {
    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            products: self.products + other.products,
            pairs: self.pairs + other.pairs,
            count: self.count + other.count,
        }
    }

    pub(super) fn mean(self) -> f64 {
        self.products / f64::max(self.pairs, 1.0)
    }
}

/// Places of the rows of one effort in one block: the rows themselves, or the instants of the period of a repeated motion,
/// whose rows are summed over the repetitions.
pub(super) enum Places<'a> {
    Once {
        steps: &'a [usize],
    },
    /// Place of each row, and the number of rows at each place.
    Repeated {
        places: Vec<usize>,
        numbers: Vec<f64>,
    },
}

impl<'a> Places<'a> {
    pub(super) fn of(steps: &'a [usize], period: Option<Period>) -> Self {
        let Some(period) = period else { return Self::Once { steps } };
        let count = period.instants();
        let places: Vec<usize> = steps.iter().map(|step| period.part(*step, count)).collect();
        let mut numbers = vec![0.0; count];
        places.iter().for_each(|place| numbers[*place] += 1.0);
        Self::Repeated { places, numbers }
    }

    /// Number of places.
    fn len(&self) -> usize {
        match self {
            Self::Once { steps } => steps.len(),
            Self::Repeated { numbers, .. } => numbers.len(),
        }
    }

    fn of_row(&self, row: usize) -> usize {
        match self {
            Self::Once { .. } => row,
            Self::Repeated { places, .. } => places[row],
        }
    }

    /// Sums the rows of a matrix at each place; each column of the result belongs to one place.
    pub(super) fn folded<C: Dim, S: Storage<f64, Dyn, C>>(
        &self,
        rows: &Matrix<f64, Dyn, C, S>,
    ) -> DMatrix<f64> {
        let mut sums = DMatrix::zeros(rows.ncols(), self.len());
        for (k, column) in rows.column_iter().enumerate() {
            column.iter().enumerate().for_each(|(row, x)| sums[(k, self.of_row(row))] += x);
        }
        sums
    }

    /// Sums the products of all pairs of places at one lag.
    pub(super) fn sums(&self, lag: usize, product: impl Fn(usize, usize) -> f64) -> Sums {
        let mut all = Sums::default();
        match self {
            Self::Once { steps } => {
                let mut k = 0;
                for (i, step) in steps.iter().enumerate() {
                    while k < steps.len() && steps[k] < step + lag {
                        k += 1;
                    }
                    if steps.get(k) == Some(&(step + lag)) {
                        all.products += product(i, k);
                        all.pairs += 1.0;
                    }
                }
                all.count = all.pairs;
            }
            // Lags beyond half a period are lags of the next repetition.
            Self::Repeated { numbers, .. } if lag >= numbers.len() / 2 => {}
            Self::Repeated { numbers, .. } => {
                for i in 0..numbers.len() {
                    let k = (i + lag) % numbers.len();
                    if numbers[i] > 0.0 && numbers[k] > 0.0 {
                        all.products += product(i, k);
                        all.pairs += (numbers[i] * numbers[k]).sqrt();
                        all.count += 1.0;
                    }
                }
            }
        }
        all
    }
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
    use stiction_core::random::Random;

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
