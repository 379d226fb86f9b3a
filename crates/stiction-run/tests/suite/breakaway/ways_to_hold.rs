//! Intervals and verdicts against all combinations of static friction forces.

use crate::breakaway::holder::Holder;
use crate::breakaway::near;
use crate::common::*;
use stiction_core::dynamics::Verdict;
use stiction_core::friction::InterfaceShape;
use stiction_core::random::Random;

/// Tests two actuators against all combinations of the friction of a five-bar's pins at a limit or
/// at zero.
#[test]
fn a_five_bar_against_all_combinations_of_frictions() {
    let model = model("five-bar");
    let holder = Holder::new(&model, 0.37);
    let interfaces = holder.solver.parameters().interfaces.len();
    assert!(interfaces >= 5);
    let forces = holder.solver.forces();
    let mut reached = vec![(f64::INFINITY, f64::NEG_INFINITY); 2];
    for number in 0..3_usize.pow(interfaces as u32) {
        let digit = |k: usize| (number / 3_usize.pow(k as u32) % 3) as f64 - 1.0;
        let held: Vec<[f64; 3]> = (0..interfaces).map(|k| [digit(k), 0.0, 0.0]).collect();
        for (reached, drive) in reached.iter_mut().zip(holder.drives(&held).unwrap()) {
            *reached = (reached.0.min(drive), reached.1.max(drive));
        }
    }
    for (k, (low, high)) in reached.into_iter().enumerate() {
        near(forces.effort_bounds[k].0, low);
        near(forces.effort_bounds[k].1, high);
        let (outer_low, outer_high) = forces.effort_outer_bounds[k];
        assert!(outer_low <= low && high <= outer_high);
        // Guaranteed bounds must be finite to be useful.
        assert!(
            outer_high - outer_low < 1.2 * (high - low),
            "{outer_low} {low} {high} {outer_high}"
        );
    }
}

/// Tests that no random admissible static friction leads outside the intervals.
#[test]
fn a_robot_against_random_static_frictions() {
    let model = model("3rps");
    let holder = Holder::new(&model, 0.3);
    let interfaces = &holder.solver.parameters().interfaces;
    let forces = holder.solver.forces();
    let mut random = Random::new(7);
    let mut widest = [0.0_f64; 3];
    for round in 0..2000 {
        let held: Vec<[f64; 3]> = interfaces
            .iter()
            .map(|interface| {
                let mut held = [0.0, 0.0, 0.0].map(|_: f64| random.number());
                if interface.shape != InterfaceShape::Ball {
                    held = [held[0], 0.0, 0.0];
                }
                // In every second round, all friction forces are at their limits; in the other
                // rounds, they are within the limits.
                let size = held.iter().map(|x| x * x).sum::<f64>().sqrt();
                let over = if round % 2 == 0 { 1.0 / size } else { 1.0 / size.max(1.0) };
                held.map(|x| x * over)
            })
            .collect();
        for (k, drive) in holder.drives(&held).unwrap().into_iter().enumerate() {
            let (low, high) = forces.effort_bounds[k];
            let rounding = 1e-9 * (high - low);
            assert!((low - rounding..=high + rounding).contains(&drive), "{low} {drive} {high}");
            let centre = forces.efforts[k];
            widest[k] = widest[k].max(((drive - centre) / (high - centre)).abs());
        }
    }
    // The random signs rarely agree at many interfaces, so the results cover only a part of the
    // interval.
    assert!(widest.iter().all(|w| *w > 0.4), "{widest:?}");
    for ((low, high), (outer_low, outer_high)) in
        forces.effort_bounds.iter().zip(&forces.effort_outer_bounds)
    {
        assert!(outer_low <= low && high <= outer_high);
    }
}

/// Tests a five-bar with two actuators without effort: with the reported friction forces, as
/// fractions of their limits, the kernel computes zero actuator forces.
#[test]
fn reported_frictions_hold() {
    let text = stiction_format::gallery::get("five-bar").unwrap();
    let (mut held, mut slipped) = (0, 0);
    for mu in [0.1, 1.0, 3.0, 6.0, 10.0] {
        let text = text.replace("0.08", &format!("{mu:?}")).replace("0.002", &format!("{mu:?}"));
        let holder = Holder::new(&model_of("five-bar", &text), 0.37);
        let holding = &holder.rest.unpowered;
        assert!(holding.needed.0 <= holding.needed.1, "{mu}: {:?}", holding.needed);
        if holding.verdict != Verdict::Holds {
            assert!(holding.frictions.is_empty() && holding.needed.1 > 1.0);
            slipped += usize::from(holding.verdict == Verdict::Slips);
            continue;
        }
        // Only the kernel computes the normal loads under these friction forces, so friction and
        // loads are iterated.
        let mut loads: Vec<f64> =
            holder.solver.forces().interfaces.iter().map(|c| c.load).collect();
        let mut left = f64::INFINITY;
        for _ in 0..1000 {
            let part = |(friction, load): (&Vec<f64>, &f64)| [friction[0] / (mu * load), 0.0, 0.0];
            let parts: Vec<[f64; 3]> = holding.frictions.iter().zip(&loads).map(part).collect();
            let Some((drives, found)) = holder.balance(&parts) else { break };
            left = drives.iter().fold(0.0, |max: f64, drive| max.max(drive.abs()));
            loads = loads.iter().zip(found).map(|(old, new)| 0.5 * (old + new)).collect();
            if left < 1e-9 {
                assert!(parts.iter().all(|part| part[0].abs() <= 1.0 + 1e-9), "{mu}: {parts:?}");
                break;
            }
        }
        assert!(left < 1e-9, "{mu}: {left}");
        held += 1;
    }
    assert!(held > 0 && slipped > 0, "{held} {slipped}");
}
