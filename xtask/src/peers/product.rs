//! Cost of one sample of the commands that users type, relative to the cost of our recorded program
//! for one state.
//!
//! A command runs with few and with many samples, so that the difference of the processor times does
//! not contain the start of the program. Rounds of commands alternate with batches of the recorded
//! program, as for the engines.

use super::Trouble;
use super::build::Programs;
use super::process::Process;
use serde_json::{Map, Value, json};
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Number of rounds; the smallest time of each command is the result.
const ROUNDS: usize = 7;
/// Recorded program with which all commands are compared; `BATCH` is the number of states in a
/// batch.
const PROGRAM: &str = "inverse_friction";
const BATCH: usize = 20_000;

/// Command that is run with two numbers of samples.
struct Case {
    model: &'static str,
    /// Key of its ratio in the results.
    ratio: &'static str,
    /// Motion at rest that replaces the default motion; `None` for the default motion.
    motion: Option<&'static str>,
    /// Two time steps, in the notation of the command line.
    steps: [&'static str; 2],
    writes_tables: bool,
}

const MOVING: [&str; 2] = ["0.5 ms", "0.1 ms"];
const RESTING: [&str; 2] = ["20 ms", "2 ms"];

const CASES: [Case; 4] = [
    Case {
        model: "3rps",
        ratio: "product_sample_vs_program",
        motion: None,
        steps: MOVING,
        writes_tables: false,
    },
    Case {
        model: "3rps",
        ratio: "product_tables_vs_program",
        motion: None,
        steps: MOVING,
        writes_tables: true,
    },
    Case {
        model: "3rps",
        ratio: "rest_sample_vs_program",
        motion: Some("platform.z = home_height; platform.rx = 0; platform.ry = 0; duration = 1 s"),
        steps: RESTING,
        writes_tables: false,
    },
    Case {
        model: "gough",
        ratio: "rest_sample_vs_program",
        motion: Some(
            "platform.x = 0; platform.y = 0; platform.z = home_height; platform.rx = 0; \
             platform.ry = 0; platform.rz = 0; duration = 1 s",
        ),
        steps: RESTING,
        writes_tables: false,
    },
];

/// Cost of a sample, ns, and its ratio to the program.
pub(crate) struct Product {
    model: &'static str,
    ratio: &'static str,
    sample: f64,
    program: f64,
}

/// Measures all commands.
pub(crate) fn measure(programs: &Programs) -> Result<Vec<Product>, Trouble> {
    CASES.iter().map(|case| case.measure(programs)).collect()
}

impl Case {
    fn measure(&self, programs: &Programs) -> Result<Product, Trouble> {
        eprintln!("== {}: {}", self.model, self.ratio);
        let mut kernel = Process::start("stiction", &mut programs.ours().arg(self.model).command())
            .map_err(Trouble::Failed)?;
        let subject = kernel.subjects.iter().position(|subject| subject.name == PROGRAM);
        let subject = subject.ok_or_else(|| Trouble::Failed(format!("no {PROGRAM}")))?;
        let folder = programs.place.join("product");
        let (mut program, mut times) = (f64::INFINITY, [f64::INFINITY; 2]);
        let mut samples = [0.0; 2];
        for _ in 0..ROUNDS {
            let each = kernel.batch(subject, BATCH).map_err(Trouble::Failed)?;
            program = program.min(each);
            for k in 0..2 {
                // Replacing the files of an earlier run would take time as well.
                if let Err(error) = std::fs::remove_dir_all(&folder)
                    && error.kind() != ErrorKind::NotFound
                {
                    return Err(Trouble::Failed(format!("{}: {error}", folder.display())));
                }
                let before = children_time();
                samples[k] = self.run(programs, self.steps[k], &folder)?;
                let taken = children_time().saturating_sub(before);
                times[k] = times[k].min(taken.as_secs_f64() * 1e9);
            }
        }
        let sample = (times[1] - times[0]) / (samples[1] - samples[0]);
        Ok(Product { model: self.model, ratio: self.ratio, sample, program })
    }

    /// Runs the command; returns the number of samples.
    fn run(&self, programs: &Programs, step: &str, folder: &Path) -> Result<f64, Trouble> {
        let mut runs = programs.program().arg("inverse").arg(self.model);
        for argument in ["--friction", "on", "--threads", "1", "--quiet", "--json", "--step", step]
        {
            runs = runs.arg(argument);
        }
        if let Some(motion) = self.motion {
            runs = runs.arg("--motion").arg(motion);
        }
        if self.writes_tables {
            runs = runs.arg("--report").arg("off").arg("--output").arg(folder);
        }
        let text = quiet_output(&mut runs.command())?;
        let samples = serde_json::from_str(&text)
            .ok()
            .and_then(|summary: Value| summary["options"]["samples"].as_f64());
        samples.ok_or_else(|| Trouble::Failed(format!("`inverse {}` has no samples", self.model)))
    }
}

/// Returns the processor time, user and system, of all child processes that have ended. Waiting for
/// the disk is not part of it.
#[cfg(unix)]
fn children_time() -> Duration {
    use nix::sys::resource::{UsageWho, getrusage};
    use nix::sys::time::TimeValLike;
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN);
    let time =
        usage.map_or(0, |usage| (usage.user_time() + usage.system_time()).num_microseconds());
    Duration::from_micros(time.unsigned_abs())
}

/// Returns the time since the first call, because the processor time of child processes is unknown.
#[cfg(not(unix))]
fn children_time() -> Duration {
    use std::{sync::LazyLock, time::Instant};
    static BEGUN: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGUN.elapsed()
}

fn quiet_output(command: &mut Command) -> Result<String, Trouble> {
    let done = command.stderr(Stdio::null()).output();
    match done {
        Ok(done) if done.status.success() => Ok(String::from_utf8_lossy(&done.stdout).into_owned()),
        Ok(done) => Err(Trouble::Failed(format!("{command:?}: {}", done.status))),
        Err(error) => Err(Trouble::Failed(format!("{command:?}: {error}"))),
    }
}

/// Returns the largest ratio of each name.
pub(crate) fn ratios(products: &[Product]) -> Map<String, Value> {
    let mut ratios = Map::new();
    for product in products {
        let ratio = product.sample / product.program;
        let known = ratios.get(product.ratio).and_then(Value::as_f64).unwrap_or(0.0);
        ratios.insert(product.ratio.into(), json!(ratio.max(known)));
    }
    ratios
}

pub(crate) fn json(products: &[Product]) -> Value {
    let row = |product: &Product| {
        json!({
            "model": product.model,
            "ratio": product.ratio,
            "sample_ns": product.sample,
            "program_ns": product.program,
        })
    };
    products.iter().map(row).collect()
}

pub(crate) fn text(products: &[Product]) -> String {
    let mut text = format!(
        "\ncommands: least processor time of a sample, and its ratio to the time of {PROGRAM}\n"
    );
    for Product { model, ratio, sample, program } in products {
        let (name, time) = (format!("{model} {ratio}"), sample / 1e3);
        text += &format!("  {name:<40} {time:>8.2} us {:>8.1}\n", sample / program);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Product, ratios};

    #[test]
    fn the_greatest_of_equal_names_counts() {
        let product = |model, sample| Product { model, ratio: "rest", sample, program: 2.0 };
        let found = ratios(&[product("a", 8.0), product("b", 20.0), product("c", 2.0)]);
        assert_eq!(found["rest"], 10.0);
        assert_eq!(found.len(), 1);
    }
}
