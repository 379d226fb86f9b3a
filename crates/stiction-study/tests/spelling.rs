//! What is said in other words, in another order or in other units gives the same driving forces.

mod common;

use common::*;
use stiction::dynamics::FrictionMode;
use stiction_model::{Model, gallery};

/// All drive columns of a model's default job by name.
fn drives(model: &Model) -> Vec<(String, Vec<f64>)> {
    let run = Run::of(&default_job(model, FrictionMode::Converged)).unwrap();
    let drives = run.inverse.columns().filter(|(name, _)| name.contains(".drive"));
    drives.map(|(name, values)| (name.clone(), values.clone())).collect()
}

/// Compares a model's drives with those of another text of the same model.
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

/// The tables of a file, each with its header.
fn tables(text: &str) -> (String, Vec<String>) {
    let mut head = String::new();
    let mut tables: Vec<String> = Vec::new();
    for line in text.lines() {
        if line.starts_with('[') {
            tables.push(String::new());
        }
        let part = tables.last_mut().unwrap_or(&mut head);
        part.push_str(line);
        part.push('\n');
    }
    (head, tables)
}

#[test]
fn the_order_of_bodies_and_joints_in_the_file_does_not_matter() {
    let mut changed = 0;
    for name in regular() {
        let text = gallery::get(name).unwrap();
        let (head, mut tables) = tables(text);
        // Places of legs are numbered by their order, so these keep it.
        let is_free = |table: &String| !table.starts_with("[[");
        let mut reversed: Vec<String> =
            tables.iter().filter(|t| is_free(t)).rev().cloned().collect();
        reversed.extend(tables.drain(..).filter(|table| !is_free(table)));
        let turned = head + &reversed.concat();
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

/// Every quantity that is a number with a unit, in a smaller or larger unit of the same kind.
fn in_other_units(text: &str) -> String {
    let pairs = [
        ("kg mm^2", "g mm^2", 1e3),
        ("kg m^2", "kg mm^2", 1e6),
        ("kg/m", "g/mm", 1.0),
        ("kg", "g", 1e3),
        ("mm", "m", 1e-3),
        ("m", "mm", 1e3),
        ("kN", "N", 1e3),
        ("N", "mN", 1e3),
        ("ms", "s", 1e-3),
        ("s", "ms", 1e3),
    ];
    let mut out = String::new();
    for line in text.lines() {
        // Only quoted texts that are nothing but a quantity: expressions have units amid names.
        for (k, part) in line.split('"').enumerate() {
            let quoted = k % 2 == 1;
            let quantity = part.split_once(' ').and_then(|(number, unit)| {
                let value: f64 = number.parse().ok()?;
                let (_, other, factor) = pairs.iter().find(|(from, _, _)| *from == unit)?;
                Some(format!("{} {other}", value * factor))
            });
            let text = quantity.filter(|_| quoted).unwrap_or_else(|| part.to_owned());
            if k > 0 {
                out.push('"');
            }
            out.push_str(&text);
        }
        out.push('\n');
    }
    out
}
