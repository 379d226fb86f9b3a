//! Comparison with published numbers of an independent derivation and three independent engines
//! (`reference/README.md`), given with their published digits.

mod friction;
mod ideal;
mod kinematics;
mod map;
mod reactions;
mod report;
mod simulation;
mod structure;

use super::robot::Robot;

/// Tolerance of half a unit in the last digit, with a margin for rounding.
fn near(found: f64, published: f64, digits_after_point: i32) {
    let half = 0.501 * 10.0_f64.powi(-digits_after_point);
    assert!((found - published).abs() <= half, "{found} is not {published}");
}

fn robots() -> [Robot; 2] {
    [Robot::printed(), Robot::regular()]
}
