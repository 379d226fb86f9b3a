//! Instrumental variables remove the bias that is caused by noise in the measured motion.

use super::{axis, normal, parameter};
use crate::program::{Folder, json};
use serde_json::Value;
use std::fmt::Write as _;

/// True inertia of the arm, which is less than that of its model.
const INERTIA: f64 = 0.02;
const COULOMB: f64 = 0.2;
const VISCOUS: f64 = 0.05;
/// Standard deviation of the encoder, rad. Filtered at 40 Hz, the noise causes accelerations of 11
/// rad/s^2, compared with 46 rad/s^2 of the motion: least squares then underestimates the inertia
/// by 5 %.
const NOISE: f64 = 1e-3;

/// Log with commanded and measured positions; the measured motion has a delay and a smaller
/// amplitude.
fn log(seed: u64) -> String {
    let mut noise = normal(seed);
    let mut text = "time [s],axis.reference [rad],axis [rad],axis.effort [N m]\n".to_owned();
    let waves = [(0.5, 6.0, 0.0), (0.3, 14.4, 1.0), (0.08, 27.0, 2.0)];
    for k in 0..5000 {
        let t = 2e-3 * f64::from(k);
        let [mut reference, mut angle, mut rate, mut acceleration] = [0.0; 4];
        for (size, w, phase) in waves {
            reference += size * f64::sin(w * t + phase);
            let (size, phase) = (0.95 * size, w * t + phase - 0.2);
            angle += size * phase.sin();
            rate += size * w * phase.cos();
            acceleration -= size * w * w * phase.sin();
        }
        let effort = INERTIA * acceleration + COULOMB * f64::signum(rate) + VISCOUS * rate;
        let (angle, effort) = (angle + NOISE * noise(), effort + 0.02 * noise());
        writeln!(text, "{t:.3},{reference},{angle},{effort}").unwrap();
    }
    text
}

fn identified(folder: &Folder, estimator: &str) -> Value {
    folder.write("options.toml", &format!("filter = \"40 Hz\"\nestimator = \"{estimator}\"\n"));
    let run = ["identify", "arm.toml", "log.csv", "--options", "options.toml", "--json"];
    json(folder.stiction(&run).succeeds())
}

/// Error of the inertia in standard deviations, and the standard deviation relative to the inertia.
fn error(result: &Value) -> [f64; 2] {
    let found = parameter(result, "arm.izz");
    let [value, sigma] = ["value", "sigma"].map(|key| found[key].as_f64().unwrap());
    [(value - INERTIA) / sigma, sigma / INERTIA]
}

/// Noise of the accelerations biases least squares by more than three standard deviations in each
/// of five logs. The errors of instrumental variables have no common sign and agree with their
/// standard deviations.
#[test]
fn instruments_remove_the_bias_of_noise() {
    let folder = Folder::new("identify-instruments");
    folder.write("arm.toml", &axis(0.03));
    let mut all = Vec::new();
    for seed in 1..=5 {
        folder.write("log.csv", &log(seed));
        let [plain, sigma] = error(&identified(&folder, "least-squares"));
        assert!(plain < -3.0, "seed {seed}: {plain} standard deviations of {sigma}");
        let result = identified(&folder, "instrumental-variables");
        assert_eq!(result["estimator"], "instrumental-variables");
        let [unbiased, sigma] = error(&result);
        assert!(unbiased.abs() < 3.0, "seed {seed}: {unbiased} standard deviations of {sigma}");
        // The standard deviation is not large either: it is below a third of the bias of least
        // squares.
        assert!(sigma < 0.017, "seed {seed}: {sigma}");
        all.push(unbiased);
        for (name, truth) in [("axis.coulomb", COULOMB), ("axis.viscous", VISCOUS)] {
            let found = parameter(&result, name);
            let [value, sigma] = ["value", "sigma"].map(|key| found[key].as_f64().unwrap());
            assert!((value - truth).abs() < 3.0 * sigma, "seed {seed} {name}: {value} +- {sigma}");
        }
    }
    let mean = all.iter().sum::<f64>() / 5.0;
    // Three standard errors of the mean of five values.
    assert!(mean.abs() < 3.0 / 5.0_f64.sqrt(), "{all:?}");
}

/// Without a commanded motion there are no instruments; the message names the missing column.
#[test]
fn instruments_need_a_commanded_motion() {
    let folder = Folder::new("identify-without-instruments");
    folder.write("arm.toml", &axis(0.03));
    folder.write("log.csv", &log(1).replace("axis.reference [rad]", "command"));
    folder.write(
        "options.toml",
        "estimator = \"instrumental-variables\"\nfilter = \"40 Hz\"\n[columns]\ncommand = \"\"\n",
    );
    let run = ["identify", "arm.toml", "log.csv", "--options", "options.toml"];
    folder.stiction(&run).fails(2, &["has no commanded motion", "`JOINT.reference [rad]`"]);
    // The column may have any name.
    folder.write(
        "options.toml",
        "estimator = \"instrumental-variables\"\nfilter = \"40 Hz\"\n[columns]\n\
         command = \"axis.reference [rad]\"\n",
    );
    let result = json(folder.stiction(&[&run[..], &["--json"]].concat()).succeeds());
    assert!(error(&result)[0].abs() < 3.0, "{:#}", result["parameters"]);
}
