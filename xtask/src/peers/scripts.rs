//! Comparisons of whole commands by Python scripts in `peers/`: simulations and growth.

use super::Trouble;
use super::build::{Tools, output};
use serde_json::{Map, Value};
use std::fmt::Write;
use std::process::Command;

/// Script whose results are tables and ratios in JSON.
struct Script {
    file: &'static str,
    /// Harness that the script runs.
    harness: Option<&'static str>,
}

const SIMULATIONS: [Script; 2] = [
    Script { file: "simulations.py", harness: Some("mujoco_simulation") },
    Script { file: "chain.py", harness: None },
];
const GROWTH: [Script; 1] = [Script { file: "growth.py", harness: None }];

/// Runs simulations of robots beside MuJoCo, and of a row of four-bars beside Exudyn.
pub(crate) fn simulations(tools: &Tools<'_>) -> Result<Value, Trouble> {
    run(tools, &SIMULATIONS)
}

/// Measures how the time of commands grows with the size of a mechanism.
pub(crate) fn growth(tools: &Tools<'_>) -> Result<Value, Trouble> {
    run(tools, &GROWTH)
}

/// Runs scripts; returns their `ratios` and `tables` together.
fn run(tools: &Tools<'_>, scripts: &[Script]) -> Result<Value, Trouble> {
    let (mut ratios, mut tables) = (Map::new(), Vec::new());
    for script in scripts {
        eprintln!("== {}", script.file);
        let mut command = Command::new(&tools.python);
        let folder = tools.programs.place.join(script.file.trim_end_matches(".py"));
        command.arg(tools.sources.join(script.file)).arg("--out").arg(folder);
        command.arg("--stiction").arg(&tools.programs.program);
        if let Some(harness) = script.harness {
            command.arg("--harness").arg(tools.programs.place.join(harness));
        }
        let text = output(&mut command)?;
        let mut results: Value = serde_json::from_str(&text)
            .map_err(|error| Trouble::Failed(format!("{}: {error}", script.file)))?;
        if let (Value::Object(own), Value::Array(rows)) =
            (results["ratios"].take(), results["tables"].take())
        {
            ratios.extend(own);
            tables.extend(rows);
        }
    }
    Ok(serde_json::json!({ "ratios": ratios, "tables": tables }))
}

/// Formats the tables of scripts in Markdown.
pub(crate) fn tables(results: &Value) -> String {
    let mut text = String::new();
    let cells = |row: &Value| {
        let words = row.as_array().into_iter().flatten().filter_map(Value::as_str);
        format!("| {} |", words.collect::<Vec<_>>().join(" | "))
    };
    for table in results["tables"].as_array().into_iter().flatten() {
        let count = table["columns"].as_array().map_or(0, Vec::len);
        let _ = writeln!(text, "{}\n|{}", cells(&table["columns"]), " --- |".repeat(count));
        for row in table["rows"].as_array().into_iter().flatten() {
            let _ = writeln!(text, "{}", cells(row));
        }
        text.push('\n');
    }
    text
}

/// Formats the ratios of scripts, one in a line.
pub(crate) fn text(results: &Value) -> String {
    let mut text = format!("\n{}", tables(results));
    for (name, ratio) in results["ratios"].as_object().into_iter().flatten() {
        let _ = writeln!(text, "  {name:<44} {:>8.2}", ratio.as_f64().unwrap_or(f64::NAN));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::tables;

    #[test]
    fn tables_are_markdown() {
        let results = serde_json::json!({
            "tables": [{ "columns": ["a", "b"], "rows": [["1", "2"], ["3", "4"]] }],
        });
        assert_eq!(tables(&results), "| a | b |\n| --- | --- |\n| 1 | 2 |\n| 3 | 4 |\n\n");
    }
}
