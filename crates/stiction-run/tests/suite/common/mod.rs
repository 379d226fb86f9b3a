//! Runs of gallery models, and their tables, read back as another program would read them.
#![allow(dead_code, reason = "each test uses its part")]

pub(crate) mod change;
pub(crate) mod collar;

use std::collections::BTreeMap;
use stiction_core::dynamics::FrictionMode;
use stiction_format::{ModelFile, Source, gallery, read};
use stiction_run::inverse::{Tables, Verdict};
use stiction_run::{Error, Job, Sink};

pub(crate) const MODES: [FrictionMode; 3] =
    [FrictionMode::Off, FrictionMode::OnePass, FrictionMode::Converged];

/// Returns the model of a mass of 2 kg on a horizontal guide. `joint` is appended to the table of
/// the joint, `more` to the file.
pub(crate) fn slide(joint: &str, more: &str) -> ModelFile {
    let text = format!(
        r#"
        gravity = [0, 0, "-10 m/s^2"]
        [bodies.mass]
        mass = "2 kg"
        com = [0, 0, 0]
        inertia = [1, 1, 1]
        [joints.slide]
        type = "P"
        from = "ground"
        to = "mass"
        axis = "x"
        actuated = true
        {joint}
        {more}
        "#
    );
    model_of("slide", &text)
}

/// Reads a model of the gallery.
pub(crate) fn model(name: &str) -> ModelFile {
    model_of(name, gallery::get(name).unwrap())
}

/// Reads a model from its text.
pub(crate) fn model_of(name: &str, text: &str) -> ModelFile {
    read(&Source::new(format!("{name}.toml"), text), &|_| Err("no files".into()))
        .unwrap_or_else(|diagnostics| panic!("{name}: {diagnostics}"))
}

/// Creates the job of a motion of a model under one of its loads.
pub(crate) fn job<'a>(
    model: &'a ModelFile,
    motion: &str,
    load: &str,
    friction: FrictionMode,
) -> Job<'a> {
    let motion = (motion, model.motion(motion).unwrap());
    Job { friction, ..Job::new(model, motion, (load, model.load(load).unwrap())) }
}

/// Creates the job of the default motion and load of a model.
pub(crate) fn default_job(model: &ModelFile, friction: FrictionMode) -> Job<'_> {
    let (motion, load) = (model.default_motion.as_ref(), model.default_load.as_ref());
    job(model, motion.unwrap(), load.unwrap(), friction)
}

/// Table of numbers by column.
#[derive(Debug)]
pub(crate) struct Csv(BTreeMap<String, Vec<f64>>);

impl Csv {
    pub(crate) fn parse(text: &[u8]) -> Self {
        let mut reader = csv::Reader::from_reader(text);
        let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let mut columns: BTreeMap<_, _> =
            names.iter().map(|name| (name.clone(), Vec::new())).collect();
        assert_eq!(columns.len(), names.len(), "no column twice");
        for record in reader.records() {
            for (name, cell) in names.iter().zip(&record.unwrap()) {
                columns.get_mut(name).unwrap().push(cell.parse().unwrap());
            }
        }
        Self(columns)
    }

    /// Returns a column, given its complete name with unit.
    pub(crate) fn column(&self, name: &str) -> &[f64] {
        let column = self.0.get(name);
        column.unwrap_or_else(|| panic!("no column {name}; there are {:?}", self.0.keys()))
    }

    pub(crate) fn columns(&self) -> impl Iterator<Item = (&String, &Vec<f64>)> {
        self.0.iter()
    }
}

/// Creates empty tables of a job.
pub(crate) fn tables(job: &Job<'_>) -> Tables<Vec<u8>> {
    Tables::new(job, vec![Vec::new(); Tables::<Vec<u8>>::files(job).len()]).unwrap()
}

/// Returns the tables of a job by their names.
pub(crate) fn files(job: &Job<'_>, tables: Tables<Vec<u8>>) -> BTreeMap<&'static str, Vec<u8>> {
    Tables::<Vec<u8>>::files(job).into_iter().zip(tables.finish().unwrap()).collect()
}

/// Results of a run.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) inverse: Csv,
    pub(crate) reactions: Csv,
    pub(crate) friction: Csv,
    pub(crate) verdict: Verdict,
    /// Largest power residual, relative to the gross power at that instant.
    pub(crate) power_residual: f64,
    /// Largest closure error, m.
    pub(crate) closure: f64,
}

impl Run {
    pub(crate) fn of(job: &Job<'_>) -> Result<Self, Error> {
        let mut tables = tables(job);
        let (mut power_residual, mut closure) = (0.0_f64, 0.0_f64);
        let verdict = job.run(
            |sample| {
                let power = sample.forces.power;
                power_residual = power_residual.max((power.residual() / power.turnover).abs());
                closure = closure.max(sample.closure);
                tables.add(sample)
            },
            |_, _, _| true,
        )?;
        let mut files = files(job, tables);
        let mut file = |name| Csv::parse(&files.remove(name).unwrap());
        let [inverse, reactions, friction] =
            ["inverse.csv", "reactions.csv", "friction.csv"].map(&mut file);
        Ok(Self { inverse, reactions, friction, verdict, power_residual, closure })
    }
}

/// Robots of the gallery that are singular along their default motions.
pub(crate) const SINGULAR: [&str; 3] = ["3upu-singular", "griffis-duffy", "zhang2018"];

/// Returns the names of the robots of the gallery with finite actuator forces.
pub(crate) fn regular() -> impl Iterator<Item = &'static str> {
    gallery::names().filter(|name| !SINGULAR.contains(name))
}

/// Returns the names of all pairs of a motion and a load.
pub(crate) fn cases(model: &ModelFile) -> impl Iterator<Item = (&str, &str)> {
    model.motions.iter().flat_map(|(motion, _)| {
        model.loads.iter().map(move |(load, _)| (motion.as_str(), load.as_str()))
    })
}

/// Splits a model file into the text before its first table and its tables, each with its header.
fn sections(text: &str) -> (String, Vec<String>) {
    let mut head = String::new();
    let mut tables: Vec<String> = Vec::new();
    for line in text.lines() {
        if line.starts_with('[') {
            tables.push(String::new());
        }
        let part = tables.last_mut().unwrap_or(&mut head);
        part.push_str(line);
        part.push('\n');
    }
    (head, tables)
}

/// Returns the text of a model file with its tables in reverse order.
pub(crate) fn in_reverse(text: &str) -> String {
    let (head, mut tables) = sections(text);
    // The entries of the array `place` are numbered by their order, so this order is preserved.
    let is_free = |table: &String| !table.starts_with("[[");
    let mut reversed: Vec<String> = tables.iter().filter(|t| is_free(t)).rev().cloned().collect();
    reversed.extend(tables.drain(..).filter(|table| !is_free(table)));
    head + &reversed.concat()
}

/// Rewrites every quantity that is a number with a unit in a smaller or larger unit of the same
/// kind.
pub(crate) fn in_other_units(text: &str) -> String {
    let pairs = [
        ("kg mm^2", "g mm^2", 1e3),
        ("kg m^2", "kg mm^2", 1e6),
        ("kg/m", "g/mm", 1.0),
        ("kg", "g", 1e3),
        ("mm", "m", 1e-3),
        ("m", "mm", 1e3),
        ("kN", "N", 1e3),
        ("N", "mN", 1e3),
        ("ms", "s", 1e-3),
        ("s", "ms", 1e3),
    ];
    let mut out = String::new();
    for line in text.lines() {
        // Only quoted texts that are a single quantity are rewritten, because expressions contain
        // units between names.
        for (k, part) in line.split('"').enumerate() {
            let quoted = k % 2 == 1;
            let quantity = part.split_once(' ').and_then(|(number, unit)| {
                let value: f64 = number.parse().ok()?;
                let (_, other, factor) = pairs.iter().find(|(from, _, _)| *from == unit)?;
                Some(format!("{} {other}", value * factor))
            });
            let text = quantity.filter(|_| quoted).unwrap_or_else(|| part.to_owned());
            if k > 0 {
                out.push('"');
            }
            out.push_str(&text);
        }
        out.push('\n');
    }
    out
}
