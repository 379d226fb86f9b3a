//! The singular value decomposition that decides ranks.

use crate::common::random::*;
use nalgebra::DMatrix;
use proptest::prelude::*;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::linalg::{Svd, smallest_singular_value};

fn check(matrix: &DMatrix<f64>) {
    let svd = Svd::new(matrix);
    let scale = matrix.amax().max(f64::MIN_POSITIVE) * matrix.ncols() as f64;
    let again = &svd.u * DMatrix::from_diagonal(&svd.singular_values) * svd.v.transpose();
    // Round-off grows with the number of rotations of a column, of which there are a few per other
    // column.
    assert!((again - matrix).amax() <= 1e-14 * scale);
    let identity = DMatrix::identity(matrix.ncols(), matrix.ncols());
    assert!((svd.v.tr_mul(&svd.v) - identity).amax() <= 1e-13);
    assert!(svd.singular_values.as_slice().is_sorted_by(|a, b| a >= b));
}

proptest! {
    #[test]
    fn random_matrices(rows in 0..8usize, columns in 0..8usize, numbers in prop::collection::vec(-1.0..1.0f64, 64)) {
        check(&DMatrix::from_fn(rows, columns, |i, j| numbers[8 * i + j]));
    }

    /// Products of a tall and a wide factor have a rank equal to the inner dimension.
    #[test]
    fn rank_is_found(rank in 1..5usize, numbers in prop::collection::vec(-1.0..1.0f64, 80)) {
        let left = DMatrix::from_fn(8, rank, |i, j| numbers[5 * i + j]);
        let right = DMatrix::from_fn(rank, 8, |i, j| numbers[40 + 5 * j + i]);
        prop_assume!(Svd::new(&left).singular_values.min() > 1e-3);
        prop_assume!(Svd::new(&right.transpose()).singular_values.min() > 1e-3);
        let product = left * right;
        check(&product);
        let svd = Svd::new(&product);
        prop_assert_eq!(svd.rank(1e-10), rank);
        for vector in svd.null_space(rank) {
            prop_assert!((&product * vector).amax() < 1e-14);
        }
    }
}

/// The fast computation of the smallest singular value, for matrices from well-conditioned to
/// singular.
#[test]
fn smallest_singular_values() {
    let mut random = Random(7);
    for size in 1..30 {
        for smallest in [1.0, 1e-2, 1e-5, 1e-9, 0.0] {
            let extra = random.below(5);
            let mut entry = || random.signed();
            let mut matrix = DMatrix::from_fn(size, size + extra, |_, _| entry());
            // Rows that are linearly dependent except for `smallest`.
            if size > 1 {
                let (first, last) = (matrix.row(0).into_owned(), matrix.row(size - 1).into_owned());
                matrix.set_row(size - 1, &(first + last * smallest));
            }
            let expected = Svd::new(&matrix.transpose()).singular_values[size - 1];
            for matrix in [matrix.clone(), matrix.transpose()] {
                let found = smallest_singular_value(&matrix);
                let error = (found - expected).abs();
                assert!(
                    error <= 1e-9 * expected + 1e-15,
                    "{size} {smallest:e}: {found:e} {expected:e}"
                );
            }
        }
    }
}

/// One of these matrices made the decomposition of a general-purpose library fail.
#[test]
fn matrices_of_mechanisms() {
    for seed in 0..60 {
        let (_, case) = case(Class::Parallel, seed, 0.0);
        let settings = Settings::default();
        let solver = InverseDynamics::new(
            case.mechanism.clone(),
            &[],
            &case.coordinates,
            &case.targets,
            settings,
        );
        let types: Vec<_> = case.mechanism.joints().iter().map(|j| j.joint_type).collect();
        check(&solver.unwrap().statics().system().scaled_matrix(&types).to_dense());
    }
}
