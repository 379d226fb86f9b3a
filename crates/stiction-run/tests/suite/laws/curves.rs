//! Coefficients as functions of the sliding speed, for both directions and at rest.

use crate::laws::{G, body, model, run};

/// Returns the actuator force of a block of 2 kg on a guide at an angle to the ground, and the
/// interval of this force at rest.
fn block(angle: f64, friction: &str, motion: &str) -> [f64; 3] {
    let parts = format!(
        r#"{}
        [joints.guide]
        type = "P"
        from = "ground"
        to = "block"
        axis = ["cos({angle} deg)", 0, "sin({angle} deg)"]
        actuated = true
        friction = {{ {friction} }}
        "#,
        body("block", 2.0)
    );
    let run = run(&model(&parts, &format!("guide = \"{motion}\""))).unwrap();
    ["drive", "drive_low", "drive_high"]
        .map(|column| run.inverse.column(&format!("guide.{column} [N]"))[1])
}

#[test]
fn an_inclined_plane() {
    let weight = 2.0 * G;
    for angle in [0.0, 5.0, 20.0, 45.0, 80.0_f64] {
        let (sin, cos) = angle.to_radians().sin_cos();
        for (mu, mu_static) in [(0.0, 0.0), (0.1, 0.1), (0.4, 0.7)] {
            let friction = format!("mu = {mu:?}, mu_static = {mu_static:?}");
            let near = |found: f64, part: f64| (found - weight * (sin + part * cos)).abs() < 1e-12;
            let [up, low, high] = block(angle, &friction, "0.2 m/s*t");
            assert!(near(up, mu) && low == up && high == up, "{angle} {mu}: {up}");
            let [down, ..] = block(angle, &friction, "-0.2 m/s*t");
            assert!(near(down, -mu), "{angle} {mu}: {down}");
            let [rest, low, high] = block(angle, &friction, "0.2 m");
            let bounded = near(low, -mu_static) && near(high, mu_static);
            assert!(near(rest, 0.0) && bounded, "{angle} {mu}: {low} {rest} {high}");
        }
    }
}

/// Returns the apparent friction coefficient of a level guide at a sliding velocity.
fn coefficient(friction: &str, velocity: f64) -> f64 {
    let [drive, ..] = block(0.0, friction, &format!("{velocity:?} m/s*t"));
    drive / (2.0 * G) * velocity.signum()
}

#[test]
fn coefficients_over_the_speed() {
    let curve = |falls: f64| 0.1 + 0.2 * (-falls).exp();
    let speeds = [0.001, 0.01, 0.02, 0.05, 0.3_f64];
    let keys = "mu = 0.1, mu_static = 0.3, stribeck_velocity = \"20 mm/s\"";
    for speed in speeds {
        let x = speed / 0.02;
        for (extra, expected) in [
            ("", curve(x * x)),
            (", law = \"stribeck\"", curve(x * x)),
            (", stribeck_exponent = 0.5", curve(x.sqrt())),
            (", law = \"exponential\"", curve(x)),
            (", law = \"lugre\", sigma0 = 1e5, sigma1 = 300", curve(x * x)),
            (", viscous = \"5 N s/m\"", curve(x * x) + 5.0 * speed / (2.0 * G)),
            (
                ", law = \"lugre\", sigma0 = 1e5, sigma1 = 300, sigma2 = \"5 N s/m\"",
                curve(x * x) + 5.0 * speed / (2.0 * G),
            ),
            (
                ", regularised = \"tanh\", regularisation_velocity = \"8 mm/s\"",
                curve(x * x) * (speed / 0.008).tanh(),
            ),
        ] {
            for velocity in [speed, -speed] {
                let found = coefficient(&format!("{keys}{extra}"), velocity);
                assert!((found - expected).abs() < 1e-13, "{velocity}{extra}: {found} {expected}");
            }
        }
        let dahl = "law = \"dahl\", mu = 0.1, sigma0 = \"1e5 N/m / 1 N\"";
        assert!((coefficient(dahl, speed) - 0.1).abs() < 1e-14);
    }
    let table = "table = [[0, 0.3], [\"10 mm/s\", 0.15], [\"0.05 m/s\", 0.1], [0.4, 0.2]]";
    for (speed, expected) in
        [(0.005, 0.225), (0.01, 0.15), (0.03, 0.125), (0.05, 0.1), (0.225, 0.15), (2.0, 0.2)]
    {
        let found = coefficient(table, speed);
        assert!((found - expected).abs() < 1e-14, "{speed}: {found} {expected}");
    }
    // At rest, the first row of the table limits the actuator force.
    let [_, low, high] = block(0.0, table, "1 m");
    assert!((high - 0.3 * 2.0 * G).abs() < 1e-12 && (low + high).abs() < 1e-12);
}

#[test]
fn coefficients_of_both_directions() {
    let friction = "mu = 0.1, viscous = \"3 N s/m\", \
                    backward = { mu = 0.25, mu_static = 0.4, viscous = \"1 N s/m\" }";
    let weight = 2.0 * G;
    assert!((coefficient(friction, 0.5) - (0.1 + 1.5 / weight)).abs() < 1e-14);
    assert!((coefficient(friction, -0.5) - (0.25 + 0.5 / weight)).abs() < 1e-14);
    // At rest each direction has its own limit.
    let [rest, low, high] = block(0.0, friction, "1 m");
    assert!(rest.abs() < 1e-12);
    assert!((low + 0.4 * weight).abs() < 1e-12, "{low}");
    assert!((high - 0.1 * weight).abs() < 1e-12, "{high}");
    // Missing keys have the values of the forward direction. A table may replace a coefficient, and
    // a coefficient a table.
    let inherited = "mu = 0.1, viscous = \"3 N s/m\", backward = { table = [[0, 0.3], [1, 0.2]] }";
    assert!((coefficient(inherited, -0.5) - (0.25 + 1.5 / weight)).abs() < 1e-14);
    let turned = "table = [[0, 0.3], [1, 0.2]], backward = { mu = 0.05 }";
    assert!((coefficient(turned, 0.5) - 0.25).abs() < 1e-14);
    assert!((coefficient(turned, -0.5) - 0.05).abs() < 1e-14);
}

/// Tests that regularised friction has no interval at rest, because nothing sticks.
#[test]
fn a_regularised_friction_does_not_hold() {
    let friction = "mu = 0.3, regularised = \"tanh\", regularisation_velocity = \"1 mm/s\"";
    let [rest, low, high] = block(0.0, friction, "1 m");
    assert_eq!((rest, rest), (low, high));
}
