//! The command `stiction inverse`.

use crate::program::{Folder, column, json};
use serde_json::Value;

const TABLES: [&str; 6] =
    ["bodies.csv", "friction.csv", "inverse.csv", "joints.csv", "reactions.csv", "summary.json"];

#[test]
fn without_arguments_the_built_in_robot_runs() {
    let said = Folder::new("default").stiction::<&str>(&[]);
    let out = said.succeeds();
    assert!(out.starts_with("zhang2018-regular:"), "{out}");
    assert!(said.err.contains("nonsingular variant of a published"), "{}", said.err);
    for word in
        ["leg1.P", "relative power residual", "all reactions and actuator efforts are unique"]
    {
        assert!(out.contains(word), "{out}");
    }
}

#[test]
fn the_summary_reads_well() {
    let folder = Folder::new("summary");
    for model in ["zhang2018-regular", "slider-crank"] {
        let said = folder.stiction(&["inverse", model]);
        // Rounding errors differ between machines.
        let stable: Vec<&str> =
            said.succeeds().lines().filter(|line| !line.starts_with("loop closure")).collect();
        insta::assert_snapshot!(model, stable.join("\n"));
    }
}

#[test]
fn the_files_are_complete() {
    let folder = Folder::new("files");
    folder.stiction(&["inverse", "-o", "new/deep"]).succeeds();
    let inner = Folder(folder.0.join("new/deep"));
    let mut expected: Vec<&str> = TABLES.to_vec();
    expected.extend([
        "drives.svg",
        "friction.svg",
        "path.svg",
        "power.svg",
        "report.html",
        "singularity.svg",
        "contributions.csv",
        "contributions.svg",
    ]);
    expected.sort_unstable();
    assert_eq!(inner.files(), expected);

    let inverse = inner.read("inverse.csv");
    let times = column(&inverse, "time [s]");
    assert_eq!((times.len(), times[0], times[100]), (101, 0.0, 1.0));
    let (drive, low, high) = (
        column(&inverse, "leg1.P.drive [N]"),
        column(&inverse, "leg1.P.drive_low [N]"),
        column(&inverse, "leg1.P.drive_high [N]"),
    );
    assert!(drive.iter().zip(low.iter().zip(&high)).all(|(d, (l, h))| l <= d && d <= h));
    assert!(column(&inverse, "closure [m]").iter().all(|x| *x <= 1e-12));
    for name in ["power.residual [W]", "distance.actuation [-]", "distance.constraint [-]"] {
        assert_eq!(column(&inverse, name).len(), 101);
    }
    let reactions = inner.read("reactions.csv");
    assert!(column(&reactions, "leg2.S.determined").iter().all(|flag| *flag == 1.0));
    let friction = inner.read("friction.csv");
    let along = column(&friction, "leg1.P.power [W]");
    assert!(along.iter().all(|power| *power >= 0.0));

    let shares = inner.read("contributions.csv");
    assert_eq!(column(&shares, "leg1.P.from.leg2.S [N]").len(), 101);
    assert_eq!(shares.lines().next().unwrap().split(',').count(), 1 + 3 * 9);

    let summary = json(&inner.read("summary.json"));
    assert_eq!(summary["model"]["name"], "zhang2018-regular");
    assert!(summary.to_string().contains("version"));
}

#[test]
fn an_expression_can_be_the_motion_and_the_load() {
    let folder = Folder::new("expressions");
    let motion = "platform.x = 60 mm; platform.z = 530 mm + 5 mm*sin(2*pi*t); \
                  platform.ry = 20 deg; duration = 0.5 s; step = 50 ms";
    let load = "platform.fz = -50 N";
    folder
        .stiction(&["inverse", "zhang2018-regular", "--motion", motion, "--load", load, "-o", "."])
        .succeeds();
    let loaded = folder.read("inverse.csv");
    assert_eq!(column(&loaded, "time [s]").len(), 11);
    folder
        .stiction(&["inverse", "zhang2018-regular", "--motion", motion, "--load", "L0", "-o", "."])
        .succeeds();
    let free = folder.read("inverse.csv");
    assert_ne!(column(&loaded, "leg1.P.drive [N]"), column(&free, "leg1.P.drive [N]"));
}

#[test]
fn a_recording_can_be_the_motion() {
    let folder = Folder::new("recording");
    let mut rows = String::from("time [s],A [deg]\n");
    for k in 0..=50 {
        let t = f64::from(k) / 50.0;
        rows += &format!("{t},{}\n", 60.0 + 360.0 * t);
    }
    folder.write("turn.csv", &rows);
    let said = folder.stiction(&["inverse", "four-bar", "--motion", "turn.csv", "-o", "."]);
    said.succeeds();
    let recorded = column(&folder.read("inverse.csv"), "A.drive [N m]");
    folder.stiction(&["inverse", "four-bar", "--step", "0.02", "-o", "."]).succeeds();
    let exact = column(&folder.read("inverse.csv"), "A.drive [N m]");
    assert_eq!(recorded.len(), exact.len());
    for (recorded, exact) in recorded.iter().zip(exact) {
        // A spline through collinear samples is a straight line.
        assert!((recorded - exact).abs() < 1e-6, "{recorded} {exact}");
    }
}

/// An encoder that counts within one turn would otherwise imply a very fast motion.
#[test]
fn wrapped_recordings_are_reported() {
    let folder = Folder::new("wrapped");
    let mut rows = String::from("time [s],A [deg]\n");
    for k in 0..=100 {
        let angle = (60.0 + 3.6 * f64::from(k)) % 360.0;
        rows += &format!("{},{angle}\n", 0.01 * f64::from(k));
    }
    folder.write("turn.csv", &rows);
    let said = folder.stiction(&["inverse", "four-bar", "--motion", "turn.csv"]);
    said.fails(
        2,
        &[
            "turn.csv:",
            "changes by -356 deg",
            "more than half a turn",
            "let angles continue beyond a full turn",
        ],
    );
}

#[test]
fn friction_has_three_modes() {
    let folder = Folder::new("modes");
    let mut drives = Vec::new();
    for mode in ["on", "one-pass", "off"] {
        folder.stiction(&["inverse", "--friction", mode, "-o", "."]).succeeds();
        drives.push(column(&folder.read("inverse.csv"), "leg1.P.drive [N]")[25]);
    }
    // The error of decoupled friction, as in the paper, is nonzero and smaller than friction
    // itself.
    assert!(drives[0] != drives[1] && drives[1] != drives[2]);
    let (missed, friction) = ((drives[0] - drives[1]).abs(), (drives[0] - drives[2]).abs());
    assert!(missed < 0.5 * friction, "{drives:?}");
}

#[test]
fn the_printed_robot_has_no_answer_and_leaves_no_file() {
    let folder = Folder::new("printed");
    let said = folder.stiction(&["inverse", "zhang2018", "-o", "results"]);
    said.fails(
        1,
        &["no finite actuator effort", "platform", "rotation about y", "53.8929 to 55.6108 N m"],
    );
    assert!(folder.files().is_empty());

    let said = folder.stiction(&["inverse", "zhang2018", "--json"]);
    assert_eq!((said.code, said.err.as_str()), (1, ""));
    let error = &json(&said.out)["error"];
    assert_eq!((&error["kind"], &error["details"]["unit"]), (&"no-answer".into(), &Value::Null));
    assert_eq!(error["details"]["missing"]["unit"], "N m");
    assert!((error["details"]["missing"]["least"].as_f64().unwrap() - 53.9).abs() < 0.05);
}

#[test]
fn programs_get_one_json_text() {
    let folder = Folder::new("json");
    let said = folder.stiction(&["inverse", "five-bar", "--json"]);
    let summary = json(said.succeeds());
    assert_eq!(summary["model"]["name"], "five-bar");
    assert_eq!(said.err, "");
    let said = folder.stiction(&["inverse", "nothing.toml", "--json"]);
    assert_eq!(said.code, 2);
    assert_eq!(json(&said.out)["error"]["kind"], "input");
}

#[test]
fn old_files_stay_until_all_new_ones_are_complete() {
    let folder = Folder::new("kept");
    folder.write("inverse.csv", "mine");
    folder.write("notes.txt", "mine too");
    folder.stiction(&["inverse", "zhang2018", "-o", "."]).fails(1, &[]);
    assert_eq!(folder.files(), ["inverse.csv", "notes.txt"]);
    assert_eq!(folder.read("inverse.csv"), "mine");
    folder.stiction(&["inverse", "four-bar", "-o", "."]).succeeds();
    assert!(folder.read("inverse.csv").starts_with("time [s],"));
    assert_eq!(folder.read("notes.txt"), "mine too");
    assert!(folder.files().iter().all(|name| !name.contains("partial")));
    // Files of an earlier run that the last run did not write are removed.
    assert!(folder.files().contains(&"friction.svg".to_owned()));
    folder.stiction(&["inverse", "four-bar", "--friction", "off", "-o", "."]).succeeds();
    for stale in ["friction.svg", "contributions.csv", "contributions.svg"] {
        assert!(!folder.files().contains(&stale.to_owned()), "{stale}");
    }
    assert_eq!(folder.read("notes.txt"), "mine too");
}

#[test]
fn wrong_input_is_reported_with_a_suggestion() {
    let folder = Folder::new("wrong");
    folder.write("broken.toml", "gravity = [0, 0\n");
    folder.write("out", "a file");
    folder.write("bytes.toml", "x");
    std::fs::write(folder.0.join("bytes.toml"), [0xff, 0xfe, 0x00]).unwrap();
    let cases: &[(&[&str], &[&str])] = &[
        (&["inverse", "zhang"], &["there is no built-in model and no file named `zhang`"]),
        (&["inverse", "four-bra"], &["did you mean `four-bar`?"]),
        (&["inverse", "none.toml"], &["cannot read the model none.toml: there is no such file"]),
        (&["inverse", "."], &["."]),
        (&["inverse", "broken.toml"], &["broken.toml:1"]),
        (&["inverse", "bytes.toml"], &["it is UTF-16 text; save it as UTF-8"]),
        (&["inverse", "--motion", "regluar"], &["regluar", "regular"]),
        (&["inverse", "--motion", "platform.q = 3 mm"], &["platform.q"]),
        (&["inverse", "--motion", "platform.x = 3 kg"], &["kg"]),
        (&["inverse", "--load", "L9"], &["L9"]),
        (&["inverse", "--step", "0"], &["--step"]),
        (&["inverse", "--step", "-1"], &["step"]),
        (&["inverse", "--step", "nan"], &["step"]),
        (&["inverse", "--step", "1e-15"], &["--step"]),
        (&["inverse", "--friction", "yes"], &["one-pass"]),
        (&["inverse", "-o", "out"], &["-o needs a folder, but out is a file"]),
        (&["invert"], &["did you mean `stiction inverse`?"]),
        (&["invers", "lift.toml"], &["no command `invers`", "did you mean `stiction inverse`?"]),
        (&["models", "gouhg"], &["did you mean `gough`?"]),
    ];
    for (arguments, texts) in cases {
        folder.stiction(arguments).fails(2, texts);
    }
}

#[test]
fn incomplete_or_unreachable_motions_are_reported() {
    let folder = Folder::new("reach");
    let said =
        folder.stiction(&["inverse", "five-bar", "--motion", "tool.x = 0 mm; duration = 1 s"]);
    said.fails(
        2,
        &[
            "leave one degree of freedom undetermined",
            "prescribe one coordinate more",
            "`start` values",
        ],
    );
    let motion = "tool.x = 0 mm; tool.y = 400 mm + 200 mm*t; duration = 1 s";
    let said = folder.stiction(&["inverse", "five-bar", "--motion", motion]);
    said.fails(1, &["at t = ", "out of reach"]);
}

#[test]
fn a_check_gives_verdicts() {
    let folder = Folder::new("check");
    let printed = json(folder.stiction(&["check", "zhang2018", "--json"]).succeeds());
    let mobility = &printed["mobility"];
    assert_eq!(mobility["gruebler"], 3);
    assert_eq!(mobility["instantaneous"], 4);
    assert_eq!(mobility["finite"], 3);
    assert_eq!(printed["redundant_constraints"], 1);
    assert_eq!(printed["singularities"]["actuation"]["singular_samples"], 101);
    // The self-stress state: forces along y at the ball joints in the ratio -2 : 1 : 1.
    let stress = printed["self_stresses"][0].as_array().unwrap();
    let along_y = |name: &str| {
        let joint = stress.iter().find(|entry| entry["joint"] == name).unwrap();
        joint["force"][1].as_f64().unwrap()
    };
    let first = along_y("leg1.S");
    for other in ["leg2.S", "leg3.S"] {
        assert!((along_y(other) / first + 0.5).abs() < 1e-9);
    }
    let regular = json(folder.stiction(&["check", "--json"]).succeeds());
    assert_eq!(regular["undetermined_reactions"].as_array().unwrap().len(), 0);
    assert_eq!(regular["drives_unique"], true);
    folder.stiction(&["check", "nothing"]).fails(2, &["no built-in model"]);
}

#[test]
fn models_are_listed_and_printed() {
    let folder = Folder::new("models");
    let said = folder.stiction(&["models"]);
    let out = said.succeeds();
    let names = [
        "3rps",
        "3rrr",
        "3upu",
        "4ups-upu",
        "andrews",
        "delta",
        "five-bar",
        "four-bar",
        "gough",
        "griffis-duffy",
        "slider-crank",
        "spherical-3rrr",
        "zhang2018",
    ];
    for name in names {
        assert!(out.contains(name), "{out}");
        let said = folder.stiction(&["models", name]);
        folder.write("copy.toml", said.succeeds());
        // The printed text is a valid model file.
        let code = i32::from(["griffis-duffy", "zhang2018"].contains(&name));
        assert_eq!(folder.stiction(&["inverse", "copy.toml"]).code, code, "{name}");
    }
    let list = json(folder.stiction(&["models", "--json"]).succeeds());
    assert!(list.to_string().contains("slider-crank"));
    json(folder.stiction(&["schema"]).succeeds());
}

/// Large recording that consists mostly of comment lines.
fn long_recording(rows: usize) -> String {
    let comment = "# ".to_owned() + &"-".repeat(1000);
    let mut text = String::from("time [s],A [deg]\n");
    for k in 0..rows {
        let t = k as f64 * 0.01;
        text += &format!("{t},{}\n{comment}\n", 60.0 + 0.125 * t);
    }
    text
}

/// A pipe cannot be read a second time, as a long recording requires.
#[cfg(unix)]
#[test]
fn a_long_recording_is_the_same_in_pieces() {
    let folder = Folder::new("long-recording");
    let text = long_recording(9000);
    assert!(text.len() > 8 << 20, "it is read as a whole");
    folder.write("turn.csv", &text);
    let arguments =
        |motion| ["inverse", "four-bar", "--motion", motion, "--step", "0.1", "-o", "."];
    folder.stiction(&arguments("turn.csv")).succeeds();
    let pieces = folder.read("inverse.csv");
    assert_eq!(pieces.lines().count(), 1 + 900);
    folder.stiction_given(&arguments("/dev/stdin"), &text).succeeds();
    assert!(folder.read("inverse.csv") == pieces, "tables differ");
}

/// Times on the command line accept units, and a wrong unit is reported.
#[test]
fn times_take_units() {
    let folder = Folder::new("inverse-units");
    let samples = |step: &str| {
        let said = folder.stiction(&["inverse", "four-bar", "--step", step, "--json"]);
        said.succeeds();
        json(&said.out)["samples"].clone()
    };
    assert_eq!(samples("50 ms"), samples("0.05"));
    folder
        .stiction(&["inverse", "four-bar", "--step", "3 mm"])
        .fails(2, &["'3 mm'", "--step", "expected a time, found a length"]);
}

/// A model file can have any name that the operating system allows.
#[cfg(unix)]
#[test]
fn names_of_files_need_not_be_utf_8() {
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::new("inverse-bytes");
    let text = stiction_format::gallery::get("four-bar").unwrap();
    let name = std::ffi::OsStr::from_bytes(b"four-b\xe4r.toml");
    // Some file systems accept only UTF-8.
    if std::fs::write(folder.0.join(name), text).is_ok() {
        assert!(folder.command(&["inverse"]).arg(name).output().unwrap().status.success());
    }
}

#[test]
fn a_defect_at_the_end_of_a_long_recording_has_its_place() {
    let folder = Folder::new("long-defect");
    folder.write("turn.csv", &(long_recording(9000) + "0.5,3\n"));
    let said = folder.stiction(&["inverse", "four-bar", "--motion", "turn.csv"]);
    said.fails(2, &["turn.csv:18002:1", "time does not increase", "not later than the row above"]);
    let mut bytes = long_recording(9000).into_bytes();
    bytes.extend_from_slice(b"2,\xe9\n");
    std::fs::write(folder.0.join("turn.csv"), bytes).unwrap();
    let said = folder.stiction(&["inverse", "four-bar", "--motion", "turn.csv"]);
    said.fails(2, &["motion:1:1", "the file cannot be read: it is not UTF-8 text: in line 18002"]);
}

/// The spin of a rod between balls matters only if its centre of mass is off the axis.
#[test]
fn a_rod_whose_centre_of_mass_is_off_its_axis_is_refused_with_the_distance() {
    let folder = Folder::new("rods");
    let with = |x: &str| {
        let set = format!("legs.rod.com=[{x}, 0, \"-rod/2\"]");
        folder.stiction(&["inverse", "delta", "--set", &set])
    };
    with("\"0.2 mm\"").fails(2, &["its centre of mass is 0.20 mm off this axis"]);
    with("1e-9").succeeds();
}
