//! Search for the numbers in the text of a model, which the page shows as sliders.

use serde_json::{Value, json};
use toml::Table;

/// Lists the numbers in a model text, each with the path of its key and its unit. Formulas and
/// arrays are omitted.
pub(crate) fn numeric_values(text: &str) -> Vec<Value> {
    let mut values = Vec::new();
    if let Ok(table) = text.parse::<Table>() {
        collect(&table, "", &mut values);
    }
    values
}

fn collect(table: &Table, path: &str, values: &mut Vec<Value>) {
    for (name, value) in table {
        let key = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        let found = match value {
            toml::Value::Table(inner) => {
                collect(inner, &key, values);
                continue;
            }
            // Whole numbers of a model file are far below 2^53.
            toml::Value::Integer(value) => Some((*value as f64, "")),
            toml::Value::Float(value) => Some((*value, "")),
            toml::Value::String(text) => quantity(text),
            _ => None,
        };
        if let Some((number, unit)) = found.filter(|(number, _)| number.is_finite()) {
            values.push(json!({ "key": key, "value": number, "unit": unit }));
        }
    }
}

/// Parses a number with its unit, such as `"2.5 kg m^2"`; returns `None` for formulas and other
/// texts.
fn quantity(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let end =
        text.find(|c: char| !(c.is_ascii_digit() || ".+-eE".contains(c))).unwrap_or(text.len());
    let (number, unit) = (text[..end].parse().ok()?, text[end..].trim());
    let is_unit = |c: char| c.is_alphabetic() || c.is_ascii_digit() || " /^%°µ".contains(c);
    let starts = unit.chars().next().is_none_or(|c| c.is_alphabetic() || c == '%' || c == '°');
    (starts && unit.chars().all(is_unit)).then_some((number, unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_have_a_number_and_a_unit() {
        let cases = [
            ("450 mm", Some((450.0, "mm"))),
            ("0.0142 kg m^2", Some((0.0142, "kg m^2"))),
            ("-9.81 m/s^2", Some((-9.81, "m/s^2"))),
            ("1e-3", Some((1e-3, ""))),
            ("2 * base_radius", None),
            ("base_radius", None),
            ("3 m + 2 mm", None),
            ("", None),
        ];
        for (text, expected) in cases {
            assert_eq!(quantity(text), expected, "{text}");
        }
    }

    #[test]
    fn keys_are_paths() {
        let values =
            numeric_values("[parameters]\nr = \"2 mm\"\n[bodies.a]\nmass = 3\nname = \"a\"\n");
        assert_eq!(values.len(), 2);
        assert_eq!(values[0], json!({ "key": "parameters.r", "value": 2.0, "unit": "mm" }));
        assert_eq!(values[1], json!({ "key": "bodies.a.mass", "value": 3.0, "unit": "" }));
    }
}
