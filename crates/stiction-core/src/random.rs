//! Pseudo-random numbers that are the same in every run.

use crate::linalg::{Basis, SparseVector, sum_of};
use crate::spatial::Vec3;
use nalgebra::DVector;

/// Pseudo-random number generator: linear congruential method with Knuth's constants.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// Creates the generator with the given seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns a random number, uniformly distributed from -1 (included) to 1 (excluded).
    pub fn number(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Returns a random vector whose components are uniformly distributed from -1 to 1.
    pub fn vector(&mut self) -> Vec3<f64> {
        Vec3::new(self.number(), self.number(), self.number())
    }

    /// Returns `count` random sums of vectors with `length` components. In each sum, every vector has
    /// another amount.
    pub(crate) fn sums(
        &mut self,
        vectors: &[SparseVector],
        length: usize,
        count: usize,
    ) -> Vec<DVector<f64>> {
        let mut amounts = core::iter::repeat_with(|| self.number());
        (0..count).map(|_| sum_of(vectors, amounts.by_ref(), length)).collect()
    }

    /// Returns a random unit vector in the span of `basis`, which contains at least one vector.
    pub(crate) fn within(&mut self, basis: &Basis) -> DVector<f64> {
        let sum = basis.sum(core::iter::repeat_with(|| self.number()));
        let size = sum.norm();
        if size > 0.0 { sum / size } else { basis.sum([1.0]) }
    }
}
