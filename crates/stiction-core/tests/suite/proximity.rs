//! Singularity indices from sparse block products, compared with dense decompositions.

use crate::common::random::*;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::kinematics::Target;
use stiction_core::statics::{Distances, SingularityDistances, Statics};

/// For random mechanisms of all classes without redundant constraints, both indices agree with
/// those of the decomposed matrix, up to the digits that the products preserve.
#[test]
fn products_agree_with_decompositions() {
    let mut looked_at = 0;
    for class in CLASSES {
        for seed in 0..6 {
            let (_, case) = case(class, seed, 0.0);
            let (coordinates, targets) = (&case.coordinates, &case.targets);
            let settings = Settings::default();
            let mechanism = case.mechanism.clone();
            // Some mechanisms have more DOFs than prescribed coordinates.
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
                // The eigenvector is accurate to 2e-11; the error of the eigenvalue is quadratic in
                // this error.
                let error = (found - expected).abs() / expected;
                assert!(error < 2e-12, "{class:?} {seed}: {found} {expected}, {error}");
            }
            // The next configuration reuses the buffers and the results.
            let again = proximity.measure(mechanism, parameters, solver.bodies());
            assert!((again.actuation - found.actuation).abs() < 2e-12 * found.actuation);
            assert!((again.constraint - found.constraint).abs() < 2e-12 * found.constraint);
            looked_at += 1;
        }
    }
    assert!(looked_at >= 12, "{looked_at}");
}

/// Along motions, each value is predicted from the previous ones. The motions have small and large
/// steps, jumps (where the prediction is wrong), and instants at which another singular value
/// becomes the smallest.
#[test]
fn values_along_motions_agree_with_decompositions() {
    let (mut looked_at, mut largest) = (0, 0.0_f64);
    for class in CLASSES {
        for (seed, step) in [(0, 1e-3), (1, 1e-2), (2, 0.05), (3, 0.2), (4, 1e-2)] {
            let (_, case) = case(class, seed, 0.0);
            let (coordinates, start) = (&case.coordinates, &case.targets);
            let (settings, mechanism) = (Settings::default(), case.mechanism.clone());
            let Ok(mut solver) = InverseDynamics::new(mechanism, &[], coordinates, start, settings)
            else {
                continue;
            };
            let Some(mut proximity) = SingularityDistances::new(solver.mechanism()) else {
                continue;
            };
            // Amplitudes in m or rad; every sixth sample is at a distant configuration.
            let motion = |k: usize| -> Vec<Target<f64>> {
                let time = step * if k % 6 == 5 { 3.0 + k as f64 } else { k as f64 };
                let away = 0.1 * (time + 0.3 * time * time).sin();
                start
                    .iter()
                    .map(|target| Target { value: target.value + away, ..*target })
                    .collect()
            };
            let (mut traveller, mut last) = (proximity.clone(), None::<Distances>);
            for k in 0..24 {
                if solver.move_to(&motion(k)).is_err() {
                    continue;
                }
                let statics = solver.statics();
                let expected = Distances::new(&statics, coordinates.len(), 0);
                let travel = traveller.travel(solver.parameters(), solver.bodies());
                if let Some(last) = last.replace(expected) {
                    // The bound must hold up to the rounding of the decompositions.
                    let within = |change: f64, bound: f64| change.abs() <= bound + 1e-12;
                    assert!(within(expected.actuation - last.actuation, travel.actuation));
                    assert!(within(expected.constraint - last.constraint, travel.constraint));
                }
                let singular = expected.actuation.min(expected.constraint) < 1e-5;
                if statics.redundancy() > 0 || singular {
                    continue;
                }
                let found =
                    proximity.measure(solver.mechanism(), solver.parameters(), solver.bodies());
                for (found, expected) in
                    [(found.actuation, expected.actuation), (found.constraint, expected.constraint)]
                {
                    let error = (found - expected).abs() / expected;
                    assert!(error < 1e-9, "{class:?} {seed} {k}: {found} {expected}, {error}");
                    largest = largest.max(error);
                }
                looked_at += 1;
            }
        }
    }
    assert!(looked_at >= 200, "{looked_at}");
    println!("{looked_at} positions, largest relative error {largest:.1e}");
}
