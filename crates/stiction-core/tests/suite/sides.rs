//! Sides of actuation singularities: the sign from the balance of a solution, compared with the
//! sign from the loop constraints.

use crate::common::random::*;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::kinematics::Target;

/// Along motions with small steps and jumps, on both sides of singularities and after the balance
/// was compiled again, both determinants have the same sign up to one constant factor.
#[test]
fn balance_and_loop_constraints_give_the_same_side() {
    let (mut compared, mut changes) = (0, 0);
    for class in CLASSES {
        for seed in 0..3 {
            let (_, case) = case(class, seed, 0.0);
            let (coordinates, start) = (&case.coordinates, &case.targets);
            let (settings, mechanism) = (Settings::default(), case.mechanism.clone());
            let Ok(mut solver) = InverseDynamics::new(mechanism, &[], coordinates, start, settings)
            else {
                continue;
            };
            let mut last = None;
            for k in 0..12 {
                // Amplitudes in m or rad.
                let time = 0.7 * f64::from(k);
                let away = 0.8 * (time + 0.3 * time * time).sin();
                let targets: Vec<Target<f64>> = start
                    .iter()
                    .map(|target| Target { value: target.value + away, ..*target })
                    .collect();
                if solver.move_to(&targets).is_err() || solver.solve(&[]).is_err() {
                    continue;
                }
                let (found, expected) = (solver.side_of_solution(), solver.side());
                assert_eq!(found, expected, "{class:?} {seed} {k}");
                compared += usize::from(found.is_some());
                changes += usize::from(last.is_some_and(|last| last != found));
                last = Some(found);
            }
        }
    }
    assert!(compared >= 100 && changes >= 3, "{compared} {changes}");
}
