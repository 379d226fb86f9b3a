//! Commands that compute efforts along motions.

use super::shared::{Filter, Friction, Model, Reading, Report, Sampling, Tables, Threads};
use clap::{Args, ValueEnum};
use std::ffi::OsString;
use std::path::PathBuf;

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction inverse gough\n\
    \x20 stiction inverse robot.toml --motion lift --load part -o results\n\
    \x20 stiction inverse five-bar --motion \"tool.x = 50 mm*sin(2*pi*t); tool.y = 380 mm; duration = 1 s\"\n\
    \x20 stiction inverse five-bar --set crank=220mm --set tool.mass=0.7kg\n\
    \x20 stiction inverse gough --load none --load payload -o results\n\
    \x20 stiction inverse robot.toml --motion log.csv --filter \"20 Hz\"")]
pub(crate) struct Inverse {
    #[command(flatten)]
    pub(crate) model: Model,
    /// A motion: its name in the model, a CSV file, or assignments like "platform.x = 5 mm*sin(2*pi*t); duration = 2
    /// s"; repeatable: all motions are combined with all loads, followed by the envelope of all runs
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Vec<String>,
    #[command(flatten)]
    pub(crate) filter: Filter,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"; repeatable
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Vec<String>,
    /// Friction of joints, motors and gears: coupled with the reactions (on), computed once from frictionless reactions
    /// (one-pass), or none (off) [default: that of the model, else on]
    #[arg(long, value_name = "MODE")]
    pub(crate) friction: Option<Friction>,
    #[command(flatten)]
    pub(crate) sampling: Sampling,
    /// Find the friction margin to jamming: the factor by which all friction coefficients can grow
    /// before friction locks the mechanism
    #[arg(long)]
    pub(crate) friction_margin: bool,
    #[command(flatten)]
    pub(crate) threads: Threads,
    #[command(flatten)]
    pub(crate) report: Report,
    /// Write inverse.csv, reactions.csv, friction.csv, bodies.csv, summary.json, plots and a report into this folder.
    /// For several motions or loads write them into subfolders, with envelope.csv and a common plot
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) tables: Tables,
    /// Print the summary or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction compare five-bar --set-b crank=220mm\n\
    \x20 stiction compare 3rps 3rps --set-b legs.P.friction.mu=0.2 --friction on -o comparison\n\
    \x20 stiction compare old.toml new.toml --motion lift --load part")]
pub(crate) struct Compare {
    /// The first model: a file, `-` for standard input, or the name of a built-in model
    #[arg(value_name = "A")]
    pub(crate) first: OsString,
    /// The second model [default: the first]
    #[arg(value_name = "B")]
    pub(crate) second: Option<OsString>,
    /// Change a value of both models, as in `stiction inverse --help`; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// Change a value of the first model; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set_a: Vec<String>,
    /// Change a value of the second model; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set_b: Vec<String>,
    /// The motion of both models: its name in the models, a CSV file, or assignments; see `stiction inverse --help`
    /// [default: that of each model]
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    #[command(flatten)]
    pub(crate) filter: Filter,
    /// The load on both models: its name in the models, or assignments like "platform.fz = -100 N" [default: that of
    /// each model]
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Option<String>,
    /// Friction of joints, motors and gears: coupled with the reactions (on), computed once from frictionless reactions
    /// (one-pass), or none (off) [default: that of each model, else on]
    #[arg(long, value_name = "MODE")]
    pub(crate) friction: Option<Friction>,
    #[command(flatten)]
    pub(crate) sampling: Sampling,
    /// Find the friction margin to jamming of both models: the factor by which all friction coefficients can grow before
    /// friction locks the mechanism
    #[arg(long)]
    pub(crate) friction_margin: bool,
    #[command(flatten)]
    pub(crate) threads: Threads,
    #[command(flatten)]
    pub(crate) report: Report,
    /// Write compare.csv, compare.json and drives.svg into this folder, and the results of each model into its
    /// subfolders A and B
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print the figures and both summaries, or the error, as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction sweep five-bar --vary \"crank = 180 mm..240 mm in 7\" --objective \"peak(left_motor.effort)\"\n\
    \x20 stiction sweep 3rps --vary \"legs.P.friction.mu = 0.05..0.3 in 6\" --friction on --objective \"work(leg1.P.power)\"\n\
    \x20 stiction sweep 3rps --motion \"platform.rx = 0; platform.ry = 0; duration = 0\" \\\n\
    \x20     --vary \"motion.platform.z = 500 mm..600 mm in 11\" --objective \"min(distance.actuation)\"\n\
    \x20 stiction sweep robot.toml --table designs.csv --objective \"rms(A.motor_torque)\" -o part2 --shard 2/8\n\
    \x20 stiction sweep --merge part1 part2 -o all")]
pub(crate) struct Sweep {
    #[command(flatten)]
    pub(crate) model: Model,
    /// A key of the model or a parameter, as in --set, and its values: "mu = 0.05..0.3 in 6", with `log` for
    /// equal ratios, "crank = [200 mm, 220 mm]", or an interval to be sampled, "mu = 0.05..0.3". Keys of the
    /// motion or load begin with `motion.` or `load.`; repeatable
    #[arg(long, value_name = "KEY=VALUES")]
    pub(crate) vary: Vec<String>,
    /// A statistic of a column, like "peak(leg1.P.effort)": peak, rms, mean, min, max, range, final or work of any
    /// column in the tables that `inverse` writes; repeatable
    #[arg(long, value_name = "FUNCTION(COLUMN)")]
    pub(crate) objective: Vec<String>,
    /// The design of the study: all combinations, a Latin hypercube, or Sobol's sequence [default: grid]
    #[arg(long, value_name = "DESIGN", conflicts_with = "table")]
    pub(crate) design: Option<Plan>,
    /// Number of designs for a Latin hypercube or Sobol's sequence
    #[arg(long, value_name = "N", conflicts_with = "table")]
    pub(crate) samples: Option<u64>,
    /// Seed of a sampled design; it shifts Sobol's sequence [default: 0 for a Latin hypercube, no shift]
    #[arg(long, value_name = "S", conflicts_with = "table")]
    pub(crate) seed: Option<u64>,
    /// Read the designs from a CSV file whose columns are keys, like `mu` or `tool.mass [kg]`
    #[arg(long, value_name = "FILE", conflicts_with = "vary")]
    pub(crate) table: Option<PathBuf>,
    /// The motion of all designs; see `stiction inverse --help` [default: that of the model]
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    #[command(flatten)]
    pub(crate) filter: Filter,
    /// The load of all designs: its name in the model, or assignments [default: that of the model]
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Option<String>,
    /// Friction of joints, motors and gears: coupled with the reactions (on), computed once from frictionless reactions
    /// (one-pass), or none (off) [default: that of the model, else on]
    #[arg(long, value_name = "MODE")]
    pub(crate) friction: Option<Friction>,
    #[command(flatten)]
    pub(crate) sampling: Sampling,
    /// Compute only part K of N of the designs: every N-th row, starting at row K
    #[arg(long, value_name = "K/N", value_parser = shard, default_value = "1/1", hide_default_value = true)]
    pub(crate) shard: Shard,
    #[command(flatten)]
    pub(crate) threads: Threads,
    #[command(flatten)]
    pub(crate) report: Report,
    /// Write sweep.csv, sweep.json, plots over one or two keys and a report into this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Continue an interrupted study in the folder of -o
    #[arg(long, requires = "output")]
    pub(crate) resume: bool,
    /// Merge the results in these folders, the parts of one study, into the folder of -o
    #[arg(long, value_name = "DIR", num_args = 1.., requires = "output",
        conflicts_with_all = ["name", "set", "vary", "objective", "table", "motion", "load", "shard", "resume"])]
    pub(crate) merge: Vec<PathBuf>,
    /// Print the summary or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Kind of design.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Plan {
    Grid,
    Lhs,
    Sobol,
}

/// Part of a study that is computed on its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    /// Number of the part, counted from 1.
    pub(crate) part: u64,
    pub(crate) parts: u64,
}

fn shard(text: &str) -> Result<Shard, String> {
    let numbers = text.split_once('/');
    let numbers = numbers.and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    match numbers {
        Some((part, parts)) if (1..=parts).contains(&part) => Ok(Shard { part, parts }),
        _ => Err("write K/N, like 2/8, with K from 1 to N".to_owned()),
    }
}
