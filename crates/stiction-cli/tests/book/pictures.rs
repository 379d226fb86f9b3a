//! Pictures of the book are what the program writes, or curves of its tables.

use crate::program::Folder;
use crate::{book, renewed};
use std::fs;
use stiction_study::figure::{Figure, Line, Panel};

/// Coordinates are written to a tenth or finer: rounding may differ by one between machines.
const ROUNDING: f64 = 0.15;

/// Checks `NAME.svg: FILE` or `NAME.svg: COLUMN of FILE, FILE`, files lying in the page's folder.
pub(crate) fn check(folder: &Folder, wish: &str, page: &str) {
    let (name, source) = wish.split_once(": ").unwrap_or_else(|| panic!("{page}: {wish}"));
    let own = match source.split_once(" of ") {
        None => folder.read(source),
        Some((column, files)) => {
            let lines = files.split(", ").enumerate().map(|(colour, file)| Line {
                label: file.split('/').next().unwrap().replace('_', " "),
                points: curve(&folder.read(file), column),
                colour,
                dashed: false,
            });
            let panel = Panel { y_label: column.into(), lines: lines.collect() };
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

/// A column of a table over its first. `A - B` is the difference of two.
fn curve(table: &str, column: &str) -> Vec<(f64, f64)> {
    let mut rows = table.lines();
    let names: Vec<&str> = rows.next().unwrap().split(',').collect();
    let unit = |text: &str| text[text.find('[').unwrap()..].to_owned();
    let terms: Vec<String> = match column.split_once(" - ") {
        Some((first, second)) => vec![format!("{first} {}", unit(second)), second.into()],
        None => vec![column.into()],
    };
    let places: Vec<usize> = terms
        .iter()
        .map(|term| names.iter().position(|name| name == term).unwrap_or_else(|| panic!("{term}")))
        .collect();
    let point = |row: &str| {
        let numbers: Vec<f64> =
            row.split(',').map(|entry| entry.parse().unwrap_or(f64::NAN)).collect();
        let value = numbers[places[0]] - places.get(1).map_or(0.0, |place| numbers[*place]);
        (numbers[0], value)
    };
    rows.map(point).collect()
}

/// Whether two texts differ in nothing but the rounding of numbers.
fn same(a: &str, b: &str) -> bool {
    let (a, b) = (parts(a), parts(b));
    a.len() == b.len()
        && a.iter().zip(&b).all(|(a, b)| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(a), Ok(b)) => (a - b).abs() <= ROUNDING,
            _ => a == b,
        })
}

/// Numbers, and what is between them.
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
fn pictures_are_told_apart() {
    assert!(same("<g x='1.04'/>", "<g x='1.0'/>"));
    assert!(!same("<g x='1.04'/>", "<g x='1.4'/>"));
    assert!(!same("<g x='1'/>", "<g y='1'/>"));
    assert!(!same("<g/>", "<g/><g/>"));
    assert_eq!(curve("t,a [m],b [m]\n0,3,1\n", "a - b [m]"), [(0.0, 2.0)]);
}
