//! Tables for the robots of the gallery against results of independent programs.

use crate::common::*;
use stiction_core::dynamics::FrictionMode;

/// Reads a file of reference data by column; comment lines begin with `#`.
fn reference(file: &str) -> Csv {
    let path = format!("{}/../../reference/{file}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    Csv::parse(lines.join("\n").as_bytes())
}

/// Compares the columns of the reference that the tables contain in the same axes. Tests of
/// `stiction-core` compare the other columns.
#[test]
fn symmetric_3rps() {
    let model = model("3rps");
    let run = Run::of(&default_job(&model, FrictionMode::Off)).unwrap();
    let (drives, reactions) =
        (reference("3rps_symmetric_actuator.csv"), reference("3rps_symmetric_reactions.csv"));
    let compare = |found: &[f64], expected: &[f64], what: &str| {
        assert_eq!((found.len(), expected.len()), (101, 101), "{what}");
        let largest = expected.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        // Columns that vanish by symmetry are compared relative to typical joint forces of 10 N.
        let scale = if largest < 1e-9 { 10.0 } else { largest };
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() <= 1e-11 * scale, "{what}: {found} {expected}");
        }
    };
    compare(run.inverse.column("time [s]"), drives.column("t"), "t");
    for n in 1..=3 {
        let found = run.inverse.column(&format!("leg{n}.P.drive [N]"));
        compare(found, drives.column(&format!("tau{n}")), "drive");
        for axis in ["x", "y", "z"] {
            for (ours, unit, theirs) in
                [("S.f", "N", "FS"), ("R.f", "N", "FR"), ("R.m", "N m", "MR")]
            {
                let found = run.reactions.column(&format!("leg{n}.{ours}{axis} [{unit}]"));
                let column = format!("{theirs}{n}_{axis}");
                compare(found, reactions.column(&column), &column);
            }
        }
    }
}

/// Tests a slider-crank against reference values: crank angle in degrees, torque without and with
/// friction in N m, forces at A, B, C and perpendicular to the guide in N. Newton's method and a
/// fixed-point iteration for these values agree to 2.5e-14.
#[test]
fn slider_crank() {
    let rows: [[f64; 7]; 3] = [
        [30.0, -3.447334000, -3.050682842, 56.845662, 61.476467, 77.400784, 36.769097355],
        [60.0, -8.506718049, -7.801557188, 81.293050, 84.999450, 93.389043, 49.943387241],
        [210.0, 3.246730104, 3.537393733, 137.332221, 129.816773, 115.182916, 7.861372153],
    ];
    let model = model("slider-crank");
    let run = Run::of(&default_job(&model, FrictionMode::Converged)).unwrap();
    for [degrees, frictionless, drive, a, b, c, guide] in rows {
        // One sample per degree.
        let row = degrees as usize;
        let near = |column: &str, expected: f64| {
            let found = run.inverse.column(column)[row];
            assert!((found - expected).abs() < 1e-9, "{degrees} {column}: {found} {expected}");
        };
        near("A.drive [N m]", drive);
        near("A.drive_frictionless [N m]", frictionless);
        for (joint, expected) in [("A", a), ("B", b), ("C", c)] {
            let component = |axis| run.reactions.column(&format!("{joint}.f{axis} [N]"))[row];
            let found = component("x").hypot(component("y"));
            assert!((found - expected).abs() < 1e-6, "{degrees} {joint}: {found} {expected}");
            // The friction of the pin follows from its normal load.
            let friction = run.friction.column(&format!("{joint}.friction [N]"))[row];
            assert!((friction.abs() - 0.1 * found).abs() < 1e-9);
        }
        let across = run.reactions.column("guide.fy [N]")[row].abs();
        assert!((across - guide).abs() < 1e-8, "{degrees}: {across} {guide}");
    }
}

/// Tests the initial state of the motion, at which two programs agree to fifteen digits.
#[test]
fn planar_3rrr() {
    let model = model("3rrr");
    let run = Run::of(&default_job(&model, FrictionMode::Off)).unwrap();
    let expected = [16.80837220529022, -2.718582445783226, -9.500616292200838];
    for (n, expected) in expected.into_iter().enumerate() {
        let found = run.inverse.column(&format!("leg{}.R1.drive [N m]", n + 1))[0];
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
}

/// Tests all actuator forces of the regular variant of the printed robot in three friction modes,
/// with ten digits.
#[test]
fn regular_twin() {
    let model = model("zhang2018-regular");
    let path =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../reference/3rps_parallel_axis_regular_L0.csv");
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(','));
    let header: Vec<&str> = lines.next().unwrap().collect();
    let rows: Vec<Vec<&str>> = lines.map(Iterator::collect).collect();
    let place = |name: &str| header.iter().position(|cell| *cell == name).unwrap();
    let mut compared = 0;
    for (case, friction) in ["frictionless", "onepass", "converged"].into_iter().zip(MODES) {
        let run = Run::of(&job(&model, "regular", "L0", friction)).unwrap();
        let times = run.inverse.column("time [s]");
        for row in rows.iter().filter(|row| row[place("case")] == case) {
            let t: f64 = row[place("t")].parse().unwrap();
            let sample = times.iter().position(|time| (time - t).abs() < 1e-9).unwrap();
            for n in 1..=3 {
                let expected: f64 = row[place(&format!("tau{n}"))].parse().unwrap();
                let found = run.inverse.column(&format!("leg{n}.P.drive [N]"))[sample];
                assert!((found - expected).abs() < 5.1e-8, "{case} {t} {n}: {found} {expected}");
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 99);
}
