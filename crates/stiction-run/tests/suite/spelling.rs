//! Equivalent model files, with other notation, order or units, give the same actuator forces.

use crate::common::*;
use stiction_core::dynamics::FrictionMode;
use stiction_format::{ModelFile, gallery};

/// Returns all columns of actuator forces in a model's default run, by name.
fn drives(model: &ModelFile) -> Vec<(String, Vec<f64>)> {
    let run = Run::of(&default_job(model, FrictionMode::Converged)).unwrap();
    let drives = run.inverse.columns().filter(|(name, _)| name.contains(".drive"));
    drives.map(|(name, values)| (name.clone(), values.clone())).collect()
}

/// Compares a model's actuator forces with those of another text of the same model.
fn assert_same(name: &str, text: &str, what: &str) {
    let (expected, found) = (drives(&model(name)), drives(&model_of(name, text)));
    assert_eq!(expected.len(), found.len());
    for ((column, expected), (other, found)) in expected.iter().zip(&found) {
        assert_eq!(column, other);
        let largest = expected.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        for (expected, found) in expected.iter().zip(found) {
            let error = (expected - found).abs();
            assert!(error <= 1e-11 * largest, "{name} {what} {column}: {expected} {found}");
        }
    }
}

#[test]
fn the_order_of_bodies_and_joints_in_the_file_does_not_matter() {
    let mut changed = 0;
    for name in regular() {
        let text = gallery::get(name).unwrap();
        let turned = in_reverse(text);
        assert_ne!(turned, text);
        assert_same(name, &turned, "reversed");
        changed += 1;
    }
    assert_eq!(changed, regular().count());
}

#[test]
fn units_do_not_matter() {
    for name in regular() {
        let text = gallery::get(name).unwrap();
        let other = in_other_units(text);
        assert_ne!(other, text);
        assert_same(name, &other, "in other units");
    }
}
