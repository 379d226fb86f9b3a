//! Singularity indices by products of sparse blocks against dense decompositions.

use crate::common::random::*;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::statics::{Distances, SingularityDistances, Statics};

/// Random mechanisms of all classes without redundant constraints: both indices agree with those of
/// the decomposed matrix, up to the digits that the products keep.
#[test]
fn products_agree_with_decompositions() {
    let mut looked_at = 0;
    for class in CLASSES {
        for seed in 0..6 {
            let (_, case) = case(class, seed, 0.0);
            let (coordinates, targets) = (&case.coordinates, &case.targets);
            let settings = Settings::default();
            let mechanism = case.mechanism.clone();
            // Some mechanisms have more DOFs than are prescribed.
            let Ok(solver) = InverseDynamics::new(mechanism, &[], coordinates, targets, settings)
            else {
                continue;
            };
            let Some(mut proximity) = SingularityDistances::new(solver.mechanism()) else {
                continue;
            };
            let statics: Statics = solver.statics();
            if statics.redundancy() > 0 {
                continue;
            }
            let expected = Distances::new(&statics, coordinates.len(), 0);
            let (mechanism, parameters) = (solver.mechanism(), solver.parameters());
            let found = proximity.measure(mechanism, parameters, solver.bodies());
            let pairs =
                [(found.actuation, expected.actuation), (found.constraint, expected.constraint)];
            for (found, expected) in pairs {
                // The eigenvalue iteration stops at 1e-12.
                let error = (found - expected).abs() / expected;
                assert!(error < 2e-12, "{class:?} {seed}: {found} {expected}, {error}");
            }
            // The next position reuses the buffers.
            assert_eq!(proximity.measure(mechanism, parameters, solver.bodies()), found);
            looked_at += 1;
        }
    }
    assert!(looked_at >= 12, "{looked_at}");
}
