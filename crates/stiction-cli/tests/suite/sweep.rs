//! `stiction sweep`: values, parts, threads, interruptions, invalid input.

use crate::program::models::slope;
use crate::program::{Folder, Said};
use serde_json::Value;
use std::fs;

const OBJECTIVES: [&str; 8] = [
    "peak(left_motor.effort)",
    "rms(left_motor.drive)",
    "mean(right_motor.drive)",
    "min(distance.actuation)",
    "max(right_motor.drive_high)",
    "range(left_motor.position)",
    "final(left_motor.speed)",
    "work(right_motor.power)",
];

fn with_objectives<'a>(arguments: &[&'a str]) -> Vec<&'a str> {
    let mut all = arguments.to_vec();
    OBJECTIVES.iter().for_each(|objective| all.extend(["--objective", objective]));
    all
}

/// Header and rows of a CSV table, as texts.
fn rows(text: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let split = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
    let mut lines = text.lines().map(split);
    (lines.next().unwrap(), lines.collect())
}

fn column(text: &str, header: &str) -> Vec<f64> {
    let (headers, rows) = rows(text);
    let at = headers.iter().position(|name| name == header).unwrap_or_else(|| panic!("{header}"));
    rows.iter().map(|row| row[at].parse().unwrap()).collect()
}

fn run(folder: &Folder, arguments: &[&str]) -> Said {
    let said = folder.stiction(arguments);
    assert_eq!(said.code, 0, "{}", said.err);
    said
}

/// Compares every statistic with values computed here from the table that `inverse --set` writes.
#[test]
fn values_are_statistics_of_the_tables_of_inverse() {
    let folder = Folder::new("sweep-values");
    let sweep = ["sweep", "five-bar", "--vary", "crank = [190 mm, 230 mm]", "-o", "s"];
    run(&folder, &with_objectives(&sweep));
    let table = folder.read("s/sweep.csv");
    for (k, crank) in ["crank=190mm", "crank=230mm"].into_iter().enumerate() {
        run(&folder, &["inverse", "five-bar", "--set", crank, "-o", "i"]);
        let inverse = folder.read("i/inverse.csv");
        let of = |name: &str| column(&inverse, name);
        let time = of("time [s]");
        let n = time.len() as f64;
        let left = of("left_motor.drive [N m]");
        let power = of("right_motor.power [W]");
        let position = of("left_motor.position [rad]");
        let greatest = |values: &[f64]| values.iter().copied().fold(f64::MIN, f64::max);
        let least = |values: &[f64]| values.iter().copied().fold(f64::MAX, f64::min);
        let expected = [
            ("peak(left_motor.effort) [N m]", greatest(&left).max(-least(&left))),
            ("rms(left_motor.drive) [N m]", (left.iter().map(|x| x * x).sum::<f64>() / n).sqrt()),
            (
                "mean(right_motor.drive) [N m]",
                of("right_motor.drive [N m]").iter().sum::<f64>() / n,
            ),
            ("min(distance.actuation) [-]", least(&of("distance.actuation [-]"))),
            ("max(right_motor.drive_high) [N m]", greatest(&of("right_motor.drive_high [N m]"))),
            ("range(left_motor.position) [rad]", greatest(&position) - least(&position)),
            ("final(left_motor.speed) [rad/s]", *of("left_motor.speed [rad/s]").last().unwrap()),
            (
                "work(right_motor.power) [J]",
                (1..time.len())
                    .map(|k| 0.5 * (power[k] + power[k - 1]) * (time[k] - time[k - 1]))
                    .sum(),
            ),
        ];
        for (header, expected) in expected {
            // The order of summation differs.
            let found = column(&table, header)[k];
            assert!(
                (found - expected).abs() <= 1e-13 * expected.abs().max(1.0),
                "{header}: {found}"
            );
        }
    }
    assert!(folder.read("s/sweep.svg").starts_with("<svg"));
    let json: Value = serde_json::from_str(&folder.read("s/sweep.json")).unwrap();
    assert_eq!((json["rows"].as_u64(), json["ok"].as_u64()), (Some(2), Some(2)));
    let peak = &json["objectives"]["peak(left_motor.effort) [N m]"];
    assert_eq!(peak["greatest"]["settings"]["crank [mm]"], 230.0);
}

/// The number of threads and the division into parts do not change any byte of the results.
/// The root mean square of a motor's torque is that of `inverse`, which is taken over time: samples
/// at both ends of a motion count half.
#[test]
fn the_rms_of_a_motor_is_that_of_inverse() {
    let folder = Folder::new("sweep-motor");
    let text = "
        gravity = [0, 0, -9.81]
        [bodies.carriage]
        mass = 10
        com = [0, 0, 0]
        inertia = [0.1, 0.1, 0.1]
        [joints.guide]
        type = \"P\"
        from = \"ground\"
        to = \"carriage\"
        axis = \"x\"
        friction = { mu = 0.2 }
        [actuators.M]
        joint = \"guide\"
        lead = \"10 mm/rev\"
        efficiency = 0.9
        [motions.m]
        duration = 1
        step = \"0.1 s\"
        guide = \"0.1 m*t^3\"
        [default]
        motion = \"m\"";
    folder.write("slide.toml", text);
    let objective = ["--vary", "M.efficiency = [0.8]", "--objective", "rms(M.motor_torque)"];
    run(&folder, &[&["sweep", "slide.toml", "-o", "s"], &objective[..]].concat());
    let found = column(&folder.read("s/sweep.csv"), "rms(M.motor_torque) [N m]")[0];
    let said = run(&folder, &["inverse", "slide.toml", "--set", "M.efficiency=0.8", "--json"]);
    let summary: Value = serde_json::from_str(&said.out).unwrap();
    let expected = summary["actuators"]["M"]["motor_torque"]["rms"].as_f64().unwrap();
    assert!((found - expected).abs() < 1e-12 * expected, "{found} {expected}");
}

#[test]
fn threads_and_merged_parts_give_the_same_bytes() {
    let folder = Folder::new("sweep-parts");
    folder.write(
        "designs.csv",
        "crank [mm],tool.mass\n190,0.5 kg\n1,0.5\n200,\n210,heavy\n220,1\n230,0.9 kg\n240,0.1\n",
    );
    let sweep = |more: &[&str]| {
        let all = [
            "sweep",
            "five-bar",
            "--table",
            "designs.csv",
            "--objective",
            "peak(left_motor.effort)",
        ];
        run(&folder, &[&all[..], more].concat())
    };
    sweep(&["-o", "one", "--threads", "1"]);
    sweep(&["-o", "many", "--threads", "4"]);
    let whole = folder.read("one/sweep.csv");
    assert_eq!(whole, folder.read("many/sweep.csv"));
    for part in ["1/3", "2/3", "3/3"] {
        sweep(&["-o", &format!("part{}", &part[..1]), "--shard", part]);
    }
    let said = run(&folder, &["sweep", "--merge", "part3", "part1", "part2", "-o", "all"]);
    assert!(said.out.contains("7 designs: 5 ok, 2 without results"), "{}", said.out);
    assert_eq!(said.err.matches("sweep.csv").count(), 1, "{}", said.err);
    assert_eq!(folder.read("all/sweep.csv"), whole);
    let (headers, rows) = rows(&whole);
    assert_eq!(
        headers,
        ["row", "crank [mm]", "tool.mass", "peak(left_motor.effort) [N m]", "status"]
    );
    let words: Vec<&str> = rows.iter().map(|row| row[4].split(' ').next().unwrap()).collect();
    assert_eq!(words, ["ok", "no", "ok", "failed:", "ok", "ok", "ok"]);
    let json = |path: &str| serde_json::from_str::<Value>(&folder.read(path)).unwrap();
    assert_eq!(json("one/sweep.json")["verdicts"], json("all/sweep.json")["verdicts"]);

    let refused = |arguments: &[&str], words: &str| {
        let said = folder.stiction(arguments);
        assert_eq!(said.code, 2);
        assert!(said.err.contains(words), "{}", said.err);
    };
    refused(&["sweep", "--merge", "part1", "part2", "-o", "x"], "part 3 of 3 is missing");
    refused(
        &["sweep", "--merge", "part1", "part1", "part2", "-o", "x"],
        "part 1 of 3 is given twice",
    );
    refused(&["sweep", "--merge", "part1", "one", "-o", "x"], "are not parts of one study");
    refused(&["sweep", "--merge", "nowhere", "-o", "x"], "does not contain a complete part");
}

/// Numbers for a parameter are refused before the first row if they lack the unit that its formulas
/// need.
#[test]
fn numbers_without_the_unit_of_a_parameter_are_refused() {
    let folder = Folder::new("sweep-unit");
    let sweep = |vary: &str| {
        let all =
            ["sweep", "3rps", "--objective", "peak(leg1.P.effort)", "--vary", vary, "-o", "x"];
        folder.stiction(&all)
    };
    let said = sweep("base_radius = 0.4..0.5 in 3000");
    said.fails(2, &["the values of `base_radius` have no unit", "in m", "`base_radius [m]`"]);
    assert_eq!(said.out, "");
    sweep("base_radius = 0.4 m..0.5 m in 2").succeeds();
    folder.write("designs.csv", "base_radius\n0.45\n450 mm\n");
    let table = ["sweep", "3rps", "--objective", "peak(leg1.P.effort)", "--table", "designs.csv"];
    folder.stiction(&table).fails(2, &["the values of `base_radius` have no unit"]);
}

/// Sampled designs are equal in every run, and a longer Sobol design begins with a shorter one.
#[test]
fn sampled_designs_can_be_repeated() {
    let folder = Folder::new("sweep-sampled");
    let sweep = |more: &[&str]| {
        let all = [
            "sweep",
            "five-bar",
            "--motion",
            "duration = 0; tool.y = 380 mm",
            "--vary",
            "motion.tool.x = -50 mm..50 mm",
            "--vary",
            "tool.mass = 0.2 kg..2 kg",
            "--objective",
            "peak(left_motor.effort)",
            "-o",
            "out",
        ];
        run(&folder, &[&all[..], more].concat());
        folder.read("out/sweep.csv")
    };
    let sobol = sweep(&["--design", "sobol", "--samples", "8"]);
    assert!(sweep(&["--design", "sobol", "--samples", "12"]).starts_with(&sobol));
    assert_eq!(column(&sobol, "motion.tool.x [mm]")[..4], [-50.0, 0.0, 25.0, -25.0]);
    let shifted = sweep(&["--design", "sobol", "--samples", "8", "--seed", "1"]);
    assert_ne!(shifted, sobol);
    let cube = sweep(&["--design", "lhs", "--samples", "10", "--seed", "7"]);
    assert_eq!(cube, sweep(&["--design", "lhs", "--samples", "10", "--seed", "7"]));
    let mut places: Vec<i64> =
        column(&cube, "motion.tool.x [mm]").iter().map(|x| ((x + 50.0) / 10.0) as i64).collect();
    places.sort_unstable();
    assert_eq!(places, (0..10).collect::<Vec<_>>());

    // A scatter plot for each key, with a mark for each design.
    for file in ["out/sweep-1.svg", "out/sweep-2.svg"] {
        assert_eq!(folder.read(file).matches("<circle").count(), 10, "{file}");
    }
    // The plots follow the pictures of the robots, which also contain circles.
    let page = folder.read("out/report.html");
    let (_, plots) = page.split_once("Over the varied keys").expect("the plots");
    assert_eq!(plots.matches("<circle").count(), 20);
}

/// A study that was killed twice and continued has files identical to those of an uninterrupted
/// study.
#[test]
#[cfg(unix)]
fn a_killed_study_continues_to_the_same_bytes() {
    let folder = Folder::new("sweep-killed");
    let arguments = [
        "sweep",
        "3rps",
        "--vary",
        "legs.P.friction.mu = 0.05..0.3 in 100",
        "--vary",
        "home_height = 500 mm..600 mm in 5",
        "--friction",
        "on",
        "--step",
        "5 ms",
        "--objective",
        "peak(leg1.P.effort)",
        "--threads",
        "2",
    ];
    let with = |more: &[&'static str]| [&arguments[..], more].concat();
    run(&folder, &with(&["-o", "whole"]));
    for resumed in [&[][..], &["--resume"]] {
        let partial = folder.0.join("out/sweep.partial.csv");
        let length = fs::metadata(&partial).map_or(0, |about| about.len());
        let grown = || fs::metadata(&partial).is_ok_and(|about| about.len() > length + 1000);
        let mut child = folder.begin(&with(&[&["-o", "out"][..], resumed].concat()), grown);
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(!folder.0.join("out/sweep.csv").exists(), "the study ended too early to be killed");
    }
    // A truncated row is computed again.
    let partial = folder.0.join("out/sweep.partial.csv");
    let text = fs::read(&partial).unwrap();
    fs::write(&partial, &text[..text.len() - 7]).unwrap();
    let refused = folder.stiction(&with(&["-o", "out"]));
    assert!(
        refused.code == 2 && refused.err.contains("holds an interrupted study"),
        "{}",
        refused.err
    );
    let other = folder.stiction(&with(&["-o", "out", "--resume", "--load", "none"]));
    assert!(other.code == 2 && other.err.contains("belongs to another study"), "{}", other.err);
    run(&folder, &with(&["-o", "out", "--resume"]));
    for file in ["sweep.csv", "sweep.svg", "sweep.json"] {
        assert!(
            folder.read(&format!("out/{file}")) == folder.read(&format!("whole/{file}")),
            "{file}"
        );
    }
    assert_eq!(Folder(folder.0.join("out")).files(), Folder(folder.0.join("whole")).files());
}

/// A study in which no design has results fails with the first reason.
#[test]
fn a_study_without_results_fails() {
    let folder = Folder::new("sweep-fails");
    let base =
        ["sweep", "five-bar", "--objective", "peak(left_motor.effort)", "-o", "out", "--vary"];
    let said = folder.stiction(&[&base[..], &["crank = 1 mm..2 mm in 2"]].concat());
    assert_eq!(said.code, 1);
    assert!(said.err.contains("no design has results; row 1: no answer: "), "{}", said.err);
    assert!(folder.read("out/sweep.csv").lines().count() == 3);
    let said = folder.stiction(&[&base[..], &["crank = [1 kg]"]].concat());
    assert_eq!(said.code, 2);
}

/// Messages on defective arguments.
#[test]
fn bad_arguments_are_explained() {
    let folder = Folder::new("sweep-bad");
    folder.write("odd.csv", "crank [mm],crank\n1,2\n");
    folder.write("short.csv", "crank [mm]\n");
    let peak = ["--objective", "peak(left_motor.effort)"];
    let cases: &[&[&str]] = &[
        &["sweep"],
        &["sweep", "five-bar"],
        &["sweep", "five-bar", "--vary", "crank = 1 mm..2 mm"],
        &[
            "sweep",
            "five-bar",
            "--vary",
            "crank = 1 mm..2 mm in 2",
            "--design",
            "sobol",
            "--samples",
            "3",
        ],
        &["sweep", "five-bar", "--vary", "crank = 1 mm..2 mm", "--design", "lhs"],
        &["sweep", "five-bar", "--vary", "crank = 1..2 in 2", "--samples", "3"],
        &["sweep", "five-bar", "--vary", "crank = [1]", "--vary", "crank = [2]"],
        &["sweep", "five-bar", "--vary", "cranc = [1]"],
        &["sweep", "five-bar", "--vary", "crank"],
        &["sweep", "five-bar", "--table", "odd.csv"],
        &["sweep", "five-bar", "--table", "short.csv"],
        &["sweep", "five-bar", "--table", "none.csv"],
        &["sweep", "five-bar", "--vary", "crank = [1 m]", "--resume", "-o", "out"],
        &["sweep", "five-bar", "--vary", "load.tool.fx = [1]", "--load", "none"],
    ];
    let mut all = String::new();
    for case in cases {
        let said = folder.stiction(&[*case, &peak[..]].concat());
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{case:?}");
        all += &format!("$ {}\n{}\n", case.join(" "), said.err);
    }
    insta::assert_snapshot!(all);
    assert!(!folder.0.join("out").exists());
}

/// Verdicts of a study: class, statement and meaning.
fn verdicts(folder: &Folder, arguments: &[&str]) -> Vec<[String; 3]> {
    let said = folder.stiction(&[&["sweep"], arguments, &["--json", "-o", "verdicts"]].concat());
    let value: Value = serde_json::from_str(&said.out).unwrap_or_else(|_| panic!("{}", said.err));
    let text = |one: &Value, key: &str| one[key].as_str().unwrap().to_owned();
    let all = value["verdicts"].as_array().unwrap();
    all.iter().map(|one| ["class", "statement", "meaning"].map(|key| text(one, key))).collect()
}

/// Verdicts with the given words in the statement and in the meaning.
fn states(all: &[[String; 3]], class: &str, statement: &str, meaning: &str) {
    let is_it = |one: &[String; 3]| {
        one[0] == class && one[1].contains(statement) && one[2].contains(meaning)
    };
    assert!(all.iter().any(is_it), "{class} {statement} {meaning}: {all:#?}");
}

/// A study states which designs fail and why, with advice for each reason, and the report shows the same verdicts.
#[test]
fn a_study_has_verdicts() {
    let folder = Folder::new("sweep-verdicts");
    folder
        .write("designs.csv", "crank [mm],tool.mass\n190,0.5 kg\n1,0.5\n2,0.5\n210,heavy\n220,1\n");
    let effort = ["--objective", "peak(left_motor.effort)"];
    let all = verdicts(&folder, &[&["five-bar", "--table", "designs.csv"], &effort[..]].concat());
    states(
        &all,
        "caution",
        "2 of 5 designs have no results: rows 2, 3; row 2: ",
        "cannot make the motion",
    );
    states(&all, "caution", "1 of 5 designs has no results: row 4: ", "The model cannot be read");
    let ends = "least 5.707 in row 1; greatest 8.814 in row 5, at an end of `crank`, `tool.mass`";
    states(&all, "good", ends, "One lies between the ends");
    let page = folder.read("verdicts/report.html");
    assert!(page.contains("2 of 5 designs have no results: rows 2, 3; row 2: "));
    assert!(page.find("<h2>Verdicts</h2>") < page.find("<h2>Extremes</h2>"));

    let vary = ["five-bar", "--vary", "crank = 180 mm..240 mm in 4"];
    let index = ["--objective", "min(distance.actuation)"];
    let all = verdicts(&folder, &[&vary[..], &index].concat());
    states(&all, "good", "All designs have results without cautions", "no singular position");
    let statement = "least 0.1664 in row 1, at an end of `crank`; greatest 0.2260 in row 3";
    states(&all, "good", statement, "One lies between the ends");
}

/// Each kind of caution and failure of a design has its own advice.
#[test]
fn reasons_have_advice() {
    let folder = Folder::new("sweep-advice");
    folder.write("slope.toml", &slope(0.1).replace("actuated", "range = [0, 0.15]\nactuated"));
    let effort = ["--objective", "peak(slope.effort)"];
    let vary =
        ["slope.toml", "--friction", "off", "--vary", "joints.slope.friction.mu = 0.1..0.3 in 3"];
    let all = verdicts(&folder, &[&vary[..], &effort].concat());
    states(
        &all,
        "caution",
        "3 of 3 designs have cautions: rows 1, 2, 3; row 1: slope exceeds its range of",
        "leaves its declared range",
    );
    states(&all, "note", "peak(slope.effort) [N] is 10.00 in all designs", "no effect");

    let motor =
        "[actuators.M]\njoint = \"slope\"\nlead = \"10 mm/rev\"\nlimits = { peak = \"10 mN m\" }\n";
    folder.write("motor.toml", &format!("{}{motor}", slope(0.0)));
    let mass = ["--vary", "bodies.block.mass = [0.2 kg, 2 kg, 4 kg]"];
    let all = verdicts(&folder, &[&["motor.toml"], &mass[..], &effort].concat());
    states(
        &all,
        "caution",
        "2 of 3 designs have cautions: rows 2, 3; row 2: M: ",
        "A limit of a motor is exceeded",
    );
    states(
        &all,
        "note",
        "is greatest in row 3, which has cautions",
        "Without them, the greatest value is 1.000 in row 1",
    );

    let all = verdicts(
        &folder,
        &[
            "3upu-singular",
            "--vary",
            "bodies.platform.mass = [1 kg, 2 kg]",
            "--objective",
            "peak(leg1.P.effort)",
        ],
    );
    states(
        &all,
        "caution",
        "2 of 2 designs have cautions: rows 1, 2; row 1: singular at t = 0 s",
        "cannot balance every load. ",
    );
    states(&all, "caution", "actuator efforts are not unique", "depend on an assumption");
}
