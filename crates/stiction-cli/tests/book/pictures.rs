//! Comparison of the book's pictures with outputs of the program and with curves of its tables.

use crate::program::Folder;
use crate::{book, renewed};
use std::fs;
use stiction_draw::figure::{Figure, Line, Panel};

/// Tolerance of coordinates, px. They are written with at least one decimal, whose rounding may
/// differ between machines.
const ROUNDING: f64 = 0.15;

/// Checks `NAME.svg: FILE` or `NAME.svg: error of JOINT in FILE, FILE`, with files in the folder of
/// the page.
pub(crate) fn check(folder: &Folder, wish: &str, page: &str) {
    let (name, source) = wish.split_once(": ").unwrap_or_else(|| panic!("{page}: {wish}"));
    let own = match source.strip_prefix("error of ").and_then(|rest| rest.split_once(" in ")) {
        None => folder.read(source),
        Some((joint, files)) => {
            let lines = files.split(", ").enumerate().map(|(colour, file)| Line {
                label: file.split('/').next().unwrap().replace('_', " "),
                points: errors(&folder.read(file), joint),
                colour,
                dashed: false,
            });
            let y_label = format!("error of {joint} [mm]");
            let panel = Panel { y_label, lines: lines.collect(), ..Panel::default() };
            Figure { title: String::new(), x_label: "time [s]".into(), panels: vec![panel] }.svg()
        }
    };
    let path = book().join("pictures").join(name);
    if renewed() {
        fs::write(&path, &own).unwrap();
    }
    let known = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(same(&known, &own), "{page}: {name} is out of date: `cargo xtask book` renews it");
}

/// Tracking error of a prismatic joint over time, mm, from a simulation's table.
fn errors(table: &str, joint: &str) -> Vec<(f64, f64)> {
    let mut rows = table.lines();
    let names: Vec<&str> = rows.next().unwrap().split(',').collect();
    let place = |what: &str| {
        let name = format!("{joint}.{what} [m]");
        names.iter().position(|known| *known == name).unwrap_or_else(|| panic!("no {name}"))
    };
    let (position, wanted) = (place("position"), place("reference"));
    let point = |row: &str| {
        let numbers: Vec<f64> = row.split(',').map(|entry| entry.parse().unwrap()).collect();
        (numbers[0], 1e3 * (numbers[position] - numbers[wanted]))
    };
    rows.map(point).collect()
}

/// Tests if two texts differ only in the rounding of numbers.
fn same(a: &str, b: &str) -> bool {
    let (a, b) = (parts(a), parts(b));
    a.len() == b.len()
        && a.iter().zip(&b).all(|(a, b)| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(a), Ok(b)) => (a - b).abs() <= ROUNDING,
            _ => a == b,
        })
}

/// Splits a text into numbers and the text between them.
fn parts(text: &str) -> Vec<&str> {
    let is_of_number = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
    let mut parts = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let end = rest.find(|c| is_of_number(c) != is_of_number(first)).unwrap_or(rest.len());
        parts.push(&rest[..end]);
        rest = &rest[end..];
    }
    parts
}

#[test]
fn pictures_are_compared() {
    assert!(same("<g x='1.04'/>", "<g x='1.0'/>"));
    assert!(!same("<g x='1.04'/>", "<g x='1.4'/>"));
    assert!(!same("<g x='1'/>", "<g y='1'/>"));
    assert!(!same("<g/>", "<g/><g/>"));
    assert_eq!(errors("t,a.position [m],a.reference [m]\n0,3,1\n", "a"), [(0.0, 2000.0)]);
}
