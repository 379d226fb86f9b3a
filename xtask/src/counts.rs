//! `cargo xtask counts`: instruction counts of the kernels and of runs.
//!
//! Unlike times, counts do not vary between runs or with the load of the machine, so they show a loss of a few
//! percent. Callgrind counts the instructions of one call after some calls for warm-up. Counts depend on the
//! compiler and on the library functions of the processor. If the compiler differs from that of the stored
//! counts, the comparison gives no verdict.

use crate::{cargo, runs};
use serde_json::{Map, Value, json};
use std::process::{Command, ExitCode, Stdio};

const FILE: &str = "crates/stiction-run/benches/counts.json";
/// Relative increase that fails the comparison.
const TOLERANCE: f64 = 0.03;
/// Largest accepted ratios between two counts: motors must not make a sample expensive.
const RATIOS: [(&str, &str, f64); 1] = [("gough/run-geared", "gough/run", 1.3)];

pub(crate) fn counts(mut arguments: impl Iterator<Item = String>) -> ExitCode {
    let write = match (arguments.next().as_deref(), arguments.next()) {
        (None, _) => false,
        (Some("--write"), None) => true,
        _ => {
            eprintln!("usage: cargo xtask counts [--write]");
            return ExitCode::from(2);
        }
    };
    if !runs(Command::new("valgrind").arg("--version")) {
        eprintln!("counts: skipped: valgrind is not installed");
        return ExitCode::SUCCESS;
    }
    match count(write) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("counts: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Counts the instructions of all kernels and compares them with the stored counts; returns `true`
/// if no kernel is slower.
fn count(write: bool) -> Result<bool, String> {
    let program = build()?;
    let compiler = output(Command::new("rustc").arg("--version"))?.trim().to_owned();
    let known: Value = std::fs::read_to_string(FILE)
        .ok()
        .and_then(|text| serde_json::from_str(&text).ok())
        .unwrap_or_default();
    let is_comparable = known["compiler"] == compiler.as_str();
    let list = output(Command::new(&program).arg("--list"))?;
    let (mut found, mut good) = (Map::new(), true);
    println!("{:<32} {:>12} {:>9}", "one call of", "instructions", "change");
    for name in list.lines() {
        let count = instructions(&program, name)?;
        let before = known["instructions"][name].as_u64();
        let change = before.map(|before| count as f64 / before as f64 - 1.0);
        let change_text =
            change.map_or("new".to_owned(), |change| format!("{:+.1} %", 100.0 * change));
        println!("{name:<32} {count:>12} {change_text:>9}");
        good &= !change.is_some_and(|change| change > TOLERANCE);
        found.insert(name.to_owned(), json!(count));
    }
    for (name, base, most) in RATIOS {
        let count = |name: &str| found.get(name).and_then(Value::as_f64);
        let Some((count, base_count)) = count(name).zip(count(base)) else {
            return Err(format!("{name} or {base} is not counted"));
        };
        let ratio = count / base_count;
        println!("{name} over {base}: {ratio:.3}, at most {most}");
        if ratio > most {
            return Ok(false);
        }
    }
    if write {
        let text = format!("{:#}\n", json!({ "compiler": compiler, "instructions": found }));
        std::fs::write(FILE, text).map_err(|error| format!("{FILE}: {error}"))?;
        return Ok(true);
    }
    if !good && !is_comparable {
        println!("no verdict: the stored counts are those of {}", known["compiler"]);
    }
    Ok(good || !is_comparable)
}

/// Builds the benchmark program and returns its path.
fn build() -> Result<String, String> {
    let mut command = cargo(&["bench", "-p", "stiction-run", "--bench", "counts", "--no-run"]);
    let messages = output(command.arg("--message-format=json"))?;
    let artifacts = messages.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    artifacts
        .filter(|message| message["target"]["name"] == "counts")
        .find_map(|message| message["executable"].as_str().map(str::to_owned))
        .ok_or_else(|| "cargo built no program `counts`".to_owned())
}

fn instructions(program: &str, name: &str) -> Result<u64, String> {
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]);
    command.args(["--toggle-collect=counts::counted*", program, name]);
    let output = command.output().map_err(|error| format!("valgrind: {error}"))?;
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let line = text.lines().find_map(|line| line.split_once("Collected :"));
    let count = line.and_then(|(_, count)| count.trim().parse().ok()).filter(|count| *count > 0);
    count.ok_or_else(|| format!("{name}: Callgrind counted no instructions\n{text}"))
}

fn output(command: &mut Command) -> Result<String, String> {
    let output = command
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| format!("cannot run {command:?}: {error}"))?;
    if !output.status.success() {
        return Err(format!("{command:?} failed"));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
