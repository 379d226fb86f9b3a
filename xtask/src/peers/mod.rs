//! `cargo xtask peers`: compares speed with other engines, see `peers/README.md`.
//!
//! First measures the commands that users type and our recorded program; this part needs no other
//! engine. Then builds a harness for each engine, compares its forces with ours, and runs batches
//! of a millisecond of all engines in rotation, so that a slow period of the machine affects all of
//! them. At last runs whole simulations, and measures the growth with the size of a mechanism.

mod build;
mod machine;
mod page;
mod process;
mod product;
mod report;
mod rounds;
mod scripts;

use build::{Programs, Tools};
use process::Process;
use report::ModelResult;
use serde_json::{Map, Value, json};
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
    groups: Vec<Group>,
}

/// Part of the comparison that can be selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Group {
    /// Our commands beside our recorded program.
    Commands,
    /// One state, beside all engines.
    States,
    /// Whole simulations, beside MuJoCo and Exudyn.
    Simulations,
    /// Growth with the size of a mechanism.
    Growth,
}

const GROUPS: [(&str, Group); 4] = [
    ("commands", Group::Commands),
    ("states", Group::States),
    ("simulations", Group::Simulations),
    ("growth", Group::Growth),
];

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
    let groups = GROUPS.map(|(_, group)| group).to_vec();
    let mut options = Options { json: None, rounds: 300, write: false, groups };
    while let Some(option) = arguments.next() {
        if option == "--write" {
            options.write = true;
            continue;
        }
        let value = arguments.next().ok_or_else(|| format!("{option} needs a value"))?;
        match option.as_str() {
            "--json" => options.json = Some(value.into()),
            "--only" => options.groups = value.split(',').map(group).collect::<Result<_, _>>()?,
            "--samples" => match value.parse() {
                Ok(rounds) if rounds > 0 => options.rounds = rounds,
                _ => return Err(format!("--samples needs a positive integer, not `{value}`")),
            },
            _ => return Err(format!("unknown option `{option}`")),
        }
    }
    Ok(options)
}

fn group(name: &str) -> Result<Group, String> {
    let found = GROUPS.iter().find(|(known, _)| *known == name);
    found.map(|(_, group)| *group).ok_or_else(|| {
        let names = GROUPS.map(|(known, _)| known).join(", ");
        format!("--only needs some of {names}, separated by commas, not `{name}`")
    })
}

fn run(options: &Options) -> Result<(), Trouble> {
    let has = |group| options.groups.contains(&group);
    let programs = Programs::build()?;
    let mut data = json!({ "ratios": {}, "machine": machine::machine(&programs) });
    if has(Group::Commands) {
        let products = product::measure(&programs)?;
        print!("{}", product::text(&products));
        data["commands"] = product::json(&products);
        add_ratios(&mut data, product::ratios(&products));
    }
    if options.groups == [Group::Commands] {
        return save(options, &data);
    }
    let tools = match Tools::find(&programs) {
        Ok(tools) => tools,
        Err(trouble) => {
            // Our own commands need no other engine.
            save(options, &data)?;
            return Err(trouble);
        }
    };
    if has(Group::States) {
        compare(options, &tools, &mut data)?;
    }
    for (name, wanted, measure) in [
        ("simulations", Group::Simulations, scripts::simulations as fn(&Tools<'_>) -> _),
        ("growth", Group::Growth, scripts::growth),
    ] {
        if has(wanted) {
            let results: Value = measure(&tools)?;
            print!("{}", scripts::text(&results));
            add_ratios(&mut data, results["ratios"].as_object().cloned().unwrap_or_default());
            data[name] = results;
        }
    }
    save(options, &data)?;
    if options.write { page::write(&tools, &data).map_err(Trouble::Failed) } else { Ok(()) }
}

fn add_ratios(data: &mut Value, ratios: Map<String, Value>) {
    if let Some(known) = data["ratios"].as_object_mut() {
        known.extend(ratios);
    }
}

/// Compares the forces at one state with the other engines.
fn compare(options: &Options, tools: &Tools<'_>, data: &mut Value) -> Result<(), Trouble> {
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
    let versions = tools.versions()?;
    print!("{}", report::text(&results, &python, &data["machine"], &versions));
    let mut own = report::json(&results, &python, versions, options.rounds);
    let ratios = own["ratios"].take().as_object().cloned().unwrap_or_default();
    add_ratios(data, ratios);
    add_ratios(data, report::python_ratios(&python, &results));
    for (key, value) in own.as_object().into_iter().flatten().filter(|(key, _)| *key != "ratios") {
        data[key] = value.clone();
    }
    // All other ratios at the top are those of the first model.
    let gough = data["models"]["gough"]["ratios"]["forward_vs_pinocchio"].clone();
    data["ratios"]["forward_gough_vs_pinocchio"] = gough;
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
    use super::{Group, options};

    fn read(words: &str) -> Result<super::Options, String> {
        options(words.split_whitespace().map(String::from))
    }

    #[test]
    fn options_are_read_or_refused() {
        let Ok(options) = read("--json a.json --samples 7 --write --only growth,commands") else {
            panic!("the options are valid");
        };
        assert_eq!((options.rounds, options.write), (7, true));
        assert_eq!(options.groups, [Group::Growth, Group::Commands]);
        assert_eq!(options.json, Some("a.json".into()));
        for wrong in
            ["--samples", "--only speed", "--samples 0", "--samples x", "--quick 1", "3rps"]
        {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
