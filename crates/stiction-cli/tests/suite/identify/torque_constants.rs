//! Estimation of torque constants that the model lacks, from logged currents.

use super::{MOTION, columns, normal, parameter};
use crate::program::{Folder, json};
use serde_json::Value;
use std::fmt::Write as _;

/// True torque constants, N m/A.
const TRUTH: [(&str, f64); 2] = [("left", 0.08), ("right", 0.11)];
/// Standard deviation of the currents, A.
const NOISE: f64 = 0.01;
const HEAVY: &str = "filter = \"15 Hz\"\n[[logs]]\nfile = \"heavy.csv\"\nload = \"payload\"\n";

/// Model of the five-bar with geared motors. Only the motors in `known` have torque constants.
fn model(folder: &Folder, known: &[&str]) -> String {
    let mut text = folder.stiction(&["models", "five-bar"]).succeeds().to_owned();
    for (name, constant) in TRUTH {
        let constant = match known.contains(&name) {
            true => format!("torque_constant = \"{constant} N m/A\"\n"),
            false => String::new(),
        };
        write!(
            text,
            "\n[actuators.{name}]\njoint = \"{name}_motor\"\nratio = 10\n\
             rotor_inertia = \"2e-6 kg m^2\"\n{constant}"
        )
        .unwrap();
    }
    text
}

/// Writes `true.toml`, `model.toml` without torque constants, and logs of currents without and with
/// a payload.
fn logs(folder: &Folder, seed: u64) {
    folder.write("true.toml", &model(folder, &["left", "right"]));
    folder.write("model.toml", &model(folder, &[]));
    let mut normal = normal(seed);
    for (load, file) in [("none", "light.csv"), ("payload", "heavy.csv")] {
        let options = ["--load", load, "--step", "4 ms", "--report", "off", "-o", "out"];
        let run = [&["inverse", "true.toml", "--motion", MOTION], &options[..]].concat();
        folder.stiction(&run).succeeds();
        let table = folder.read("out/inverse.csv");
        let names = ["time", "left_motor.pos", "right_motor.pos", "left.current", "right.current"];
        let mut text =
            "time [s],left_motor [rad],right_motor [rad],left.current [A],right.current [A]\n"
                .to_owned();
        for [t, q1, q2, i1, i2] in columns(&table, names) {
            let [q1, q2] = [q1, q2].map(|q| (q * 1e6).round() / 1e6);
            let [i1, i2] = [i1, i2].map(|i| i + NOISE * normal());
            writeln!(text, "{t},{q1},{q2},{i1},{i2}").unwrap();
        }
        folder.write(file, &text);
    }
}

fn identified(folder: &Folder, options: &str, run: &[&str]) -> Value {
    folder.write("options.toml", options);
    let more = ["--options", "options.toml", "--json"];
    json(folder.stiction(&[run, &more].concat()).succeeds())
}

/// Checks a torque constant against the truth, within three standard deviations.
fn check(result: &Value, name: &str, truth: f64, verdict: &str) -> f64 {
    let found = parameter(result, &format!("{name}.torque_constant"));
    let [value, sigma] = ["value", "sigma"].map(|key| found[key].as_f64().unwrap());
    assert!((value - truth).abs() < 3.0 * sigma, "{name}: {value} +- {sigma}, true {truth}");
    assert_eq!(found["verdict"], verdict, "{name}: {value} +- {sigma}");
    assert_eq!((&found["prior"], &found["unit"]), (&Value::Null, &Value::from("N m/A")));
    sigma / value
}

/// A payload of known mass in one of two logs determines the scale of the torque constants. Wrong
/// masses in the model do not bias it.
#[test]
fn a_known_payload_decides_the_scale() {
    let folder = Folder::new("identify-torque-constants");
    logs(&folder, 1);
    let wrong = ["--set", "bodies.tool.mass=0.6", "--set", "bodies.left_crank.mass=0.25"];
    let run = ["identify", "model.toml", "light.csv", "heavy.csv", "-o", "found"];
    let result = identified(&folder, HEAVY, &[&run[..], &wrong].concat());
    assert_eq!(result["verdict"], "identified", "{:#}", result["cautions"]);
    for (name, truth) in TRUTH {
        let relative = check(&result, name, truth, "identified");
        assert!(relative < 0.03, "{name}: {relative}");
    }
    // Friction is in N m, although only currents were measured.
    for (name, truth) in [("left_elbow.mu", 0.08), ("tip.mu", 0.08)] {
        let found = parameter(&result, name);
        let [value, sigma] = ["value", "sigma"].map(|key| found[key].as_f64().unwrap());
        assert!((value - truth).abs() < 3.0 * sigma, "{name}: {value} +- {sigma}");
    }
    // The written model contains the torque constants.
    let model = folder.read("found/identified.toml");
    assert_eq!(model.matches("\ntorque_constant = ").count(), 2, "{model}");
    // The efforts in the table are those of the joints, in N m.
    let efforts = columns(
        &folder
            .read("found/efforts.csv")
            .replace("\"light.csv\"", "1")
            .replace("\"heavy.csv\"", "2")
            .replace(",,,,", ",NaN,NaN,NaN,NaN"),
        ["left_motor.measured", "left_motor.predicted ["],
    );
    let rows = efforts.iter().filter(|row| row[0].is_finite());
    let (error, size) = rows.fold((0.0, 0.0), |(error, size), [measured, predicted]| {
        (error + (measured - predicted).powi(2), size + measured * measured)
    });
    assert!(error < 0.03_f64.powi(2) * size, "{}", (error / size).sqrt());
}

/// A current of the wrong sign would need a negative torque constant: the fit fails, and the motor
/// is reported.
#[test]
fn a_current_of_the_wrong_sign_is_named() {
    let folder = Folder::new("identify-torque-constant-sign");
    logs(&folder, 4);
    let columns = "[columns]\n\"left.current\" = { is = \"left.current [A]\", factor = -1 }\n";
    let options = HEAVY.replacen('\n', &format!("\n{columns}"), 1);
    let run = ["identify", "model.toml", "light.csv", "heavy.csv"];
    let result = identified(&folder, &options, &run);
    assert_eq!(result["verdict"], "failed");
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains("efforts have the wrong sign on left_motor"), "{cautions}");
}

/// The known torque constant of one motor determines that of the other motor, because both move the
/// same bodies.
#[test]
fn a_known_motor_decides_the_scale_of_the_other() {
    let folder = Folder::new("identify-torque-constant");
    logs(&folder, 2);
    folder.write("model.toml", &model(&folder, &["right"]));
    let run = ["identify", "model.toml", "light.csv"];
    let result = identified(&folder, "filter = \"15 Hz\"\n", &run);
    let relative = check(&result, "left", 0.08, "identified");
    assert!(relative < 0.05, "{relative}");
}

/// Without any known quantity, the scale of the torque constants is undetermined. The fit is
/// refused with a message, unless the inertias of the model are held constant or the strength of
/// the prior is stated.
#[test]
fn a_scale_without_reference_is_refused() {
    let folder = Folder::new("identify-torque-constant-refused");
    logs(&folder, 3);
    let options = "filter = \"15 Hz\"\n";
    folder.write("options.toml", options);
    let run = ["identify", "model.toml", "light.csv"];
    let said = folder.stiction(&[&run[..], &["--options", "options.toml"]].concat());
    let texts = [
        "left.torque_constant, right.torque_constant cannot be determined",
        "payload of known mass",
        "prior = 100",
    ];
    said.fails(2, &texts);
    // The same payload in all logs acts like a different tool.
    folder.write("options.toml", HEAVY);
    let run = ["identify", "model.toml", "heavy.csv", "--options", "options.toml"];
    folder.stiction(&run).fails(2, &["cannot be determined"]);
    let run = ["identify", "model.toml", "light.csv"];
    // Correct inertias of the model, held constant.
    let held = identified(&folder, "filter = \"15 Hz\"\nestimate = \"friction\"\n", &run);
    for (name, truth) in TRUTH {
        assert!(check(&held, name, truth, "identified") < 0.01);
    }
    // With a stated strength of the prior, the values are as uncertain as the inertias of the
    // model, which are ten percent too large here.
    let wrong = [
        "bodies.tool.mass=0.55",
        "bodies.left_crank.mass=0.385",
        "bodies.right_crank.mass=0.385",
        "bodies.left_coupler.mass=0.242",
        "bodies.right_coupler.mass=0.242",
    ];
    let mut all = run.to_vec();
    wrong.iter().for_each(|value| all.extend(["--set", value]));
    let prior = identified(&folder, "filter = \"15 Hz\"\nprior = 100\n", &all);
    for (name, truth) in TRUTH {
        let relative = check(&prior, name, truth, "fits only");
        assert!((0.03..0.3).contains(&relative), "{name}: {relative}");
    }
    assert_eq!(prior["verdict"], "fits only");
    let cautions = prior["cautions"].to_string();
    assert!(cautions.contains("from the inertias of the model"), "{cautions}");
}
