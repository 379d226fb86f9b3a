//! Options that several commands share.

use clap::{Args, ColorChoice, ValueEnum};
use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use stiction::FrictionMode;
use stiction_format::{hertz, seconds};

/// Options for the messages of the program.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Messages {
    /// Print results, warnings and errors, but neither notes nor progress
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// Print messages in colour: always, never, or automatically if the output is a terminal
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

/// Options for reading robot files of other programs.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct Reading {
    /// Keep every joint of a URDF, MJCF or SDF unchanged; by default, a combination of joints that acts as one hinge or
    /// ball joint is replaced by it
    #[arg(long)]
    pub(crate) literal: bool,
    /// A folder to search for packages and models (package://, model://); repeatable
    #[arg(long, value_name = "DIR")]
    pub(crate) package_path: Vec<PathBuf>,
}

impl Reading {
    pub(crate) fn import(&self) -> stiction::Import {
        stiction::Import { literal: self.literal, package_paths: self.package_path.clone() }
    }
}

/// Filter for recorded motions.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Filter {
    /// Filter recorded motions with a zero-phase low-pass filter; the value is the cut-off frequency (-3 dB), in Hz or
    /// with a unit ("20 Hz"). The caution on a noisy recording suggests one [default: that of the motion, else none]
    #[arg(long, value_name = "FREQUENCY", value_parser = hertz, allow_negative_numbers = true)]
    pub(crate) filter: Option<f64>,
}

/// Format of tables.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct Tables {
    /// Format of the tables: csv, npz (NumPy archives with an array for each column), mcap (one log with joint states
    /// and a moving skeleton), or several: csv,npz [default: csv]
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', requires = "output")]
    pub(crate) format: Vec<TableFormat>,
}

/// Format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TableFormat {
    Csv,
    Npz,
    Mcap,
}

/// Formats in which tables are written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Formats {
    pub(crate) csv: bool,
    pub(crate) npz: bool,
    pub(crate) mcap: bool,
}

impl Tables {
    pub(crate) fn formats(&self) -> Formats {
        let has = |format| self.format.contains(&format);
        Formats {
            csv: has(TableFormat::Csv) || self.format.is_empty(),
            npz: has(TableFormat::Npz),
            mcap: has(TableFormat::Mcap),
        }
    }
}

/// The report of a run.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Report {
    /// Write report.html with the other results: a self-contained page with headline figures, the moving robot, plots,
    /// peaks and verdicts
    #[arg(long, value_name = "MODE", default_value = "on")]
    pub(crate) report: Switch,
    /// Open the report in a browser; without -o, the results go into a temporary folder
    #[arg(long)]
    pub(crate) open: bool,
}

/// Switch: on or off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Switch {
    On,
    Off,
}

/// Friction mode.
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

/// Sampling of a motion.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Sampling {
    /// Time between samples, in seconds or with a unit ("10 ms") [default: that of the motion, else 0.01 s]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
}

/// Threads of a computation.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Threads {
    /// Number of threads; results do not depend on it [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub(crate) threads: Option<NonZeroUsize>,
}

fn threads(text: &str) -> Result<NonZeroUsize, String> {
    text.trim().parse().map_err(|_| "expected a whole number above 0, such as 4".to_owned())
}
