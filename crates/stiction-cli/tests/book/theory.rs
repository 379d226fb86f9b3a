//! Checks that the theory names, for each numbered equation, the file that computes the equation
//! and cites it, and a test that evaluates it.
//!
//! Equations are lines of `text` blocks that end with a label like `(K3)`: a letter for the page
//! and a number. Table rows that begin with such labels name the file and the tests.

use crate::{book, pages};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

/// Row of a table: the code and the tests of equations.
#[derive(Debug)]
struct Row {
    page: String,
    equations: Vec<String>,
    code: Vec<String>,
    /// File and function of each test.
    tests: Vec<(String, String)>,
}

/// Labels like `(K3)` in a text.
fn marks(text: &str) -> Vec<String> {
    let inner = text.split('(').skip(1).filter_map(|rest| rest.split_once(')'));
    let is_mark = |mark: &str| {
        let mut signs = mark.chars();
        signs.next().is_some_and(|sign| "KMBFRDEGPLIX".contains(sign))
            && signs.clone().next().is_some()
            && signs.all(|sign| sign.is_ascii_digit())
    };
    inner.map(|(mark, _)| mark.to_owned()).filter(|mark| is_mark(mark)).collect()
}

/// Texts between backquotes.
fn quoted(text: &str) -> Vec<String> {
    text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// All equations with their pages, and the rows of all tables.
fn read() -> (BTreeMap<String, String>, Vec<Row>) {
    let (mut equations, mut rows) = (BTreeMap::new(), Vec::new());
    for path in pages() {
        let page = path.file_name().unwrap().to_string_lossy().into_owned();
        if !page.starts_with("theory") && page != "friction.md" {
            continue;
        }
        let mut fenced = false;
        for line in fs::read_to_string(&path).unwrap().lines() {
            if line.starts_with("```") {
                fenced = !fenced;
            } else if fenced {
                let last = line.trim_end().rsplit("  ").next().unwrap_or("");
                for mark in marks(last).into_iter().filter(|mark| last == format!("({mark})")) {
                    let twice = equations.insert(mark.clone(), page.clone());
                    assert!(twice.is_none(), "{page}: ({mark}) is there twice");
                }
            } else if line.starts_with("| (") {
                let cells: Vec<&str> = line.trim_matches('|').split('|').collect();
                assert_eq!(cells.len(), 3, "{page}: {line}");
                let tests = quoted(cells[2]);
                assert!(tests.len().is_multiple_of(2) && !tests.is_empty(), "{page}: {line}");
                rows.push(Row {
                    page: page.clone(),
                    equations: marks(cells[0]),
                    code: quoted(cells[1]),
                    tests: tests.chunks(2).map(|two| (two[0].clone(), two[1].clone())).collect(),
                });
            }
        }
    }
    (equations, rows)
}

fn crates() -> PathBuf {
    book().join("../../crates")
}

#[test]
fn equations_have_code_and_tests() {
    let (equations, rows) = read();
    assert!(equations.len() > 30, "the theory has equations");
    let mut wrong = Vec::new();
    let mut known = BTreeSet::new();
    for row in &rows {
        let place = format!("{}: {:?}", row.page, row.equations);
        for mark in &row.equations {
            known.insert(mark.clone());
            if equations.get(mark) != Some(&row.page) {
                wrong.push(format!("{place}: ({mark}) is not on this page"));
            }
        }
        let sources: String = row
            .code
            .iter()
            .map(|file| match fs::read_to_string(crates().join(file)) {
                Ok(source) => source,
                Err(error) => {
                    wrong.push(format!("{place}: {file}: {error}"));
                    String::new()
                }
            })
            .collect();
        for mark in &row.equations {
            if !sources.contains(&format!("({mark})")) {
                wrong.push(format!("{place}: no file of {:?} cites ({mark})", row.code));
            }
        }
        for (file, test) in &row.tests {
            let source = fs::read_to_string(crates().join(file)).unwrap_or_default();
            let lines: Vec<&str> = source.lines().map(str::trim).collect();
            // The line of a property test does not end after the name, because the test has
            // arguments.
            let at = lines.iter().position(|line| line.starts_with(&format!("fn {test}(")));
            if !at.is_some_and(|at| at > 0 && lines[at - 1] == "#[test]") {
                wrong.push(format!("{place}: {test} is no test of {file}"));
            }
        }
    }
    let lost = equations.keys().filter(|mark| !known.contains(*mark));
    wrong.extend(lost.map(|mark| format!("({mark}) has neither code nor test")));
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Every equation that the code cites is in the book.
#[test]
fn citations_have_equations() {
    let (equations, _) = read();
    let mut wrong = Vec::new();
    let mut folders = vec![crates(), crates().join("../studies")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs")
                && path.components().any(|part| part.as_os_str() == "src")
            {
                let source = fs::read_to_string(&path).unwrap();
                for line in source.lines().filter(|line| line.trim_start().starts_with("//")) {
                    let unknown =
                        marks(line).into_iter().filter(|mark| !equations.contains_key(mark));
                    wrong.extend(unknown.map(|mark| format!("{}: ({mark})", path.display())));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn labels_are_recognised() {
    assert_eq!(marks("(K3), (B12) and (22), (K), (Kx), (k3)"), ["K3", "B12"]);
    assert_eq!(quoted("`a.rs` `b`"), ["a.rs", "b"]);
}
