//! Sobol's sequence: points that fill a cube evenly, for any number of points.

use super::direction_numbers::DIRECTION_NUMBERS;

/// Largest number of dimensions of Sobol's sequence.
pub(super) const MOST_DIMENSIONS: usize = DIRECTION_NUMBERS.len() + 1;
/// Number of bits of a coordinate.
const BITS: usize = 64;

/// One dimension of Sobol's sequence, with 64 bits for each coordinate.
///
/// The points are in the order of the Gray code, as in the program of S. Joe and F. Y. Kuo.
#[derive(Clone, Debug)]
pub(super) struct Sobol {
    directions: [u64; BITS],
}

impl Sobol {
    /// Creates a dimension of the sequence; `dimension` counts from 0 and is less than [`MOST_DIMENSIONS`].
    pub(super) fn new(dimension: usize) -> Self {
        let mut directions = [0; BITS];
        let Some((degree, coefficients, first)) =
            dimension.checked_sub(1).and_then(|k| DIRECTION_NUMBERS.get(k)).copied()
        else {
            // The first dimension is the van der Corput sequence.
            for (k, direction) in directions.iter_mut().enumerate() {
                *direction = 1 << (BITS - 1 - k);
            }
            return Self { directions };
        };
        for k in 0..BITS {
            directions[k] = match k.checked_sub(degree) {
                None => u64::from(first[k]) << (BITS - 1 - k),
                // Recurrence of the primitive polynomial.
                Some(before) => {
                    let mut direction = directions[before] ^ (directions[before] >> degree);
                    for j in 1..degree {
                        if coefficients >> (degree - 1 - j) & 1 == 1 {
                            direction ^= directions[k - j];
                        }
                    }
                    direction
                }
            };
        }
        Self { directions }
    }

    /// Returns the coordinate of the point with this index, in units of 2^-64.
    pub(super) fn at(&self, point: u64) -> u64 {
        let gray = point ^ (point >> 1);
        let is_set = |k: &usize| gray >> k & 1 == 1;
        (0..BITS).filter(is_set).fold(0, |sum, k| sum ^ self.directions[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fraction(x: u64) -> f64 {
        x as f64 / 2f64.powi(64)
    }

    /// Checks the first ten points in three dimensions against those that S. Joe and F. Y. Kuo
    /// publish on the page of their program `sobol.cc` ("Sobol sequence generator").
    #[test]
    fn published_first_points() {
        let published = [
            [0.0, 0.0, 0.0],
            [0.5, 0.5, 0.5],
            [0.75, 0.25, 0.25],
            [0.25, 0.75, 0.75],
            [0.375, 0.375, 0.625],
            [0.875, 0.875, 0.125],
            [0.625, 0.125, 0.875],
            [0.125, 0.625, 0.375],
            [0.1875, 0.3125, 0.9375],
            [0.6875, 0.8125, 0.4375],
        ];
        let dimensions = [0, 1, 2].map(Sobol::new);
        for (k, expected) in published.into_iter().enumerate() {
            let found = dimensions.each_ref().map(|sobol| fraction(sobol.at(k as u64)));
            assert_eq!(found, expected, "point {k}");
        }
    }

    /// Tests that, in every dimension, each of 2^k equal intervals contains exactly one of 2^k
    /// points that begin at a multiple of 2^k. A wrong direction number would violate this property
    /// of Sobol's sequence.
    #[test]
    fn every_dimension_is_evenly_filled() {
        for dimension in 0..MOST_DIMENSIONS {
            let sobol = Sobol::new(dimension);
            for k in [1, 4, 7, 10] {
                let count = 1_u64 << k;
                for begin in [0, count, 5 * count] {
                    let mut seen = vec![false; count as usize];
                    for point in begin..begin + count {
                        let cell = (sobol.at(point) >> (BITS - k)) as usize;
                        assert!(!seen[cell], "dimension {dimension}, {count} points from {begin}");
                        seen[cell] = true;
                    }
                }
            }
        }
    }

    /// Checks that all initial direction numbers are odd, that the k-th number of each dimension is
    /// less than 2^k, and that all polynomials differ.
    #[test]
    fn direction_numbers_are_admissible() {
        let mut polynomials = Vec::new();
        for (degree, coefficients, first) in DIRECTION_NUMBERS {
            assert_eq!(first.len(), degree);
            for (k, number) in first.iter().enumerate() {
                assert!(number % 2 == 1 && *number < 2 << k, "{first:?}");
            }
            polynomials.push((degree, coefficients));
        }
        let count = polynomials.len();
        polynomials.sort_unstable();
        polynomials.dedup();
        assert_eq!(polynomials.len(), count);
    }

    /// Tests that, for pairs of dimensions, 4096 points leave no square of side 1/4 empty. (For
    /// many pairs, 4^k points even have exactly one point in each square of side 2^-k.)
    #[test]
    fn pairs_of_dimensions_leave_no_hole() {
        let all: Vec<Sobol> = (0..MOST_DIMENSIONS).map(Sobol::new).collect();
        for (i, a) in all.iter().enumerate() {
            for (j, b) in all.iter().enumerate().take(i) {
                let mut seen = [false; 16];
                for point in 0..4096 {
                    seen[((a.at(point) >> 62) * 4 + (b.at(point) >> 62)) as usize] = true;
                }
                assert!(seen.iter().all(|seen| *seen), "dimensions {j} and {i}");
            }
        }
    }
}
