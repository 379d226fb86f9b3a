//! Identification from logs with effects that the model or the options lack: offsets, delays,
//! spikes, other friction laws. The efforts come from the textbook equation of a pendulum, which is
//! written here and independent of the program.

use super::{Folder, json, normal, parameter};
use serde_json::Value;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

const MODEL: &str = "gravity = [0, 0, -9.81]\n[bodies.bar]\nmass = 2\ncom = [-0.2, 0, 0]\n\
    inertia = [0.02, 0.02, 0.02]\n[joints.hinge]\ntype = \"R\"\nfrom = \"ground\"\nto = \"bar\"\n\
    axis = \"y\"\nactuated = true\n[actuators.M]\njoint = \"hinge\"\n\
    motor_friction = { constant = 0.6, viscous = 0.4 }\n";
/// Product of mass and centre of mass, kg m.
const MOMENT: f64 = -0.4;
const INERTIA: f64 = 0.02 + 2.0 * 0.2 * 0.2;
const COULOMB: f64 = 0.6;
const VISCOUS: f64 = 0.4;
const STEP: f64 = 5e-3;
const ROWS: u32 = 2400;

/// Angle, rate and acceleration at a time, s.
fn motion(t: f64) -> [f64; 3] {
    let sum = |f: &dyn Fn(f64, f64) -> f64| f(0.5, 0.7 * TAU) + f(0.3, 0.31 * TAU);
    [
        sum(&|a, w| a * (w * t).sin()),
        sum(&|a, w| a * w * (w * t).cos()),
        sum(&|a, w| -a * w * w * (w * t).sin()),
    ]
}

fn effort(t: f64) -> f64 {
    let [q, v, a] = motion(t);
    INERTIA * a - MOMENT * 9.81 * q.cos() + COULOMB * v.signum() + VISCOUS * v
}

/// Log of the motion with the given efforts and noise.
fn log(seed: u64, effort: impl Fn(f64) -> f64) -> String {
    let mut noise = normal(seed);
    let mut text = "time [s],hinge [rad],M.motor_torque [N m]\n".to_owned();
    for k in 0..ROWS {
        let t = STEP * f64::from(k);
        let position = motion(t)[0] + 1e-5 * noise();
        writeln!(text, "{t:.4},{position},{}", effort(t) + 0.02 * noise()).unwrap();
    }
    text
}

fn identified(folder: &Folder, log: &str, options: &str) -> Value {
    identified_with(folder, log, options, "8 Hz")
}

fn identified_with(folder: &Folder, log: &str, options: &str, filter: &str) -> Value {
    folder.write("model.toml", MODEL);
    folder.write("log.csv", log);
    folder.write("options.toml", options);
    let run = ["identify", "model.toml", "log.csv", "--filter", filter, "--json"];
    json(folder.stiction(&[&run[..], &["--options", "options.toml"]].concat()).succeeds())
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap()
}

/// Error of a parameter in standard deviations, and its standard deviation.
fn error(result: &Value, name: &str, truth: f64) -> (f64, f64) {
    let found = parameter(result, name);
    let sigma = number(found, "sigma");
    ((number(found, "value") - truth) / sigma, sigma)
}

fn is_empty(result: &Value, key: &str) -> bool {
    result[key].as_array().unwrap().is_empty()
}

/// Logs without defects cause no cautions.
#[test]
fn clean_logs_are_complete() {
    let folder = Folder::new("identify-clean");
    for seed in 1..=20 {
        let result = identified(&folder, &log(seed, effort), "");
        for key in ["missing", "delays", "cautions"] {
            assert!(is_empty(&result, key), "{seed}: {:#}", result[key]);
        }
        assert_eq!(result["verdict"], "identified");
    }
}

/// A constant error of the effort biases the estimated gravity moment: the error is reported with
/// its value and the option that corrects it, and no parameter that it changes counts as
/// identified. With this option, the true values are found.
#[test]
fn a_constant_error_of_the_effort_is_named() {
    let folder = Folder::new("identify-offset");
    let log = log(1, |t| effort(t) + 0.8);
    let result = identified(&folder, &log, "");
    let found = &result["missing"][0];
    let (value, sigma) = (number(found, "value"), number(found, "sigma"));
    assert!((value - 0.8).abs() < 4.0 * sigma && sigma < 0.05, "{found:#}");
    let cautions = result["cautions"].to_string();
    for part in ["hinge: the residuals show a constant error", "`offsets = true`", "bar.mx by"] {
        assert!(cautions.contains(part), "{part}: {cautions}");
    }
    assert_ne!(parameter(&result, "bar.mx")["verdict"], "identified");
    assert_ne!(result["verdict"], "identified");
    let mended = identified(&folder, &log, "offsets = true\n");
    let (off, sigma) = error(&mended, "bar.mx", MOMENT);
    assert!(off.abs() < 4.0 && sigma < 0.01, "{off} {sigma}");
    assert!(is_empty(&mended, "missing"), "{:#}", mended["missing"]);
    assert_eq!(parameter(&mended, "bar.mx")["verdict"], "identified");
}

/// Factors of formulas take part in the structure of the regression: one that differs from all other columns is
/// determined alone, one that equals the constant friction only in combination with it, and one without any effort
/// has no effect and is not excited.
#[test]
fn the_structure_contains_factors_of_formulas() {
    let folder = Folder::new("identify-terms");
    let log = log(1, |t| effort(t) + 0.5 * (2.0 * motion(t)[0]).sin());
    let result = identified(
        &folder,
        &log,
        "[terms]\nspring = \"hinge = 1 N m*sin(2*hinge)\"\ndry = \"hinge = 1 N m*sign(d(hinge))\"\n\
         nothing = \"hinge = 0 N m*hinge\"\n",
    );
    let structure = |name: &str| parameter(&result, name)["structure"].clone();
    assert_eq!(structure("spring"), "alone");
    for name in ["dry", "hinge.coulomb"] {
        assert_eq!(structure(name), "combination", "{name}");
    }
    assert_eq!(structure("nothing"), "none");
    assert_eq!(parameter(&result, "nothing")["verdict"], "not excited");
    assert_eq!(parameter(&result, "spring")["verdict"], "identified");
    let (off, sigma) = error(&result, "spring", 0.5);
    assert!(off.abs() < 3.5 && sigma < 0.05, "{off} {sigma}");
}

/// Delays of several samples and of fractions of a sample are found, reported and corrected. Delays
/// that an option leaves uncorrected are reported.
#[test]
fn a_delay_of_the_effort_is_taken_back() {
    let folder = Folder::new("identify-delay");
    for (seed, delay) in [(1, 20e-3), (2, -8.3e-3), (3, 2e-3)] {
        let log = log(seed, |t| effort(t - delay));
        let result = identified(&folder, &log, "");
        let found = &result["delays"][0];
        let (value, sigma) = (number(found, "value"), number(found, "sigma"));
        // Reversals of friction lie between samples, and each is known to a fraction of a sample;
        // the standard deviation includes this uncertainty.
        assert!((value - delay).abs() < 3.0 * sigma && sigma < 0.8e-3, "{delay}: {found:#}");
        assert!(result["cautions"].to_string().contains("`delay = 0`"), "{delay}");
        for (name, truth) in [("hinge.viscous", VISCOUS), ("hinge.coulomb", COULOMB)] {
            let (off, sigma) = error(&result, name, truth);
            assert!(off.abs() < 3.5 && sigma < 0.02, "{delay} {name}: {off} {sigma}");
        }
        assert!(is_empty(&result, "missing"), "{delay}: {:#}", result["missing"]);
    }
    let log = log(1, |t| effort(t - 20e-3));
    let result = identified(&folder, &log, "delay = 0\n");
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains("a delay of the effort relative to the positions"), "{cautions}");
    assert_ne!(parameter(&result, "hinge.viscous")["verdict"], "identified");
    // A known delay needs no caution.
    let result = identified(&folder, &log, "delay = \"20 ms\"\n");
    assert!(is_empty(&result, "missing"), "{:#}", result["missing"]);
}

/// Large errors in one of a hundred samples are reported and replaced, and do not change the
/// values.
#[test]
fn spikes_are_named_and_replaced() {
    let folder = Folder::new("identify-spikes");
    let mut random = normal(77);
    let mut count = 0;
    let text: Vec<String> = log(1, effort)
        .lines()
        .map(|line| match line.rsplit_once(',') {
            // The sum of twelve uniform numbers is beyond 2.6 standard deviations in one of a hundred cases.
            Some((before, value)) if !value.contains('[') && random().abs() > 2.6 => {
                count += 1;
                format!("{before},{}", value.parse::<f64>().unwrap() + 20.0 * random().signum())
            }
            _ => line.to_owned(),
        })
        .collect();
    assert!((10..50).contains(&count), "{count}");
    let result = identified(&folder, &text.join("\n"), "");
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains("samples that stand out"), "{cautions}");
    for (name, truth) in [("bar.mx", MOMENT), ("hinge.viscous", VISCOUS)] {
        let (off, sigma) = error(&result, name, truth);
        assert!(off.abs() < 3.5 && sigma < 0.02, "{name}: {off} {sigma}");
    }
    assert_eq!(result["verdict"], "identified", "{cautions}");
}

/// Checks that a single wrong number, however large, is named and does not change the fit.
#[test]
fn one_absurd_number_is_named_and_left_out() {
    let folder = Folder::new("identify-absurd");
    for (absurd, says) in [
        ("1e6", "1 sample that stands out from its neighbours, by 1.000e6 N m"),
        ("1e200", "is 1e200"),
    ] {
        let with = |(k, line): (usize, &str)| match line.rsplit_once(',') {
            Some((before, _)) if k == 700 => format!("{before},{absurd}"),
            _ => line.to_owned(),
        };
        let text: Vec<String> = log(1, effort).lines().enumerate().map(with).collect();
        let result = identified(&folder, &text.join("\n"), "");
        let cautions = result["cautions"].to_string();
        assert!(cautions.contains(says) && cautions.contains("line 701"), "{cautions}");
        let (off, sigma) = error(&result, "bar.mx", MOMENT);
        assert!(off.abs() < 3.5 && sigma < 0.02, "{absurd}: {off} {sigma}");
        assert_eq!(result["verdict"], "identified", "{cautions}");
    }
}

/// A filter with a cut-off frequency near that of the motion removes part of the motion: the
/// estimated inertia is too large, and the reported bias agrees with the error.
#[test]
fn a_filter_that_is_too_low_is_named() {
    let folder = Folder::new("identify-low");
    // Motion with a component of 3 Hz and a slow component.
    let motion = |t: f64| {
        let (fast, slow) = (3.0 * TAU, 0.4 * TAU);
        [
            0.1 * (fast * t).sin() + 0.4 * (slow * t).sin(),
            0.1 * fast * (fast * t).cos() + 0.4 * slow * (slow * t).cos(),
            -0.1 * fast * fast * (fast * t).sin() - 0.4 * slow * slow * (slow * t).sin(),
        ]
    };
    let mut noise = normal(6);
    let mut text = "time [s],hinge [rad],M.motor_torque [N m]\n".to_owned();
    for k in 0..ROWS {
        let t = STEP * f64::from(k);
        let [q, v, a] = motion(t);
        let effort = INERTIA * a - MOMENT * 9.81 * q.cos() + COULOMB * v.signum() + VISCOUS * v;
        writeln!(text, "{t:.4},{q},{}", effort + 0.02 * noise()).unwrap();
    }
    folder.write("model.toml", MODEL);
    folder.write("log.csv", &text);
    let run = |filter: &str| {
        json(
            folder
                .stiction(&["identify", "model.toml", "log.csv", "--filter", filter, "--json"])
                .succeeds(),
        )
    };
    // The inertias of body and rotor have the same effect.
    let inertia = |result: &Value| {
        let all = result["combinations"].as_array().unwrap();
        let own = all.iter().find(|c| c["name"].as_str().unwrap().contains("bar.iyy")).unwrap();
        [number(own, "value") - INERTIA, number(own, "filter_bias"), number(own, "sigma")]
    };
    let low = run("3.6 Hz");
    let [error, bias, sigma] = inertia(&low);
    assert!(error > 0.05 * INERTIA && error > sigma, "{error} {sigma}");
    // The amplitude at 3 Hz is 1/(1 + 0.414 (3/3.6)^8) = 0.91; the reported bias is accurate to
    // first order in the lost amplitude.
    assert!((bias / error - 1.0).abs() < 0.3, "{bias} {error}");
    let cautions = low["cautions"].to_string();
    assert!(cautions.contains("the filter removes part of the motion"), "{cautions}");
    let [error, bias, sigma] = inertia(&run("12 Hz"));
    assert!(error.abs() < 4.0 * sigma && bias.abs() < sigma, "{error} {bias} {sigma}");
}

/// Irregular time stamps, as of a busy computer, are reported and not mistaken for a delay.
#[test]
fn jitter_of_time_stamps_is_named() {
    let folder = Folder::new("identify-jitter");
    let mut jitter = normal(12);
    let text = log(1, effort);
    let rows = text.lines().map(|line| match line.split_once(',') {
        Some((time, rest)) if !line.starts_with('t') => {
            let late = (0.2 * STEP * jitter()).clamp(-0.45 * STEP, 0.45 * STEP);
            format!("{},{rest}\n", time.parse::<f64>().unwrap() + late)
        }
        _ => format!("{line}\n"),
    });
    let result = identified(&folder, &rows.collect::<String>(), "");
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains("steps of the time scatter by 1."), "{cautions}");
    assert!(is_empty(&result, "delays"), "{:#}", result["delays"]);
}

/// Friction effects that the model's law lacks are recognised and reported.
#[test]
fn other_laws_of_friction_are_named() {
    let folder = Folder::new("identify-laws");
    let slow = |t: f64| {
        let v = motion(t)[1];
        effort(t) + 0.5 * v.signum() * (-(v / 0.3).powi(2)).exp()
    };
    let quadratic = |t: f64| {
        let v = motion(t)[1];
        effort(t) + 0.1 * v * v.abs()
    };
    let warming = |t: f64| effort(t) - 0.25 * motion(t)[1].signum() * (t / 6.0 - 1.0);
    let drifting = |t: f64| effort(t) + 0.3 * (t / 6.0 - 1.0);
    let laws: [(&str, &dyn Fn(f64) -> f64); 4] = [
        ("Stribeck", &slow),
        ("friction at high speed", &quadratic),
        ("joints warm up", &warming),
        ("a drift of the effort", &drifting),
    ];
    for (words, law) in laws {
        let result = identified(&folder, &log(1, law), "");
        let first = result["missing"][0]["what"].to_string();
        assert!(first.contains(words), "{words}: {:#}", result["missing"]);
        assert_eq!(result["verdict"], "fits only", "{words}");
    }
}

/// Angles in degrees that are declared as radians, and times in milliseconds that are declared as
/// seconds, are reported.
#[test]
fn missing_units_of_positions_and_times_are_named() {
    let folder = Folder::new("identify-units");
    let text = log(1, effort);
    let changed = |head: &str, time: f64, angle: f64| {
        let rows = text.lines().skip(1).map(|line| {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            format!("\n{},{},{}", time * cells[0], angle * cells[1], cells[2])
        });
        format!("{head}{}", rows.collect::<String>())
    };
    let degrees = changed("time,hinge,M.motor_torque", 1.0, 180.0 / PI);
    let result = identified(&folder, &degrees, "");
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains("check the unit of the positions"), "{cautions}");
    let milliseconds = changed("time,hinge,M.motor_torque", 1000.0, 1.0);
    let result = identified_with(&folder, &milliseconds, "", "0.008 Hz");
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains("check the unit of the time"), "{cautions}");
}
