//! `stiction forward` as its users meet it.

mod program;

use program::{Folder, column, json};

const FILES: [&str; 8] = [
    "bodies.csv",
    "energy.csv",
    "events.csv",
    "forward.csv",
    "friction.csv",
    "motion.csv",
    "reactions.csv",
    "summary.json",
];

/// 2 kg on a slope of 30 degrees: without a drive it slides if mu < tan 30 deg = 0.57735.
fn slope(mu: f64) -> String {
    format!(
        r#"
        gravity = [0, 0, "-10 m/s^2"]
        [bodies.block]
        mass = "2 kg"
        com = [0, 0, 0]
        inertia = [1, 1, 1]
        [joints.slope]
        type = "P"
        from = "ground"
        to = "block"
        axis = ["cos(30 deg)", 0, "sin(30 deg)"]
        actuated = true
        friction = {{ mu = {mu:?} }}
        [motions.up]
        duration = "2 s"
        slope = "0.1 m/s*t"
        "#
    )
}

#[test]
fn without_arguments_a_controller_follows_the_robots_own_motion() {
    let said = Folder::new("forward-default").stiction(&["forward"]);
    let out = said.succeeds();
    assert!(said.err.contains("knows the robot, but not its friction"), "{}", said.err);
    // What differs between machines is left out.
    let stable: Vec<&str> = out.lines().filter(|line| !line.starts_with("loops closed")).collect();
    insta::assert_snapshot!("forward-default", stable.join("\n"));
}

#[test]
fn the_files_are_complete() {
    let folder = Folder::new("forward-files");
    folder.stiction(&["forward", "-o", "new/deep", "--until", "0.2"]).succeeds();
    let inner = Folder(folder.0.join("new/deep"));
    let mut expected = FILES.to_vec();
    expected.extend(["drives.svg", "energy.svg", "error.svg", "friction.svg", "motion.svg"]);
    expected.sort_unstable();
    assert_eq!(inner.files(), expected);

    let forward = inner.read("forward.csv");
    let times = column(&forward, "time [s]");
    assert_eq!((times.len(), times[0], times[20]), (21, 0.0, 0.2));
    let (position, wanted) =
        (column(&forward, "leg1.P.position [m]"), column(&forward, "leg1.P.wanted [m]"));
    // It follows the motion, but for what friction makes of it.
    assert!(position.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-3 && *a > 0.5));
    assert!(column(&forward, "closure [m]").iter().all(|x| *x < 1e-12));
    assert_eq!(column(&forward, "leg2.R.rate [rad/s]").len(), 21);

    let friction = inner.read("friction.csv");
    for contact in ["leg1.R", "leg2.P", "leg3.S"] {
        let get = |what: &str| column(&friction, &format!("{contact}.{what}"));
        let (force, limit, sticks) = (get("friction [N]"), get("limit [N]"), get("sticks"));
        for ((force, limit), sticks) in force.iter().zip(limit).zip(sticks) {
            assert!(sticks == 0.0 || force.abs() <= limit * (1.0 + 1e-8), "{contact}");
        }
    }
    let energy = inner.read("energy.csv");
    let turnover = column(&energy, "turnover [J]")[20];
    assert!(column(&energy, "error [J]").iter().all(|x| x.abs() < 1e-9 * turnover));
    let summary = json(&inner.read("summary.json"));
    assert_eq!(summary["ended"], "reached");
    assert_eq!(summary["options"]["controller"], "computed-torque");
    assert!(inner.read("events.csv").starts_with("time [s],event,at,detail\n"));
    let svg = inner.read("friction.svg");
    assert!(svg.contains("contacts that stick") && !svg.contains("NaN"));
}

/// From rest: s = g (sin a - mu cos a) t^2/2 downwards, or nothing at all.
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
        // A parabola: steps of any length are exact.
        assert!((s - 0.5 * acceleration * t * t).abs() < 1e-12, "{t}: {s}");
    }
    let energy = folder.read("energy.csv");
    let dissipated = column(&energy, "slope.dissipated [J]")[200];
    // mu N s = 0.2 * 20 N cos 30 deg * 6.5359 m
    let expected = 0.2 * 20.0 * 0.75_f64.sqrt() * -2.0 * acceleration;
    assert!((dissipated - expected).abs() < 1e-9, "{dissipated} {expected}");

    folder.write("slope.toml", &slope(0.6));
    folder.stiction(&run).succeeds();
    assert!(column(&folder.read("forward.csv"), "slope.position [m]").iter().all(|s| *s == 0.0));
    assert!(column(&folder.read("friction.csv"), "slope.sticks").iter().all(|s| *s == 1.0));
    // It holds the block's weight along the slope, 10 N downwards, by friction upwards.
    let friction = column(&folder.read("friction.csv"), "slope.friction [N]");
    assert!(friction.iter().all(|f| (f + 10.0).abs() < 1e-12), "{friction:?}");
    assert_eq!(json(&folder.read("summary.json"))["friction"]["slope"]["sticks"], 2.0);
}

/// Two programs that share neither unknowns nor elimination, by way of the files: the drives that inverse
/// dynamics finds for what happened are those that made it happen.
#[test]
fn inverse_dynamics_of_what_happened_is_what_was_done() {
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
                // Rounding, magnified by the way to a singular position: 0.015 of it is left at the end.
                assert!(
                    resting[row] || (found - given).abs() < 1e-9,
                    "{model} {row}: {found} {given}"
                );
            }
            assert!(resting.iter().filter(|rests| **rests).count() < 3);
        }
    }
}

/// The efforts of a run drive the next.
#[test]
fn drives_can_come_from_a_file() {
    let folder = Folder::new("forward-drives");
    folder.write("slope.toml", &slope(0.0));
    folder.write("push.csv", "time [s],slope [kN]\n0,0.01\n1,0.03\n");
    let run = ["forward", "slope.toml", "--drives", "push.csv", "--from", "rest", "-o", "."];
    folder.stiction(&run).succeeds();
    let table = folder.read("forward.csv");
    // From 10 N, which just holds it, to 30 N within a second: x''' = 20/2 m/s^3.
    for (t, s) in column(&table, "time [s]").iter().zip(column(&table, "slope.position [m]")) {
        assert!((s - 10.0 * t.powi(3) / 6.0).abs() < 1e-10, "{t}: {s}");
    }
    folder.write("again.csv", &table);
    folder
        .stiction(&["forward", "slope.toml", "--drives", "again.csv", "--from", "rest"])
        .succeeds();
}

#[test]
fn joints_can_be_prescribed_and_locked() {
    let folder = Folder::new("forward-locks");
    let drives = "leg3.P = 20 N";
    let run = [
        "forward",
        "--prescribe",
        "leg1.P,leg2.P",
        "--drives",
        drives,
        "--until",
        "0.1",
        "-o",
        ".",
    ];
    folder.stiction(&run).succeeds();
    let table = folder.read("forward.csv");
    let get = |name: &str| column(&table, name);
    let (position, wanted) = (get("leg2.P.position [m]"), get("leg2.P.wanted [m]"));
    assert!(position.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12));
    assert!(get("leg3.P.drive [N]").iter().all(|drive| *drive == 20.0));
    // A joint without an actuator: its lock takes an effort.
    let run = [
        "forward",
        "four-bar",
        "--hold",
        "B",
        "--from",
        "rest",
        "--drives",
        "A = 1 N m",
        "-o",
        ".",
    ];
    folder.stiction(&run).succeeds();
    let table = folder.read("forward.csv");
    let locked = column(&table, "B.position [rad]");
    assert!(locked.iter().all(|angle| *angle == locked[0]));
    assert!(column(&table, "B.drive [N m]").iter().any(|effort| effort.abs() > 0.1));
}

/// A motion that begins beyond half a turn is told where it is; a lock that is named twice is one.
#[test]
fn angles_count_on_from_where_they_are() {
    let folder = Folder::new("forward-turns");
    let run = [
        "forward",
        "four-bar",
        "--prescribe",
        "A",
        "--motion",
        "A = 7 rad + 1 rad/s*t; duration = 0.02 s",
        "-o",
        ".",
    ];
    folder.stiction(&run).succeeds();
    let table = folder.read("forward.csv");
    let places = column(&table, "A.position [rad]");
    let wanted = column(&table, "A.wanted [rad]");
    assert!((places[0] - 7.0).abs() < 1e-12);
    // Nothing but the closing of the loop lies between them.
    assert!(places.iter().zip(&wanted).all(|(place, wanted)| (place - wanted).abs() < 1e-12));
    folder
        .stiction(&["forward", "four-bar", "--hold", "A,A", "--until", "0.01", "--drives", "none"])
        .succeeds();
}

/// Turns between two rows count, where they are and where they are wanted: 20 rad/s, a row a second.
#[test]
fn turns_between_rows_count() {
    let folder = Folder::new("forward-spin");
    let model = r#"
        gravity = [0, 0, 0]
        [bodies.wheel]
        mass = 1
        com = [0, 0, 0]
        inertia = [0.1, 0.1, 0.1]
        [joints.axle]
        type = "R"
        from = "ground"
        to = "wheel"
        axis = "z"
        actuated = true
        [motions.spin]
        duration = 5
        axle = "20 rad/s*t"
        "#;
    folder.write("wheel.toml", model);
    let controller = "type = pd; kp = 0.01; kd = 0.05; period = 0.5 s";
    let spin = ["forward", "wheel.toml", "--step", "1", "-o", ".", "--controller", controller];
    folder.stiction(&spin).succeeds();
    let table = folder.read("forward.csv");
    for name in ["axle.position [rad]", "axle.wanted [rad]"] {
        let angles = column(&table, name);
        assert_eq!(angles.len(), 6);
        for (second, angle) in angles.iter().enumerate() {
            assert!((angle - 20.0 * second as f64).abs() < 1e-10, "{name}: {angles:?}");
        }
    }
}

/// A cart is moved as prescribed, the pendulum on it is free: nothing says how the whole moves, and nothing has to.
/// Leaning back by atan(a/g) it rests on the cart, and the drive of the cart is that of all the mass.
#[test]
fn what_is_not_prescribed_is_free() {
    let folder = Folder::new("forward-cart");
    let model = r#"
        gravity = [0, "-10 m/s^2", 0]
        [bodies.cart]
        mass = 3
        com = [0, 0, 0]
        inertia = [1, 1, 1]
        [bodies.bob]
        mass = 1
        com = [0, -0.5, 0]
        inertia = [0.02, 0.02, 0.02]
        [joints.rail]
        type = "P"
        from = "ground"
        to = "cart"
        axis = "x"
        actuated = true
        [joints.pivot]
        type = "R"
        from = "cart"
        to = "bob"
        axis = "z"
        actuated = true
        friction = { mu = 0.2, radius = "20 mm" }
        [motions.push]
        duration = 2
        rail = "1.5 m/s^2*t^2"
        "#;
    folder.write("cart.toml", model);
    let run =
        ["forward", "cart.toml", "--prescribe", "rail", "--from", "pivot = -atan(0.3)", "-o", "."];
    folder.stiction(&run).succeeds();
    let table = folder.read("forward.csv");
    let angles = column(&table, "pivot.position [rad]");
    assert!(angles.iter().all(|angle| (angle + 0.3f64.atan()).abs() < 1e-12), "{angles:?}");
    assert!(column(&table, "rail.drive [N]").iter().all(|drive| (drive - 12.0).abs() < 1e-9));
    let (at, wanted) = (column(&table, "rail.position [m]"), column(&table, "rail.wanted [m]"));
    assert!(at.iter().zip(wanted).all(|(at, wanted)| (at - wanted).abs() < 1e-12));
    // The pivot follows nothing.
    assert!(!table.contains("pivot.wanted"));
    // Nor does a controller ask for more, if it has gains.
    let alone = model.replace("axis = \"z\"\n        actuated = true", "axis = \"z\"");
    assert!(alone.len() < model.len());
    folder.write("alone.toml", &alone);
    let gains = ["forward", "alone.toml", "--controller", "type = pd; kp = 1e4; kd = 400"];
    folder.stiction(&gains).succeeds();
    folder.stiction(&["forward", "alone.toml"]).fails(2, &["leaves one freedom open"]);
    // Neither does a motion that nobody follows.
    folder.stiction(&["forward", "cart.toml", "--drives", "none", "--until", "0.1"]).succeeds();
}

/// 1 kg on a level guide under a formula; its rate at the end, and its table of events.
fn pushed(folder: &Folder, mu: &str, drive: &str, step: &str) -> (f64, String) {
    let model = format!(
        r#"
        gravity = [0, 0, "-10 m/s^2"]
        [bodies.block]
        mass = 1
        com = [0, 0, 0]
        inertia = [1, 1, 1]
        [joints.guide]
        type = "P"
        from = "ground"
        to = "block"
        axis = "x"
        actuated = true
        {mu}
        "#
    );
    folder.write("block.toml", &model);
    let drive = format!("guide = {drive}");
    let run =
        ["forward", "block.toml", "--until", "2", "--step", step, "-o", ".", "--drives", &drive];
    folder.stiction(&run).succeeds();
    let rates = column(&folder.read("forward.csv"), "guide.rate [m/s]");
    (*rates.last().unwrap(), folder.read("events.csv"))
}

/// What is shorter than a step of a mechanism that moves steadily or not at all is seen all the same, and rows have
/// nothing to do with it: a push of 1000 N for 0.6 ms, 0.2 ms of them on either side to come and to go (0.6 N s in all).
#[test]
fn a_short_push_is_not_missed() {
    let folder = Folder::new("forward-push");
    let push = "1000 N*(smooth(t, 1.0021, 1.0023) - smooth(t, 1.0027, 1.0029))";
    for step in ["0.01", "0.1", "1"] {
        let (rate, _) = pushed(&folder, "", push, step);
        assert!((rate - 0.6).abs() < 1e-10, "{step}: {rate}");
        let (_, events) = pushed(&folder, "friction = { mu = 0.5 }", push, step);
        assert!(events.contains("slides"), "{step}: {events}");
    }
}

/// A force that swings 50 times a second is zero whenever a row is written, and still more than friction bears; one
/// that is more by 1e-4 for a moment lets go at that moment.
#[test]
fn a_force_that_swings_between_rows_lets_go() {
    let folder = Folder::new("forward-swing");
    let begins = |events: &str| -> f64 {
        let first = events.lines().nth(1).unwrap_or_else(|| panic!("nothing happens: {events}"));
        assert!(first.contains("slides"), "{first}");
        first.split(',').next().unwrap().parse().unwrap()
    };
    for step in ["0.01", "0.1"] {
        let (_, events) = pushed(&folder, "friction = { mu = 0.5 }", "10 N*sin(2*pi*50*t)", step);
        // At half its amplitude; then it slides to and fro without rest.
        assert!((begins(&events) - 1.0 / 600.0).abs() < 1e-10, "{step}: {events}");
        assert_eq!(events.matches("reverses").count(), 199, "{step}: {events}");
    }
    let first = (5.0 / 5.0005_f64).asin() / std::f64::consts::TAU;
    for step in ["0.01", "0.07", "0.1"] {
        let both = "friction = { mu = 0.2, mu_static = 0.5 }";
        let (_, events) = pushed(&folder, both, "5.0005 N*sin(2*pi*t)", step);
        let at = begins(&events);
        // Friction lets go at 1e-9 beyond its limit: about a peak that is a later time by 1e-9/(2 pi cos).
        let forgiven = 1e-9 / (std::f64::consts::TAU * (1.0 - (5.0 / 5.0005_f64).powi(2)).sqrt());
        assert!((at - first).abs() < 1.1 * forgiven, "{step}: {at} {first}");
        // Once a half turn.
        assert_eq!(events.matches("slides").count(), 4, "{step}: {events}");
    }
}

#[test]
fn the_start_may_be_partial() {
    let folder = Folder::new("forward-start");
    let from = "A = 40 deg + 2 rad/s*t";
    folder
        .stiction(&["forward", "four-bar", "--from", from, "--until", "0.01", "-o", "."])
        .succeeds();
    let table = folder.read("forward.csv");
    assert!((column(&table, "A.position [rad]")[0] - 40_f64.to_radians()).abs() < 1e-12);
    assert!((column(&table, "A.rate [rad/s]")[0] - 2.0).abs() < 1e-12);
    // One leg of three: the others are where the model puts them.
    let run =
        ["forward", "--from", "leg1.P = 590 mm", "--drives", "none", "--until", "0.01", "-o", "."];
    folder.stiction(&run).succeeds();
    let table = folder.read("forward.csv");
    assert!((column(&table, "leg1.P.position [m]")[0] - 0.59).abs() < 1e-12);
    assert_eq!(column(&table, "leg2.P.rate [m/s]")[0], 0.0);
}

/// Rods that are light about their own axes, in two balls each: events come without end, steps do not.
#[test]
fn a_delta_robot_is_passed_in_steps_and_says_so() {
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
    // Balls turn and slide from here on.
    assert!(summary["energy"]["contacts"].as_f64().unwrap() > 0.0);
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
        // g (sin - mu cos) t^2 / 2, downwards; steps at mid-velocities are exact for a parabola.
        let (sin, cos) = 30_f64.to_radians().sin_cos();
        let expected = -0.5 * 10.0 * (sin - 0.3 * cos) * 0.25;
        let found = *column(&inner.read("forward.csv"), "slope.position [m]").last().unwrap();
        assert!((found - expected).abs() < 1e-9, "{method}: {found} {expected}");
    }
}

#[test]
fn programs_get_one_json_text() {
    let folder = Folder::new("forward-json");
    let said = folder.stiction(&["forward", "five-bar", "--json", "--until", "0.02"]);
    assert_eq!(
        (json(said.succeeds())["model"]["name"].as_str(), said.err.as_str()),
        (Some("five-bar"), "")
    );
    let said = folder.stiction(&["forward", "--drives", "leg1.Q = 1 N", "--json"]);
    assert_eq!((said.code, said.err.as_str()), (2, ""));
    assert_eq!(json(&said.out)["error"]["diagnostics"][0]["code"], "unknown-name");
}

/// The last row is at the instant that was asked for, whether the step divides the time or not.
#[test]
fn it_ends_when_it_was_asked_to() {
    let folder = Folder::new("forward-last");
    for (until, rows) in [("0.025", 4), ("0.03", 4), ("0.004", 2)] {
        let run = ["forward", "four-bar", "--until", until, "--step", "0.01", "-o", "."];
        folder.stiction(&run).succeeds();
        let times = column(&folder.read("forward.csv"), "time [s]");
        assert_eq!((times.len(), times.last()), (rows, until.parse().ok().as_ref()), "{times:?}");
    }
}

/// Drives that were recorded say nothing of later times.
#[test]
fn drives_do_not_outlast_their_record() {
    let folder = Folder::new("forward-record");
    folder.write("slope.toml", &slope(0.0));
    folder.write("push.csv", "time [s],slope [N]\n0,10\n1,30\n");
    let run = ["forward", "slope.toml", "--drives", "push.csv", "--from", "rest", "--until", "1.5"];
    folder.stiction(&run).fails(2, &["push.csv end at 1 s", "1.5 s", "--until 1"]);
}

/// One of two freedoms is told which.
#[test]
fn a_lock_of_one_of_two_freedoms_is_named() {
    let folder = Folder::new("forward-which");
    let run =
        ["forward", "gough", "--hold", "leg2.U.second", "--drives", "none", "--until", "0.001"];
    let said = folder.stiction(&[&run[..], &["-o", "."]].concat());
    let out = said.succeeds();
    assert!(out.contains("locked: leg2.U.second\n"), "{out}");
    assert!(folder.read("forward.csv").contains(",leg2.U.second.drive [N m],"));
}

/// With two legs locked as they are the platform cannot swing, and friction jams it while it moves: nothing is
/// solved at the start, so no row is written.
#[test]
fn what_has_no_solution_at_the_start_writes_no_row() {
    let folder = Folder::new("forward-jammed");
    let hold = ["forward", "gough", "--hold", "leg1.U,leg2.U.second", "--drives", "none"];
    let run = [&hold[..], &["--until", "0.02", "-o", "."]].concat();
    folder.stiction(&run).fails(1, &["at t = 0 s", "no acceleration", "leg2.S"]);
    assert!(!folder.files().iter().any(|name| name == "forward.csv"), "{:?}", folder.files());
}

#[test]
fn wrong_input_is_told_with_a_way_out() {
    let folder = Folder::new("forward-wrong");
    folder.write("times.csv", "time [s],leg1.P [N]\n0,1\n0,2\n");
    folder.write("names.csv", "time [s],leg1.R [N m]\n0,1\n");
    folder.write("units.csv", "time [s],leg1.P [mm]\n0,1\n");
    folder.write("control.toml", "type = \"pid\"\n");
    folder.write("nothing.toml", "# no effort\n");
    folder.write("late.csv", "time [s],leg1.P [N]\n0.5,1\n1,2\n");
    folder.write("file", "");
    let cases: &[(&[&str], &[&str])] = &[
        (&["forward", "--drives", "leg1.P = 3 mm"], &["expected a force", "a length"]),
        (&["forward", "--drives", "leg1.R = 3 N m"], &["joint `leg1.R` has no actuator", "leg1.P"]),
        (&["forward", "--drives", "leg1.P = 1; leg1.P = 2"], &["given twice"]),
        (&["forward", "--drives", "push"], &["`push` is not understood", "inverse"]),
        (&["forward", "--drives", "none.csv"], &["there is no such file"]),
        (&["forward", "--drives", "times.csv"], &["time does not increase"]),
        (&["forward", "--drives", "names.csv"], &["joint `leg1.R` has no actuator"]),
        (&["forward", "--drives", "units.csv"], &["N, kN"]),
        (&["forward", "--drives", "nothing.toml"], &["no actuator is given an effort", "leg1.P"]),
        (&["forward", "--drives", "late.csv"], &["late.csv begin at 0.5 s", "start at 0 s"]),
        (
            &["forward", "--drives", "leg1.P = 3 N", "--hold", "leg1.P"],
            &["--drives names `leg1.P`", "locked by --hold", "leave `leg1.P` out"],
        ),
        (
            &["forward", "--controller", "type = pd; leg1.P.limit = 3 N", "--prescribe", "leg1.P"],
            &["--controller names `leg1.P`", "moved as prescribed by --prescribe"],
        ),
        (
            &["forward", "--controller", "pd", "--hold", "leg1.P,leg2.P,leg3.P"],
            &["nothing to drive", "leave it out"],
        ),
        (&["forward", "-o", "file"], &["-o wants a folder, but file is a file"]),
        (&["forward", "-o", "file/deeper"], &["-o wants a folder, but file is a file"]),
        (
            &[
                "forward",
                "slider-crank",
                "--drives",
                "none",
                "--from",
                "A = 3 rad/s*t",
                "--hold",
                "guide",
            ],
            &["joint `guide`", "a dead centre", "start at rest or elsewhere"],
        ),
        (&["forward", "--controller", "pdd"], &["did you mean `pd`?"]),
        (
            &["forward", "--controller", "control.toml"],
            &["control.toml:1", "`pid` is not understood"],
        ),
        (&["forward", "--controller", "period = 1 ms"], &["no `type`"]),
        (&["forward", "--controller", "type = pd; period = 0 s"], &["greater than 0"]),
        (&["forward", "--controller", "type = pd; bandwidth = 60 rad/s"], &["a frequency", "2*pi"]),
        (&["forward", "--controller", "type = computed-torque; kp = 3 N/m"], &["`bandwidth`"]),
        (&["forward", "--controller", "type = pd; leg9.P.limit = 3 N"], &["no actuator `leg9.P`"]),
        (&["forward", "--controller", "type = pd; leg1.P.limt = 3 N"], &["did you mean `limit`?"]),
        (&["forward", "--hold", "leg1.Q"], &["no joint `leg1.Q`", "did you mean"]),
        (&["forward", "--hold", "leg1.S"], &["no coordinate that could be held"]),
        (
            &["forward", "--hold", "leg1.P", "--prescribe", "leg1.P"],
            &["locked and moved", "either --hold"],
        ),
        (&["forward", "--until", "inf"], &["--until is inf s", "a number of seconds"]),
        (&["forward", "--prescribe", "leg1.R"], &["has no actuator"]),
        (&["forward", "--until", "-1"], &["--until is -1 s"]),
        (&["forward", "--until", "nan"], &["--until"]),
        (&["forward", "--step", "0"], &["--step"]),
        (&["forward", "--tolerance", "1"], &["1e-10 is usual"]),
        (&["forward", "--from", "platform.q = 1"], &["platform.q"]),
        (&["forward", "--friction", "one-pass"], &["on", "off"]),
        (&["forward", "griffis-duffy"], &["as many as there are freedoms", "type = pd"]),
        (&["forward", "nothing"], &["no built-in model"]),
    ];
    for (arguments, texts) in cases {
        folder.stiction(arguments).fails(2, texts);
    }
}

/// Friction grows with the loads that it makes, until nothing satisfies the laws: what was computed before is
/// kept.
#[test]
fn what_was_computed_before_it_jams_is_kept() {
    let folder = Folder::new("forward-jam");
    // Event by event: some contacts hold, and the automatic method gets past them, to where all slide.
    let run = [
        "forward",
        "3upu",
        "--drives",
        "none",
        "--from",
        "rest",
        "--method",
        "event-driven",
        "-o",
        ".",
    ];
    let said = folder.stiction(&run);
    said.fails(
        1,
        &[
            "has no acceleration",
            "first in joint `leg",
            "what was computed up to t = 0.39 s is in .",
        ],
    );
    assert_eq!(column(&folder.read("forward.csv"), "time [s]").len(), 40);
    let summary = json(&folder.read("summary.json"));
    assert_eq!(summary["ended"], "failed");
    assert!(summary["ended_because"].as_str().unwrap().contains("no acceleration"));
    assert!(folder.files().iter().all(|name| !name.contains("partial")));
}

/// Begins a run in a folder and waits until some rows are written.
#[cfg(unix)]
fn begin(folder: &Folder, arguments: &[&str]) -> std::process::Child {
    let written = || {
        let sizes = std::fs::read_dir(&folder.0).unwrap().filter_map(|e| e.ok()?.metadata().ok());
        sizes.map(|m| m.len()).max().unwrap_or(0)
    };
    folder.begin(arguments, || written() >= 100_000)
}

#[cfg(unix)]
fn interrupt(child: &std::process::Child) {
    use std::process::Command;
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
}

/// Ctrl-C keeps complete files up to there, and the exit code says so.
#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_is_done() {
    let folder = Folder::new("forward-interrupt");
    let child = begin(&folder, &["forward", "--drives", "inverse", "--until", "1000", "-o", "."]);
    interrupt(&child);
    let output = child.wait_with_output().unwrap();
    let said = program::Said::from(output);
    said.fails(130, &["interrupted; what was computed up to t = ", "--resume goes on"]);
    let mut expected = FILES.to_vec();
    expected.extend(["checkpoint.json"]);
    expected.extend(["drives.svg", "energy.svg", "error.svg", "friction.svg", "motion.svg"]);
    expected.sort_unstable();
    assert_eq!(folder.files(), expected);
    let rows = |name: &str| folder.read(name).lines().count();
    assert!(rows("forward.csv") > 10);
    for name in ["bodies.csv", "energy.csv", "friction.csv", "motion.csv", "reactions.csv"] {
        assert_eq!(rows(name), rows("forward.csv"), "{name}");
    }
    assert_eq!(json(&folder.read("summary.json"))["ended"], "interrupted");
}

/// Whatever stops a run, it goes on where it was: with nothing but efforts digit by digit, with controllers,
/// whose own model is assembled anew, to rounding.
#[cfg(unix)]
#[test]
fn an_interrupted_run_goes_on_as_if_it_had_not_been() {
    let cases: [(&[&str], f64); 2] = [
        (&["four-bar", "--drives", "A = 2 N m*sin(9*t)", "--from", "rest", "--step", "0.002"], 0.0),
        // Effort over stiffness, 1e-13 of 100 N over 1e4 N/m, and what the integrator makes of it.
        (&["--controller", "pd", "--drives", "inverse", "--step", "0.002"], 1e-9),
    ];
    for (index, (case, tolerance)) in cases.into_iter().enumerate() {
        let until = ["--until", if index == 0 { "2" } else { "0.4" }, "-o", "."];
        let folder = |name: &str| Folder::new(&format!("forward-resume-{index}-{name}"));
        let all = |more: &[&'static str]| [&["forward"][..], case, &until, more].concat();
        let whole = folder("whole");
        whole.stiction(&all(&[])).succeeds();
        for way in ["interrupted", "killed"] {
            let parted = folder(way);
            let mut child = begin(&parted, &all(&["--checkpoint", "0"]));
            if way == "killed" {
                child.kill().unwrap();
            } else {
                interrupt(&child);
            }
            child.wait().unwrap();
            let said = parted.stiction(&all(&["--resume"]));
            said.succeeds();
            assert_eq!(parted.files(), whole.files(), "{way}");
            for name in FILES.iter().filter(|name| name.ends_with(".csv")) {
                let (a, b) = (whole.read(name), parted.read(name));
                assert_eq!(a.lines().count(), b.lines().count(), "{way} {name}");
                if tolerance == 0.0 {
                    assert!(a == b, "{way} {name}");
                } else if *name == "forward.csv" {
                    for column_name in a.lines().next().unwrap().split(',') {
                        if !column_name.contains(".position") && !column_name.contains(".wanted") {
                            continue;
                        }
                        let (a, b) = (column(&a, column_name), column(&b, column_name));
                        let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                        assert!(apart < tolerance, "{way} {column_name}: {apart:e}");
                    }
                }
            }
            let part =
                |folder: &Folder, name: &str| json(&folder.read("summary.json"))[name].clone();
            assert_eq!(part(&parted, "events"), part(&whole, "events"), "{way}");
        }
    }
}

#[test]
fn what_cannot_go_on_is_told() {
    let folder = Folder::new("forward-resume-wrong");
    folder.stiction(&["forward", "--resume"]).fails(2, &["--output"]);
    folder.stiction(&["forward", "--resume", "-o", "."]).fails(2, &["no checkpoint.json"]);
    folder.write("checkpoint.json", "{");
    let resume = ["forward", "--resume", "-o", "."];
    folder.stiction(&resume).fails(2, &["is damaged: it is no JSON any more (line 1)"]);
    folder.write("checkpoint.json", "{}");
    folder.stiction(&resume).fails(2, &["is damaged: it does not say of which simulation it is"]);
    folder.write("checkpoint.json", "{\"fingerprint\": \"12\"}");
    folder.stiction(&["forward", "--resume", "-o", "."]).fails(2, &["of another simulation"]);
    folder
        .stiction(&["forward", "--checkpoint", "-1", "-o", "."])
        .fails(2, &["--checkpoint is -1 s"]);
}
