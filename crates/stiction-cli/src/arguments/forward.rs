//! Commands that simulate robots.

use super::shared::{Filter, Model, Report, Sampling, Switch, Tables};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use stiction_format::{hertz, length_or_angle, seconds};

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
    /// The motion from which the mechanism starts and which it follows: its name in the model, a CSV file, or
    /// assignments; see `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    #[command(flatten)]
    pub(crate) filter: Filter,
    /// Efforts of actuators: assignments like "leg1.P = 50 N*sin(2*pi*t); leg2.P = 20 N", which may contain measured
    /// coordinates and rates, "A = -200 N m/rad*A - 5 N m s/rad*d(A)"; a CSV file such as the inverse.csv of a run;
    /// `inverse` (the efforts of inverse dynamics for the motion); or `none` [default: none]
    #[arg(long, value_name = "DRIVES")]
    pub(crate) drives: Option<String>,
    /// A controller that follows the motion: `pd`, `computed-torque`, `computed-torque+friction`, a
    /// TOML file, assignments like "type = pid; ki = 2 kN/(m s); period = 2 ms; leg1.P.limit = 300 N", or
    /// `none`
    /// [default: computed-torque, if neither --drives nor --prescribe is given]
    #[arg(long, value_name = "CONTROLLER")]
    pub(crate) controller: Option<String>,
    /// Actuators that follow the motion exactly; the simulation computes their efforts
    #[arg(long, value_name = "ACTUATOR", value_delimiter = ',')]
    pub(crate) prescribe: Vec<String>,
    /// Joints that are locked at their start positions; they need no actuator
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    pub(crate) hold: Vec<String>,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"; repeatable: each load is simulated,
    /// followed by the envelope of all runs
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Vec<String>,
    /// The start: `motion` (position and rates of the motion), `rest` (its position, at rest), or assignments like "A =
    /// 60 deg + 2 rad/s*t", whose values and rates at t = 0 are used. Rates can also be given separately, "A = 60 deg;
    /// d(B) = 2 rad/s". All other coordinates follow from the loops and the model's home position [default: motion]
    #[arg(long, value_name = "STATE")]
    pub(crate) from: Option<String>,
    /// The end time, in seconds or with a unit [default: the end of the followed motion, else 10 s after the start]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
    /// Condition that ends the simulation as soon as it is true, like "platform.z < 100 mm" or "d(A) > 2 rad/s";
    /// repeatable
    #[arg(long, value_name = "CONDITION")]
    pub(crate) stop: Vec<String>,
    #[command(flatten)]
    pub(crate) sampling: Sampling,
    /// Friction of joints, motors and gears [default: that of the model, else on]
    #[arg(long, value_name = "MODE")]
    pub(crate) friction: Option<Switch>,
    /// Integration scheme: event-driven, time-stepping, or automatic (event-driven with time-stepping as
    /// fallback)
    #[arg(long, value_name = "METHOD", default_value = "automatic")]
    pub(crate) method: Method,
    /// Relative error of an integration step; the tolerance of time stepping is a thousand times as large
    #[arg(long, value_name = "NUMBER", default_value = "1e-10", allow_negative_numbers = true)]
    pub(crate) tolerance: f64,
    /// Wall-clock time between two checkpoints of a run with -o, in seconds or with a unit
    #[arg(long, value_name = "TIME", value_parser = seconds, default_value = "60", allow_negative_numbers = true)]
    pub(crate) checkpoint: f64,
    /// Wall-clock time after which the run ends, in seconds or with a unit. The results until then are complete, and
    /// --resume continues the run
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) time_limit: Option<f64>,
    /// Resume an interrupted run; give the same options and the same -o, only --until may differ
    #[arg(long, requires = "output")]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) report: Report,
    /// Write forward.csv, reactions.csv, friction.csv, bodies.csv, energy.csv, events.csv, motion.csv, summary.json,
    /// plots and a report into this folder. For several loads write them into subfolders, with envelope.csv and a
    /// common plot
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

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction compensate\n\
    \x20 stiction compensate five-bar --period \"0.1 ms\" --known-to 30% --resolution \"0.1 mrad\" --delay \"1 ms\"\n\
    \x20 stiction compensate gough --controller computed-torque,computed-torque+friction -o results")]
pub(crate) struct Compensate {
    #[command(flatten)]
    pub(crate) model: Model,
    /// The motion that the robot follows: its name in the model, a CSV file, or assignments; see
    /// `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// A load on the robot that the controllers do not know
    #[arg(long, value_name = "LOAD", default_value = "none")]
    pub(crate) load: String,
    /// Controllers to compare: `pd`, `computed-torque`, each also with `+coulomb` (the best constant friction of each
    /// actuator), `computed-torque+friction` (the friction of the model) [default: all]
    #[arg(long, value_name = "CONTROLLER", value_delimiter = ',')]
    pub(crate) controller: Vec<String>,
    /// Compensation of friction where the reference reverses or rests, one or several to compare: `sign` of the
    /// reference rate; `fade`, the same but fading at rest; or a width such as `5%`, the tanh of the reference rate over
    /// this part of its largest value
    #[arg(long, value_name = "TRANSITION", value_delimiter = ',', default_value = "sign", value_parser = stiction::Transition::parse)]
    pub(crate) transition: Vec<stiction::Transition>,
    /// Bandwidth of the position control, in Hz or with a unit
    #[arg(long, value_name = "FREQUENCY", default_value = "5 Hz", value_parser = hertz, allow_negative_numbers = true)]
    pub(crate) bandwidth: f64,
    /// Time between samples of the controller, in seconds or with a unit
    #[arg(long, value_name = "TIME", default_value = "1 ms", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) period: f64,
    /// Largest relative error of each friction coefficient in the controller's model; the errors are random
    #[arg(long, value_name = "PART", default_value = "10%", value_parser = part, allow_negative_numbers = true)]
    pub(crate) known_to: f64,
    /// Seed of the random errors and of the measurement noise
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) seed: u64,
    /// Increment of the encoders, in m or rad or with a unit
    #[arg(long, value_name = "SIZE", default_value = "0", value_parser = length_or_angle, allow_negative_numbers = true)]
    pub(crate) resolution: f64,
    /// Standard deviation of the noise of each measured position, in m or rad or with a unit
    #[arg(long, value_name = "SIZE", default_value = "0", value_parser = length_or_angle, allow_negative_numbers = true)]
    pub(crate) noise: f64,
    /// Delay between measurement and effort, in seconds or with a unit
    #[arg(long, value_name = "TIME", default_value = "0", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) delay: f64,
    /// Write compensate.json, compensate.csv, the tracking errors over time, and report.html into this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) report: Report,
    /// Print the figures or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Parses a fraction: a number, or a percentage.
fn part(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, factor) = match text.strip_suffix('%') {
        Some(number) => (number.trim(), 0.01),
        None => (text, 1.0),
    };
    let number: f64 = number.parse().map_err(|_| {
        "expected a fraction or a percentage, such as 0.1 \
        or 10%"
            .to_owned()
    })?;
    Ok(number * factor)
}
