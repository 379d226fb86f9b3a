//! Positions of the actuators at the start of a plant.

use crate::importer::{Extracted, Importer, Version};
use stiction::Robot;

/// Height of the tool of `five-bar`, m, at the given crank angles, rad. `side` is the assembly
/// mode: 1 with the tool above the elbows, -1 with the tool below.
fn height(left: f64, right: f64, side: f64) -> f64 {
    let elbow = |base: f64, angle: f64| (base + 0.2 * angle.cos(), 0.2 * angle.sin());
    let (a, b) = (elbow(-0.06, left), elbow(0.06, right));
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let apart = dx.hypot(dy);
    0.5 * (a.1 + b.1) + side * (0.28_f64.powi(2) - 0.25 * apart * apart).sqrt() * dx / apart
}

/// With other positions at the start, the plant remains in the assembly mode of the model, in both
/// modes.
#[test]
fn other_starts_keep_the_assembly_mode() {
    for (side, elbow) in [(1.0, 80), (-1.0, 178)] {
        let starts = [("left", -elbow), ("right", elbow)];
        let robot =
            starts.iter().fold(Robot::builtin("five-bar").unwrap(), |robot, (which, angle)| {
                robot.with(&format!("joints.{which}_elbow.start = {angle} deg")).unwrap()
            });
        let from =
            "left_motor = 130 deg; right_motor = 50 deg; d(left_motor) = 0; d(right_motor) = 0";
        let unit = Extracted::new(&format!("mode-{elbow}"), &robot.export().plant().from(from));
        for version in [Version::Two, Version::Three { events: false }] {
            for turned in [[0.0, 0.0], [0.1, -0.1], [0.5, 0.3], [-0.6, -0.4]] {
                let at = [130_f64, 50.0].map(f64::to_radians);
                let at = [at[0] + turned[0], at[1] + turned[1]];
                let plant = Importer::new(&unit, version);
                plant.set("start.left_motor.position", at[0]);
                plant.set("start.right_motor.position", at[1]);
                plant.enter(0.0);
                assert_eq!(plant.exit(), 0, "{}", plant.said());
                let (found, expected) = (plant.get("tool.y"), height(at[0], at[1], side));
                // The loops are closed to 1e-12 of the robot's size.
                assert!((found - expected).abs() < 1e-11, "{side} {turned:?}: {found} {expected}");
            }
        }
    }
}
