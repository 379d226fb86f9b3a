//! The output-error method: identification along motions that are simulated in the closed loop.

use super::{axis, normal, parameter};
use crate::program::{Folder, json};
use serde_json::Value;
use std::fmt::Write as _;

/// True values of the arm: inertia, kg m^2, Coulomb friction, N m, and viscous friction, N m s/rad.
const TRUTH: [(&str, f64); 3] = [("arm.izz", 0.02), ("axis.coulomb", 0.2), ("axis.viscous", 0.05)];
/// Gains of the arm's controller, N m/rad and N m s/rad, which is sampled every millisecond.
const GAINS: [f64; 2] = [50.0, 2.0];
/// Standard deviation of the encoder, rad, and of the measured effort, N m.
const NOISE: [f64; 2] = [1e-3, 0.02];
const OPTIONS: &str = "filter = \"40 Hz\"\nestimator = \"output-error\"\n\
                       controller = \"type = pd; period = 1 ms; kp = 50 N m/rad; kd = 2 N m s/rad\"\n";

/// Log of the arm in the closed loop, every second sample of the controller. Between two samples the effort is constant,
/// so the motion is known exactly; friction is reversed or holds the arm where the rate is zero.
fn log(seed: u64, columns: [bool; 2]) -> String {
    let mut noise = normal(seed);
    let [inertia, coulomb, viscous] = TRUTH.map(|(_, value)| value);
    let command = |t: f64| {
        let waves = [(0.5, 6.0, 0.0), (0.3, 14.4, 1.0), (0.08, 27.0, 2.0)];
        let sum = |of: &dyn Fn(f64, f64, f64) -> f64| {
            waves.iter().map(|&(a, w, p)| of(a, w, p)).sum::<f64>()
        };
        [sum(&|a, w, p| a * (w * t + p).sin()), sum(&|a, w, p| a * w * (w * t + p).cos())]
    };
    let [mut angle, mut rate] = command(0.0);
    let mut text = "time [s]".to_owned();
    let names = ["axis.reference [rad]", "axis [rad]"];
    let used = || columns.iter().enumerate().filter(|(_, used)| **used).map(|(k, _)| k);
    used().for_each(|k| write!(text, ",{}", names[k]).unwrap());
    text += ",axis.effort [N m]\n";
    for k in 0..6_000 {
        let t = 1e-3 * f64::from(k);
        let [reference, reference_rate] = command(t);
        let effort = GAINS[0] * (reference - angle) + GAINS[1] * (reference_rate - rate);
        if k % 2 == 0 {
            let measured = [reference, angle + NOISE[0] * noise()];
            write!(text, "{t:.3}").unwrap();
            used().for_each(|k| write!(text, ",{}", measured[k]).unwrap());
            writeln!(text, ",{}", effort + NOISE[1] * noise()).unwrap();
        }
        let mut left = 1e-3;
        while left > 0.0 {
            if rate == 0.0 && effort.abs() <= coulomb {
                break;
            }
            let direction = if rate == 0.0 { effort.signum() } else { rate.signum() };
            let final_rate = (effort - direction * coulomb) / viscous;
            let decay = viscous / inertia;
            let stops =
                (rate * final_rate < 0.0).then(|| ((final_rate - rate) / final_rate).ln() / decay);
            let (step, is_end) =
                stops.filter(|stop| *stop < left).map_or((left, false), |stop| (stop, true));
            let factor = (-decay * step).exp();
            angle += final_rate * step + (rate - final_rate) * (1.0 - factor) / decay;
            rate = if is_end { 0.0 } else { final_rate + (rate - final_rate) * factor };
            left -= step;
        }
    }
    text
}

const RUN: [&str; 5] = ["identify", "arm.toml", "log.csv", "--options", "options.toml"];

/// Error of each parameter in standard deviations.
fn errors(result: &Value) -> [f64; 3] {
    TRUTH.map(|(name, truth)| {
        let found = parameter(result, name);
        assert_eq!(found["verdict"], "identified", "{name}");
        let [value, sigma] = ["value", "sigma"].map(|key| found[key].as_f64().unwrap());
        (value - truth) / sigma
    })
}

/// The closed loop of a model with half as much inertia again and no friction leads to the true values, although noise of
/// the encoder biases least squares.
#[test]
fn the_closed_loop_is_identified_without_bias() {
    let folder = Folder::new("identify-closed-loop");
    folder.write("arm.toml", &axis(0.03));
    folder.write("options.toml", OPTIONS);
    let mut squares = [0.0; 3];
    const LOGS: u64 = 3;
    for seed in 1..=LOGS {
        folder.write("log.csv", &log(seed, [true, true]));
        let result = json(folder.stiction(&[&RUN[..], &["--json"]].concat()).succeeds());
        assert_eq!(result["estimator"], "output-error");
        for (sum, error) in squares.iter_mut().zip(errors(&result)) {
            assert!(error.abs() < 3.5, "seed {seed}: {error} standard deviations");
            *sum += error * error;
        }
        // The simulation differs from the measured motion by the part of the encoder's noise that the filter leaves: 40 of
        // 250 Hz.
        let own = &result["simulated"]["deviations"][0];
        assert!((own["rms"].as_f64().unwrap() / (0.4 * NOISE[0]) - 1.0).abs() < 0.2, "{own}");
    }
    // Three squares of errors with unit variance have a sum above 0.02 with a probability of 99.9 %, and below 16.3 with
    // the same probability.
    for sum in squares {
        assert!((0.02..16.3).contains(&sum), "{squares:?}");
    }
    // Plain least squares on the same log.
    folder.write("options.toml", "filter = \"40 Hz\"\n");
    let result = json(folder.stiction(&[&RUN[..], &["--json"]].concat()).succeeds());
    let found = parameter(&result, "arm.izz");
    let [value, sigma] = ["value", "sigma"].map(|key| found[key].as_f64().unwrap());
    assert!((value - TRUTH[0].1) / sigma < -4.0, "{value} +- {sigma}");
}

/// Commanded positions and efforts suffice: the simulation supplies the motion.
#[test]
fn measured_positions_are_not_needed() {
    let folder = Folder::new("identify-without-positions");
    folder.write("arm.toml", &axis(0.03));
    folder.write("options.toml", OPTIONS);
    folder.write("log.csv", &log(7, [true, false]));
    let result = json(folder.stiction(&[&RUN[..], &["--json"]].concat()).succeeds());
    assert!(errors(&result).iter().all(|error| error.abs() < 3.5), "{:#}", result["parameters"]);
    assert_eq!(result["simulated"]["deviations"].as_array().unwrap().len(), 0);
}

/// A controller with other gains moves the simulated robot differently than the real one; a caution says so.
#[test]
fn wrong_gains_are_noticed() {
    let folder = Folder::new("identify-wrong-gains");
    folder.write("arm.toml", &axis(0.03));
    folder.write("log.csv", &log(1, [true, true]));
    folder.write("options.toml", &OPTIONS.replace("kp = 50", "kp = 25"));
    let result = json(folder.stiction(&[&RUN[..], &["--json"]].concat()).succeeds());
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains("check the gains"), "{cautions}");
    assert_eq!(result["verdict"], "fits only");
}

#[test]
fn what_the_method_needs_is_named() {
    let folder = Folder::new("identify-closed-loop-needs");
    folder.write("arm.toml", &axis(0.03));
    let all = log(1, [true, true]);
    folder.write("log.csv", &all);
    let refused = |options: &str, words: &[&str]| {
        folder.write("options.toml", options);
        folder.stiction(&RUN).fails(2, words);
    };
    refused("estimator = \"output-error\"\n", &["`controller` is missing", "type = pd"]);
    refused("controller = \"pd\"\n", &["`controller` applies only to", "output-error"]);
    refused(&OPTIONS.replace("kp", "gain"), &["`controller` is not understood", "gain"]);
    refused(
        &format!("{OPTIONS}[terms]\nspring = \"axis = 1 N m/rad*axis\"\n"),
        &["`terms` cannot be simulated"],
    );
    folder.write("log.csv", &log(1, [false, true]));
    refused(OPTIONS, &["has no commanded motion", "`JOINT.reference [rad]`"]);
    // The sampled loop is unstable with these gains.
    folder.write("log.csv", &all);
    refused(
        &OPTIONS.replace("kd = 2", "kd = 200"),
        &["the closed loop cannot be simulated", "check `controller`"],
    );
}
