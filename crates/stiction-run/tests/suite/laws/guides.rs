//! Guides whose supports carry moments.

use crate::common::collar::push_beside;
use crate::laws::{G, body, model, run};
use stiction_core::dynamics::InverseError;
use stiction_run::Error;

/// Returns the model of a collar of 10 kg on a vertical rod with pads 0.1 m apart and an eccentric
/// actuator force.
fn collar(mu: f64, offset: f64, friction: &str, motion: &str) -> String {
    let parts = format!(
        r#"{}
        [bodies.rod]
        [bodies.driver]
        [joints.guide]
        type = "P"
        from = "collar"
        to = "ground"
        axis = "-z"
        friction = {{ mu = {mu:?}, {friction} }}
        {}
        "#,
        body("collar", 10.0),
        push_beside(offset)
    );
    model(&parts, &format!("guide = \"{motion}\""))
}

/// Tests `P = W / (1 - 2 mu e / s)` for a hundred offsets `e`, and self-locking beyond
/// `s / (2 mu)`.
#[test]
fn a_collar_at_a_hundred_offsets() {
    let (mu, span, weight) = (0.2, 0.1, 10.0 * G);
    let limit = span / (2.0 * mu);
    for combine in ["pads", "sum"] {
        let friction = format!("bending_span = {span:?}, combine = \"{combine}\"");
        for k in 0..if combine == "pads" { 100 } else { 10 } {
            let offset = limit * (0.001 + 0.998 * f64::from(k) / 99.0);
            let found = run(&collar(mu, offset, &friction, "0.1 m/s*t")).unwrap();
            let drive = found.inverse.column("drive.drive [N]")[1];
            let left = 1.0 - 2.0 * mu * offset / span;
            // The condition number of the problem is proportional to the reciprocal of the
            // denominator.
            let tolerance = 1e-8 * weight / (left * left);
            assert!((drive - weight / left).abs() < tolerance, "{offset}: {drive}");
        }
        for part in [1.0, 1.001, 1.5, 4.0] {
            match run(&collar(mu, part * limit, &friction, "0.1 m/s*t")) {
                Err(Error::Forces { error: InverseError::Locked { joint, percent }, .. }) => {
                    assert_eq!(joint, "guide");
                    assert!((percent - 100.0 / part).abs() < 0.1, "{part}: {percent}");
                }
                other => panic!("{part}: {other:?}"),
            }
        }
    }
}

/// Tests a rod with a weight at its end that extends from a horizontal cylinder. The rod is a lever
/// between gland and piston, whose overlap decreases.
#[test]
fn a_rod_in_its_cylinder() {
    let (mu, weight) = (0.1, 2.0 * G);
    let text = |motion: &str| {
        let parts = format!(
            r#"{}
            [joints.rod]
            type = "P"
            from = "ground"
            to = "tip"
            axis = "x"
            actuated = true
            friction = {{ mu = {mu:?}, gland = "0.5 m", piston = "-0.6 m", combine = "pads" }}
            "#,
            body("tip", 2.0)
        );
        model(&parts, &format!("rod = \"{motion}\""))
    };
    let found = run(&text("0.6 m + 4 m/s*t")).unwrap();
    for (k, slide) in [0.6, 0.8, 1.0].into_iter().enumerate() {
        let overlap = 1.1 - slide;
        let (gland, piston) = (weight * 0.6 / overlap, weight * (slide - 0.5) / overlap);
        let load = found.friction.column("rod.load [N]")[k];
        assert!((load / (gland + piston) - 1.0).abs() < 1e-12, "{slide}: {load}");
        let drive = found.inverse.column("rod.drive [N]")[k];
        assert!((drive / (mu * load) - 1.0).abs() < 1e-12);
    }
    match run(&text("1 m + 2 m/s*t")) {
        Err(Error::Forces { error: InverseError::NoOverlap { joint, beyond }, time }) => {
            assert_eq!((joint.as_str(), time), ("rod", 0.05));
            assert!(beyond.abs() < 1e-12);
        }
        other => panic!("{other:?}"),
    }
}

/// Tests that supports on the other body are equivalent to the reversed joint.
#[test]
fn supports_on_either_body() {
    let friction = "mu = 0.15, bending_span = 0.1, torsion_arm = 0.05";
    let carriage = |from: &str, to: &str, axis: &str, supports: &str| {
        let parts = format!(
            r#"{}
            [joints.rail]
            type = "P"
            from = "{from}"
            to = "{to}"
            axis = "{axis}"
            actuated = true
            friction = {{ {friction}, supports = "{supports}" }}
            "#,
            body("carriage", 2.0)
        );
        let text = model(&parts, "rail = \"0.3 m + 0.5 m/s*t\"");
        let load = "[loads.none]\ncarriage = { fy = \"30 N\", at = [\"5 mm\", 0, \"40 mm\"] }";
        let found = run(&text.replace("[loads.none]", load)).unwrap();
        found.inverse.column("rail.drive [N]").to_vec()
    };
    let on_rail = carriage("ground", "carriage", "x", "from");
    let on_carriage = carriage("ground", "carriage", "x", "to");
    let turned = carriage("carriage", "ground", "-x", "from");
    assert!((on_rail[1] - on_carriage[1]).abs() > 1.0);
    for (a, b) in on_carriage.iter().zip(&turned) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
    // If the supports are on the carriage, the position of the carriage does not matter.
    assert!((on_carriage[0] - on_carriage[2]).abs() < 1e-12);
}
