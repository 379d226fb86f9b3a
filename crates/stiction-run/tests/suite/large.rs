//! Tests on the gallery of sparse factorizations, which decide the verdicts on large mechanisms.

use crate::common::*;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::linalg::{Decomposition, Limit, Svd};
use stiction_format::gallery;

/// Tests that sparse factorizations decide the rank of the equilibrium equations of every gallery
/// model like the dense decomposition.
#[test]
fn gallery() {
    for name in gallery::names() {
        let model = model(name);
        let motion = model.motion(model.default_motion.as_ref().unwrap()).unwrap();
        let coordinates: Vec<_> = motion.coordinates.iter().map(|(own, _)| *own).collect();
        // This instant is away from reversals and symmetric positions.
        let time = motion.start + 0.07 * motion.duration;
        let targets: Vec<_> = motion.at(time).collect();
        let (homes, settings) = (&model.initial_poses, Settings::default());
        let mechanism = model.mechanism.clone();
        let solver = InverseDynamics::new(mechanism, homes, &coordinates, &targets, settings);
        let statics = solver.unwrap().statics();
        let matrix = statics.scaled_matrix();
        let single: Vec<usize> = (0..matrix.ncols()).collect();
        let sparse = Decomposition::sparse(matrix.clone(), &single, Limit::OfLargest(1e-10));
        assert!(sparse.is_sparse(), "{name}");
        assert_eq!(sparse.rank(), statics.rank(), "{name}");
        let smallest = Svd::new(&matrix.to_dense()).singular_values[statics.rank() - 1];
        let found = sparse.value(statics.rank() - 1);
        assert!((found / smallest - 1.0).abs() < 1e-12 / smallest, "{name}");
        let mut free = vec![0.0; matrix.ncols()];
        for (k, x) in sparse.null_space(sparse.rank()).into_iter().flatten() {
            free[k] += x * x;
        }
        let drives = statics.determined_drives();
        let first = free.len() - drives.len();
        for (own, drive) in free[first..].iter().zip(drives) {
            assert_eq!(own.sqrt() < 1e-8, drive, "{name}");
        }
    }
}
