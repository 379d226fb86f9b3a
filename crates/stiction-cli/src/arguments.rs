//! The command line.

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use stiction_core::dynamics::FrictionMode;

/// What a robot with closed kinematic chains needs from its actuators when its joints have friction
///
/// Without a command, runs `inverse` on the built-in robot.
#[derive(Parser, Debug)]
#[command(name = "stiction", version, args_conflicts_with_subcommands = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) inverse: Inverse,
}

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    /// Driving forces with and without friction, and every joint reaction, along a motion
    Inverse(Inverse),
    /// What a mechanism does under forces, controllers and locks: joints stick and slip, each friction
    /// bounded by the joint's own reaction
    Forward(Forward),
    /// What a mechanism can do, what of it is redundant, unique and singular
    Check(Check),
    /// At rest: what static friction leaves open, at what driving forces motion begins, and whether
    /// the mechanism holds without drives
    Breakaway(Breakaway),
    /// A study that comes with the program: `zhang2018`, a paper equation by equation
    Study(Study),
    /// Write a mechanism, assembled, for other programs
    Convert(Convert),
    /// List the built-in models, or print one
    Models(Models),
    /// Print the JSON Schema of the model file, for editors
    Schema,
}

#[derive(Args, Debug)]
pub(crate) struct Inverse {
    /// A model file, `-` for standard input, or the name of a built-in model (`stiction models`)
    pub(crate) model: Option<String>,
    /// A motion: its name in the model, a CSV file, or assignments like
    /// "platform.x = 5 mm*sin(2*pi*t); duration = 2 s"
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Option<String>,
    /// Friction: coupled with the reactions it comes from (on), once from frictionless reactions
    /// (one-pass), or none (off) [default: as the model says, else on]
    #[arg(long, value_name = "MODE")]
    pub(crate) friction: Option<Friction>,
    /// Time between samples in seconds [default: as the motion says, else 0.01]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Find out by which factor all coefficients of friction can grow before friction locks the
    /// mechanism
    #[arg(long)]
    pub(crate) friction_margin: bool,
    /// Threads that compute; results do not depend on their number [default: as many as the machine
    /// has processors]
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<std::num::NonZeroUsize>,
    /// Write inverse.csv, reactions.csv, friction.csv, bodies.csv, summary.json and plots into this
    /// folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print the summary, or what is wrong, as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Forward {
    /// A model file, `-` for standard input, or the name of a built-in model (`stiction models`)
    /// [default: zhang2018-regular]
    pub(crate) model: Option<String>,
    /// The motion that it starts on and follows: its name in the model, a CSV file, or assignments;
    /// see `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// Efforts of actuators: assignments like "leg1.P = 50 N*sin(2*pi*t); leg2.P = 20 N", a CSV file
    /// such as the inverse.csv of a run, `inverse` (what inverse dynamics says for the motion), or
    /// `none` [default: none]
    #[arg(long, value_name = "DRIVES")]
    pub(crate) drives: Option<String>,
    /// A controller that follows the motion: `pd`, `computed-torque`, `computed-torque+friction`, a
    /// TOML file, assignments like "type = pd; period = 2 ms; leg1.P.limit = 300 N", or `none`
    /// [default: computed-torque, if neither --drives nor --prescribe is given]
    #[arg(long, value_name = "CONTROLLER")]
    pub(crate) controller: Option<String>,
    /// Actuators that move exactly as the motion says, whatever effort that takes
    #[arg(long, value_name = "ACTUATOR", value_delimiter = ',')]
    pub(crate) prescribe: Vec<String>,
    /// Joints that are locked where they start, driven or not
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    pub(crate) hold: Vec<String>,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Option<String>,
    /// Where it starts: `motion` (as the motion does), `rest` (there, but at rest), or assignments like
    /// "A = 60 deg + 2 rad/s*t", position and rate at t = 0; what they leave open is as in the model
    /// [default: motion]
    #[arg(long, value_name = "STATE")]
    pub(crate) from: Option<String>,
    /// The last instant in seconds [default: the end of what is followed, else 10 s after the start]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
    /// Time between samples in seconds [default: as the motion says, else 0.01]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Whether friction acts [default: as the model says, else on]
    #[arg(long, value_name = "MODE")]
    pub(crate) friction: Option<Switch>,
    /// How time is passed: from event to event, in steps of a nonsmooth time stepper, or whichever goes
    #[arg(long, value_name = "METHOD", default_value = "automatic")]
    pub(crate) method: Method,
    /// Relative error of a step of integration; of the time stepper a thousand times as much
    #[arg(long, value_name = "NUMBER", default_value = "1e-10", allow_negative_numbers = true)]
    pub(crate) tolerance: f64,
    /// How often a run with -o writes down where it is, in seconds of waiting
    #[arg(long, value_name = "SECONDS", default_value = "60", allow_negative_numbers = true)]
    pub(crate) checkpoint: f64,
    /// Go on where a run with the same options and the same -o was interrupted; --until may be another
    #[arg(long, requires = "output")]
    pub(crate) resume: bool,
    /// Write forward.csv, reactions.csv, friction.csv, bodies.csv, energy.csv, events.csv, motion.csv,
    /// summary.json and plots into this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print the summary, or what is wrong, as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// How a simulation passes time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    Automatic,
    EventDriven,
    TimeStepping,
}

/// On or off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Switch {
    On,
    Off,
}

#[derive(Args, Debug)]
pub(crate) struct Check {
    /// A model file, `-` for standard input, or the name of a built-in model (`stiction models`)
    /// [default: zhang2018-regular]
    pub(crate) model: Option<String>,
    /// The motion along which to look: its name in the model, a CSV file, or assignments; see
    /// `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// Time between samples in seconds [default: as the motion says, else 0.01]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Write check.html, a report with a picture of the mechanism, check.json and mechanism.svg into
    /// this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print the findings, or what is wrong, as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Breakaway {
    /// A model file, `-` for standard input, or the name of a built-in model (`stiction models`)
    /// [default: zhang2018-regular]
    pub(crate) model: Option<String>,
    /// The motion on whose way the position is: its name in the model, a CSV file, or assignments
    /// like "A = 60 deg; duration = 0 s"; see `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// The instant of the motion at which the mechanism stands still, in seconds [default: its
    /// start]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub(crate) at: Option<f64>,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Option<String>,
    /// Print the findings, or what is wrong, as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Study {
    /// Which study; without a name they are listed
    pub(crate) name: Option<String>,
    /// Write the report into this folder: report.html, report.md, report.json, pictures and tables
    /// [default: study-NAME; with --json none]
    #[arg(short, long, value_name = "DIR", requires = "name")]
    pub(crate) output: Option<PathBuf>,
    /// Print findings and tables, or what is wrong, as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Convert {
    /// A model file, `-` for standard input, or the name of a built-in model (`stiction models`)
    pub(crate) model: String,
    /// The format
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: Format,
    /// The motion at whose first instant the mechanism is put together: its name in the model, a CSV
    /// file, or assignments; see `stiction inverse --help` [default: as the model says]
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// Write into this file [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

/// What other programs read.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Format {
    /// The mechanism as plain numbers, a format of this program
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

/// How friction is coupled.
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
