//! Inputs of a run: initial state, efforts, prescribed and locked joints.

use crate::program::models::slope;
use crate::program::{Folder, column, json};

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
    // The position of one leg is given; the other two legs have their start values.
    let run =
        ["forward", "--from", "leg1.P = 590 mm", "--drives", "none", "--until", "0.01", "-o", "."];
    folder.stiction(&run).succeeds();
    let table = folder.read("forward.csv");
    assert!((column(&table, "leg1.P.position [m]")[0] - 0.59).abs() < 1e-12);
    assert_eq!(column(&table, "leg2.P.rate [m/s]")[0], 0.0);
}

/// Checks positions and rates that are given separately, of one coordinate or of two. Full turns
/// are kept and have no other effect.
#[test]
fn rates_may_be_given_apart() {
    let folder = Folder::new("forward-rates");
    let begin = |from: &str| {
        let run = ["forward", "four-bar", "--from", from, "--until", "0.01", "-o", "."];
        folder.stiction(&run).succeeds();
        let table = folder.read("forward.csv");
        ["A.position [rad]", "A.rate [rad/s]", "B.position [rad]", "B.rate [rad/s]"]
            .map(|name| column(&table, name)[0])
    };
    let whole = begin("A = -60 deg + 2 rad/s*t");
    let same = [
        "A = -60 deg; d(A) = 2 rad/s".to_owned(),
        // Position of one coordinate, and rate of another.
        format!("A = -60 deg; d(B) = {} rad/s", whole[3]),
        format!("d(B) = {} rad/s; A = -60 deg + 5 rad/s*t; d(A) = 2 rad/s", whole[3]),
    ];
    for from in same {
        for (one, other) in begin(&from).iter().zip(whole) {
            assert!((one - other).abs() < 1e-9, "{from}: {one} {other}");
        }
    }
    let turned = begin("A = 300 deg; d(A) = 2 rad/s");
    assert!((turned[0] - 300_f64.to_radians()).abs() < 1e-12, "{turned:?}");
    for (one, other) in turned[1..].iter().zip(&whole[1..]) {
        assert!((one - other).abs() < 1e-9, "{turned:?} {whole:?}");
    }
}

/// The efforts in the table of one run can be the input of the next run.
#[test]
fn drives_can_come_from_a_file() {
    let folder = Folder::new("forward-drives");
    folder.write("slope.toml", &slope(0.0));
    folder.write("push.csv", "time [s],slope [kN]\n0,0.01\n1,0.03\n");
    let run = ["forward", "slope.toml", "--drives", "push.csv", "--from", "rest", "-o", "."];
    folder.stiction(&run).succeeds();
    let table = folder.read("forward.csv");
    // The effort rises from 10 N, which just holds the block, to 30 N within one second: x''' =
    // 20/2 m/s^3.
    for (t, s) in column(&table, "time [s]").iter().zip(column(&table, "slope.position [m]")) {
        assert!((s - 10.0 * t.powi(3) / 6.0).abs() < 1e-10, "{t}: {s}");
    }
    folder.write("again.csv", &table);
    folder
        .stiction(&["forward", "slope.toml", "--drives", "again.csv", "--from", "rest"])
        .succeeds();
}

/// Recorded efforts are undefined after their last sample.
#[test]
fn recorded_efforts_end_with_their_recording() {
    let folder = Folder::new("forward-record");
    folder.write("slope.toml", &slope(0.0));
    folder.write("push.csv", "time [s],slope [N]\n0,10\n1,30\n");
    let run = ["forward", "slope.toml", "--drives", "push.csv", "--from", "rest", "--until", "1.5"];
    folder.stiction(&run).fails(2, &["push.csv end at 1 s", "1.5 s", "end the simulation at 1 s"]);
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
    let (position, wanted) = (get("leg2.P.position [m]"), get("leg2.P.reference [m]"));
    assert!(position.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12));
    assert!(get("leg3.P.drive [N]").iter().all(|drive| *drive == 20.0));
    // A joint without an actuator is locked, so the lock exerts an effort.
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

/// One of the two degrees of freedom of a joint can be locked by its name.
#[test]
fn a_lock_of_one_of_two_dofs_is_named() {
    let folder = Folder::new("forward-which");
    let run =
        ["forward", "gough", "--hold", "leg2.U.second", "--drives", "none", "--until", "0.001"];
    let said = folder.stiction(&[&run[..], &["-o", "."]].concat());
    let out = said.succeeds();
    assert!(out.contains("locked: leg2.U.second\n"), "{out}");
    assert!(folder.read("forward.csv").contains(",leg2.U.second.drive [N m],"));
}

/// A motion that begins beyond half a turn keeps its full turns. A joint that is named twice is
/// locked once.
#[test]
fn angles_continue_with_their_turns() {
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
    let wanted = column(&table, "A.reference [rad]");
    assert!((places[0] - 7.0).abs() < 1e-12);
    // The values differ only by the closure error of the loop.
    assert!(places.iter().zip(&wanted).all(|(place, wanted)| (place - wanted).abs() < 1e-12));
    folder
        .stiction(&["forward", "four-bar", "--hold", "A,A", "--until", "0.01", "--drives", "none"])
        .succeeds();
}

/// A cart with prescribed motion carries a pendulum, whose motion is free. At an angle of atan(a/g)
/// backwards, the pendulum is at rest relative to the cart, and the effort of the cart accelerates
/// the total mass.
#[test]
fn unprescribed_coordinates_are_free() {
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
    let (at, wanted) = (column(&table, "rail.position [m]"), column(&table, "rail.reference [m]"));
    assert!(at.iter().zip(wanted).all(|(at, wanted)| (at - wanted).abs() < 1e-12));
    // The pivot has no reference position.
    assert!(!table.contains("pivot.reference"));
    // A controller with given gains needs no further input.
    let alone = model.replace("axis = \"z\"\n        actuated = true", "axis = \"z\"");
    assert!(alone.len() < model.len());
    folder.write("alone.toml", &alone);
    let gains = ["forward", "alone.toml", "--controller", "type = pd; kp = 1e4; kd = 400"];
    folder.stiction(&gains).succeeds();
    folder
        .stiction(&["forward", "alone.toml"])
        .fails(2, &["leave one degree of freedom undetermined"]);
    // A motion without a controller needs no further input either.
    folder.stiction(&["forward", "cart.toml", "--drives", "none", "--until", "0.1"]).succeeds();
}

/// The actuators of `4ups-upu` are coupled so strongly that gains of 10 Hz are unstable with a
/// sampling period of 1 ms: the robot is torn apart within 20 ms. Default gains are lowered, and
/// given ones are named as the cause.
#[test]
fn default_gains_of_coupled_actuators_are_stable() {
    let folder = Folder::new("forward-coupled-gains");
    let run = |controller: &str| {
        let until = ["--until", "0.1", "--json", "--report", "off"];
        let all = [&["forward", "4ups-upu", "--controller", controller][..], &until].concat();
        json(folder.stiction(&all).succeeds())
    };
    let summary = run("pd");
    let verdict = &summary["verdicts"]["controller"];
    assert!(verdict["growth_per_period"].as_f64().is_some_and(|growth| growth < 1.0));
    assert!(verdict["lowered_bandwidth"].as_f64().is_some_and(|hertz| hertz < 8.0));
    assert_eq!(summary["cautions"].as_array().unwrap().len(), 0);
    for (_, drive) in summary["drives"].as_object().unwrap() {
        assert!(drive["drive"]["peak"].as_f64().unwrap().abs() < 1e4);
        assert!(drive["error"]["peak"].as_f64().unwrap().abs() < 0.05);
    }
    let summary = run("type = pd; bandwidth = 10 Hz");
    let growth = &summary["verdicts"]["controller"]["growth_per_period"];
    assert!(growth.as_f64().is_some_and(|growth| growth > 2.0), "{growth}");
    let caution = summary["cautions"][0].as_str().unwrap();
    assert!(caution.contains("the controller is unstable at the start"), "{caution}");
    // A shorter period permits the bandwidth.
    let summary = run("type = pd; period = 0.1 ms");
    assert!(summary["verdicts"]["controller"]["lowered_bandwidth"].is_null());
}
