//! The command `stiction identify`.

mod arm;
mod closed_loop;
mod coverage;
mod imperfect;
mod instruments;
mod missing;
mod motors;
mod screws;
mod torque_constants;

use crate::program::{Folder, json};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const MOTION: &str = "tool.x = 60 mm*sin(4.4*t) + 30 mm*sin(10.7*t + 1); \
                      tool.y = 360 mm + 40 mm*sin(5.7*t) + 20 mm*sin(13.2*t); duration = 8 s";

/// Model of an arm on one driven axis, without gravity and friction.
fn axis(inertia: f64) -> String {
    format!(
        r#"
gravity = [0, 0, 0]

[bodies.arm]
mass = "1 kg"
com = [0, 0, 0]
inertia = ["{inertia} kg m^2", "{inertia} kg m^2", "{inertia} kg m^2"]

[joints.axis]
type = "R"
from = "ground"
to = "arm"
axis = "z"
actuated = true
"#
    )
}

/// Nearly normal numbers.
fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1;
    move || {
        let mut sum = -6.0;
        for _ in 0..12 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum
    }
}

/// Numbers of a table in the columns whose names begin with `names`, one array per row. If several
/// names begin with the same text, the first column is used.
fn columns<const N: usize>(table: &str, names: [&str; N]) -> Vec<[f64; N]> {
    let mut lines = table.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let places = names.map(|name| head.iter().position(|own| own.starts_with(name)).unwrap());
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        places.map(|place| cells[place])
    };
    lines.map(row).collect()
}

/// Log of the five-bar with quantised positions and efforts with noise of one percent.
fn log(folder: &Folder, load: &str, seed: u64, sign: f64) -> String {
    let options =
        ["--motion", MOTION, "--load", load, "--step", "4 ms", "--report", "off", "-o", "out"];
    folder.stiction(&[&["inverse", "five-bar"], &options[..]].concat()).succeeds();
    let columns = columns(
        &folder.read("out/inverse.csv"),
        [
            "time",
            "left_motor.position",
            "right_motor.position",
            "left_motor.drive [",
            "right_motor.drive [",
        ],
    );
    let mut normal = normal(seed);
    let mut text =
        "time [s],left_motor [rad],right_motor [rad],left_motor.effort [N m],right_motor.effort [N m]\n"
            .to_owned();
    for [t, left, right, a, b] in columns {
        let quantised = |x: f64| (x * 1e6).round() / 1e6;
        writeln!(
            text,
            "{t},{},{},{},{}",
            quantised(left),
            quantised(right),
            a + 0.02 * normal(),
            sign * (b + 0.02 * normal())
        )
        .unwrap();
    }
    text
}

fn parameter<'a>(result: &'a Value, name: &str) -> &'a Value {
    let all = result["parameters"].as_array().unwrap();
    all.iter().find(|p| p["name"] == name).unwrap()
}

/// Identification with a wrong model and two payloads recovers the friction of actuated and passive
/// joints, and the identified model predicts the efforts.
#[test]
fn friction_of_a_five_bar() {
    let folder = Folder::new("identify");
    folder.write("light.csv", &log(&folder, "none", 1, 1.0));
    folder.write("heavy.csv", &log(&folder, "payload", 2, 1.0));
    folder.write("check.csv", &log(&folder, "none", 3, 1.0));
    folder.write(
        "options.toml",
        "filter = \"12 Hz\"\n[[logs]]\nfile = \"heavy.csv\"\nload = \"payload\"\n\
         [[logs]]\nfile = \"check.csv\"\nuse = \"predict\"\n",
    );
    let wrong = [
        "--set",
        "joints.left_elbow.friction.mu=0.12",
        "--set",
        "joints.left_motor.friction.viscous=1",
        "--set",
        "bodies.tool.mass=0.6",
    ];
    let said = folder.stiction(
        &[
            &["identify", "five-bar", "light.csv", "heavy.csv", "check.csv"][..],
            &["--options", "options.toml", "--json", "-o", "found"],
            &wrong,
        ]
        .concat(),
    );
    let result = json(said.succeeds());
    assert_eq!(result, json(&folder.read("found/identify.json")));
    assert_eq!(result["verdict"], "identified", "{:#}", result["cautions"]);
    let mut inside = 0;
    let mut of = 0;
    let truth = [
        ("left_motor.viscous", 2e-4),
        ("left_motor.coulomb", 4e-4),
        ("left_elbow.mu", 0.08),
        ("right_elbow.mu", 0.08),
        ("tip.mu", 0.08),
    ];
    for (name, value) in truth {
        let found = parameter(&result, name);
        let (estimate, sigma) =
            (found["value"].as_f64().unwrap(), found["sigma"].as_f64().unwrap());
        // Three standard deviations: in one of seventy logs, one of the five values lies outside.
        inside += usize::from((estimate - value).abs() < 3.0 * sigma);
        of += 1;
    }
    assert_eq!(inside, of, "{:#}", result["parameters"]);
    let predictions = result["predictions"].as_array().unwrap();
    assert_eq!(predictions.len(), 3);
    assert_eq!(predictions[2]["used_for_fit"], false);
    for p in predictions {
        for (name, error) in p["error_percent"].as_object().unwrap() {
            let before = p["error_percent_of_model"][name].as_f64().unwrap();
            let error = error.as_f64().unwrap();
            // The noise is one percent of the efforts before the filter.
            assert!(error < 2.0 && error < before, "{name}: {error} {before}");
        }
    }
    // The identified model is a valid model file.
    let again = ["inverse", "found/identified.toml", "--motion", MOTION, "--step", "20 ms"];
    folder.stiction(&again).succeeds();
    assert!(folder.read("found/identified.toml").contains("# left_motor.viscous = "));
    // The identified model can be exported, with its coefficients as defaults of the parameters.
    let options = ["--to", "c", "--name", "arm", "--vectors", "5", "-o", "code"];
    folder.stiction(&[&["export", "found/identified.toml"], &options[..]].concat()).succeeds();
    let header = folder.read("code/arm.h");
    let line = header.lines().find(|line| line.contains("left_elbow = ")).unwrap();
    let default: f64 = line.rsplit(' ').next().unwrap().parse().unwrap();
    let estimate = parameter(&result, "left_elbow.mu")["value"].as_f64().unwrap();
    // The file contains the digits that the standard deviation leaves.
    assert!((default / estimate - 1.0).abs() < 0.01, "{line}: {estimate}");
}

#[test]
fn bad_rows_are_named_and_left_out() {
    let folder = Folder::new("identify-rows");
    let text = log(&folder, "none", 4, 1.0);
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    // A row edited by hand, a cell that is not a number, and a time that decreases.
    lines[10] = "0.036,,was -8.9,1,1".to_owned();
    lines[20] = lines[20].replace(',', ",NaN,").replacen(",NaN,", ",", 1);
    lines[30] = lines[29].clone();
    folder.write("log.csv", &lines.join("\n"));
    let said = folder.stiction(&["identify", "five-bar", "log.csv", "--filter", "12 Hz", "--json"]);
    let result = json(said.succeeds());
    let cautions = result["cautions"].to_string();
    for part in [
        "3 bad rows",
        "line 11",
        "line 21",
        "line 31",
        "not later than the time of the previous row",
    ] {
        assert!(cautions.contains(part), "{part}: {cautions}");
    }
}

#[test]
fn wrong_signs_fail_and_write_no_model() {
    let folder = Folder::new("identify-sign");
    folder.write("log.csv", &log(&folder, "none", 5, -1.0));
    let arguments = ["identify", "five-bar", "log.csv", "--filter", "12 Hz", "-o", "found"];
    let said = folder.stiction(&arguments);
    assert!(said.succeeds().contains("efforts have the wrong sign on right_motor"), "{}", said.out);
    assert!(said.out.starts_with("verdict: failed"));
    assert_eq!(folder.files(), ["found", "log.csv", "out"]);
    assert!(!folder.0.join("found/identified.toml").exists());
    folder.stiction(&[&arguments[..], &["--force"]].concat()).succeeds();
    assert!(folder.0.join("found/identified.toml").exists());
}

#[test]
fn unusable_input_is_refused() {
    let folder = Folder::new("identify-refused");
    let good = log(&folder, "none", 6, 1.0);
    folder.write("good.csv", &good);
    folder.write("short.csv", &good.lines().take(60).collect::<Vec<_>>().join("\n"));
    // The positions of the first row, and no efforts of the second motor.
    let first: Vec<&str> = good.lines().nth(1).unwrap().split(',').collect();
    let [mut rest, mut one] = [0, 1].map(|_| good.lines().next().unwrap().to_owned());
    one = one.rsplit_once(',').unwrap().0.to_owned();
    for line in good.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let still = [cells[0], first[1], first[2], cells[3], cells[4]];
        rest += &format!("\n{}", still.join(","));
        one += &format!("\n{}", cells[..4].join(","));
    }
    folder.write("rest.csv", &rest);
    folder.write("one.csv", &one);
    folder.write("unknown.csv", &good.replacen("left_motor [rad]", "left_moter [rad]", 1));
    folder.write("unit.csv", &good.replacen("left_motor.effort [N m]", "left_motor.effort [N]", 1));
    folder.write("effort.csv", &good.replacen("left_motor.effort", "left_elbow.effort", 1));
    folder.write("options.toml", "fliter = \"3 Hz\"\n");
    folder.write("hold.toml", "hold = [\"left_motr.*\"]\n");
    let run = |log: &str, more: &[&str]| {
        folder.stiction(&[&["identify", "five-bar", log][..], more].concat())
    };
    run("missing.csv", &[]).fails(2, &["cannot read missing.csv"]);
    run("short.csv", &[]).fails(2, &["independent samples", "for 65 parameters"]);
    run("rest.csv", &[]).fails(2, &["a joint is at rest", "too few for 65 parameters"]);
    run("one.csv", &[]).fails(2, &["no effort of right_motor", "`right_motor.effort [N m]`"]);
    run("unknown.csv", &[]).fails(2, &["left_moter", "left_motor"]);
    run("unit.csv", &[]).fails(2, &["`left_motor.effort` has the unit of a force"]);
    run("effort.csv", &[]).fails(2, &["left_elbow", "has no actuator"]);
    run("good.csv", &["--options", "options.toml"]).fails(2, &["fliter", "filter"]);
    run("good.csv", &["--options", "hold.toml"]).fails(2, &["no parameter matches"]);
    run("good.csv", &["--filter", "900 Hz"])
        .fails(2, &["a filter of 900 Hz is outside of the range"]);
}

#[test]
fn the_template_is_accepted() {
    let folder = Folder::new("identify-template");
    folder.write("good.csv", &log(&folder, "none", 7, 1.0));
    let template = folder.stiction(&["identify", "--template"]);
    folder.write("options.toml", template.succeeds());
    let arguments = [
        "identify",
        "five-bar",
        "good.csv",
        "--options",
        "options.toml",
        "--filter",
        "12 Hz",
        "--json",
    ];
    assert!(json(folder.stiction(&arguments).succeeds())["parameters"].is_array());
}

fn shared_data() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/kuka_kr300");
    folder.join("traj_A.csv").exists().then_some(folder)
}

/// Model of the KUKA KR300: geometry by standard DH steps, inertias by the table of the data's README.
fn kuka(readme: &str) -> String {
    let steps: [(f64, f64, f64, f64); 6] = [
        (-0.675, 0.35, 90.0, 0.0),
        (-0.189, 1.15, 0.0, -90.0),
        (0.189, 0.041, -90.0, 180.0),
        (-1.0, 0.0, 90.0, 0.0),
        (0.0, 0.0, -90.0, 0.0),
        (-0.24, 0.0, 180.0, 0.0),
    ];
    let ratios = ["1798/7", "1872/7", "757/3", "221", "5032/21", "206793/1340"];
    let rotors = [0.00923, 0.0118, 0.0118, 0.00173, 0.00173, 0.00173];
    // The base is upside down in these frames.
    let mut text = "gravity = [0, 0, \"9.81 m/s^2\"]\n".to_owned();
    let rows = readme.lines().filter(|line| {
        let first = line.strip_prefix("| ").and_then(|rest| rest.chars().next());
        first.is_some_and(|c| c.is_ascii_digit())
    });
    for (k, row) in rows.enumerate() {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let numbers = cells[3].split(',').map(|x| x.trim().parse::<f64>().unwrap());
        let mut inertia: Vec<f64> = numbers.collect();
        inertia.resize(6, 0.0);
        let [xx, yy, zz, xy, yz, xz] = inertia[..] else { panic!("{row}") };
        let (d, a, twist, offset) = steps[k];
        let turn = twist.to_radians();
        let (number, from) = (k + 1, if k == 0 { "ground".to_owned() } else { format!("link{k}") });
        let (y, z) = (-d * turn.sin(), -d * turn.cos());
        writeln!(
            text,
            "[bodies.link{number}]\nmass = {}\ncom = [{}]\n\
             inertia = {{ xx = {xx}, yy = {yy}, zz = {zz}, xy = {xy}, yz = {yz}, xz = {xz} }}\n\
             [joints.axis{number}]\ntype = \"R\"\nfrom = \"{from}\"\nto = \"link{number}\"\naxis = \"z\"\n\
             to_at = [{}, {y}, {z}]\nturn = {{ zyx = [\"{offset} deg\", 0, \"{twist} deg\"] }}\nactuated = true\n\
             [actuators.M{number}]\njoint = \"axis{number}\"\nratio = \"{}\"\nrotor_inertia = {}",
            cells[1], cells[2], -a, ratios[k], rotors[k]
        )
        .unwrap();
    }
    text
}

/// Fits log A of a KUKA KR300 (see the data's README). The model then predicts logs B and C better
/// than the published baseline, least squares with a prior at the CAD data; plain least squares is
/// refused.
#[test]
fn a_kuka_kr300_predicts_logs_that_were_not_used() {
    let Some(data) = shared_data() else {
        println!("skipped: the folder of measured data is absent");
        return;
    };
    let folder = Folder::new("identify-kuka");
    folder.write("kuka.toml", &kuka(&std::fs::read_to_string(data.join("README.md")).unwrap()));
    folder.write("options.toml", include_str!("identify/kuka_kr300_options.toml"));
    let logs: Vec<String> = ["A", "B", "C"]
        .map(|log| data.join(format!("traj_{log}.csv")).display().to_string())
        .into();
    let arguments = [
        "identify",
        "kuka.toml",
        &logs[0],
        &logs[1],
        &logs[2],
        "--options",
        "options.toml",
        "--json",
    ];
    let result = json(folder.stiction(&arguments).succeeds());
    let baseline = [[27.5, 26.4, 13.0, 42.4, 16.7, 26.6], [25.6, 27.3, 10.8, 36.6, 20.8, 22.4]];
    for (log, baseline) in [1, 2].into_iter().zip(baseline) {
        let errors = result["predictions"][log]["error_percent"].as_object().unwrap();
        let errors: Vec<f64> = errors.values().map(|e| e.as_f64().unwrap()).collect();
        let mean = |all: &[f64]| all.iter().sum::<f64>() / 6.0;
        assert!(mean(&errors) < 1.05 * mean(&baseline), "{errors:?}");
        for (error, bound) in errors.iter().zip(baseline) {
            assert!(*error < 1.2 * bound, "{errors:?}");
        }
    }
    assert!(result["cautions"].to_string().contains("plain least squares is refused"));
}
