//! The command line.

use clap::{Args, ColorChoice, Parser, Subcommand, ValueEnum};
use std::ffi::OsString;
use std::path::PathBuf;
use stiction::FrictionMode;
use stiction_format::{hertz, length_or_angle, seconds};

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

/// Options on the messages of the program.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Messages {
    /// Print results, warnings and errors only: no notes and no progress
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// When to print messages in colour
    #[arg(long, value_name = "WHEN", default_value = "auto", global = true)]
    pub(crate) color: ColorChoice,
}

/// The model of a command.
#[derive(Args, Debug)]
pub(crate) struct Model {
    /// A model file, `-` for standard input, or the name of a built-in model (`stiction models`)
    /// [default: zhang2018-regular]
    #[arg(value_name = "MODEL")]
    pub(crate) name: Option<OsString>,
    /// Change a value of the model: the path of a key or the name of a parameter, and the value, like
    /// bodies.platform.mass=2kg, legs.P.friction.mu=0.12 or mu=0.12; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    #[command(flatten)]
    pub(crate) reading: Reading,
}

/// How robot files of other programs are read.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct Reading {
    /// Keep every joint of a URDF, MJCF or SDF as it is, instead of recognising hinges and balls
    #[arg(long)]
    pub(crate) literal: bool,
    /// A folder in which packages and models are looked for (package://, model://); repeatable
    #[arg(long, value_name = "DIR")]
    pub(crate) package_path: Vec<PathBuf>,
}

impl Reading {
    pub(crate) fn import(&self) -> stiction::Import {
        stiction::Import { literal: self.literal, package_paths: self.package_path.clone() }
    }
}

/// The filter of recorded motions.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Filter {
    /// Low-pass filter a recorded motion, without phase shift: the cut-off frequency (-3 dB), in Hz or with a
    /// unit ("20 Hz"); the caution on a noisy recording suggests one [default: as the motion says, else none]
    #[arg(long, value_name = "FREQUENCY", value_parser = hertz, allow_negative_numbers = true)]
    pub(crate) filter: Option<f64>,
}

/// The format of tables.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct Tables {
    /// Format of the tables: csv, npz (a NumPy archive with an array for each column), or both: csv,npz
    /// [default: csv]
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', requires = "output")]
    pub(crate) format: Vec<TableFormat>,
}

/// Format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TableFormat {
    Csv,
    Npz,
}

/// Formats in which tables are written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Formats {
    pub(crate) csv: bool,
    pub(crate) npz: bool,
}

impl Tables {
    pub(crate) fn formats(&self) -> Formats {
        let has = |format| self.format.contains(&format);
        Formats { csv: has(TableFormat::Csv) || self.format.is_empty(), npz: has(TableFormat::Npz) }
    }
}

/// The report of a run.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Report {
    /// Write report.html with the other results: a page with headline figures, the moving robot, plots,
    /// peaks and verdicts, that needs no other file
    #[arg(long, value_name = "MODE", default_value = "on")]
    pub(crate) report: Switch,
    /// Open the report in a browser; without -o, the results go into a temporary folder
    #[arg(long)]
    pub(crate) open: bool,
}

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    /// Actuator forces with and without friction, and every joint reaction, along a motion
    Inverse(Inverse),
    /// Two models, or a model and its variant, along the same motion: figures side by side
    Compare(Compare),
    /// The motion under forces, controllers and locks, with joints that stick and slip
    Forward(Forward),
    /// Mobility, redundant constraints, statically indeterminate reactions and singular positions
    Check(Check),
    /// Statistics of inverse dynamics for many designs: grids, samples or a table of values of the model
    Sweep(Box<Sweep>),
    /// The robot and its motion without forces: a page with the moving robot, and a moving picture
    View(View),
    /// Static friction at rest: the range of each actuator force, the forces at which motion begins, and
    /// whether the mechanism holds without drives
    Breakaway(Breakaway),
    /// Positions of rest without friction, under gravity, springs, loads and efforts, and their stability
    Equilibrium(Equilibrium),
    /// Linear model about an operating point: A, B, C, D in independent coordinates, and its eigenvalues
    Linearize(Linearize),
    /// Inertia and friction from logged positions and efforts, with what the logs cannot tell
    Identify(crate::identify::Identify),
    /// A study that ships with the program: `zhang2018`, a paper equation by equation
    Study(Study),
    /// Write an assembled mechanism in a format of other programs
    Convert(Convert),
    /// Controllers with and without friction compensation on the simulated robot: tracking errors, work,
    /// limit cycles
    Compensate(Compensate),
    /// Write inverse dynamics with friction for a controller: source code in C or Rust, or an FMU
    Export(Export),
    /// List the built-in models, or print one
    Models(Models),
    /// Print the JSON Schema of the model file, for editors that complete and check it
    Schema,
    /// Print completions for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page, in roff
    Man,
}

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
    /// A motion: its name in the model, a CSV file, or assignments like
    /// "platform.x = 5 mm*sin(2*pi*t); duration = 2 s"; repeatable: all motions run with all loads, and
    /// their envelope follows
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Vec<String>,
    #[command(flatten)]
    pub(crate) filter: Filter,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"; repeatable
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Vec<String>,
    /// Joint friction: coupled with the reactions (on), computed once from frictionless reactions
    /// (one-pass), or none (off) [default: as the model says, else on]
    #[arg(long, value_name = "MODE")]
    pub(crate) friction: Option<Friction>,
    /// Time between samples, in seconds or with a unit ("10 ms") [default: as the motion says, else 0.01]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Find the friction margin to jamming: the factor by which all friction coefficients can grow
    /// before friction locks the mechanism
    #[arg(long)]
    pub(crate) friction_margin: bool,
    /// Number of threads; results do not depend on it [default: one for each processor]
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<std::num::NonZeroUsize>,
    #[command(flatten)]
    pub(crate) report: Report,
    /// Write inverse.csv, reactions.csv, friction.csv, bodies.csv, summary.json, plots and a report into
    /// this folder; of several motions or loads into folders below it, with envelope.csv and a common plot
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
    /// The motion of both: its name in the models, a CSV file, or assignments; see `stiction inverse
    /// --help` [default: that of each model]
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    #[command(flatten)]
    pub(crate) filter: Filter,
    /// The load of both: its name in the models, or assignments like "platform.fz = -100 N" [default:
    /// that of each model]
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Option<String>,
    /// Joint friction: coupled with the reactions (on), computed once from frictionless reactions
    /// (one-pass), or none (off) [default: as each model says, else on]
    #[arg(long, value_name = "MODE")]
    pub(crate) friction: Option<Friction>,
    /// Time between samples, in seconds or with a unit ("10 ms") [default: as the motion says, else 0.01]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Number of threads; results do not depend on it [default: one for each processor]
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<std::num::NonZeroUsize>,
    #[command(flatten)]
    pub(crate) report: Report,
    /// Write compare.csv, compare.json, drives.svg, and the results of each model in the folders A and B
    /// below this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print the figures and both summaries, or the error, as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction forward 3rps --until 2s -o results\n\
    \x20 stiction forward four-bar --from \"A = 60 deg\" --drives none\n\
    \x20 stiction forward 3rps --controller pd --step 5ms\n\
    \x20 stiction forward gough --load none --load payload -o results\n\
    \x20 stiction forward four-bar --drives none --from \"A = 60 deg\" --stop \"A > 90 deg\"")]
pub(crate) struct Forward {
    #[command(flatten)]
    pub(crate) model: Model,
    /// The motion on which the mechanism starts and which it follows: its name in the model, a CSV file,
    /// or assignments; see `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    #[command(flatten)]
    pub(crate) filter: Filter,
    /// Efforts of actuators: assignments like "leg1.P = 50 N*sin(2*pi*t); leg2.P = 20 N", also over
    /// measured coordinates and rates, "A = -200 N m/rad*A - 5 N m s/rad*d(A)", a CSV file
    /// such as the inverse.csv of a run, `inverse` (the efforts of inverse dynamics for the motion), or
    /// `none` [default: none]
    #[arg(long, value_name = "DRIVES")]
    pub(crate) drives: Option<String>,
    /// A controller that follows the motion: `pd`, `computed-torque`, `computed-torque+friction`, a
    /// TOML file, assignments like "type = pid; ki = 2 kN/(m s); period = 2 ms; leg1.P.limit = 300 N", or
    /// `none`
    /// [default: computed-torque, if neither --drives nor --prescribe is given]
    #[arg(long, value_name = "CONTROLLER")]
    pub(crate) controller: Option<String>,
    /// Actuators that follow the motion exactly; their efforts are results
    #[arg(long, value_name = "ACTUATOR", value_delimiter = ',')]
    pub(crate) prescribe: Vec<String>,
    /// Joints that are locked at their start positions, with or without actuators
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    pub(crate) hold: Vec<String>,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"; repeatable: each load has
    /// a run, and their envelope follows
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Vec<String>,
    /// The start: `motion` (position and rates of the motion), `rest` (its position, at rest), or
    /// assignments like "A = 60 deg + 2 rad/s*t", whose values and rates at t = 0 count, or with rates
    /// apart, "A = 60 deg; d(B) = 2 rad/s"; all other coordinates follow from the loops and the
    /// model's home position [default: motion]
    #[arg(long, value_name = "STATE")]
    pub(crate) from: Option<String>,
    /// The end, in seconds or with a unit [default: the end of the followed motion, else 10 s after the start]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
    /// Ends the run as soon as this holds, like "platform.z < 100 mm" or "d(A) > 2 rad/s"; repeatable
    #[arg(long, value_name = "CONDITION")]
    pub(crate) stop: Vec<String>,
    /// Time between samples, in seconds or with a unit ("10 ms") [default: as the motion says, else 0.01]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Joint friction [default: as the model says, else on]
    #[arg(long, value_name = "MODE")]
    pub(crate) friction: Option<Switch>,
    /// Integration scheme: event-driven, time-stepping, or automatic (event-driven with time-stepping as
    /// fallback)
    #[arg(long, value_name = "METHOD", default_value = "automatic")]
    pub(crate) method: Method,
    /// Relative error of an integration step; that of a time step is a thousand times as large
    #[arg(long, value_name = "NUMBER", default_value = "1e-10", allow_negative_numbers = true)]
    pub(crate) tolerance: f64,
    /// Wall-clock time between two checkpoints of a run with -o, in seconds or with a unit
    #[arg(long, value_name = "TIME", value_parser = seconds, default_value = "60", allow_negative_numbers = true)]
    pub(crate) checkpoint: f64,
    /// Wall-clock time after which the run ends, in seconds or with a unit; the results up to then
    /// are complete, and --resume continues
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) time_limit: Option<f64>,
    /// Resume an interrupted run with the same options and the same -o; --until may differ
    #[arg(long, requires = "output")]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) report: Report,
    /// Write forward.csv, reactions.csv, friction.csv, bodies.csv, energy.csv, events.csv, motion.csv,
    /// summary.json, plots and a report into this folder; of several loads into folders below it, with
    /// envelope.csv and a common plot
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) tables: Tables,
    /// Print the summary or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Integration scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    Automatic,
    EventDriven,
    TimeStepping,
}

/// A switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Switch {
    On,
    Off,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction check gough\n\
    \x20 stiction check robot.toml --motion lift -o results")]
pub(crate) struct Check {
    #[command(flatten)]
    pub(crate) model: Model,
    /// The motion along which the mechanism is checked: its name in the model, a CSV file, or assignments; see
    /// `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    #[command(flatten)]
    pub(crate) filter: Filter,
    /// Time between samples, in seconds or with a unit ("10 ms") [default: as the motion says, else 0.01]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Write check.html, a report with a picture of the mechanism, check.json and mechanism.svg into
    /// this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print the findings or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction view delta\n\
    \x20 stiction view robot.toml --motion lift -o pictures")]
pub(crate) struct View {
    #[command(flatten)]
    pub(crate) model: Model,
    /// The motion: its name in the model, a CSV file, or assignments; see `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    #[command(flatten)]
    pub(crate) filter: Filter,
    /// Time between samples, in seconds or with a unit ("10 ms") [default: as the motion says, else 0.01]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Write report.html, the page, and moving.svg, a picture for a README, into this folder [default: a
    /// temporary folder, and the page opens]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Open the page in a browser, with -o too
    #[arg(long)]
    pub(crate) open: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction breakaway 3rps\n\
    \x20 stiction breakaway five-bar --load payload --at \"0.2 s\"")]
pub(crate) struct Breakaway {
    #[command(flatten)]
    pub(crate) model: Model,
    /// The motion that leads to the position: its name in the model, a CSV file, or assignments
    /// like "A = 60 deg; duration = 0 s"; see `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// The time of the motion at which the mechanism rests, in seconds or with a unit [default: the
    /// start of the motion]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) at: Option<f64>,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Option<String>,
    #[command(flatten)]
    pub(crate) report: Report,
    /// Write breakaway.json and a report into this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print the findings or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction equilibrium four-bar\n\
    \x20 stiction equilibrium robot.toml --hold crank --load part\n\
    \x20 stiction equilibrium four-bar --from \"A = 60 deg\" --nearest")]
pub(crate) struct Equilibrium {
    #[command(flatten)]
    pub(crate) model: Model,
    /// The motion whose first position starts the search; see `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// Where the search starts, as in `stiction forward --help` [default: motion]
    #[arg(long, value_name = "STATE")]
    pub(crate) from: Option<String>,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Option<String>,
    /// Efforts of actuators, as in `stiction forward --help` [default: none]
    #[arg(long, value_name = "DRIVES")]
    pub(crate) drives: Option<String>,
    /// Joints that are locked at their start positions, with or without actuators
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    pub(crate) hold: Vec<String>,
    /// Take the nearest equilibrium, stable or not, instead of the stable one down the potential
    #[arg(long)]
    pub(crate) nearest: bool,
    /// Print the findings or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction linearize five-bar --friction off\n\
    \x20 stiction linearize robot.toml --motion lift --at \"0.4 s\" -o linear\n\
    \x20 stiction linearize four-bar --from \"A = 60 deg; d(A) = 2 rad/s\" --json")]
pub(crate) struct Linearize {
    #[command(flatten)]
    pub(crate) model: Model,
    /// The motion that leads to the operating point; see `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// The time of the motion, in seconds or with a unit [default: the start of the motion]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true, conflicts_with = "from")]
    pub(crate) at: Option<f64>,
    /// The operating point, as in `stiction forward --help`: like "A = 60 deg; d(B) = 2 rad/s"
    /// [default: motion]
    #[arg(long, value_name = "STATE")]
    pub(crate) from: Option<String>,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Option<String>,
    /// Efforts at the operating point, as in `stiction forward --help` [default: inverse if the actuators
    /// determine the motion, else none]
    #[arg(long, value_name = "DRIVES")]
    pub(crate) drives: Option<String>,
    /// Joints that are locked, with or without actuators
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    pub(crate) hold: Vec<String>,
    /// Joint friction [default: as the model says, else on]
    #[arg(long, value_name = "MODE")]
    pub(crate) friction: Option<Switch>,
    /// Write A.csv, B.csv, C.csv, D.csv and linearize.json into this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print the model or the error as JSON
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
    /// A statistic of a column, like "peak(leg1.P.effort)": peak, rms, mean, min, max, range, final or work of
    /// any column of the tables that `inverse` writes; repeatable
    #[arg(long, value_name = "FUNCTION(COLUMN)")]
    pub(crate) objective: Vec<String>,
    /// All combinations, a Latin hypercube, or Sobol's sequence [default: grid]
    #[arg(long, value_name = "DESIGN", conflicts_with = "table")]
    pub(crate) design: Option<Plan>,
    /// Number of designs of a sampled plan
    #[arg(long, value_name = "N", conflicts_with = "table")]
    pub(crate) samples: Option<u64>,
    /// Seed of a sampled plan; Sobol's sequence is shifted by it [default: 0 for a Latin hypercube, no shift]
    #[arg(long, value_name = "S", conflicts_with = "table")]
    pub(crate) seed: Option<u64>,
    /// Take the designs from a CSV file whose columns are keys, like `mu` or `tool.mass [kg]`
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
    /// Joint friction: coupled with the reactions (on), computed once from frictionless reactions
    /// (one-pass), or none (off) [default: as the model says, else on]
    #[arg(long, value_name = "MODE")]
    pub(crate) friction: Option<Friction>,
    /// Time between samples, in seconds or with a unit ("10 ms") [default: as the motion says, else 0.01]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Compute one part of the designs only: part K of N, every N-th row from row K
    #[arg(long, value_name = "K/N", value_parser = shard, default_value = "1/1", hide_default_value = true)]
    pub(crate) shard: Shard,
    /// Number of threads; results do not depend on it [default: one for each processor]
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<std::num::NonZeroUsize>,
    /// Write sweep.csv, sweep.json and plots over one or two keys into this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Continue an interrupted study in the folder of -o
    #[arg(long, requires = "output")]
    pub(crate) resume: bool,
    /// Merge the folders of all parts of a study into that of -o
    #[arg(long, value_name = "DIR", num_args = 1.., requires = "output",
        conflicts_with_all = ["name", "set", "vary", "objective", "table", "motion", "load", "shard", "resume"])]
    pub(crate) merge: Vec<PathBuf>,
    /// Print the summary or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Choice of designs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Plan {
    Grid,
    Lhs,
    Sobol,
}

/// Part of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    /// Number of the part, from 1.
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

#[derive(Args, Debug)]
pub(crate) struct Study {
    /// The study; without a name, all studies are listed
    pub(crate) name: Option<String>,
    /// Write the report into this folder: report.html, report.md, report.json, pictures and tables
    /// [default: study-NAME; with --json none]
    #[arg(short, long, value_name = "DIR", requires = "name")]
    pub(crate) output: Option<PathBuf>,
    /// Print findings and tables or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction convert robot.urdf -o robot.toml\n\
    \x20 stiction convert gough --to mjcf -o gough.xml\n\
    \x20 stiction convert robot.toml --to model")]
pub(crate) struct Convert {
    /// A model file, a URDF, MJCF or SDF, `-` for standard input, or the name of a built-in model
    /// (`stiction models`)
    pub(crate) model: OsString,
    /// Change a value of the model, as in `stiction inverse --help`; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// The format [default: by the ending of the file of -o; a model file for a URDF, MJCF or SDF]
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: Option<Format>,
    /// The motion at whose first instant the mechanism is assembled: its name in the model, a CSV
    /// file, or assignments; see `stiction inverse --help` [default: as the model says]
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// Write into this file [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: Reading,
}

/// Format of the converted mechanism.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// The mechanism as plain numbers, in a JSON format of this program
    Json,
    /// MuJoCo's XML
    Mjcf,
    /// URDF, with a YAML file beside it that closes loops and names motors
    Urdf,
    /// SDF, the format of Gazebo
    Sdf,
    /// A model file of this program: legs written out, formulas evaluated
    Model,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction export 3rps --to c -o code && make -C code test\n\
    \x20 stiction export robot.toml --to c --precision float --own-math -o code\n\
    \x20 stiction export five-bar --to rust --payload tool -o code")]
pub(crate) struct Export {
    #[command(flatten)]
    pub(crate) model: Model,
    /// The programming language, or a functional mock-up unit
    #[arg(long, value_name = "LANGUAGE")]
    pub(crate) to: Language,
    /// Write the code, its self-test with test vectors, build files and README.md into this folder; an
    /// FMU into this file
    #[arg(short, long, value_name = "PATH")]
    pub(crate) output: PathBuf,
    /// Version of the FMI standard
    #[arg(long, value_name = "VERSION", default_value = "3", value_parser = clap::value_parser!(u8).range(2..=3))]
    pub(crate) fmi: u8,
    /// Name of the files and beginning of all names in the code [default: made of the model's name]
    #[arg(long = "name", value_name = "NAME")]
    pub(crate) prefix: Option<String>,
    /// Floating-point type
    #[arg(long, value_name = "TYPE", default_value = "double")]
    pub(crate) precision: Precision,
    /// Include sine and cosine in the code, instead of those of the mathematical library
    #[arg(long)]
    pub(crate) own_math: bool,
    /// Numbers of the model that can be changed at run time
    #[arg(long, value_name = "KIND", value_delimiter = ',', default_value = "friction")]
    pub(crate) tunable: Vec<Tunable>,
    /// A body that carries a point mass, whose size and place can be changed at run time
    #[arg(long, value_name = "BODY")]
    pub(crate) payload: Option<String>,
    /// Number of test vectors
    #[arg(long, value_name = "N", default_value = "200", value_parser = clap::value_parser!(u32).range(0..=100_000))]
    pub(crate) vectors: u32,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction compensate\n\
    \x20 stiction compensate five-bar --known-to 30% --resolution \"0.1 mrad\" --delay \"1 ms\"\n\
    \x20 stiction compensate gough --controller computed-torque,computed-torque+friction -o results")]
pub(crate) struct Compensate {
    #[command(flatten)]
    pub(crate) model: Model,
    /// The motion that the robot follows: its name in the model, a CSV file, or assignments; see
    /// `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// A load on the robot, which no controller knows
    #[arg(long, value_name = "LOAD", default_value = "none")]
    pub(crate) load: String,
    /// Controllers to compare: `pd`, `computed-torque`, each also with `+coulomb` (the best constant friction
    /// of each actuator), `computed-torque+friction` (the friction of the model) [default: all]
    #[arg(long, value_name = "CONTROLLER", value_delimiter = ',')]
    pub(crate) controller: Vec<String>,
    /// Bandwidth of the position control, in Hz or with a unit
    #[arg(long, value_name = "FREQUENCY", default_value = "5 Hz", value_parser = hertz, allow_negative_numbers = true)]
    pub(crate) bandwidth: f64,
    /// Time between samples of the controller, in seconds or with a unit
    #[arg(long, value_name = "TIME", default_value = "1 ms", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) period: f64,
    /// Accuracy to which the friction model knows each coefficient; the differences are random
    #[arg(long, value_name = "PART", default_value = "10%", value_parser = part, allow_negative_numbers = true)]
    pub(crate) known_to: f64,
    /// Seed of the random differences and of the noise
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) seed: u64,
    /// Increment of the encoders, in m or rad or with a unit
    #[arg(long, value_name = "SIZE", default_value = "0", value_parser = length_or_angle, allow_negative_numbers = true)]
    pub(crate) resolution: f64,
    /// Standard deviation of the noise of each measured position, in m or rad or with a unit
    #[arg(long, value_name = "SIZE", default_value = "0", value_parser = length_or_angle, allow_negative_numbers = true)]
    pub(crate) noise: f64,
    /// Time between measurement and effort, in seconds or with a unit
    #[arg(long, value_name = "TIME", default_value = "0", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) delay: f64,
    /// Write compensate.json and compensate.csv, the tracking errors over time, into this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print the figures or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// A part of one: a number, or percent.
fn part(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, factor) = match text.strip_suffix('%') {
        Some(number) => (number.trim(), 0.01),
        None => (text, 1.0),
    };
    let number: f64 = number.parse().map_err(|_| "expected a number or percent".to_owned())?;
    Ok(number * factor)
}

/// Programming language of exported code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Language {
    /// C99
    C,
    /// Rust without its standard library
    Rust,
    /// Functional mock-up unit for co-simulation, with source code in C99
    Fmu,
}

/// Floating-point type of exported code.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Precision {
    Double,
    Float,
}

/// Numbers that can be changed at run time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Tunable {
    /// None
    None,
    /// Coefficients of all friction interfaces
    Friction,
    /// Masses of all bodies
    Masses,
}

#[derive(Args, Debug)]
pub(crate) struct Models {
    /// The model to print
    pub(crate) name: Option<String>,
    /// Print the list as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Coupling of friction and reactions.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Friction {
    On,
    OnePass,
    Off,
}

impl From<Friction> for FrictionMode {
    fn from(friction: Friction) -> Self {
        match friction {
            Friction::On => Self::Converged,
            Friction::OnePass => Self::OnePass,
            Friction::Off => Self::Off,
        }
    }
}
