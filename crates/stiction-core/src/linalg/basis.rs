//! Orthonormal bases of subspaces, such as null spaces, with sparse vectors.

use super::decomposition::{SparseVector, sum_of, to_dense};
use nalgebra::DVector;

/// Orthonormal basis of a subspace.
#[derive(Clone, Debug)]
pub struct Basis {
    vectors: Vec<SparseVector>,
    /// Number of components of each vector.
    length: usize,
}

impl Basis {
    /// Creates a basis from orthonormal vectors with `length` components.
    pub(crate) fn new(vectors: Vec<SparseVector>, length: usize) -> Self {
        Self { vectors, length }
    }

    /// Creates a basis from orthonormal vectors with `length` components.
    pub(crate) fn of_dense(vectors: &[DVector<f64>], length: usize) -> Self {
        let sparse = |vector: &DVector<f64>| vector.iter().copied().enumerate().collect();
        Self::new(vectors.iter().map(sparse).collect(), length)
    }

    /// Orthonormalises linearly independent vectors with `length` components. Components below
    /// `negligible` times the norm of a vector are omitted.
    pub(crate) fn orthonormalised(
        vectors: impl IntoIterator<Item = SparseVector>,
        length: usize,
        negligible: f64,
    ) -> Self {
        let mut basis: Vec<SparseVector> = Vec::new();
        // Basis vectors with each component: only these may overlap with the next vector.
        let mut having = vec![Vec::new(); length];
        let mut work = vec![0.0; length];
        for vector in vectors {
            let mut others: Vec<usize> =
                vector.iter().flat_map(|(k, _)| having[*k].iter().copied()).collect();
            others.sort_unstable();
            others.dedup();
            let mut parts: Vec<usize> = vector.iter().map(|(k, _)| *k).collect();
            parts.extend(others.iter().flat_map(|other| basis[*other].iter().map(|(k, _)| *k)));
            parts.sort_unstable();
            parts.dedup();
            vector.into_iter().for_each(|(k, x)| work[k] = x);
            // Gram-Schmidt orthogonalisation. The second pass removes the round-off errors of the
            // first pass.
            for _ in 0..2 {
                for known in others.iter().map(|other| &basis[*other]) {
                    let amount: f64 = known.iter().map(|&(k, x)| x * work[k]).sum();
                    if amount != 0.0 {
                        known.iter().for_each(|&(k, x)| work[k] -= amount * x);
                    }
                }
            }
            let norm = parts.iter().map(|k| work[*k] * work[*k]).sum::<f64>().sqrt();
            let kept = parts.iter().filter(|k| work[**k].abs() > negligible * norm);
            let made: SparseVector = kept.map(|k| (*k, work[*k] / norm)).collect();
            made.iter().for_each(|(k, _)| having[*k].push(basis.len()));
            parts.iter().for_each(|k| work[*k] = 0.0);
            basis.push(made);
        }
        Self::new(basis, length)
    }

    /// Returns the dimension of the subspace.
    pub fn len(&self) -> usize {
        self.vectors.len()
    }

    /// Returns true if the subspace contains only zero.
    pub fn is_empty(&self) -> bool {
        self.vectors.is_empty()
    }

    pub(crate) fn vectors(&self) -> &[SparseVector] {
        &self.vectors
    }

    /// Returns the vectors in dense storage.
    pub fn dense(&self) -> Vec<DVector<f64>> {
        (0..self.len()).map(|k| self.vector(k)).collect()
    }

    /// Returns the vector with the given index in dense storage.
    pub fn vector(&self, index: usize) -> DVector<f64> {
        to_dense(&self.vectors[index], self.length)
    }

    /// Computes the sum of the vectors, multiplied by the given amounts.
    pub(crate) fn sum(&self, amounts: impl IntoIterator<Item = f64>) -> DVector<f64> {
        sum_of(&self.vectors, amounts, self.length)
    }

    /// Projects a vector onto the subspace.
    pub(crate) fn projection(&self, vector: &DVector<f64>) -> DVector<f64> {
        self.sum(self.vectors.iter().map(|own| own.iter().map(|&(k, x)| x * vector[k]).sum()))
    }
}
