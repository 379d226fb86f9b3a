//! Identification of a single axis: dwells, bounds, and efforts of the wrong sign.

use super::{axis, normal, parameter};
use crate::program::{Folder, json};
use serde_json::Value;
use std::fmt::Write as _;

const COULOMB: f64 = 2.0;
const VISCOUS: f64 = 0.5;

/// Moves of one second and one radian, forward and backward, with dwells of one second between
/// them. During a dwell, the controller lets the arm creep by less than the noise of the encoder,
/// and the effort can have any value within the limits of static friction.
fn log(seed: u64, sign: f64) -> String {
    let (mut noise, step) = (normal(seed), 2e-3);
    let mut text = "time [s],axis [rad],axis.effort [N m]\n".to_owned();
    for k in 0..10_000 {
        let t = step * f64::from(k);
        let (period, u) = ((t / 2.0).floor(), (t % 2.0).min(1.0));
        let forth = if period % 2.0 == 0.0 { 1.0 } else { -1.0 };
        let shape = u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u);
        let mut angle = if forth > 0.0 { shape } else { 1.0 - shape };
        let rate = forth * 30.0 * (u * (1.0 - u)).powi(2);
        let acceleration = forth * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u);
        let effort = if u < 1.0 {
            0.02 * acceleration + COULOMB * forth + VISCOUS * rate
        } else {
            angle += 3e-4 * (2.0 * t).sin();
            // The effort differs between dwells.
            0.9 * COULOMB * (7.0 * period).sin()
        };
        let angle = angle + 2e-4 * noise();
        writeln!(text, "{t:.3},{angle},{}", sign * (effort + 0.02 * noise())).unwrap();
    }
    text
}

fn identified(folder: &Folder, logs: &[&str], more: &[&str]) -> Value {
    let arguments = ["--filter", "10 Hz", "--json"];
    let run = [&["identify", "arm.toml"], logs, &arguments, more].concat();
    json(folder.stiction(&run).succeeds())
}

/// Friction at rest is only bounded: dwells are recognised from the noise of the positions,
/// excluded and counted.
#[test]
fn dwells_are_left_out() {
    let folder = Folder::new("identify-dwells");
    folder.write("arm.toml", &axis(0.02));
    folder.write("log.csv", &log(1, 1.0));
    let result = identified(&folder, &["log.csv"], &[]);
    for (name, truth) in [("axis.coulomb", COULOMB), ("axis.viscous", VISCOUS)] {
        let found = parameter(&result, name);
        let (value, sigma) = (found["value"].as_f64().unwrap(), found["sigma"].as_f64().unwrap());
        // The filter smooths the steps of friction at both ends of each move; these rows are
        // excluded, too.
        assert!((value - truth).abs() < 3.0 * sigma, "{name}: {value} +- {sigma}");
        assert!(sigma < 0.05 * truth, "{name}: {value} +- {sigma}");
    }
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains("because a joint is at rest there"), "{cautions}");
}

/// Efforts of the wrong sign are detected although the model has no friction, also in logs for
/// prediction.
#[test]
fn wrong_signs_without_friction_in_the_model() {
    let folder = Folder::new("identify-sign-arm");
    folder.write("arm.toml", &axis(0.02));
    folder.write("good.csv", &log(1, 1.0));
    folder.write("bad.csv", &log(2, -1.0));
    let text = "efforts have the wrong sign on axis";
    let wrong = identified(&folder, &["bad.csv"], &[]);
    assert!(wrong["cautions"].to_string().contains(text), "{:#}", wrong["cautions"]);
    assert_eq!(wrong["verdict"], "failed");
    folder.write("options.toml", "[[logs]]\nfile = \"bad.csv\"\nuse = \"predict\"\n");
    let predicted = identified(&folder, &["good.csv", "bad.csv"], &["--options", "options.toml"]);
    let cautions = predicted["cautions"].to_string();
    assert!(cautions.contains(&format!("bad.csv: {text}")), "{cautions}");
    assert_ne!(predicted["verdict"], "failed", "{cautions}");
}

/// Checks that dwells whose efforts exceed the static friction limit, as with a brake, are
/// reported, and that dwells within the limit are not.
#[test]
fn dwells_bound_friction() {
    let folder = Folder::new("identify-bounds");
    folder.write("arm.toml", &axis(0.02));
    let text = "an effort lies beyond the static friction limits";
    // The efforts during dwells, at most 1.8 N m, are multiplied by three; half of them clearly
    // exceed 2 N m.
    let good = log(1, 1.0);
    let rows = good.lines().map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        let time: f64 = cells[0].parse().unwrap_or(0.0);
        match time % 2.0 > 1.02 && time % 2.0 < 1.98 {
            true => {
                format!("{},{},{}\n", cells[0], cells[1], 3.0 * cells[2].parse::<f64>().unwrap())
            }
            false => format!("{line}\n"),
        }
    });
    folder.write("brake.csv", &rows.collect::<String>());
    folder.write("good.csv", &good);
    let cautions = identified(&folder, &["good.csv"], &[])["cautions"].to_string();
    assert!(!cautions.contains(text), "{cautions}");
    // The value of a formula at rest is unknown, so dwells set no limits and are only counted.
    folder.write("term.toml", "[terms]\nspring = \"axis = 0.1 N m*sin(axis)\"\n");
    let open = identified(&folder, &["good.csv"], &["--options", "term.toml"]);
    let cautions = open["cautions"].to_string();
    assert!(cautions.contains("give no bounds on static friction"), "{cautions}");
    let result = identified(&folder, &["brake.csv"], &[]);
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains(text) && cautions.contains("dwells are left out"), "{cautions}");
    let found = parameter(&result, "axis.coulomb");
    let (value, sigma) = (found["value"].as_f64().unwrap(), found["sigma"].as_f64().unwrap());
    // The moves determine the value.
    assert!((value - COULOMB).abs() < 3.0 * sigma.max(0.01), "{value} +- {sigma}");
}

/// Checks that the factor of a term of the options is identified if the log contains its effect.
#[test]
fn the_factor_of_a_term_is_identified() {
    const SPRING: f64 = 5.0;
    let folder = Folder::new("identify-term");
    folder.write("arm.toml", &axis(0.02));
    let with_spring = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let (angle, effort) = (cells[1].parse::<f64>().ok()?, cells[2].parse::<f64>().ok()?);
        Some(format!("{},{angle},{}\n", cells[0], effort + SPRING * angle.sin()))
    };
    let rows = log(1, 1.0)
        .lines()
        .map(|line| with_spring(line).unwrap_or_else(|| format!("{line}\n")))
        .collect::<String>();
    folder.write("spring.csv", &rows);
    folder.write("term.toml", "[terms]\nspring = \"axis = 1 N m*sin(axis)\"\n");
    let result = identified(&folder, &["spring.csv"], &["--options", "term.toml"]);
    let found = parameter(&result, "spring");
    let (value, sigma) = (found["value"].as_f64().unwrap(), found["sigma"].as_f64().unwrap());
    assert!((value - SPRING).abs() < 4.0 * sigma && sigma < 0.5, "{value} +- {sigma}");
    assert_eq!(found["verdict"], "identified", "{found}");
}

/// A bound that contradicts the log is respected and reported.
#[test]
fn bounds_hold_and_are_named() {
    let folder = Folder::new("identify-bounds-named");
    folder.write("arm.toml", &axis(0.02));
    folder.write("log.csv", &log(1, 1.0));
    let options = |text: &str| folder.write("options.toml", &format!("[bounds]\n{text}\n"));
    options("\"*.coulomb\" = [2.5, 4]");
    let result = identified(&folder, &["log.csv"], &["--options", "options.toml"]);
    let found = parameter(&result, "axis.coulomb");
    assert!((found["value"].as_f64().unwrap() - 2.5).abs() < 1e-12, "{found}");
    assert_eq!(found["verdict"], "fits only");
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains("axis.coulomb lies at its bound 2.5 N m"), "{cautions}");
    // A value does not lie at a bound that is infinite.
    options("\"*.coulomb\" = [0, inf]\n\"arm.mass\" = [0, inf]");
    let result = identified(&folder, &["log.csv"], &["--options", "options.toml"]);
    let cautions = result["cautions"].to_string();
    assert!(!cautions.contains("lies at its bound"), "{cautions}");
    let run = ["identify", "arm.toml", "log.csv", "--filter", "10 Hz", "--options", "options.toml"];
    for (text, expected) in [
        ("\"axis.coulomb\" = [4, 2.5]", "two numbers, the least and the greatest value"),
        ("\"axis.coulomb\" = [inf, inf]", "two numbers, the least and the greatest value"),
        ("\"axis.coulomb\" = [-4, -2.5]", "leave no value for `axis.coulomb`"),
        ("\"axis.columb\" = [0, 1]", "no parameter matches `axis.columb` of `bounds`"),
        ("\"arm.mass\" = [2, 3]", "the fit begins at the value of the model, 1 kg"),
    ] {
        options(text);
        folder.stiction(&run).fails(2, &[expected]);
    }
}
