//! Sparse decompositions compared with the dense ones that they replace for large mechanisms.

use crate::common::random::*;
use nalgebra::{DMatrix, DVector};
use stiction_core::dynamics::FrictionMode;
use stiction_core::linalg::{Decomposition, Limit, SparseMatrix, Svd};

const LIMIT: Limit = Limit::OfLargest(1e-10);
/// In unit vectors of a null space, components below this value count as zero, as in the library.
const DETERMINED: f64 = 1e-8;

/// Asserts that both decompositions agree. Returns `false` if the sparse factors leave the rank in
/// doubt.
fn agree(matrix: &SparseMatrix, groups: &[usize], what: &str) -> bool {
    let sparse = Decomposition::sparse(matrix.clone(), groups, LIMIT);
    let dense = Svd::new(&matrix.to_dense());
    let rank = dense.rank(1e-10);
    assert_eq!(sparse.rank(), rank, "rank {what}");
    if !sparse.is_sparse() {
        return false;
    }
    assert!((sparse.largest() / dense.largest() - 1.0).abs() < 1e-2, "largest {what}");
    let size = matrix.ncols();
    if rank > 0 {
        let smallest = dense.singular_values[rank - 1];
        // The round-off of the factors is that of the matrix divided by the smallest singular
        // value.
        let error = 1e-10 + 1e-13 * dense.largest() / smallest;
        let found = sparse.value(rank - 1);
        assert!((found / smallest - 1.0).abs() < error, "smallest {what}");
        let weakest = DVector::from_column_slice(sparse.weakest().unwrap());
        assert!((weakest.norm() - 1.0).abs() < 1e-12, "{what}");
        let image = (matrix.to_dense() * weakest).norm();
        assert!((image - smallest).abs() < 1e-7 * dense.largest(), "weakest {what}");
    }

    // Both bases must span the same space, and the same unknowns must be determinate.
    let vectors = sparse.null_space(rank);
    assert_eq!(vectors.len(), size - rank, "null space {what}");
    let mut free = vec![0.0; size];
    for vector in &vectors {
        let mut full = DVector::zeros(size);
        vector.iter().for_each(|&(k, x)| full[k] = x);
        assert!((full.norm() - 1.0).abs() < 1e-12, "{what}");
        assert!((matrix.to_dense() * full).norm() < 1e-10 * dense.largest().max(1.0), "{what}");
        vector.iter().for_each(|&(k, x)| free[k] += x * x);
    }
    let orthonormal = sparse.orthonormal_null_space(rank).dense();
    if !orthonormal.is_empty() {
        let basis = DMatrix::from_columns(&orthonormal);
        let identity = DMatrix::identity(size - rank, size - rank);
        assert!((basis.tr_mul(&basis) - identity).amax() < 1e-12, "orthonormal {what}");
    }
    for (k, free) in free.iter().enumerate() {
        let own = (rank..size).map(|j| dense.v[(k, j)].powi(2)).sum::<f64>().sqrt();
        assert_eq!(free.sqrt() < DETERMINED, own < DETERMINED, "unknown {k} {what}");
    }

    // Minimum-norm least-squares solutions for an arbitrary right-hand side.
    let right: Vec<f64> = (0..matrix.nrows()).map(|k| (1.0 + 0.3 * k as f64).sin()).collect();
    let found = DVector::from_vec(sparse.solve(&right));
    let expected = dense.solve(&DVector::from_vec(right), rank);
    if rank > 0 {
        let condition = dense.largest() / dense.singular_values[rank - 1];
        let error = (found - &expected).norm();
        assert!(error <= 1e-14 * condition * condition * expected.norm().max(1.0), "solve {what}");
    }
    true
}

/// Balances of random mechanisms of all classes: with loops, redundant constraints, redundant
/// actuators and local degrees of freedom. Tests the matrices of all unknowns, and those of the
/// constraints alone, which leave motions unconstrained.
#[test]
fn random_mechanisms() {
    let mut doubtful = 0;
    let mut all = 0;
    for class in CLASSES {
        for seed in 0..12 {
            let (_, case) = case(class, seed, 0.0);
            let Some((solver, _)) = case.regular_solver(FrictionMode::Off) else { continue };
            let system = solver.balance();
            let types: Vec<_> = case.mechanism.joints().iter().map(|j| j.joint_type).collect();
            let balance = system.scaled_matrix(&types);
            let drives = case.mechanism.actuators().count();
            let constraints: Vec<usize> = (0..balance.ncols() - drives).collect();
            let alone = balance.select_columns(&constraints);
            for (name, matrix) in [("all", &balance), ("constraints", &alone)] {
                let bodies: Vec<usize> = (0..matrix.nrows()).map(|row| row / 6).collect();
                let single: Vec<usize> = (0..matrix.ncols()).collect();
                let what = format!("{class:?} {seed} {name}");
                for is_decided in [
                    agree(matrix, &single, &what),
                    agree(&matrix.transpose(), &bodies, &format!("{what} transposed")),
                ] {
                    all += 1;
                    doubtful += usize::from(!is_decided);
                }
            }
        }
    }
    // With more doubtful cases, large mechanisms would be slow.
    assert!(all > 200 && doubtful * 20 < all, "{doubtful} of {all} left to dense decompositions");
}

/// Matrices without entries, columns or rows.
#[test]
fn empty_matrices() {
    for (rows, columns) in [(0, 0), (0, 5), (5, 0), (4, 6)] {
        let matrix = SparseMatrix::new((rows, columns), std::iter::empty());
        let groups: Vec<usize> = (0..columns).collect();
        let found = Decomposition::sparse(matrix, &groups, LIMIT);
        assert_eq!(found.rank(), 0);
        assert_eq!(found.null_space(0).len(), columns);
        assert_eq!(found.solve(&vec![1.0; rows]), vec![0.0; columns]);
    }
}

/// Singular values below the limit count as zero also if all columns are clearly independent, as in
/// long rows of loops.
#[test]
fn small_values_of_independent_columns_count_as_zero() {
    const SIZE: usize = 50;
    let entries = (0..SIZE).flat_map(|k| [(k, k, 1.0), (k + 1, k, -1.0)]);
    let matrix = SparseMatrix::new((SIZE + 1, SIZE), entries);
    let groups: Vec<usize> = (0..SIZE).collect();
    let sparse = Decomposition::sparse(matrix.clone(), &groups, Limit::OfLargest(0.1));
    let dense = Svd::new(&matrix.to_dense());
    // The values are 2 sin(k pi / 102): 0.062, 0.123, 0.185 are below 0.2, and 0.246 is above.
    let rank = SIZE - 3;
    assert!(sparse.is_sparse());
    assert_eq!((sparse.rank(), dense.rank(0.1)), (rank, rank));
    for k in [rank - 1, rank] {
        assert!((sparse.value(k) / dense.singular_values[k] - 1.0).abs() < 1e-9, "{k}");
    }
    let basis = DMatrix::from_columns(&sparse.orthonormal_null_space(rank).dense());
    let expected = DMatrix::from_columns(&dense.null_space(rank));
    let cosines = basis.tr_mul(&expected).singular_values();
    assert!(cosines.len() == 3 && cosines.iter().all(|cosine| (cosine - 1.0).abs() < 1e-9));
    let right: Vec<f64> = (0..=SIZE).map(|k| (1.0 + 0.3 * k as f64).sin()).collect();
    let found = DVector::from_vec(sparse.solve(&right));
    let expected = dense.solve(&DVector::from_vec(right), rank);
    assert!((found - &expected).norm() < 1e-10 * expected.norm());
}
