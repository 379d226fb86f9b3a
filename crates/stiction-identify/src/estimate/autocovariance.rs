//! Autocovariance of the residuals by lag.

use crate::block::Block;
use crate::motions::motions;
use crate::period::Period;
use nalgebra::{DMatrix, DVector, Dim, Dyn, Matrix, Storage};
use std::borrow::Cow;

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

/// Residuals of one effort in all blocks of one motion.
pub(super) struct Series<'a> {
    pub(super) places: Places<'a>,
    pub(super) residuals: Cow<'a, DVector<f64>>,
}

/// Residuals of one effort in the blocks of each motion.
pub(super) fn series<'a>(
    blocks: &'a [Block],
    channel: usize,
    residuals: &'a [DVector<f64>],
) -> Vec<Series<'a>> {
    let each = motions(blocks).into_iter().map(|members| Series {
        places: Places::of(blocks, &members, channel),
        residuals: match members[..] {
            [only] => Cow::Borrowed(&residuals[only]),
            _ => {
                let all = members.iter().flat_map(|&k| residuals[k].iter().copied());
                Cow::Owned(DVector::from_vec(all.collect()))
            }
        },
    });
    each.collect()
}

/// Autocovariance of the residuals of one effort in all blocks, by lag, up to twice the lag at
/// which the residuals become uncorrelated. The residuals of a repeated motion are summed over its
/// repetitions first: the columns repeat themselves, so the products of residuals in different
/// repetitions count like those in one. Errors of the model are the same in all repetitions.
pub(super) fn autocovariance(all: &[Series<'_>]) -> Vec<f64> {
    let all = all.iter().map(|own| (&own.places, own.places.folded(&own.residuals)));
    let all: Vec<(&Places<'_>, DMatrix<f64>)> = all.collect();
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

/// Places of the rows of one effort in the blocks of one motion: the rows themselves, or the instants of a motion that is
/// repeated in one or several logs, whose rows are summed over the repetitions.
pub(super) enum Places<'a> {
    Once {
        steps: &'a [usize],
    },
    /// Place of each row, the number of rows at each place, and whether the first place follows the last one.
    Repeated {
        places: Vec<usize>,
        numbers: Vec<f64>,
        is_cyclic: bool,
    },
}

impl<'a> Places<'a> {
    /// Returns the places of the rows of an effort in the blocks `members`, which have the same motion.
    pub(super) fn of(blocks: &'a [Block], members: &[usize], channel: usize) -> Self {
        let first = &blocks[members[0]];
        let period = first.period();
        if period.is_none() && members.len() == 1 {
            return Self::Once { steps: &first.channels[channel].steps };
        }
        let length = first.repetition().map_or(0, |own| own.length);
        let count = period.map_or(length, Period::instants);
        let place = |instant: usize| period.map_or(instant, |period| period.part(instant, count));
        let rows = members.iter().flat_map(|&k| {
            let block = &blocks[k];
            block.channels[channel].steps.iter().map(move |step| place(block.instant(*step)))
        });
        let places: Vec<usize> = rows.collect();
        let mut numbers = vec![0.0; count];
        places.iter().for_each(|place| numbers[*place] += 1.0);
        Self::Repeated { places, numbers, is_cyclic: period.is_some() }
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
            Self::Repeated { numbers, is_cyclic: true, .. } if lag >= numbers.len() / 2 => {}
            Self::Repeated { numbers, is_cyclic, .. } => {
                let last =
                    if *is_cyclic { numbers.len() } else { numbers.len().saturating_sub(lag) };
                for i in 0..last {
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
            let (places, residuals) = (Places::Once { steps: &steps }, Cow::Borrowed(&residuals));
            autocovariance(&[Series { places, residuals }]).len()
        };
        let mut random = Random::new(3);
        assert_eq!(lags(&mut |_| random.number()), LAGS);
        let slow = lags(&mut |k| if (k / 100) % 2 == 0 { 1.0 } else { -1.0 });
        // The autocorrelation falls linearly to zero at fifty rows; the lags reach twice as far.
        assert!((90..=100).contains(&slow), "{slow}");
    }
}
