//! Studies of many designs.

use crate::{GRAVITY, LENGTH, pendulum};
use stiction::format::Setting;
use stiction::run::sweep::Status;
use stiction::{FrictionMode, Robot, sweep};

fn numbers<const N: usize>(rows: &[[f64; N]]) -> Vec<[Setting; N]> {
    rows.iter().map(|row| row.map(Setting::Number)).collect()
}

/// A pendulum held at rest: its torque is m g l sin(angle), with masses and angles from a table.
#[test]
fn poses_of_a_pendulum_have_closed_forms() {
    let study = pendulum().sweep().unwrap().friction(FrictionMode::Off);
    let study = study
        .motion("duration = 0")
        .objective("peak(pivot.effort)")
        .objective("final(pivot.position)");
    let table = [[2000.0, 30.0], [500.0, -90.0], [1.0, 10.0]];
    let rows = sweep(&study, &["bob.mass [g]", "motion.pivot [deg]"], &numbers(&table)).unwrap();
    for (row, [mass, angle]) in rows.iter().zip(table) {
        assert!(row.status.is_ok(), "{}", row.status);
        let angle = angle.to_radians();
        let torque = (1e-3 * mass * GRAVITY * LENGTH * angle.sin()).abs();
        // A few rounding errors.
        assert!((row.values[0].unwrap() - torque).abs() <= 1e-14 * torque);
        assert!((row.values[1].unwrap() - angle).abs() <= 1e-15);
    }
}

/// Rows are bitwise equal to single runs with changed values, in whatever pieces the rows are
/// computed.
#[test]
fn rows_are_single_runs_in_any_pieces() {
    let robot = Robot::builtin("five-bar").unwrap();
    let study = robot
        .sweep()
        .unwrap()
        .objective("max(left_motor.drive)")
        .objective("min(distance.actuation)");
    let keys = ["crank [mm]", "tool.mass [kg]"];
    let table = numbers(&[[180.0, 0.5], [200.0, 0.7], [220.0, 0.9], [240.0, 1.1]]);
    let rows = sweep(&study, &keys, &table).unwrap();
    for (row, [crank, mass]) in rows.iter().zip(&table) {
        let changed = robot.with(&format!("crank = {crank} mm")).unwrap();
        let changed = changed.with(&format!("tool.mass = {mass} kg")).unwrap();
        let samples = changed.inverse().collect().unwrap();
        let efforts = samples.iter().map(|sample| sample.effort("left_motor").unwrap());
        let distances = samples.iter().map(|sample| sample.actuation_distance);
        let expected = [efforts.fold(f64::MIN, f64::max), distances.fold(f64::MAX, f64::min)];
        assert_eq!(row.values, expected.map(Some));
    }
    let pieces: Vec<_> =
        table.chunks(1).rev().flat_map(|piece| sweep(&study, &keys, piece).unwrap()).collect();
    assert!(pieces.iter().rev().eq(&rows));
    let study = study
        .study(keys.map(|key| stiction::format::Key::of_header(key).unwrap()).to_vec())
        .unwrap();
    for threads in [1, 2, 5] {
        let mut found = Vec::new();
        let designs = table.iter().map(|row| Ok(row.to_vec()));
        study
            .run(designs, threads.try_into().unwrap(), |settings, row| {
                assert_eq!(settings, table[found.len()]);
                found.push(row);
                Ok(true)
            })
            .unwrap();
        assert_eq!(found, rows, "{threads} threads");
    }
}

/// A failed design has a reason, and the other designs have results.
#[test]
fn failures_stay_in_their_rows() {
    let robot = Robot::builtin("five-bar").unwrap();
    let study = robot.sweep().unwrap().objective("peak(left_motor.effort)");
    let table = ["200 mm", "1 mm", "3 kg", "", "-1 m"].map(|text| [Setting::Text(text.to_owned())]);
    let rows = sweep(&study, &["crank"], &table).unwrap();
    let words: Vec<String> = rows.iter().map(|row| row.status.to_string()).collect();
    assert_eq!(words[0], "ok");
    assert!(words[1].starts_with("no answer: at t = 0 s: "), "{}", words[1]);
    assert_eq!(
        words[2],
        "failed: expected a length such as \"128.48 mm\" or a bare number in m, found a mass \
         (five-bar.toml:14:9)"
    );
    // An empty text keeps the value of the model, 200 mm.
    assert_eq!(rows[3], rows[0]);
    assert!(rows[4].status.is_failed());
    for row in &rows {
        assert_eq!(row.values[0].is_some(), !row.status.is_failed());
        assert_eq!(
            Status::parse(&row.status.to_string()).unwrap().to_string(),
            row.status.to_string()
        );
    }
}

/// An error that concerns the whole study is reported before the first row.
#[test]
fn defective_studies_are_refused() {
    let robot = Robot::builtin("five-bar").unwrap();
    let base = robot.sweep().unwrap();
    let peak = base.clone().objective("peak(left_motor.effort)");
    let row = numbers(&[[1.0]]);
    let said =
        |study: &stiction::Sweep, key: &str| sweep(study, &[key], &row).unwrap_err().to_string();
    assert!(said(&base, "crank").contains("no objective"));
    assert!(said(&peak, "cranc").contains("did you mean `crank`?"));
    assert!(said(&peak, "crank [furlong]").contains("furlong"));
    assert!(said(&peak.clone().objective("peak(x)"), "crank").contains("no column `x`"));
    assert!(said(&peak.clone().motion("circl"), "crank").contains("circl"));
    assert!(said(&peak.clone().motion("log.csv"), "motion.x").contains("which has no keys"));
    assert!(said(&peak.clone().step(-1.0), "crank").contains("between samples"));
    let error = sweep(&peak, &["crank", "tool.mass"], &row).unwrap_err();
    assert_eq!(error.message(), "row 1 has 1 values for 2 keys");
    let described = Robot::from(robot.mechanism().clone());
    assert!(described.sweep().is_err());
}

/// Objectives may be columns with equal names in several tables, and components of vectors.
#[test]
fn objectives_name_columns_of_all_tables() {
    let robot = Robot::builtin("3rps").unwrap();
    let texts = [
        "peak(leg1.P.power)",
        "peak(friction:leg1.P.power)",
        "max(leg2.S.reaction.force)",
        "max(leg2.S.fx)",
        "max(leg2.S.fy [N])",
        "max(reactions.csv:leg2.S.fz)",
        "range(leg1.length)",
        "work(leg1.P.power)",
        "peak(platform.vz)",
    ];
    let study = texts.iter().fold(robot.sweep().unwrap(), |study, text| study.objective(*text));
    let study = study
        .friction(FrictionMode::Converged)
        .motion("platform.z = 550 mm + 20 mm*t; platform.rx = 0; platform.ry = 0; duration = 0");
    let rows = sweep(&study, &["home_height [mm]"], &numbers(&[[550.0]])).unwrap();
    assert!(rows[0].status.is_ok(), "{}", rows[0].status);
    let values: Vec<f64> = rows[0].values.iter().map(|value| value.unwrap()).collect();
    assert_ne!(values[0], values[1]);
    // One pose: the force is the length of its components.
    let force = values[3].hypot(values[4]).hypot(values[5]);
    assert!((values[2] - force).abs() <= 1e-15 * force);
    assert_eq!((values[6], values[7], values[8]), (0.0, 0.0, 0.02));
}
