//! The command line.

use clap::{Args, ColorChoice, Parser, Subcommand, ValueEnum};
use std::ffi::OsString;
use std::path::PathBuf;
use stiction::FrictionMode;
use stiction_format::seconds;

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
}

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    /// Actuator forces with and without friction, and every joint reaction, along a motion
    Inverse(Inverse),
    /// The motion under forces, controllers and locks, with joints that stick and slip
    Forward(Forward),
    /// Mobility, redundant constraints, statically indeterminate reactions and singular positions
    Check(Check),
    /// Static friction at rest: the range of each actuator force, the forces at which motion begins, and
    /// whether the mechanism holds without drives
    Breakaway(Breakaway),
    /// A study that ships with the program: `zhang2018`, a paper equation by equation
    Study(Study),
    /// Write an assembled mechanism in a format of other programs
    Convert(Convert),
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
    \x20 stiction inverse five-bar --set crank=220mm --set tool.mass=0.7kg")]
pub(crate) struct Inverse {
    #[command(flatten)]
    pub(crate) model: Model,
    /// A motion: its name in the model, a CSV file, or assignments like
    /// "platform.x = 5 mm*sin(2*pi*t); duration = 2 s"
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Option<String>,
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
    /// Write inverse.csv, reactions.csv, friction.csv, bodies.csv, summary.json and plots into this
    /// folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print the summary or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction forward 3rps --until 2s -o results\n\
    \x20 stiction forward four-bar --from \"A = 60 deg\" --drives none\n\
    \x20 stiction forward 3rps --controller pd --step 5ms")]
pub(crate) struct Forward {
    #[command(flatten)]
    pub(crate) model: Model,
    /// The motion on which the mechanism starts and which it follows: its name in the model, a CSV file,
    /// or assignments; see `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// Efforts of actuators: assignments like "leg1.P = 50 N*sin(2*pi*t); leg2.P = 20 N", a CSV file
    /// such as the inverse.csv of a run, `inverse` (the efforts of inverse dynamics for the motion), or
    /// `none` [default: none]
    #[arg(long, value_name = "DRIVES")]
    pub(crate) drives: Option<String>,
    /// A controller that follows the motion: `pd`, `computed-torque`, `computed-torque+friction`, a
    /// TOML file, assignments like "type = pd; period = 2 ms; leg1.P.limit = 300 N", or `none`
    /// [default: computed-torque, if neither --drives nor --prescribe is given]
    #[arg(long, value_name = "CONTROLLER")]
    pub(crate) controller: Option<String>,
    /// Actuators that follow the motion exactly; their efforts are results
    #[arg(long, value_name = "ACTUATOR", value_delimiter = ',')]
    pub(crate) prescribe: Vec<String>,
    /// Joints that are locked at their start positions, with or without actuators
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    pub(crate) hold: Vec<String>,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Option<String>,
    /// The start: `motion` (position and rates of the motion), `rest` (its position, at rest), or
    /// assignments like "A = 60 deg + 2 rad/s*t", whose values and rates at t = 0 count, or with rates
    /// apart, "A = 60 deg; d(B) = 2 rad/s"; all other coordinates follow from the loops and the
    /// model's home position [default: motion]
    #[arg(long, value_name = "STATE")]
    pub(crate) from: Option<String>,
    /// The end, in seconds or with a unit [default: the end of the followed motion, else 10 s after the start]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
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
    /// Write forward.csv, reactions.csv, friction.csv, bodies.csv, energy.csv, events.csv, motion.csv,
    /// summary.json and plots into this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
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
    /// Print the findings or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
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
    \x20 stiction convert gough --to mjcf -o gough.xml\n\
    \x20 stiction convert robot.toml --to model")]
pub(crate) struct Convert {
    /// A model file, `-` for standard input, or the name of a built-in model (`stiction models`)
    pub(crate) model: OsString,
    /// Change a value of the model, as in `stiction inverse --help`; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// The format
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: Format,
    /// The motion at whose first instant the mechanism is assembled: its name in the model, a CSV
    /// file, or assignments; see `stiction inverse --help` [default: as the model says]
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// Write into this file [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

/// Format of the converted mechanism.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Format {
    /// The mechanism as plain numbers, in a JSON format of this program
    Json,
    /// MuJoCo's XML
    Mjcf,
    /// A model file of this program: legs written out, formulas evaluated
    Model,
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
