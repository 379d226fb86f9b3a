//! Loaded surfaces: grooves, plates, shoes.

use crate::laws::{G, body, model, run};
use stiction_core::dynamics::InverseError;
use stiction_run::Error;

/// Tests a block in a groove: each face carries `W / (2 sin a)`, where `a` is half of the groove's
/// angle.
#[test]
fn a_groove() {
    for half in [10.0, 30.0, 45.0, 75.0_f64] {
        let (mu, load) = (0.12, 2.0 * G / (2.0 * half.to_radians().sin()));
        let plate = |name: &str, side: f64| {
            format!(
                r#"
                [joints.{name}]
                type = "E"
                from = "ground"
                to = "block"
                axis = [0, "{side:?}*cos({half} deg)", "sin({half} deg)"]
                x_axis = "x"
                friction = {{ mu = {mu:?}, radius = "10 mm" }}
                "#
            )
        };
        let parts = format!(
            "{}{}actuated = [\"x\"]\n{}",
            body("block", 2.0),
            plate("left", 1.0),
            plate("right", -1.0)
        );
        let found = run(&model(&parts, "left.x = \"0.3 m/s*t\"")).unwrap();
        for face in ["left", "right"] {
            let normal = found.friction.column(&format!("{face}.load [N]"))[1];
            assert!((normal - load).abs() < 1e-11, "{half}: {normal} {load}");
        }
        let drive = found.inverse.column("left.drive [N]")[1];
        assert!((drive - 2.0 * mu * load).abs() < 1e-11, "{half}: {drive}");
    }
}

/// Tests a plate that slides and turns: friction opposes the velocity of its middle and its
/// rotation, in the ratio of the velocity to the effective radius times the angular rate.
#[test]
fn a_plate_that_slides_and_turns() {
    let (mu, radius, weight) = (0.2, 0.05, 2.0 * G);
    let parts = format!(
        r#"{}
        [joints.table]
        type = "E"
        from = "ground"
        to = "plate"
        axis = "z"
        x_axis = "x"
        actuated = true
        friction = {{ mu = {mu:?}, radius = {radius:?} }}
        "#,
        body("plate", 2.0)
    );
    for [x, y, spin] in [[0.3, 0.4, 0.0], [0.0, 0.0, 2.0], [-0.03, 0.04, 1.0], [0.2, 0.0, -4.0]] {
        let motion = format!(
            "table.x = \"{x:?} m/s*t\"\ntable.y = \"{y:?} m/s*t\"\ntable.angle = \"{spin:?} rad/s*t\""
        );
        let found = run(&model(&parts, &motion)).unwrap();
        let speed = f64::hypot(f64::hypot(x, y), radius * spin);
        let at = |name: &str| found.inverse.column(name)[0];
        for (found, expected) in [
            (at("table.x.drive [N]"), mu * weight * x / speed),
            (at("table.y.drive [N]"), mu * weight * y / speed),
            (at("table.angle.drive [N m]"), mu * weight * radius * radius * spin / speed),
        ] {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        assert!((found.friction.column("table.speed [m/s]")[0] - speed).abs() < 1e-14);
    }
}

/// Tests a sleeve, which has a single friction force of magnitude `mu N` along its surface
/// velocity. A pin and a guide that are declared separately have one friction force each. A viscous
/// coefficient in N m s/rad is divided by the square of the radius.
#[test]
fn a_sleeve_that_slides_and_turns() {
    let (mu, radius, weight) = (0.15, 0.01, 2.0 * G);
    let parts = |more: &str| {
        format!(
            r#"{}
            [joints.sleeve]
            type = "C"
            from = "ground"
            to = "shaft"
            axis = "x"
            actuated = true
            friction = {{ mu = {mu:?}, radius = {radius:?}, {more} }}
            "#,
            body("shaft", 2.0)
        )
    };
    for [slide, spin] in [[0.02, 8.0], [-0.3, 0.0], [0.0, -5.0], [0.05, -2.0]] {
        let motion =
            format!("sleeve.slide = \"{slide:?} m/s*t\"\nsleeve.angle = \"{spin:?} rad/s*t\"");
        let turn = radius * spin;
        let speed = f64::hypot(slide, turn);
        let along = |v: f64, over: f64| if v == 0.0 { 0.0 } else { mu * weight * v / over };
        for (more, damping, [slide_over, turn_over]) in [
            ("", 0.0, [speed; 2]),
            ("viscous = \"0.3 mN m s/rad\"", 0.3e-3 / (radius * radius), [speed; 2]),
            ("viscous = \"3 N s/m\"", 3.0, [speed; 2]),
            ("angle = {}, slide = {}", 0.0, [slide.abs(), turn.abs()]),
        ] {
            let found = run(&model(&parts(more), &motion)).unwrap();
            let at = |name: &str| found.inverse.column(name)[0];
            for (found, expected) in [
                (at("sleeve.slide.drive [N]"), along(slide, slide_over) + damping * slide),
                (
                    at("sleeve.angle.drive [N m]"),
                    radius * (along(turn, turn_over) + damping * turn),
                ),
            ] {
                assert!((found - expected).abs() < 1e-12, "{more}: {found} {expected}");
            }
        }
    }
}

/// Tests a shoe on a lever that brakes a straight rope. The pin of the shoe is at the distance `a`
/// from the lever's pivot along the rope and `c` across the rope. With the force `P` at the lever
/// arm `l`, the normal load of the shoe is `N = P l / (a - mu c)` if the rope pulls the shoe away
/// from the pivot, and `P l / (a + mu c)` if it pulls towards the pivot. The rope requires `mu N`.
/// For pulls away from the pivot, the brake is self-locking for `mu >= a/c`.
#[test]
fn a_rope_brake_with_a_shoe() {
    let (force, arm, a, c) = (50.0, 0.4, 0.1, 0.15);
    let brake = |mu: f64, motion: &str| {
        format!(
            r#"
            gravity = [0, 0, 0]
            {}{}{}
            [joints.rope]
            type = "P"
            from = "ground"
            to = "rope"
            at = [0, {c}, 0]
            axis = "x"
            actuated = true
            [joints.shoe]
            type = "P"
            from = "shoe"
            to = "rope"
            axis = "x"
            friction = {{ mu = {mu} }}
            [joints.pin]
            type = "R"
            from = "lever"
            to = "shoe"
            at = [{a}, {c}, 0]
            axis = "z"
            [joints.pivot]
            type = "R"
            from = "ground"
            to = "lever"
            axis = "z"
            [motions.m]
            duration = "0.1 s"
            step = "0.05 s"
            rope = "{motion}"
            [loads.press]
            lever = {{ force = [0, {down}, 0], at = [{arm}, 0, 0] }}
            [default]
            motion = "m"
            load = "press"
            "#,
            body("rope", 1.0),
            body("shoe", 1.0),
            body("lever", 1.0),
            down = -force,
        )
    };
    for mu in [0.1, 0.3, 0.6] {
        for (motion, sign) in [("0.2 m/s*t", 1.0), ("-0.2 m/s*t", -1.0)] {
            let run = run(&brake(mu, motion)).unwrap();
            let drive = run.inverse.column("rope.drive [N]")[1];
            // A rope that moves along x pulls the shoe forward; this moment about the pivot
            // increases the normal load.
            let load = force * arm / (a - sign * mu * c);
            let expected = sign * mu * load;
            assert!((drive / expected - 1.0).abs() < 1e-10, "{mu} {motion}: {drive} {expected}");
        }
    }
    for mu in [0.67, 1.0] {
        match run(&brake(mu, "0.2 m/s*t")) {
            Err(Error::Forces { error: InverseError::Locked { joint, percent }, .. }) => {
                assert_eq!(joint, "shoe");
                assert!((percent * mu - 100.0 * a / c).abs() < 0.1, "{mu}: {percent}");
            }
            other => panic!("{mu}: {other:?}"),
        }
    }
}
