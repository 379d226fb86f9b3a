//! Infeasible simulations end with a message and a suggestion.

use crate::program::{Folder, column, json};

#[test]
fn wrong_input_is_reported_with_a_suggestion() {
    let folder = Folder::new("forward-wrong");
    folder.write("times.csv", "time [s],leg1.P [N]\n0,1\n0,2\n");
    folder.write("names.csv", "time [s],leg1.R [N m]\n0,1\n");
    folder.write("units.csv", "time [s],leg1.P [mm]\n0,1\n");
    folder.write("control.toml", "type = \"pit\"\n");
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
        (&["forward", "--drives", "nothing.toml"], &["no actuator has an effort", "leg1.P"]),
        (
            &["forward", "--drives", "late.csv"],
            &["late.csv begin at 0.5 s", "start of the simulation at 0 s"],
        ),
        (
            &["forward", "--drives", "leg1.P = 3 N", "--hold", "leg1.P"],
            &["given for `leg1.P`, which is locked", "leave `leg1.P` out", "--drives"],
        ),
        (
            &["forward", "--controller", "type = pd; leg1.P.limit = 3 N", "--prescribe", "leg1.P"],
            &["the controller names `leg1.P`", "has a prescribed motion"],
        ),
        (
            &["forward", "--controller", "pd", "--hold", "leg1.P,leg2.P,leg3.P"],
            &["has no actuator", "leave the controller out"],
        ),
        (&["forward", "--stop", "leg1.P"], &["compares two quantities with `<` or `>`"]),
        (&["forward", "--stop", "leg1.P < 3 N"], &["a length is compared with", "this is"]),
        (&["forward", "--stop", "leg1.Q < 3 mm"], &["there is no body or joint `leg1.Q`"]),
        (&["forward", "--stop", "1 mm < 3 mm"], &["this condition does not depend on the motion"]),
        (&["forward", "--drives", "leg1.P = -3*leg1.P"], &["expected a force", "a length"]),
        (&["forward", "--drives", "leg1.P = 3 N*sign(t)"], &["`sign` can be used only in"]),
        (
            &[
                "forward",
                "--controller",
                "type = pid; ki = 3 kN/(m s); period = 0; resolution = 1 um",
            ],
            &["need a sampling period"],
        ),
        (&["forward", "--controller", "type = computed-torque; period = 0"], &["needs a sampling"]),
        (&["forward", "--controller", "type = pd; ki = 3 kN/(m s)"], &["has no integral gain"]),
        (&["forward", "-o", "file"], &["-o needs a folder, but file is a file"]),
        (&["forward", "-o", "file/deeper"], &["-o needs a folder, but file is a file"]),
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
            &["joint `guide`", "a dead centre", "start at rest or at another position"],
        ),
        (&["forward", "--controller", "pdd"], &["did you mean `pd`?"]),
        (
            &["forward", "--controller", "control.toml"],
            &["control.toml:1", "`pit` is not understood"],
        ),
        (&["forward", "--controller", "period = 1 ms"], &["no `type`"]),
        (&["forward", "--controller", "type = pd; period = -1 ms"], &["must not be negative"]),
        (&["forward", "--controller", "type = pd; bandwidth = 60 rad/s"], &["a frequency", "2*pi"]),
        (&["forward", "--controller", "type = computed-torque; kp = 3 N/m"], &["`bandwidth`"]),
        (&["forward", "--controller", "type = pd; leg9.P.limit = 3 N"], &["no actuator `leg9.P`"]),
        (&["forward", "--controller", "type = pd; leg1.P.limt = 3 N"], &["did you mean `limit`?"]),
        (&["forward", "--hold", "leg1.Q"], &["no joint `leg1.Q`", "did you mean"]),
        (&["forward", "--hold", "leg1.S"], &["no scalar coordinate to lock"]),
        (
            &["forward", "--hold", "leg1.P", "--prescribe", "leg1.P"],
            &["locked and have a prescribed motion", "either lock it"],
        ),
        (
            &["forward", "--until", "inf"],
            &["would end at inf s", "a finite number of seconds", "--until"],
        ),
        (&["forward", "--prescribe", "leg1.R"], &["has no actuator"]),
        (&["forward", "--until", "-1"], &["would end at -1 s", "--until"]),
        (&["forward", "--until", "nan"], &["--until"]),
        (&["forward", "--step", "0"], &["--step"]),
        (&["forward", "--tolerance", "1"], &["for example 1e-10"]),
        (&["forward", "--from", "platform.q = 1"], &["platform.q"]),
        (&["forward", "--friction", "one-pass"], &["on", "off"]),
        (&["forward", "griffis-duffy"], &["one for each degree of freedom", "type = pd"]),
        (&["forward", "nothing"], &["no built-in model"]),
    ];
    for (arguments, texts) in cases {
        folder.stiction(arguments).fails(2, texts);
    }
}

/// With two legs locked, the platform cannot tilt, and friction jams it while it moves: no
/// accelerations exist at the start, so the event-driven method writes no row.
#[test]
fn a_start_without_solution_writes_no_row() {
    let folder = Folder::new("forward-jammed");
    let hold = ["forward", "gough", "--hold", "leg1.U,leg2.U.second", "--drives", "none"];
    let load = "platform.fz = -588.6 N; platform.at = [80 mm, 0 mm, 300 mm]";
    let method = ["--method", "event-driven", "-o", "."];
    let run = [&hold[..], &["--load", load, "--until", "0.02"], &method[..]].concat();
    folder.stiction(&run).fails(1, &["at t = 0 s", "no acceleration", "leg2.S"]);
    assert!(!folder.files().iter().any(|name| name == "forward.csv"), "{:?}", folder.files());
}

/// Locks that leave nothing to move permit a standstill, although the round-off of the rates that the
/// locks remove satisfies no constraint. A controller cannot accelerate an actuator that locks stop.
#[test]
fn locks_that_stop_everything_permit_a_standstill() {
    let folder = Folder::new("forward-locked");
    for hold in ["A,B", "B,C", "A,B,D"] {
        let run = ["forward", "four-bar", "--hold", hold, "--drives", "none", "--until", "0.1"];
        let said = folder.stiction(&[&run[..], &["--report", "off", "-o", "."]].concat());
        let said = said.succeeds();
        assert!(said.contains("initial rates differ from the requested ones"), "{said}");
        let rates = column(&folder.read("forward.csv"), "C.rate [rad/s]");
        assert!(rates.iter().all(|rate| *rate == 0.0), "{hold}: {rates:?}");
    }
    let run = ["forward", "four-bar", "--hold", "B"];
    let texts = ["with `B` locked, the actuators cannot move", "--drives none", "--hold"];
    folder.stiction(&run).fails(1, &texts);
    folder.stiction(&[&run[..], &["--controller", "pd"]].concat()).fails(2, &texts);
}

/// A part without mass that can move has no acceleration, also if it turns and nothing loads it. A
/// rotor, a lock or static friction suffices.
#[test]
fn a_part_without_mass_that_can_turn_is_refused() {
    let folder = Folder::new("forward-massless");
    let pendulum = "gravity = [0, -9.81, 0]\n[bodies.bob]\ncom = [0, -0.4, 0]\n[joints.pivot]\n\
                    type = \"R\"\nfrom = \"ground\"\nto = \"bob\"\naxis = \"z\"\n";
    let motor = "[actuators.motor]\njoint = \"pivot\"\nratio = 50\nrotor_inertia = 1e-4\n";
    folder.write("pendulum.toml", pendulum);
    folder.write("ball.toml", &pendulum.replace("\"R\"", "\"S\"").replace("axis = \"z\"", ""));
    folder.write("motor.toml", &[pendulum, motor].concat());
    let run = |model: &str, more: &[&str]| {
        let run = ["forward", model, "--drives", "none", "--until", "0.1", "--report", "off"];
        folder.stiction(&[&run[..], more].concat())
    };
    let texts =
        ["at t = 0 s body `bob` can move without any inertia", "mass and moments of inertia"];
    run("pendulum.toml", &[]).fails(1, &texts);
    run("ball.toml", &[]).fails(1, &texts);
    run("pendulum.toml", &["--hold", "pivot"]).succeeds();
    run("motor.toml", &[]).succeeds();
}

/// Friction grows with the normal loads that it causes, until no acceleration satisfies the
/// friction laws. Rows before that instant are kept.
#[test]
fn results_before_a_jam_are_kept() {
    let folder = Folder::new("forward-jam");
    // With the event-driven method, some interfaces stick; the automatic method continues until all
    // of them slide.
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
            "no acceleration was found",
            "first in joint `leg",
            "the results up to t = 0.43 s are in .",
        ],
    );
    assert_eq!(column(&folder.read("forward.csv"), "time [s]").len(), 44);
    let summary = json(&folder.read("summary.json"));
    assert_eq!(summary["ended"], "failed");
    assert!(summary["ended_because"].as_str().unwrap().contains("no acceleration"));
    assert!(folder.files().iter().all(|name| !name.contains("partial")));
}
