//! Command line: one file for each group of commands, and one for the options that several commands share.

mod excite;
mod export;
mod forward;
mod identify;
mod inverse;
mod position;
mod shared;

use clap::{Args, Parser, Subcommand};
use std::ffi::OsString;
use std::path::PathBuf;

pub(crate) use excite::Excite;
pub(crate) use export::{Adapter, Convert, Export, Format, Function, Language, Precision, Tunable};
pub(crate) use forward::{Compensate, Forward, Method};
pub(crate) use identify::Identify;
pub(crate) use inverse::{Compare, Inverse, Plan, Shard, Sweep};
pub(crate) use position::{Breakaway, Check, Equilibrium, Linearize, View};
pub(crate) use shared::{Filter, Formats, Friction, Messages, Model, Reading, Report, Switch};

/// Inverse and forward dynamics of robots with closed kinematic chains and joint friction
///
/// Without a command, runs `inverse` on the built-in robot.
#[derive(Parser, Debug)]
#[command(name = "stiction", version, args_conflicts_with_subcommands = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) inverse: Inverse,
    #[command(flatten)]
    pub(crate) messages: Messages,
}

/// Joins each negative number, also with a unit, to the long option before it (`--step=-1 ms`), so
/// that it is read as the value of this option and not as another option.
pub(crate) fn with_negative_values(given: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let is_option = |text: &OsString| {
        text.to_str()
            .is_some_and(|text| text.len() > 2 && text.starts_with("--") && !text.contains('='))
    };
    let is_negative = |text: &OsString| {
        let rest = text.to_str().and_then(|text| text.strip_prefix('-'));
        rest.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit() || c == '.'))
    };
    let mut all: Vec<OsString> = Vec::new();
    let mut are_positional = false;
    for argument in given {
        are_positional |= argument == "--";
        match all.last_mut() {
            Some(last) if !are_positional && is_option(last) && is_negative(&argument) => {
                last.push("=");
                last.push(&argument);
            }
            _ => all.push(argument),
        }
    }
    all
}

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    /// Actuator forces with and without friction, and every joint reaction, along a motion
    Inverse(Inverse),
    /// Two models, or a model and its variant, along the same motion: their results side by side
    Compare(Compare),
    /// Motion under forces, controllers and locks, with joints that stick and slip
    Forward(Forward),
    /// Mobility, redundant constraints, statically indeterminate reactions and singular positions
    Check(Check),
    /// Statistics of inverse dynamics for many designs: grids, samples or a table of values of the model
    Sweep(Box<Sweep>),
    /// Page with the moving robot, and an animated picture of it, without forces
    View(View),
    /// Static friction at rest: the range of each actuator force, the forces at which motion begins, and whether the
    /// mechanism holds without actuators
    Breakaway(Breakaway),
    /// Static equilibria without friction, under gravity, springs, loads and efforts, and their stability
    Equilibrium(Equilibrium),
    /// Linear model about an operating point: A, B, C, D in independent coordinates, and its eigenvalues
    Linearize(Linearize),
    /// Inertia and friction from logged positions and efforts, with verdicts on what the logs determine
    Identify(Identify),
    /// Motions that excite chosen parameters for identification, within the limits of the robot, and the expected
    /// precision
    Excite(Box<Excite>),
    /// A study that ships with the program: `zhang2018`, a published paper checked equation by equation
    Study(Study),
    /// Convert an assembled mechanism to a format of another program
    Convert(Convert),
    /// Simulated controllers with and without friction compensation: tracking errors, work, limit cycles
    Compensate(Compensate),
    /// Export inverse dynamics with friction for a controller: source code in C or Rust, or an FMU
    Export(Export),
    /// List the built-in models, or print one
    Models(Models),
    /// Print the JSON Schema of the model file, for completion and checks in editors
    Schema,
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page, in roff
    Man,
}

#[derive(Args, Debug)]
pub(crate) struct Study {
    /// The study; without a name, all studies are listed
    pub(crate) name: Option<String>,
    /// Write the report into this folder: report.html, report.md, report.json, pictures and tables [default:
    /// study-NAME; with --json no folder]
    #[arg(short, long, value_name = "DIR", requires = "name")]
    pub(crate) output: Option<PathBuf>,
    /// Print findings and tables or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Models {
    /// The model to print
    pub(crate) name: Option<String>,
    /// Print the list as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
