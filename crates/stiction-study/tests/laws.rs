//! Friction laws and load maps against closed forms.

mod common;

use common::*;
use stiction::dynamics::{FrictionMode, InverseError};
use stiction_study::inverse::Error;

const G: f64 = 9.81;

fn run(text: &str) -> Result<Run, Error> {
    let model = model_of("closed form", text);
    Run::of(&default_job(&model, FrictionMode::Converged))
}

/// A text with one motion, no load, gravity downwards.
fn model(parts: &str, motion: &str) -> String {
    format!(
        r#"
        gravity = [0, 0, "-{G} m/s^2"]
        {parts}
        [motions.m]
        duration = "0.1 s"
        step = "0.05 s"
        {motion}
        [loads.none]
        [default]
        motion = "m"
        load = "none"
        "#
    )
}

fn body(name: &str, mass: f64) -> String {
    format!("[bodies.{name}]\nmass = {mass:?}\ncom = [0, 0, 0]\ninertia = [0.01, 0.01, 0.01]\n")
}

/// The drive of a block of 2 kg on a guide at this angle to the ground, and its interval.
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

/// The coefficient that a level guide shows at a sliding velocity.
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
    // At rest the first row bounds the drive.
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
    // What is not said is as forward; a table may take the place of a coefficient, and it of a table.
    let inherited = "mu = 0.1, viscous = \"3 N s/m\", backward = { table = [[0, 0.3], [1, 0.2]] }";
    assert!((coefficient(inherited, -0.5) - (0.25 + 1.5 / weight)).abs() < 1e-14);
    let turned = "table = [[0, 0.3], [1, 0.2]], backward = { mu = 0.05 }";
    assert!((coefficient(turned, 0.5) - 0.25).abs() < 1e-14);
    assert!((coefficient(turned, -0.5) - 0.05).abs() < 1e-14);
}

/// A regularised friction has no interval at rest: nothing sticks.
#[test]
fn a_regularised_friction_does_not_hold() {
    let friction = "mu = 0.3, regularised = \"tanh\", regularisation_velocity = \"1 mm/s\"";
    let [rest, low, high] = block(0.0, friction, "1 m");
    assert_eq!((rest, rest), (low, high));
}

/// A screw jack under 50 kg: lead angle, half flank angle across the thread, and friction angle.
struct Jack {
    radius: f64,
    pitch: f64,
    /// Half the flank angle along the axis, deg.
    flank: f64,
    mu: f64,
}

impl Jack {
    const WEIGHT: f64 = 50.0 * G;

    fn angles(&self) -> (f64, f64) {
        let lead = (self.pitch / self.radius).atan();
        let across = (self.flank.to_radians().tan() * lead.cos()).atan();
        (lead, (self.mu / across.cos()).atan())
    }

    fn friction(&self) -> String {
        let Self { radius, flank, mu, .. } = self;
        format!("friction = {{ mu = {mu:?}, radius = {radius:?}, flank_angle = \"{flank} deg\" }}")
    }

    /// A spindle that a motor turns in a nut that stands still.
    fn turned_spindle(&self, motion: &str) -> String {
        let parts = format!(
            "{}\n[joints.drive]\ntype = \"H\"\nfrom = \"ground\"\nto = \"spindle\"\naxis = \"z\"\n\
             pitch = {:?}\nactuated = true\n{}\n",
            body("spindle", 50.0),
            self.pitch,
            self.friction()
        );
        model(&parts, &format!("drive = \"{motion}\""))
    }

    /// A spindle that does not turn, in a nut that a motor turns.
    fn turned_nut(&self, motion: &str) -> String {
        let parts = format!(
            r#"{}{}
            [joints.drive]
            type = "R"
            from = "ground"
            to = "nut"
            axis = "-z"
            actuated = true
            [joints.thread]
            type = "H"
            from = "nut"
            to = "spindle"
            axis = "z"
            pitch = {:?}
            {}
            [joints.guide]
            type = "P"
            from = "ground"
            to = "spindle"
            axis = "z"
            "#,
            body("nut", 1e-9),
            body("spindle", 50.0),
            self.pitch,
            self.friction()
        );
        model(&parts, &format!("drive = \"{motion}\""))
    }
}

#[test]
fn a_screw_jack() {
    let mut held = [0, 0];
    for (radius, pitch) in [(0.01, 0.0008), (0.01, 0.004), (0.02, -0.01), (0.01, 0.012)] {
        for flank in [0.0, 15.0, 30.0] {
            for mu in [0.0, 0.05, 0.15, 0.4] {
                let jack = Jack { radius, pitch, flank, mu };
                let (lead, rub) = jack.angles();
                // Forward is up in a right-hand thread.
                let up = Jack::WEIGHT * radius * (lead + rub * pitch.signum()).tan();
                let down = Jack::WEIGHT * radius * (lead - rub * pitch.signum()).tan();
                let (up_rate, down_rate) = (pitch.signum(), -pitch.signum());
                for text in [Jack::turned_spindle, Jack::turned_nut] {
                    let torque = |motion: String, column: &str| {
                        let run = run(&text(&jack, &motion)).unwrap();
                        assert!(run.power_residual < 1e-9);
                        run.inverse.column(&format!("drive.{column} [N m]"))[1]
                    };
                    let near = |found: f64, expected: f64| {
                        // The light nut and the guide's redundancy leave round-off of the weight.
                        let error = (found - expected).abs();
                        assert!(error < 1e-8 * Jack::WEIGHT * radius, "{found} {expected}");
                    };
                    near(torque(format!("{up_rate:?} rad/s*t"), "drive"), up);
                    near(torque(format!("{down_rate:?} rad/s*t"), "drive"), down);
                    let (low, high) = (up.min(down), up.max(down));
                    near(torque("1 rad".into(), "drive_low"), low);
                    near(torque("1 rad".into(), "drive_high"), high);
                    // It holds by itself where the friction angle is greater than the lead.
                    assert_eq!(low < 0.0 && 0.0 < high, rub > lead.abs(), "{lead} {rub}");
                    held[usize::from(rub > lead.abs())] += 1;
                }
            }
        }
    }
    assert!(held.iter().all(|count| *count > 10), "{held:?}");
}

/// Where lead and friction angle make a right angle nothing turns a load up.
#[test]
fn a_screw_that_locks() {
    let jack = |mu| Jack { radius: 0.01, pitch: 0.02, flank: 0.0, mu };
    // The lead's tangent is 2, so that it locks from mu = 1/2 on.
    for mu in [0.45, 0.49] {
        let run = run(&jack(mu).turned_spindle("1 rad/s*t")).unwrap();
        let torque = run.inverse.column("drive.drive [N m]")[1];
        let expected = Jack::WEIGHT * 0.01 * (2f64.atan() + mu.atan()).tan();
        assert!((torque / expected - 1.0).abs() < 1e-10, "{torque} {expected}");
    }
    for mu in [0.5, 0.6, 1.0] {
        match run(&jack(mu).turned_spindle("1 rad/s*t")) {
            Err(Error::Forces { error: InverseError::Locked { joint, percent }, .. }) => {
                assert_eq!(joint, "drive");
                assert!((percent - 50.0 / mu).abs() < 0.1, "{mu}: {percent}");
            }
            other => panic!("{mu}: {other:?}"),
        }
    }
    // A radial load rubs on the flanks as well, and its friction bears a part of the axial one:
    // N = (W + mu N sin l) / cos l + F, with the lead l.
    let (mu, side) = (0.1, 300.0);
    let text = jack(mu).turned_spindle("1 rad/s*t");
    let text = text.replace("[loads.none]", "[loads.none]\nspindle = { fx = \"300 N\" }");
    let found = run(&text).unwrap();
    let (sin, cos) = 2f64.atan().sin_cos();
    let load = (Jack::WEIGHT / cos + side) / (1.0 - mu * sin / cos);
    let torque = Jack::WEIGHT * 0.02 + mu * load * 0.01 / cos;
    // The load is on a spindle that has moved along its axis by then.
    assert!((found.friction.column("drive.load [N]")[0] / load - 1.0).abs() < 1e-12);
    assert!((found.inverse.column("drive.drive [N m]")[0] / torque - 1.0).abs() < 1e-12);
}

/// A block in a groove: each face carries `W / (2 sin a)`, with half the groove's angle `a`.
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

/// A plate that slides and turns: its friction is along the velocity of its middle and against its
/// turning, in the ratio of velocity and effective radius times rate.
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

/// A collar of 10 kg on a vertical rod with pads 0.1 m apart, driven at an offset.
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
        [joints.drive]
        type = "P"
        from = "ground"
        to = "driver"
        at = ["{offset:?} m", 0, "-1 m"]
        axis = "z"
        actuated = true
        [joints.A]
        type = "S"
        from = "driver"
        to = "rod"
        [joints.B]
        type = "S"
        from = "rod"
        to = "collar"
        at = [0, 0, "1 m"]
        to_at = ["{offset:?} m", 0, 0]
        "#,
        body("collar", 10.0)
    );
    model(&parts, &format!("guide = \"{motion}\""))
}

/// `P = W / (1 - 2 mu e / s)` for a hundred offsets `e`, and self-locking beyond `s / (2 mu)`.
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
            // The condition of the problem grows like one over the denominator.
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

/// A rod that slides out of a level cylinder, its weight at its end: a lever between gland and
/// piston, whose overlap shrinks.
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

/// Supports that travel with the other body are those of the joint the other way round.
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
    // On the carriage it makes no difference where it is.
    assert!((on_carriage[0] - on_carriage[2]).abs() < 1e-12);
}

/// A shoe on a lever brakes a straight rope that is drawn past it. The pin of the shoe lies `a` from
/// the lever's pivot along the rope and `c` across; with the force `P` at the arm `l` the shoe is
/// pressed with `N = P l / (a - mu c)` if the rope drags it away from the pivot, `a + mu c` if
/// towards it, and the rope needs `mu N`. Away it grips by itself from `mu = a/c` on.
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
            // Drawn along x the rope drags the shoe forward: about the pivot that presses it on.
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
