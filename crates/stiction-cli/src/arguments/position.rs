//! Commands for the check of a mechanism, static friction, equilibria and linear models.

use super::shared::{Filter, Model, Report, Sampling, Switch};
use clap::Args;
use std::path::PathBuf;
use stiction_format::seconds;

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
    #[command(flatten)]
    pub(crate) sampling: Sampling,
    #[command(flatten)]
    pub(crate) report: Report,
    /// Write a report that shows the mechanism move, and the files check.json and mechanism.svg, into this folder
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
    #[command(flatten)]
    pub(crate) sampling: Sampling,
    /// Write report.html, the page, and moving.svg, a picture for a README, into this folder [default: a temporary
    /// folder, and the page opens in a browser]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Open the page in a browser even if -o is given
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
    /// The motion that contains the position: its name in the model, a CSV file, or assignments like "A = 60 deg;
    /// duration = 0 s"; see `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// The time in the motion at which the mechanism rests, in seconds or with a unit [default: the start of the
    /// motion]
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
    /// The motion whose first position is the start of the search; see `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// The start of the search, as in `stiction forward --help` [default: motion]
    #[arg(long, value_name = "STATE")]
    pub(crate) from: Option<String>,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Option<String>,
    /// Efforts of actuators, as in `stiction forward --help` [default: none]
    #[arg(long, value_name = "DRIVES")]
    pub(crate) drives: Option<String>,
    /// Joints that are locked at their start positions; they need no actuator
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    pub(crate) hold: Vec<String>,
    /// Find the nearest equilibrium, stable or not, instead of the next stable one along the descent of the potential
    /// energy
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
    /// The motion that contains the operating point; see `stiction inverse --help`
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// The time in the motion, in seconds or with a unit [default: the start of the motion]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_negative_numbers = true, conflicts_with = "from")]
    pub(crate) at: Option<f64>,
    /// The operating point, given like the start of a simulation (see `stiction forward --help`), for example "A = 60
    /// deg; d(B) = 2 rad/s" [default: motion]
    #[arg(long, value_name = "STATE")]
    pub(crate) from: Option<String>,
    /// A load: its name in the model, or assignments like "platform.fz = -100 N"
    #[arg(long, value_name = "LOAD")]
    pub(crate) load: Option<String>,
    /// Efforts at the operating point, as in `stiction forward --help` [default: inverse if the actuators
    /// determine the motion, else none]
    #[arg(long, value_name = "DRIVES")]
    pub(crate) drives: Option<String>,
    /// Joints that are locked; they need no actuator
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    pub(crate) hold: Vec<String>,
    /// Friction of joints, motors and gears [default: that of the model, else on]
    #[arg(long, value_name = "MODE")]
    pub(crate) friction: Option<Switch>,
    /// Write A.csv, B.csv, C.csv, D.csv and linearize.json into this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print the model or the error as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
