//! Designs of a parameter study, defined by variations of keys of the model or by a table.

use crate::arguments::{Plan, Shard, Sweep};
use crate::failure::Failure;
use std::fs::File;
use std::path::{Path, PathBuf};
use stiction::Error;
use stiction_format::{Key, Setting, Variation};
use stiction_run::sweep::{Design, DesignError, DesignTable};

/// Designs of a parameter study. A design does not depend on the designs before it.
pub(super) enum Designs {
    Plan(Design, Plan),
    Table { path: PathBuf, keys: Vec<Key>, count: u64 },
}

type Iter<'a> = Box<dyn Iterator<Item = Result<Vec<Setting>, Error>> + Send + 'a>;

impl Designs {
    pub(super) fn new(options: &Sweep) -> Result<Self, Failure> {
        if let Some(path) = &options.table {
            let mut table = read(path)?;
            let keys = table.keys().to_vec();
            let mut count = 0;
            for row in &mut table {
                row.map_err(|why| unreadable(path, &why))?;
                count += 1;
            }
            if count == 0 {
                return Err(unreadable(path, "it has no rows"));
            }
            return Ok(Self::Table { path: path.clone(), keys, count });
        }
        let variations =
            options.vary.iter().map(|text| Variation::parse(text).map_err(Error::from));
        let variations = variations.collect::<Result<Vec<_>, _>>()?;
        let plan = options.design.unwrap_or(Plan::Grid);
        let design = match (plan, options.samples, options.seed) {
            (Plan::Grid, None, None) => Design::grid(variations),
            (Plan::Grid, ..) => {
                return Err(Failure::input(
                    "--samples and --seed do not apply to a grid (the \
                    default of --design)",
                )
                .help("add --design lhs or --design sobol, or leave them out"));
            }
            (Plan::Lhs, Some(samples), seed) => {
                Design::latin_hypercube(variations, samples, seed.unwrap_or(0))
            }
            (Plan::Sobol, Some(samples), seed) => Design::sobol(variations, samples, seed),
            (Plan::Lhs | Plan::Sobol, None, _) => {
                return Err(Failure::input(
                    "a Latin hypercube or Sobol design needs the number of \
                    designs",
                )
                .help("add --samples, for example --samples 1000"));
            }
        };
        Ok(Self::Plan(design.map_err(|error| explained(&error))?, plan))
    }

    pub(super) fn keys(&self) -> Vec<Key> {
        match self {
            Self::Plan(design, _) => design.keys().cloned().collect(),
            Self::Table { keys, .. } => keys.clone(),
        }
    }

    pub(super) fn count(&self) -> u64 {
        match self {
            Self::Plan(design, _) => design.count(),
            Self::Table { count, .. } => *count,
        }
    }

    pub(super) fn shape(&self) -> Option<Vec<u64>> {
        match self {
            Self::Plan(design, _) => design.shape(),
            Self::Table { .. } => None,
        }
    }

    /// Returns the kind of the designs: `grid`, `lhs` (Latin hypercube), `sobol` or `table`.
    pub(super) fn plan(&self) -> &'static str {
        match self {
            Self::Plan(_, Plan::Grid) => "grid",
            Self::Plan(_, Plan::Lhs) => "lhs",
            Self::Plan(_, Plan::Sobol) => "sobol",
            Self::Table { .. } => "table",
        }
    }

    /// Returns the full path of the table, if the designs come from a table.
    pub(super) fn file(&self) -> Option<PathBuf> {
        match self {
            Self::Plan(..) => None,
            Self::Table { path, .. } => path.canonicalize().ok(),
        }
    }

    /// Iterates over the designs in the part `shard` of the study, omitting the first `done`
    /// designs of this part.
    pub(super) fn iter(&self, shard: Shard, done: u64) -> Result<Iter<'_>, Failure> {
        let (first, step) = (shard.part - 1 + done * shard.parts, shard.parts);
        Ok(match self {
            Self::Plan(design, _) => {
                let rows = std::iter::successors(Some(first), move |row| row.checked_add(step));
                let rows = rows.take_while(|row| *row < design.count());
                Box::new(rows.map(|row| Ok(design.row(row))))
            }
            Self::Table { path, .. } => {
                let step = usize::try_from(step).unwrap_or(usize::MAX);
                let first = usize::try_from(first).unwrap_or(usize::MAX);
                let rows = read(path)?.skip(first).step_by(step);
                Box::new(rows.map(|row| {
                    row.map_err(|why| {
                        Error::input(format!("cannot read {}: {why}", path.display()))
                    })
                }))
            }
        })
    }
}

fn read(path: &PathBuf) -> Result<DesignTable<File>, Failure> {
    let is_file = path.metadata().map(|about| about.is_file());
    if !is_file.map_err(|error| unreadable(path, &error.to_string()))? {
        return Err(unreadable(
            path,
            "it is not a regular file, but must be one because it is read twice",
        ));
    }
    let file = File::open(path).map_err(|error| unreadable(path, &error.to_string()))?;
    DesignTable::new(file).map_err(|why| unreadable(path, &why))
}

fn unreadable(path: &Path, why: &str) -> Failure {
    Failure::input(format!("cannot read the table of designs {}: {why}", path.display())).help(
        "a table is a CSV file whose header names keys, with units in brackets: `mu,tool.mass [kg]`",
    )
}

fn explained(error: &DesignError) -> Failure {
    let failure = Failure::input(error.to_string());
    match error {
        DesignError::Empty => {
            failure.help("add --vary \"KEY = FROM..TO in COUNT\", or --table FILE")
        }
        DesignError::Uncounted(key) => failure
            .help(format!("write `{key} = FROM..TO in 6`, or add --design lhs or --design sobol")),
        DesignError::OneValue(key) => failure.help(format!(
            "write `{key} = FROM..TO in 2` or more, or the single value as a list: `{key} = [VALUE]`"
        )),
        DesignError::Counted(key) => failure.help(format!("write `{key} = FROM..TO` without `in`")),
        DesignError::TooManyKeys { .. } => failure.help("add --design lhs"),
        DesignError::TooManyRows { .. } => failure.help(
            "give fewer keys or fewer values, or sample with --design sobol and \
                --samples",
        ),
        _ => failure,
    }
}
