//! Latin hypercubes. Each dimension is divided into as many equal intervals as there are points,
//! and each interval contains exactly one point.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// One dimension of a Latin hypercube. Equal seeds give equal points on every machine.
#[derive(Clone, Debug)]
pub(super) struct LatinHypercube {
    /// Index of the interval that contains each point.
    intervals: Vec<u32>,
    /// Random numbers for the positions of the points within their intervals. Each dimension has
    /// its own stream of numbers.
    places: ChaCha8Rng,
}

/// Index of the first random stream that determines positions of points within their intervals.
/// Streams with smaller indices are used for permutations.
const PLACES: u64 = 1 << 32;
/// Number of 32-bit random words that determine the position of one point within its interval.
const WORDS: u128 = 2;

impl LatinHypercube {
    pub(super) fn new(seed: u64, dimension: usize, points: u32) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut places = random.clone();
        random.set_stream(dimension as u64);
        places.set_stream(PLACES + dimension as u64);
        let mut intervals: Vec<u32> = (0..points).collect();
        // Fisher and Yates' shuffle.
        for last in (1..intervals.len()).rev() {
            intervals.swap(last, below(&mut random, last as u64 + 1) as usize);
        }
        Self { intervals, places }
    }

    /// Returns the coordinate of the point with this index, at least 0 and less than 1.
    pub(super) fn at(&self, point: u64) -> f64 {
        let mut places = self.places.clone();
        places.set_word_pos(WORDS * u128::from(point));
        let interval = self.intervals.get(point as usize).copied().unwrap_or(0);
        let coordinate =
            (f64::from(interval) + unit(places.next_u64())) / self.intervals.len() as f64;
        // Rounding may yield 1, which belongs to no interval.
        coordinate.min(1.0 - f64::EPSILON)
    }
}

/// Converts the 53 leading bits of `bits` to a number that is at least 0 and less than 1.
pub(super) fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// Returns a random integer less than `bound`; all integers have the same probability.
fn below(random: &mut ChaCha8Rng, bound: u64) -> u64 {
    // Numbers beyond the largest multiple of the bound are rejected, because they would favour
    // small results.
    let limit = u64::MAX - u64::MAX % bound;
    loop {
        let number = random.next_u64();
        if number < limit {
            return number % bound;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests the defining property of a Latin hypercube: in each dimension, every interval contains
    /// one point.
    #[test]
    fn every_interval_has_one_point() {
        for points in [1, 2, 7, 1000] {
            for dimension in 0..5 {
                let cube = LatinHypercube::new(3, dimension, points);
                let mut seen = vec![false; points as usize];
                for point in 0..u64::from(points) {
                    let x = cube.at(point);
                    assert!((0.0..1.0).contains(&x));
                    let interval = (x * f64::from(points)) as usize;
                    assert!(!seen[interval], "{points} points, dimension {dimension}");
                    seen[interval] = true;
                }
            }
        }
    }

    /// Tests that dimensions and seeds are independent: the correlations of 10 000 points are below
    /// six standard deviations, 6/sqrt(10 000).
    #[test]
    fn dimensions_and_seeds_are_not_correlated() {
        let cube = |seed, dimension| {
            let cube = LatinHypercube::new(seed, dimension, 10_000);
            (0..10_000).map(|point| cube.at(point) - 0.5).collect::<Vec<f64>>()
        };
        let [a, b, c] = [cube(1, 0), cube(1, 1), cube(2, 0)];
        for (x, y) in [(&a, &b), (&a, &c), (&b, &c)] {
            let product: f64 = x.iter().zip(y).map(|(x, y)| 12.0 * x * y).sum();
            assert!((product / 10_000.0).abs() < 0.06, "{product}");
        }
    }
}
