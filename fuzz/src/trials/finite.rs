//! Checks that outputs contain no NaN and no unexpected infinity.

use serde_json::Value;

/// Columns in which `inf` is a valid value, as documented in the book.
fn may_be_infinite(column: &str) -> bool {
    let name = column.split(' ').next().unwrap_or_default();
    name.ends_with(".drive_low") || name.ends_with(".drive_high") || name == "coupling"
}

/// Checks a table of numbers with a header.
pub(crate) fn table(name: &str, bytes: &[u8]) {
    let text = std::str::from_utf8(bytes).unwrap_or_else(|_| panic!("{name} is no text"));
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    for (row, line) in lines.enumerate() {
        for (cell, column) in line.split(',').zip(&header) {
            let number: f64 = cell
                .parse()
                .unwrap_or_else(|_| panic!("{name}: `{cell}` in row {row} of {column}"));
            let is_fine = number.is_finite() || (!number.is_nan() && may_be_infinite(column));
            assert!(is_fine, "{name}: {cell} in row {row} of {column}");
        }
    }
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphabetic())
}

/// Checks text for readers. It may contain `inf` where the book permits, such as in an unbounded
/// interval.
pub(crate) fn text(name: &str, text: &str) {
    assert!(words(text).all(|word| !matches!(word, "NaN" | "nan")), "{name} holds NaN:\n{text}");
}

/// Checks a picture, or a file for other programs.
pub(crate) fn picture(name: &str, text: &str) {
    let fine = words(text).all(|word| !matches!(word, "NaN" | "nan" | "inf"));
    assert!(fine, "{name} holds what is no number:\n{text}");
}

/// Checks JSON, in which `null` stands for a number that is not finite.
pub(crate) fn json(name: &str, value: &Value, may_be_null: &[&str]) {
    match value {
        Value::Array(list) => {
            for item in list {
                assert!(!item.is_null(), "{name} holds null: {value}");
                json(name, item, may_be_null);
            }
        }
        Value::Object(map) => {
            for (key, value) in map {
                let is_free = may_be_null.contains(&key.as_str());
                assert!(is_free || !value.is_null(), "{name}: {key} is null");
                if !is_free {
                    json(&format!("{name}.{key}"), value, may_be_null);
                }
            }
        }
        _ => {}
    }
}
