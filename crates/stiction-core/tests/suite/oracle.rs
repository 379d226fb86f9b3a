//! The kernels compared with the dense system as an oracle, on random mechanisms of every class.

use crate::common::random::*;
use stiction_core::dynamics::{FrictionMode, InverseDynamics, InverseError};

fn numbers(solver: &InverseDynamics) -> (Vec<f64>, Vec<f64>) {
    let forces = solver.forces();
    let reactions = forces
        .reactions
        .iter()
        .flat_map(|(f, m)| f.to_array().into_iter().chain(m.to_array()))
        .collect();
    (forces.efforts.clone(), reactions)
}

#[test]
fn kernels_agree_with_the_dense_system() {
    let (mut compared, mut locked) = (0, 0);
    for class in CLASSES {
        for seed in 0..20 {
            for friction in [FrictionMode::Off, FrictionMode::OnePass, FrictionMode::Converged] {
                let (_, case) = case(class, seed, 0.2);
                let Some((mut solver, smallest)) = case.regular_solver(friction) else { continue };
                match solver.solve(&case.loads) {
                    // The kernel and the dense method must report locking at the same fraction of
                    // the coefficients.
                    Err(InverseError::Locked { percent, .. }) => {
                        let careful = solver.solve_dense(&case.loads).unwrap_err();
                        let InverseError::Locked { percent: other, .. } = careful else {
                            panic!("{class:?} {seed}: {careful}")
                        };
                        // Near the limit, normal loads grow without bound, and neither method
                        // converges to the last digit.
                        let apart = (percent - other).abs();
                        assert!(apart < 3e-3 * percent, "{class:?} {seed} {percent} {other}");
                        locked += 1;
                        continue;
                    }
                    Err(error) => panic!("{class:?} {seed} {friction:?}: {error} {smallest}"),
                    Ok(_) => {}
                }
                let kernel = numbers(&solver);
                let power = solver.forces().power;
                assert!(
                    power.residual().abs() <= 1e-12 * power.turnover,
                    "{class:?} {seed} {power:?}"
                );
                // Near locking, normal loads and their rounding grow. The comparison there uses
                // half of the digits.
                let strong = solver.coupling().is_none_or(|coupling| coupling > 0.9);
                solver.solve_dense(&case.loads).unwrap();
                let dense = numbers(&solver);
                if strong && friction == FrictionMode::Converged {
                    let drives = apart(&kernel.0, &dense.0);
                    assert!(drives < 1e-6, "{class:?} {seed}: drives {drives:e}, near locking");
                    continue;
                }
                let (drives, reactions) = (apart(&kernel.0, &dense.0), apart(&kernel.1, &dense.1));
                let limit = 1e-12 / smallest;
                assert!(
                    drives < limit,
                    "{class:?} {seed} {friction:?}: drives {drives:e}, {smallest:e}"
                );
                assert!(
                    reactions < limit,
                    "{class:?} {seed} {friction:?}: reactions {reactions:e}, {smallest:e}"
                );
                compared += 1;
            }
        }
    }
    assert!(compared > 300 && locked < compared / 20, "{compared} {locked}");
}
