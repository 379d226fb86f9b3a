//! Free motion of random mechanisms with friction in all joints: loops stay closed, the energy
//! balance closes, nothing is NaN, and an aborted run states its reason.

use crate::common::random::*;
use stiction_core::forward::{ConstantEfforts, Event, EventKind, Forward, InterfaceMode, Settings};

#[test]
fn random_mechanisms_fall_stick_and_slide() {
    let (mut ended, mut stuck, mut worst) = (0, 0, 0.0_f64);
    let mut errors = Vec::new();
    for class in CLASSES {
        for seed in 100..103 {
            let (_, case) = case(class, seed, 0.3);
            let model = Forward::new(case.mechanism.clone(), &[]);
            let Ok(state) = model.assemble(&[], &case.coordinates, &case.targets) else { continue };
            let mut inputs = ConstantEfforts(vec![]);
            let settings = Settings { relative: 1e-9, absolute: 1e-11, ..Settings::default() };
            let mut simulation = match model.start(0.0, state, settings, &mut inputs) {
                Ok(simulation) => simulation,
                Err(error) => {
                    errors.push(format!("{class:?} {seed} start: {error}"));
                    continue;
                }
            };
            for k in 1..=5 {
                if let Err(error) = simulation.advance(0.02 * f64::from(k), &mut inputs) {
                    errors.push(format!("{class:?} {seed}: {error}"));
                    break;
                }
            }
            let now = simulation.instant();
            assert!(now.state.coordinates.iter().all(|q| q.is_finite()));
            assert!(now.state.accelerations.iter().all(|a| a.is_finite()));
            let turnover = simulation.energies().turnover + now.account.kinetic;
            let error = simulation.energy_error().abs() / turnover.max(1e-6);
            worst = worst.max(error);
            // Event-driven steps are accurate to 1e-9, time stepping is of first order.
            let steps = |event: &Event| matches!(event.kind, EventKind::Method { .. });
            let limit = if simulation.events().iter().any(steps) { 1e-5 } else { 1e-8 };
            assert!(error < limit, "{class:?} {seed}: {error:e}");
            for interface in &now.interfaces {
                if interface.interface == InterfaceMode::Sticks {
                    stuck += 1;
                    assert!(interface.margin() > -1e-6 * interface.limit, "{interface:?}");
                }
            }
            ended += 1;
        }
    }
    println!("{ended} ended, {stuck} contacts stick, energy {worst:.1e}");
    // A run that ends early must name the joint and the instant.
    for error in &errors {
        println!("{error}");
        assert!(error.contains("joint `") && error.contains("t = "), "{error}");
    }
    assert!(ended >= 20, "{ended} {stuck} {errors:?}");
}
