//! The command `stiction excite`.

use crate::program::{Folder, json};
use serde_json::Value;
use std::fmt::Write as _;

/// A vertical arm of two links with friction, ranges and motor limits.
pub(crate) const ARM: &str = r#"
gravity = [0, "-9.81 m/s^2", 0]

[bodies.upper]
mass = "2 kg"
com = ["200 mm", 0, 0]
inertia = [0, "0.03 kg m^2", "0.03 kg m^2"]

[bodies.lower]
mass = "1 kg"
com = ["150 mm", 0, 0]
inertia = [0, "0.01 kg m^2", "0.01 kg m^2"]

[joints.shoulder]
type = "R"
from = "ground"
to = "upper"
axis = "z"
actuated = true
range = ["-100 deg", "100 deg"]
friction = { mu = 0.1, radius = "20 mm", preload = "200 N", viscous = "1500 N s/m" }

[joints.elbow]
type = "R"
from = "upper"
to = "lower"
at = ["400 mm", 0, 0]
axis = "z"
actuated = true
start = "20 deg"
range = ["-60 deg", "120 deg"]
friction = { mu = 0.1, radius = "15 mm", preload = "150 N", viscous = "800 N s/m" }

[actuators.M1]
joint = "shoulder"
ratio = 50
limits = { peak = "0.6 N m", speed = "150 rad/s" }

[actuators.M2]
joint = "elbow"
ratio = 50
limits = { peak = "0.25 N m", speed = "200 rad/s" }

[loads.part]
[[loads.part.payload]]
body = "lower"
mass = "1.5 kg"
com = ["300 mm", 0, 0]
inertia = ["1e-3 kg m^2", "1e-3 kg m^2", "1e-3 kg m^2"]
"#;

const SHORT: [&str; 4] = ["--duration", "4", "--iterations", "30"];

fn arm(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("arm.toml", ARM);
    folder
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key}: {value:#}"))
}

/// Columns of a CSV table whose names begin with `names`.
pub(crate) fn columns(text: &str, names: &[&str]) -> Vec<Vec<f64>> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at: Vec<usize> = names
        .iter()
        .map(|name| header.iter().position(|own| own.starts_with(name)).unwrap())
        .collect();
    let mut out = vec![Vec::new(); names.len()];
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        for (values, &k) in out.iter_mut().zip(&at) {
            values.push(cells[k].parse().unwrap());
        }
    }
    out
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |max: f64, x| max.max(x.abs()))
}

/// On a grid ten times finer than that of the search, inverse dynamics respects all limits, and
/// some limit is nearly reached. The motion begins and ends at rest, and its information exceeds
/// that of the initial motion.
#[test]
fn limits_hold_between_the_samples_of_the_search() {
    let folder = arm("excite-limits");
    let more = ["--limit", "*.acceleration=60 rad/s^2", "--limit", "shoulder.effort=25 N m"];
    let arguments = [&["excite", "arm.toml", "-o", "out", "--json"][..], &SHORT, &more].concat();
    let result = json(folder.stiction(&arguments).succeeds());
    assert!(number(&result, "log_det") > number(&result, "log_det_of_start") + 1.0, "{result:#}");
    assert!(number(&result, "gain") > 1.0);
    let limits = result["limits"].as_array().unwrap();
    let used: Vec<f64> = limits.iter().map(|limit| number(limit, "used")).collect();
    assert!(used.iter().all(|part| *part <= 1.0), "{limits:#?}");
    // The optimum lies at limits; the barrier keeps a distance of a few percent at most.
    assert!(used.iter().any(|part| *part > 0.9), "{limits:#?}");

    // Five harmonics of 0.25 Hz with 16 samples per period of the highest one are 20 samples per
    // second; 2 ms are more than ten times finer.
    let run =
        ["inverse", "arm.toml", "--motion", "out/excite.csv", "--load", "none", "--step", "2 ms"];
    folder.stiction(&[&run[..], &["--report", "off", "-o", "run"]].concat()).succeeds();
    let [q1, v1, e1, q2, v2] = &columns(
        &folder.read("run/inverse.csv"),
        &[
            "shoulder.position",
            "shoulder.speed",
            "shoulder.drive [",
            "elbow.position",
            "elbow.speed",
        ],
    )[..] else {
        panic!()
    };
    let rounding = 1.0 + 1e-6;
    assert!(largest(q1) <= 100f64.to_radians() * rounding);
    let middle = 30f64.to_radians();
    assert!(q2.iter().all(|q| (q - middle).abs() <= 90f64.to_radians() * rounding));
    assert!(largest(v1) <= 3.0 * rounding && largest(v2) <= 4.0 * rounding);
    assert!(largest(e1) <= 25.0 * rounding);
    let torques =
        columns(&folder.read("run/inverse.csv"), &["M1.motor_torque [", "M2.motor_torque ["]);
    assert!(largest(&torques[0]) <= 0.6 * rounding && largest(&torques[1]) <= 0.25 * rounding);
    let summary = json(&folder.read("run/summary.json"));
    assert!(!summary["cautions"].to_string().contains("peak torque"), "{:#}", summary["cautions"]);
    assert!(!summary["cautions"].to_string().contains("exceeds its range"));
    let reference =
        columns(&folder.read("out/excite.csv"), &["d(shoulder)", "dd(shoulder)", "dd(elbow)"]);
    for column in &reference {
        assert_eq!((column[0], *column.last().unwrap()), (0.0, 0.0));
    }
    assert!(largest(&reference[1]) <= 60.0 * rounding);
}

/// The same seed gives identical files; another seed gives another motion.
#[test]
fn a_seed_gives_the_same_bytes() {
    let folder = arm("excite-seed");
    let run = |seed: &str, out: &str| {
        let arguments =
            [&["excite", "arm.toml", "-o", out, "--seed", seed][..], &["--iterations", "6"]]
                .concat();
        folder.stiction(&arguments).succeeds();
        ["excite.csv", "log.toml", "excite.json"].map(|file| folder.read(&format!("{out}/{file}")))
    };
    let first = run("7", "a");
    assert_eq!(first, run("7", "b"));
    assert_ne!(first[0], run("8", "c")[0]);
}

/// Generates approximately normal random numbers.
pub(crate) fn normal(seed: u64) -> impl FnMut() -> f64 {
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

/// Parameters identified from synthetic logs with the stated noise scatter as predicted.
#[test]
fn identification_scatters_as_predicted() {
    const SIGMA: f64 = 0.2;
    const SEEDS: u64 = 16;
    let folder = arm("excite-scatter");
    let chosen = "shoulder.coulomb,shoulder.viscous,elbow.coulomb,elbow.viscous";
    let arguments = ["excite", "arm.toml", "--parameters", chosen, "--noise", "0.2 N m", "--json"];
    let arguments = [&arguments[..], &SHORT, &["-o", "out"]].concat();
    let design = json(folder.stiction(&arguments).succeeds());
    let run =
        ["inverse", "arm.toml", "--motion", "out/excite.csv", "--load", "none", "--report", "off"];
    folder.stiction(&[&run[..], &["-o", "run"]].concat()).succeeds();
    let names =
        ["time", "shoulder.position", "elbow.position", "shoulder.drive [", "elbow.drive ["];
    let table = columns(&folder.read("run/inverse.csv"), &names);
    let expected = design["parameters"].as_array().unwrap();
    assert_eq!(expected.len(), 4, "{expected:#?}");
    let (mut squares, mut count) = (0.0, 0);
    for seed in 0..SEEDS {
        let mut normal = normal(seed);
        let mut text =
            "time [s],shoulder,elbow,shoulder.effort [N m],elbow.effort [N m]\n".to_owned();
        for k in 0..table[0].len() {
            let [t, q1, q2, e1, e2] = [0, 1, 2, 3, 4].map(|column| table[column][k]);
            writeln!(text, "{t},{q1},{q2},{},{}", e1 + SIGMA * normal(), e2 + SIGMA * normal())
                .unwrap();
        }
        folder.write("log.csv", &text);
        let arguments = ["identify", "arm.toml", "log.csv", "--options", "out/log.toml", "--json"];
        let found = json(folder.stiction(&arguments).succeeds());
        let found = found["parameters"].as_array().unwrap();
        for e in expected {
            let own = found.iter().find(|p| p["name"] == e["name"]).unwrap();
            let error = number(own, "value") - number(e, "value");
            squares += (error / number(e, "sigma")).powi(2);
            count += 1;
        }
    }
    // A standard deviation from 64 errors is accurate to 9 %; the bounds of 30 % are about three
    // times as large.
    let ratio = (squares / f64::from(count)).sqrt();
    assert!((0.7..1.3).contains(&ratio), "scatter over prediction {ratio}");
}

/// With one payload, the friction coefficient and the load-independent friction of a bearing are
/// confounded; the plan reports this and suggests a second payload.
#[test]
fn a_second_payload_is_asked_for() {
    let folder = arm("excite-payload");
    let plan = |payloads: &[&str]| {
        let arguments = ["excite", "arm.toml", "--parameters", "elbow.mu,elbow.coulomb", "--json"];
        let result = folder.stiction(&[&arguments[..], &SHORT, payloads, &["-o", "out"]].concat());
        json(result.succeeds())["payloads"].clone()
    };
    let alone = plan(&["--limit", "*.speed=1 rad/s"]);
    assert_eq!(alone["needs_another"], true, "{alone:#}");
    let pair = &alone["pairs"][0];
    assert_eq!(pair["with_load"], "part", "{alone:#}");
    let (before, after) = (number(pair, "correlation"), number(pair, "correlation_with_load"));
    assert!(after.abs() < before.abs());
    let both = plan(&["--limit", "*.speed=1 rad/s", "--payload", "none,part"]);
    assert_eq!(both["needs_another"], false, "{both:#}");
    let log = folder.read("out/log.toml");
    for part in ["file = \"log-none.csv\"", "file = \"log-part.csv\"", "load = \"part\""] {
        assert!(log.contains(part), "{log}");
    }
}

#[test]
fn what_cannot_be_designed_is_refused() {
    let folder = arm("excite-refused");
    let free = ARM.replace("range =", "# range =");
    folder.write("free.toml", &free);
    let run =
        |model: &str, more: &[&str]| folder.stiction(&[&["excite", model][..], more].concat());
    run("free.toml", &[]).fails(
        2,
        &["the displacement of shoulder, elbow is not limited", "--limit \"shoulder = 20 deg\""],
    );
    run("arm.toml", &["--parameters", "shouldr.mu"]).fails(2, &["shouldr.mu", "shoulder.mu"]);
    run("arm.toml", &["--limit", "elbo=3 deg"]).fails(2, &["elbo", "`elbow`"]);
    run("arm.toml", &["--limit", "elbow=3 kg"]).fails(2, &["a mass cannot be in rad"]);
    run("arm.toml", &["--limit", "elbow.effort=0.5 N m"])
        .fails(1, &["no motion is feasible", "elbow.effort", "0.5000 N m"]);
    run("arm.toml", &["--payload", "prt"]).fails(2, &["no load `prt`", "`part`"]);
    run("arm.toml", &["--motion", "swing"]).fails(2, &["no motion `swing`"]);
    run("arm.toml", &["--noise", "3 N"]).fails(2, &["N m for the effort of shoulder"]);
    run("arm.toml", &["--duration", "5", "--base-frequency", "0.5 Hz"]).fails(2, &["whole number"]);
    run("arm.toml", &["--step", "1 s"]).fails(2, &["ten times"]);
}
