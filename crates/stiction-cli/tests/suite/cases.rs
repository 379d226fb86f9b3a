//! Cases with known answers in a folder beside the project: models, commands, and numbers from closed
//! forms, published tables or other programs.

use crate::program::{Folder, column};
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Runs that are known to fail, each by case and index. A run that begins to pass must be removed
/// here.
const KNOWN_FAILURES: &[(&str, usize)] = &[];

fn cases() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/cases");
    folder.is_dir().then_some(folder)
}

/// Returns the value at a path such as `mobility/finite` or `reach/0/body`.
fn at<'a>(json: &'a Value, path: &str) -> &'a Value {
    path.split('/').fold(json, |value, key| match key.parse::<usize>() {
        Ok(index) if value.is_array() => &value[index],
        _ => &value[key],
    })
}

/// Compares numbers within a relative tolerance; for numbers below 1e-3 the tolerance is absolute.
fn is_near(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance * expected.abs().max(1e-3)
}

fn agrees(found: &Value, expected: &Value, tolerance: f64) -> bool {
    match (found, expected) {
        (Value::Array(found), Value::Array(expected)) => {
            found.len() == expected.len()
                && found.iter().zip(expected).all(|(a, b)| agrees(a, b, tolerance))
        }
        (found, expected) => match (found.as_f64(), expected.as_f64()) {
            (Some(found), Some(expected)) => is_near(found, expected, tolerance),
            _ => found == expected,
        },
    }
}

/// Entry of a table in the column with this name (without its unit), at the sample nearest to a
/// time.
fn entry(table: &str, name: &str, time: f64) -> f64 {
    let header = table.lines().next().unwrap();
    let title = header.split(',').find(|cell| cell.split(" [").next() == Some(name));
    let values = column(table, title.unwrap_or_else(|| panic!("no column {name} in {header}")));
    let times = column(table, "time [s]");
    let nearest = (0..times.len())
        .min_by(|a, b| (times[*a] - time).abs().total_cmp(&(times[*b] - time).abs()));
    values[nearest.unwrap()]
}

/// Differences between the outcome of a run and the expected outcome, one per line.
fn differences(folder: &Folder, model: &Path, run: &Value) -> String {
    let command = run["command"].as_str().unwrap();
    let model = model.to_str().unwrap();
    let mut arguments = vec![command.to_owned(), model.to_owned()];
    for argument in run["arguments"].as_array().into_iter().flatten() {
        arguments.push(argument.as_str().unwrap().to_owned());
    }
    if command == "check" {
        arguments.push("--json".to_owned());
    } else {
        arguments.extend(["-o".to_owned(), "out".to_owned()]);
    }
    let said = folder.stiction(&arguments);
    let mut text = String::new();
    let exit = run["exit"].as_i64().unwrap_or(0);
    if i64::from(said.code) != exit {
        writeln!(text, "exit {} instead of {exit}: {}{}", said.code, said.out, said.err).unwrap();
        return text;
    }
    let tolerance = run["tolerance"].as_f64().unwrap_or(1e-6);
    for expect in run["expect"].as_array().unwrap() {
        let value = &expect["value"];
        if let Some(table) = expect["table"].as_str() {
            let table = folder.read(&format!("out/{table}.csv"));
            let name = expect["column"].as_str().unwrap();
            let found = entry(&table, name, expect["t"].as_f64().unwrap());
            if !is_near(found, value.as_f64().unwrap(), tolerance) {
                writeln!(text, "{name}: {found} instead of {value}").unwrap();
            }
        } else if let Some(key) = expect["key"].as_str() {
            let json: Value = serde_json::from_str(&said.out).unwrap();
            let found = at(&json, key);
            let range = expect["or_null_with"].as_str().map(|range| at(&json, range));
            let contains = |range: &Value| {
                let bound = |k: usize| range[k].as_f64().unwrap();
                let value = value.as_f64().unwrap();
                bound(0) <= value && value <= bound(1)
            };
            let is_undecided = found.is_null() && range.is_some_and(contains);
            if !is_undecided && !agrees(found, value, tolerance) {
                writeln!(text, "{key}: {found} instead of {value}").unwrap();
            }
        } else {
            let says = expect["says"].as_str().unwrap();
            if !said.out.contains(says) && !said.err.contains(says) {
                writeln!(text, "`{says}` is missing in {}{}", said.out, said.err).unwrap();
            }
        }
    }
    text
}

#[test]
fn known_answers_are_found() {
    let Some(cases) = cases() else {
        println!("skipped: there is no folder ../shared/cases beside the project");
        return;
    };
    let mut files: Vec<PathBuf> =
        fs::read_dir(&cases).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "json"));
    files.sort();
    let mut wrong = String::new();
    for path in files {
        let json: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
        let name = path.file_stem().unwrap().to_str().unwrap();
        for (index, run) in json["runs"].as_array().into_iter().flatten().enumerate() {
            let folder = Folder::new(&format!("case-{name}-{index}"));
            let found = differences(&folder, &path.with_extension("toml"), run);
            let is_known = KNOWN_FAILURES.contains(&(name, index));
            match (found.is_empty(), is_known) {
                (true, true) => {
                    writeln!(wrong, "{name} {index} passes now: remove it from the list").unwrap();
                }
                (false, false) => writeln!(wrong, "{name} {index}:\n{found}").unwrap(),
                _ => {}
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
