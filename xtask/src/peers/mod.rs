//! `cargo xtask peers`: compares speed with other engines, see `peers/README.md`.
//!
//! First measures the commands that users type and our recorded program; this part needs no other
//! engine. Then builds a harness for each engine, compares its forces with ours, and runs batches
//! of a millisecond of all engines in rotation, so that a slow period of the machine affects all of
//! them.

mod build;
mod machine;
mod page;
mod process;
mod product;
mod report;
mod rounds;

use build::{Programs, Tools};
use process::Process;
use product::Product;
use report::ModelResult;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Reason why a comparison is not possible.
pub(crate) enum Trouble {
    /// This machine lacks a prerequisite.
    Missing(String),
    /// A step has failed.
    Failed(String),
}

struct Options {
    json: Option<PathBuf>,
    rounds: usize,
    /// True to write the tables of the book.
    write: bool,
}

/// Compared models; the reported ratios are those of the first.
const MODELS: [&str; 2] = ["3rps", "gough"];

/// Runs the comparison. Exit codes: 0 success, 1 failure or disagreement, 2 missing prerequisite.
pub(crate) fn peers(arguments: impl Iterator<Item = String>) -> ExitCode {
    let outcome = options(arguments).map_err(Trouble::Missing).and_then(|options| run(&options));
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(Trouble::Missing(what)) => {
            eprintln!("== comparison with peers not possible: {what}");
            ExitCode::from(2)
        }
        Err(Trouble::Failed(what)) => {
            eprintln!("== the comparison with peers failed: {what}");
            ExitCode::FAILURE
        }
    }
}

fn options(mut arguments: impl Iterator<Item = String>) -> Result<Options, String> {
    let mut options = Options { json: None, rounds: 300, write: false };
    while let Some(option) = arguments.next() {
        if option == "--write" {
            options.write = true;
            continue;
        }
        let value = arguments.next().ok_or_else(|| format!("{option} needs a value"))?;
        match option.as_str() {
            "--json" => options.json = Some(value.into()),
            "--samples" => match value.parse() {
                Ok(rounds) if rounds > 0 => options.rounds = rounds,
                _ => return Err(format!("--samples needs a positive integer, not `{value}`")),
            },
            _ => return Err(format!("unknown option `{option}`")),
        }
    }
    Ok(options)
}

fn run(options: &Options) -> Result<(), Trouble> {
    let programs = Programs::build()?;
    let products = product::measure(&programs)?;
    let tools = match Tools::find(&programs) {
        Ok(tools) => tools,
        Err(trouble) => {
            // Our own commands need no other engine.
            print!("{}", product::text(&products));
            let machine = machine::machine(&programs);
            let data = json!({
                "ratios": product::ratios(&products),
                "commands": product::json(&products),
                "machine": machine,
            });
            save(options, &data)?;
            return Err(trouble);
        }
    };
    compare(options, &tools, &products)
}

/// Compares with the other engines.
fn compare(options: &Options, tools: &Tools<'_>, products: &[Product]) -> Result<(), Trouble> {
    let states = tools.states(&MODELS)?;
    let mut results = Vec::new();
    for model in MODELS {
        let mut processes = processes(tools, &states, model)?;
        check(&processes)?;
        eprintln!("== {model}: {} rounds", options.rounds);
        let timings = rounds::run(&mut processes, options.rounds).map_err(Trouble::Failed)?;
        results.push(ModelResult { model, timings });
    }
    let python = python_level(tools, &states)?;
    let (machine, versions) = (machine::machine(tools.programs), tools.versions()?);
    let text = report::text(&results, &python, &machine, &versions);
    print!("{text}{}", product::text(products));
    let mut data = report::json(&results, &python, machine, versions, options.rounds);
    if let Some(ratios) = data["ratios"].as_object_mut() {
        ratios.extend(product::ratios(products));
        ratios.extend(report::python_ratios(&python, &results));
    }
    data["commands"] = product::json(products);
    save(options, &data)?;
    if options.write {
        page::write(tools, &data).map_err(Trouble::Failed)?;
    }
    Ok(())
}

/// Writes the results to the file of the option `--json`.
fn save(options: &Options, data: &Value) -> Result<(), Trouble> {
    let Some(path) = &options.json else { return Ok(()) };
    std::fs::write(path, format!("{data:#}\n"))
        .map_err(|error| Trouble::Failed(format!("{}: {error}", path.display())))
}

/// Starts our program and the harnesses of a model.
fn processes(tools: &Tools<'_>, states: &Path, model: &str) -> Result<Vec<Process>, Trouble> {
    let file = |what: &str| states.join(format!("{model}.{what}"));
    let mut commands = vec![
        ("stiction", tools.programs.ours().arg(model).arg(file("ours.txt"))),
        ("mujoco", tools.harness("mujoco").arg(file("mujoco.xml")).arg(file("mujoco.txt"))),
        ("pinocchio", tools.harness("pinocchio").arg(file("pinocchio.txt"))),
    ];
    if model == MODELS[0] {
        // The dense harness implements the 42 equations of this model.
        commands.push(("dense", tools.harness("dense")));
    }
    let start = |(name, runs): (_, build::Runs)| {
        Process::start(name, &mut runs.command()).map_err(Trouble::Failed)
    };
    commands.into_iter().map(start).collect()
}

/// Checks that all engines compute the same forces; engines with soft constraints are exempt.
fn check(processes: &[Process]) -> Result<(), Trouble> {
    // Rounding causes differences of about 1e-14.
    const LIMIT: f64 = 1e-10;
    for process in processes {
        for subject in &process.subjects {
            let is_exact = !subject.name.ends_with("_soft");
            if !subject.difference.is_finite() || (is_exact && subject.difference > LIMIT) {
                return Err(Trouble::Failed(format!(
                    "{} {} differs by {:.1e} (relative) from the expected forces",
                    process.name, subject.name, subject.difference
                )));
            }
        }
    }
    Ok(())
}

/// Measures the time of calls from Python.
fn python_level(tools: &Tools<'_>, states: &Path) -> Result<Value, Trouble> {
    eprintln!("== from Python");
    let mut command = Command::new(&tools.python);
    command.arg(tools.sources.join("python_level.py"));
    command
        .arg("--stiction")
        .arg(&tools.programs.program)
        .arg("--ours")
        .arg(&tools.programs.ours)
        .arg("--states")
        .arg(states)
        .arg(MODELS[0])
        .env("PYTHONPATH", &tools.programs.package);
    let output = build::output(&mut command)?;
    serde_json::from_str(&output)
        .map_err(|error| Trouble::Failed(format!("python_level.py: {error}")))
}

#[cfg(test)]
mod tests {
    use super::options;

    fn read(words: &str) -> Result<super::Options, String> {
        options(words.split_whitespace().map(String::from))
    }

    #[test]
    fn options_are_read_or_refused() {
        let Ok(options) = read("--json a.json --samples 7 --write") else {
            panic!("the options are valid");
        };
        assert_eq!((options.rounds, options.write), (7, true));
        assert_eq!(options.json, Some("a.json".into()));
        for wrong in ["--samples", "--samples 0", "--samples x", "--quick 1", "3rps"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
