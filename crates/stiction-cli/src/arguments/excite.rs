//! The command that designs motions for identification.

use super::shared::Model;
use clap::Args;
use std::path::PathBuf;
use stiction::run::excite::LimitSetting;
use stiction_format::{Amount, hertz, seconds};

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction excite robot.toml --limit \"platform.*=40 mm\" -o excite\n\
    \x20 stiction excite robot.toml --parameters \"*.mu,*.coulomb\" --payload none,part -o excite\n\
    \x20 stiction excite five-bar --limit \"tool.*=60 mm\" --limit \"*_motor.speed=8 rad/s\" --noise \"0.05 N m\"")]
pub(crate) struct Excite {
    #[command(flatten)]
    pub(crate) model: Model,
    /// Parameters that the logs must determine, by the names that `identify` uses; * stands for any text. All other
    /// parameters keep the values of the model [default: all]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) parameters: Vec<String>,
    /// A motion of the model. The design uses its coordinates; the robot begins and ends at rest in its first position
    /// [default: the default motion of the model; without one, the actuators from their `start` values]
    #[arg(long, value_name = "NAME")]
    pub(crate) motion: Option<String>,
    /// Use the coordinates of the actuators instead of those of the motion
    #[arg(long)]
    pub(crate) actuators: bool,
    /// Duration of the motion, in seconds or with a unit; it contains a whole number of periods
    #[arg(long, value_name = "TIME", default_value = "10", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) duration: f64,
    /// Frequency of the first harmonic, in Hz or with a unit [default: one period in the duration]
    #[arg(long, value_name = "FREQUENCY", value_parser = hertz, allow_negative_numbers = true)]
    pub(crate) base_frequency: Option<f64>,
    /// Number of harmonics
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(2..=200))]
    pub(crate) harmonics: u16,
    /// A limit in addition to those of the model (ranges of joints, limits of motors): NAME=60 mm (displacement from
    /// the first position), NAME=0 mm..120 mm, NAME.speed=…, NAME.acceleration=… of a coordinate or joint,
    /// NAME.effort=… of an actuator; * stands for any text; repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = LimitSetting::parse)]
    pub(crate) limit: Vec<LimitSetting>,
    /// Least permitted singularity index, as a fraction of the index at the first position
    #[arg(long, value_name = "PART", default_value_t = 0.3, allow_negative_numbers = true)]
    pub(crate) singularity_margin: f64,
    /// Loads of the model with which the motion is repeated, one log for each; `none` or a load without payload means
    /// the robot alone [default: the robot alone]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) payload: Vec<String>,
    /// Standard deviation of the measured efforts at the joints, for the expected precision; repeatable for N and
    /// N m [default: 2 % of the root mean square of each effort]
    #[arg(long, value_name = "EFFORT", value_parser = Amount::parse)]
    pub(crate) noise: Vec<Amount>,
    /// Efforts are measured at the motors, as torque or current, so that they include the inertia of the rotors
    #[arg(long)]
    pub(crate) at_motors: bool,
    /// Seed of the random motion from which the search starts
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Largest number of steps of the search
    #[arg(long, value_name = "N", default_value_t = 90)]
    pub(crate) iterations: u32,
    /// Time between samples of the reference, in seconds or with a unit ("10 ms") [default: a hundredth of the period
    /// of the highest harmonic, rounded down to 1, 2 or 5 times a power of ten]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Write excite.csv (the reference), log.toml (options for identify) and excite.json into this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print the results or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
