//! The command that identifies a robot.

use super::shared::{Reading, Report};
use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;
use stiction_format::hertz;

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction identify robot.toml log.csv -o results\n\
    \x20 stiction identify robot.toml light.csv heavy.csv check.csv --options log.toml -o results\n\
    \x20 stiction identify --template > log.toml")]
pub(crate) struct Identify {
    /// A model file, or the name of a built-in model (`stiction models`); its values are the initial values
    #[arg(value_name = "MODEL", required_unless_present = "template")]
    pub(crate) model: Option<OsString>,
    /// Logs: CSV files with `time [s]`, coordinates like `leg1.P [m]`, and efforts like `leg1.P.effort [N]`,
    /// `A.motor_torque [N m]` or `A.current [A]`
    #[arg(value_name = "LOG", required_unless_present = "template")]
    pub(crate) logs: Vec<String>,
    /// Options in a TOML file: payloads, units, logs for prediction, held, bounded and tied parameters [default: the
    /// file named like the first log, but with the extension .toml, if it exists]
    #[arg(long, value_name = "FILE")]
    pub(crate) options: Option<PathBuf>,
    /// Print an options file that contains every key
    #[arg(long)]
    pub(crate) template: bool,
    /// Cut-off frequency of the zero-phase low-pass filter, in Hz or with a unit ("10 Hz") [default: that of the
    /// options, else chosen from the positions]
    #[arg(long, value_name = "FREQUENCY", value_parser = hertz, allow_negative_numbers = true)]
    pub(crate) filter: Option<f64>,
    /// Change a value of the model; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// Write identified.toml even if the fit fails
    #[arg(long)]
    pub(crate) force: bool,
    /// Write identified.toml, identify.json, efforts.csv and report.html into this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) report: Report,
    /// Print the results or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
