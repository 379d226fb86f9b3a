//! Simulated motions compared with closed forms and inverse dynamics.

use crate::program::models::slope;
use crate::program::{Folder, column, json};

/// Compares with the closed form for a block on a slope, released at rest: the block slides
/// downwards by s = g (sin a - mu cos a) t^2/2, or it sticks.
#[test]
fn a_block_slides_or_sticks() {
    let folder = Folder::new("forward-slope");
    folder.write("slope.toml", &slope(0.2));
    let run =
        ["forward", "slope.toml", "--drives", "none", "--from", "rest", "--until", "2", "-o", "."];
    folder.stiction(&run).succeeds();
    let table = folder.read("forward.csv");
    let acceleration = -10.0 * (0.5 - 0.2 * 0.75_f64.sqrt());
    for (t, s) in column(&table, "time [s]").iter().zip(column(&table, "slope.position [m]")) {
        // The position is a quadratic function of time, which integration steps of any size
        // reproduce exactly.
        assert!((s - 0.5 * acceleration * t * t).abs() < 1e-12, "{t}: {s}");
    }
    let energy = folder.read("energy.csv");
    let dissipated = column(&energy, "slope.dissipated [J]")[200];
    // Friction work mu N s = 0.2 * 20 N cos 30 deg * 6.5359 m.
    let expected = 0.2 * 20.0 * 0.75_f64.sqrt() * -2.0 * acceleration;
    assert!((dissipated - expected).abs() < 1e-9, "{dissipated} {expected}");

    folder.write("slope.toml", &slope(0.6));
    folder.stiction(&run).succeeds();
    assert!(column(&folder.read("forward.csv"), "slope.position [m]").iter().all(|s| *s == 0.0));
    assert!(column(&folder.read("friction.csv"), "slope.sticks").iter().all(|s| *s == 1.0));
    // Upward friction holds the block's weight along the slope, 10 N downwards.
    let friction = column(&folder.read("friction.csv"), "slope.friction [N]");
    assert!(friction.iter().all(|f| (f + 10.0).abs() < 1e-12), "{friction:?}");
    assert_eq!(json(&folder.read("summary.json"))["friction"]["slope"]["sticks"], 2.0);
}

/// Inverse dynamics of a simulated motion, read from the simulation's files, yields the efforts of
/// the simulation. Forward and inverse dynamics share neither unknowns nor elimination.
#[test]
fn inverse_dynamics_of_a_simulation_returns_its_efforts() {
    let folder = Folder::new("forward-inverse");
    for (model, drives, names) in [
        ("four-bar", "A = 3 N m*sin(10*t)", vec!["A.drive [N m]"]),
        (
            "five-bar",
            "left_motor = 2 N m*cos(9*t); right_motor = 1 N m",
            vec!["left_motor.drive [N m]", "right_motor.drive [N m]"],
        ),
        (
            "zhang2018-regular",
            "leg1.P = 75 N + 5 N*sin(8*t); leg2.P = 60 N; leg3.P = 30 N",
            vec!["leg1.P.drive [N]", "leg2.P.drive [N]", "leg3.P.drive [N]"],
        ),
    ] {
        folder
            .stiction(&["forward", model, "--drives", drives, "--until", "0.2", "-o", "f"])
            .succeeds();
        let inner = Folder(folder.0.join("f"));
        let slow = |row: usize, table: &str| {
            let header = table.lines().next().unwrap();
            let speeds = header.split(',').filter(|name| name.ends_with("speed [m/s]"));
            speeds.into_iter().any(|name| column(table, name)[row].abs() < 1e-9)
        };
        let friction = inner.read("friction.csv");
        let count = friction.lines().count() - 1;
        let resting: Vec<bool> = (0..count).map(|row| slow(row, &friction)).collect();
        folder.stiction(&["inverse", model, "--motion", "f/motion.csv", "-o", "i"]).succeeds();
        let found = Folder(folder.0.join("i")).read("inverse.csv");
        let given = inner.read("forward.csv");
        for name in names {
            let (found, given) = (column(&found, name), column(&given, name));
            assert!(found.len() == count && count > 20);
            for (row, (found, given)) in found.iter().zip(&given).enumerate() {
                // Rounding errors are magnified near a singular position: the singularity index is
                // 0.015 at the end.
                assert!(
                    resting[row] || (found - given).abs() < 1e-9,
                    "{model} {row}: {found} {given}"
                );
            }
            assert!(resting.iter().filter(|rests| **rests).count() < 3);
        }
    }
}

/// Rods between two ball joints have little inertia about their own axes, which causes too many
/// events for the event-driven method; the simulation continues by time stepping.
#[test]
fn a_delta_robot_continues_by_time_stepping() {
    let folder = Folder::new("forward-delta");
    let run = ["forward", "delta", "--until", "0.02", "--tolerance", "1e-9", "-o", "."];
    let out = folder.stiction(&run).succeeds().to_owned();
    assert!(out.contains("time-stepping"), "{out}");
    let summary = json(&folder.read("summary.json"));
    assert_eq!(summary["ended"], "reached");
    assert_eq!(summary["options"]["method"], "automatic");
    let steps = summary["method"]["time_stepping"].as_f64().unwrap();
    let events = summary["method"]["event_driven"].as_f64().unwrap();
    assert!(steps > 0.0 && (steps + events - 0.02).abs() < 1e-12, "{steps} {events}");
    // The ball joints slide from here on.
    assert!(summary["energy"]["interfaces"].as_f64().unwrap() > 0.0);
}

#[test]
fn the_method_can_be_chosen() {
    let folder = Folder::new("forward-method");
    folder.write("slope.toml", &slope(0.3));
    for method in ["event-driven", "time-stepping"] {
        let run = [
            "forward",
            "slope.toml",
            "--drives",
            "none",
            "--from",
            "rest",
            "--until",
            "0.5",
            "--method",
            method,
            "-o",
            method,
        ];
        folder.stiction(&run).succeeds();
        let inner = Folder(folder.0.join(method));
        let summary = json(&inner.read("summary.json"));
        let passed = summary["method"][method.replace('-', "_")].as_f64().unwrap();
        assert!((passed - 0.5).abs() < 1e-12);
        // The displacement is g (sin - mu cos) t^2 / 2 downwards; time stepping with mid-step
        // velocities is exact for a quadratic function.
        let (sin, cos) = 30_f64.to_radians().sin_cos();
        let expected = -0.5 * 10.0 * (sin - 0.3 * cos) * 0.25;
        let found = *column(&inner.read("forward.csv"), "slope.position [m]").last().unwrap();
        assert!((found - expected).abs() < 1e-9, "{method}: {found} {expected}");
    }
}

/// Checks an initial state whose position and rate are given separately: `x = 0.2 + 0.3 t - 5 t^2`
/// without friction on a slope of 30 degrees. With a rate alone, the position is that of the model.
#[test]
fn a_start_names_positions_and_rates() {
    let folder = Folder::new("forward-from-rates");
    folder.write("slope.toml", &slope(0.0));
    let run = |from| {
        let times = ["--until", "0.5", "-o", ".", "--drives", "none", "--from", from];
        folder.stiction(&[&["forward", "slope.toml"][..], &times].concat())
    };
    for (from, start) in [
        ("slope = 200 mm; d(slope) = 0.3 m/s", 0.2),
        ("d(slope) = 300 mm/s; slope = 0.2 m", 0.2),
        ("d(slope) = 0.3 m/s", 0.0),
    ] {
        run(from).succeeds();
        let found = *column(&folder.read("forward.csv"), "slope.position [m]").last().unwrap();
        let expected = start + 0.3 * 0.5 - 0.5 * 10.0 * 0.5 * 0.25;
        assert!((found - expected).abs() < 1e-9, "{from}: {found} {expected}");
    }
}

/// File size limits, full devices and small stacks cause messages that state what failed.
#[cfg(target_os = "linux")]
#[test]
fn limits_of_the_system_are_said() {
    let folder = Folder::new("forward-limits");
    let program = env!("CARGO_BIN_EXE_stiction");
    for (limits, outcome, says) in [
        ("ulimit -f 8; exec \"$0\" inverse 3rps -o out > /dev/null", 2, "File too large"),
        ("ulimit -s 64; exec \"$0\" check 3rps > /dev/null", 0, ""),
        ("exec \"$0\" --help > /dev/full", 2, "No space left on device"),
        ("exec \"$0\" inverse 3rps > /dev/full", 2, "No space left on device"),
    ] {
        let shell = std::process::Command::new("sh")
            .args(["-c", limits, program])
            .current_dir(&folder.0)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&shell.stderr).into_owned();
        assert_eq!(shell.status.code(), Some(outcome), "{limits}: {said}");
        assert!(said.contains(says), "{limits}: {said}");
    }
}

/// A prescribed motion reverses a plate once, not again and again at one instant.
#[test]
fn a_prescribed_motion_reverses_a_plate_once() {
    let folder = Folder::new("forward-prescribed-reversal");
    let text = "
        gravity = [0, 0, -9.81]
        [bodies.block]
        mass = 2
        com = [0, 0, 0.05]
        inertia = [0.01, 0.01, 0.01]
        [joints.P]
        type = \"P\"
        from = \"ground\"
        to = \"block\"
        axis = \"x\"
        actuated = true
        [joints.plate]
        type = \"E\"
        from = \"ground\"
        to = \"block\"
        axis = \"z\"
        friction = { mu = 0.2, radius = 0.02 }
        [motions.m]
        duration = 1
        P = \"0.04 m*sin(2.3*t + 0.4) - 0.04 m*sin(0.4)\"";
    folder.write("block.toml", text);
    let run = ["forward", "block.toml", "--prescribe", "P", "--method", "event-driven"];
    folder.stiction(&[&run[..], &["--report", "off", "-o", "."]].concat()).succeeds();
    let events = folder.read("events.csv");
    let rows: Vec<&str> = events.lines().skip(1).collect();
    assert!(matches!(rows[..], [row] if row.contains(",reverses,plate,")), "{events}");
    let time: f64 = rows[0].split(',').next().unwrap().parse().unwrap();
    assert!((time - (std::f64::consts::FRAC_PI_2 - 0.4) / 2.3).abs() < 1e-9, "{time}");
}

/// The friction of a motor that rotates is a moment, and its sliding velocity an angular velocity.
#[test]
fn friction_of_motors_has_units_of_rotations() {
    let folder = Folder::new("forward-motor-units");
    let text = "
        gravity = [0, -9.81, 0]
        [bodies.arm]
        mass = 1
        com = [0.1, 0, 0]
        inertia = [0.01, 0.01, 0.01]
        [joints.A]
        type = \"R\"
        from = \"ground\"
        to = \"arm\"
        axis = \"z\"
        friction = { mu = 0.1, radius = 0.01 }
        [actuators.motor]
        joint = \"A\"
        ratio = 5
        motor_friction = { constant = \"20 mN m\" }
        [motions.swing]
        duration = 0.1
        A = \"t\"";
    folder.write("arm.toml", text);
    let out = folder.stiction(&["forward", "arm.toml", "-o", "."]).succeeds().to_owned();
    let friction = folder.read("friction.csv");
    let header = friction.lines().next().unwrap();
    for name in ["A.speed [m/s]", "A.load [N]", "motor.motor.speed [rad/s]"] {
        assert!(header.contains(name), "{header}");
    }
    assert!(header.contains("motor.motor.load [N m],motor.motor.friction [N m]"), "{header}");
    let line = out.lines().find(|line| line.starts_with("motor.motor ")).unwrap();
    assert!(line.ends_with(" N m"), "{line}");
}

/// The ball of a frame that cannot move sticks, while a prescribed motion moves a plate on it. The
/// ball slid at the speed of round-off, with its full friction.
#[test]
fn a_ball_that_cannot_move_sticks_beside_a_prescribed_motion() {
    let folder = Folder::new("forward-prescribed-frame");
    let body = |name: &str, mass: f64, com: &str, at: &str| {
        format!(
            "[bodies.{name}]\nmass = {mass}\ncom = {com}\ninertia = [0.04, 0.04, 0.04]\n\
             home = {{ position = {at} }}\n"
        )
    };
    let bodies = [
        body("frame", 1.2, "[0.1, 0.05, 0.2]", "[0, 0, 0]"),
        body("strut", 1.0, "[0.1, 0, 0.1]", "[-0.3, 0.2, 0.4]"),
        body("plate", 1.4, "[0.02, -0.05, 0.03]", "[0.4, 0.1, 0.3]"),
    ];
    let joints = "
        [joints.foot]
        type = \"S\"
        from = \"ground\"
        to = \"frame\"
        friction = { mu = 0.25, radius = 0.02, preload = 5 }
        [joints.cross]
        type = \"U\"
        from = \"ground\"
        to = \"strut\"
        at = [-0.3, 0.2, 0.4]
        axis = [1, 0.3, 0]
        second_axis = [-0.3, 1, 0]
        [joints.pin]
        type = \"R\"
        from = \"strut\"
        to = \"frame\"
        at = [0.3, -0.1, 0.3]
        to_at = [0, 0.1, 0.7]
        axis = [0.3, 1, 0.2]
        [joints.plane]
        type = \"E\"
        from = \"frame\"
        to = \"plate\"
        at = [0.4, 0.1, 0.3]
        axis = [0.1, 0.2, 1]
        actuated = [\"angle\"]
        friction = { mu = 0.23, radius = 0.03 }
        [joints.ball]
        type = \"S\"
        from = \"plate\"
        to = \"ground\"
        at = [0.2, 0.1, 0.1]
        to_at = [0.6, 0.2, 0.4]
        friction = { mu = 0.1, viscous = 3, radius = 0.029 }
        [motions.m]
        duration = 1
        plane.angle = \"0.4 rad*(1 - cos(7*t))\"";
    folder.write("frame.toml", &format!("gravity = [3, -2, -9]\n{}{joints}", bodies.concat()));
    let run = ["forward", "frame.toml", "--prescribe", "plane.angle", "--report", "off", "-o", "."];
    folder.stiction(&run).succeeds();
    let friction = folder.read("friction.csv");
    assert!(column(&friction, "foot.sticks").iter().all(|sticks| *sticks == 1.0));
    let summary = json(&folder.read("summary.json"));
    let error = summary["energy"]["error_relative"].as_f64().unwrap();
    assert!(error < 1e-9, "{error}");
}
