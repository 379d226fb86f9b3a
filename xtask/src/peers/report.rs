//! Results as a table and as JSON.

use super::rounds::Timing;
use serde_json::{Map, Value, json};
use std::fmt::Write;

pub(crate) struct ModelResult {
    pub(crate) model: &'static str,
    pub(crate) timings: Vec<Timing>,
}

const OURS: &str = "stiction";

/// Returns `true` if a subject computes accelerations from forces.
fn is_forward(subject: &str) -> bool {
    subject.starts_with("forward")
}

/// Names of ratios: `inverse_friction_vs_mujoco`, `forward_vs_mujoco_soft`.
fn ratio_name(ours: &Timing, theirs: &Timing) -> String {
    let what = theirs.subject.trim_start_matches("inverse").trim_start_matches("forward");
    let what = if theirs.engine == "dense" { format!("_{}", theirs.subject) } else { what.into() };
    format!("{}_vs_{}{what}", ours.subject, theirs.engine)
}

/// Ratios of our time to the time of each other engine, for the same task.
fn ratios(result: &ModelResult) -> Vec<(String, f64)> {
    let (ours, theirs): (Vec<_>, Vec<_>) = result.timings.iter().partition(|t| t.engine == OURS);
    let mut ratios = Vec::new();
    for ours in ours {
        for theirs in &theirs {
            if is_forward(&ours.subject) == is_forward(&theirs.subject) {
                ratios.push((ratio_name(ours, theirs), ours.ratio_to(theirs)));
            }
        }
    }
    ratios
}

/// Ratios of our Python package: those measured in Python, and the time of a batch relative to that
/// of a loop in C or C++ over each engine's inverse dynamics, for the same model.
pub(crate) fn python_ratios(python: &Value, results: &[ModelResult]) -> Map<String, Value> {
    let mut ratios = python["ratios"].as_object().cloned().unwrap_or_default();
    let result = results.iter().find(|result| python["model"] == result.model);
    let theirs = result.into_iter().flat_map(|result| &result.timings);
    for theirs in theirs.filter(|t| t.engine != OURS && t.subject == "inverse") {
        for row in python["rows"].as_array().into_iter().flatten() {
            let task = row["task"].as_str().filter(|task| task.starts_with("batch_"));
            let (Some(task), Some(ours)) = (task, row["median_ns"].as_f64()) else { continue };
            let name = format!("python_{task}_vs_{}_loop", theirs.engine);
            ratios.insert(name, (ours / theirs.median()).into());
        }
    }
    ratios
}

pub(crate) fn text(
    results: &[ModelResult],
    python: &Value,
    machine: &Value,
    versions: &Value,
) -> String {
    let mut text = String::new();
    for result in results {
        let _ = writeln!(
            text,
            "\n{}\n  {:<34} {:>9} {:>9} {:>12}",
            result.model, "", "median", "minimum", "difference"
        );
        for timing in &result.timings {
            let name = format!("{} {}", timing.engine, timing.subject);
            let (median, minimum) = (timing.median() / 1e3, timing.minimum() / 1e3);
            let _ = writeln!(
                text,
                "  {name:<34} {median:>6.2} us {minimum:>6.2} us {:>12.0e}",
                timing.difference
            );
        }
        let _ = writeln!(text, "  ratios, ours / theirs");
        for (name, ratio) in ratios(result) {
            let _ = writeln!(text, "  {name:<44} {ratio:>8.2}");
        }
    }
    let _ = writeln!(text, "\nfrom Python, {}", python["model"].as_str().unwrap_or_default());
    for row in python["rows"].as_array().into_iter().flatten() {
        let word = |key: &str| row[key].as_str().unwrap_or_default().to_string();
        let time = row["median_ns"].as_f64().unwrap_or(f64::NAN) / 1e3;
        let name = format!("{} {}", word("engine"), word("task"));
        let _ = writeln!(text, "  {name:<34} {time:>6.2} us  {}", word("what"));
    }
    for (name, ratio) in python_ratios(python, results) {
        let _ = writeln!(text, "  {name:<44} {:>8.2}", ratio.as_f64().unwrap_or(f64::NAN));
    }
    let _ = writeln!(text, "\nmachine: {machine}\nversions: {versions}");
    text
}

pub(crate) fn json(
    results: &[ModelResult],
    python: &Value,
    versions: Value,
    rounds: usize,
) -> Value {
    let table = |result: &ModelResult, number: &dyn Fn(&Timing) -> Value| -> Map<String, Value> {
        let row = |t: &Timing| (format!("{} {}", t.engine, t.subject), number(t));
        result.timings.iter().map(row).collect()
    };
    let ratio_map = |result: &ModelResult| -> Map<String, Value> {
        ratios(result).into_iter().map(|(name, ratio)| (name, ratio.into())).collect()
    };
    let model = |result: &ModelResult| {
        let data = json!({
            "ratios": ratio_map(result),
            "median_ns": table(result, &|t| t.median().into()),
            "minimum_ns": table(result, &|t| t.minimum().into()),
            "difference": table(result, &|t| t.difference.into()),
            "evaluations_in_a_batch": table(result, &|t| t.size.into()),
        });
        (result.model.to_string(), data)
    };
    json!({
        "model": results.first().map(|result| result.model),
        "ratios": results.first().map(ratio_map),
        "batches": rounds,
        "models": results.iter().map(model).collect::<Map<_, _>>(),
        "python": python,
        "versions": versions,
    })
}

#[cfg(test)]
mod tests {
    use super::{ModelResult, ratios};
    use crate::peers::rounds::Timing;

    #[test]
    fn ratios_compare_the_same_task() {
        let timing = |engine, subject: &str, time: f64| {
            let (subject, batches) = (subject.to_string(), vec![time]);
            Timing { engine, subject, difference: 0.0, batches, size: 1 }
        };
        let timings = vec![
            timing("stiction", "inverse_friction", 6.0),
            timing("stiction", "forward", 2.0),
            timing("mujoco", "inverse", 2.0),
            timing("mujoco", "forward_soft", 8.0),
            timing("pinocchio", "forward", 4.0),
            timing("dense", "lu42", 12.0),
        ];
        let expected = [
            ("inverse_friction_vs_mujoco", 3.0),
            ("inverse_friction_vs_dense_lu42", 0.5),
            ("forward_vs_mujoco_soft", 0.25),
            ("forward_vs_pinocchio", 0.5),
        ];
        let found = ratios(&ModelResult { model: "3rps", timings });
        assert_eq!(found, expected.map(|(name, ratio)| (name.to_string(), ratio)));
    }
}
