//! Commands that write files for other programs.

use super::shared::{Model, Reading, Switch};
use clap::{Args, ValueEnum};
use std::ffi::OsString;
use std::path::PathBuf;

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
    /// The format of the output [default: by the file extension of -o; for a URDF, MJCF or SDF a model file]
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: Option<Format>,
    /// The motion at whose first instant the mechanism is assembled: its name in the model, a CSV file, or assignments;
    /// see `stiction inverse --help` [default: that of the model]
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    /// Write the result to this file [default: standard output]
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
    /// URDF, with an accompanying YAML file for loop closures and motors
    Urdf,
    /// SDF, the format of Gazebo
    Sdf,
    /// A model file of this program; with legs written as bodies and joints, and formulas as numbers
    Model,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n\
    \x20 stiction export 3rps --to c -o code && make -C code test\n\
    \x20 stiction export robot.toml --to c --precision float --own-math -o code\n\
    \x20 stiction export five-bar --to rust --payload tool -o code\n\
    \x20 stiction export delta --to c --functions kinematics,reactions -o code\n\
    \x20 stiction export 3rps --to c --coordinates platform.z,platform.rx,platform.ry -o code\n\
    \x20 stiction export five-bar --to c --adapters ctypes,linuxcnc -o code\n\
    \x20 stiction export five-bar --to fmu -o five-bar.fmu\n\
    \x20 stiction export five-bar --to fmu --plant --force-on tool -o plant.fmu")]
pub(crate) struct Export {
    #[command(flatten)]
    pub(crate) model: Model,
    /// The programming language, or a functional mock-up unit
    #[arg(long, value_name = "LANGUAGE")]
    pub(crate) to: Language,
    /// Write the code, its self-test with test vectors, build files and README.md into this folder; for `--to fmu`
    /// write this file
    #[arg(short, long, value_name = "PATH")]
    pub(crate) output: PathBuf,
    /// Version of the FMI standard, 2 or 3, for `--to fmu`
    #[arg(long, value_name = "VERSION", default_value = "3", value_parser = clap::value_parser!(u8).range(2..=3))]
    pub(crate) fmi: u8,
    /// The motion near which the code is recorded and tested, or at whose first instant the plant starts: its name in
    /// the model, a CSV file, or assignments; see `stiction inverse --help` [default: that of the model]
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,
    #[command(flatten)]
    pub(crate) plant: PlantOptions,
    /// Name of the files and prefix of all names in the code [default: derived from the model's name]
    #[arg(long = "name", value_name = "NAME")]
    pub(crate) prefix: Option<String>,
    /// Floating-point type
    #[arg(long, value_name = "TYPE", default_value = "double")]
    pub(crate) precision: Precision,
    /// Include sine and cosine in the code instead of calling the mathematical library
    #[arg(long)]
    pub(crate) own_math: bool,
    /// Numbers of the model that the code can change at run time
    #[arg(long, value_name = "KIND", value_delimiter = ',', default_value = "friction")]
    pub(crate) tunable: Vec<Tunable>,
    /// Functions in addition to inverse dynamics
    #[arg(long, value_name = "FUNCTIONS", value_delimiter = ',')]
    pub(crate) functions: Vec<Function>,
    /// Independent coordinates, by name: those of joints, such as `leg1.P`, and those that the motion
    /// prescribes, such as `platform.z` [default: all actuators]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) coordinates: Vec<String>,
    /// Files that run the code in other environments, for `--to c`
    #[arg(long, value_name = "ADAPTERS", value_delimiter = ',')]
    pub(crate) adapters: Vec<Adapter>,
    /// A body with a force and a moment that can be changed at run time, parameters of the code or inputs of
    /// a plant; repeatable
    #[arg(long, value_name = "BODY")]
    pub(crate) force_on: Vec<String>,
    /// A body that carries a point mass, whose mass and position can be changed at run time
    #[arg(long, value_name = "BODY")]
    pub(crate) payload: Option<String>,
    /// Number of test vectors
    #[arg(long, value_name = "N", default_value = "200", value_parser = clap::value_parser!(u32).range(0..=100_000))]
    pub(crate) vectors: u32,
}

/// Options for plant FMUs.
#[derive(Args, Debug)]
#[command(next_help_heading = "Plants, with --plant")]
pub(crate) struct PlantOptions {
    /// Export the robot as a plant instead of its feed-forward, for `--to fmu`: forward dynamics with stick and slip,
    /// whose inputs are the efforts of the actuators
    #[arg(
        long,
        conflicts_with_all = [
            "precision", "own_math", "tunable", "functions", "coordinates", "adapters", "payload", "vectors"
        ]
    )]
    pub(crate) plant: bool,
    /// The start: `motion` (position and rates of the motion), `rest` (its position, at rest), or assignments; see
    /// `stiction forward --help` [default: motion]
    #[arg(long, value_name = "STATE", requires = "plant")]
    pub(crate) from: Option<String>,
    /// The load that acts inside the plant: its name in the model, or assignments [default: that of the model]
    #[arg(long, value_name = "LOAD", requires = "plant")]
    pub(crate) load: Option<String>,
    /// Friction of joints, motors and gears [default: that of the model, else on]
    #[arg(long, value_name = "FRICTION", requires = "plant")]
    pub(crate) friction: Option<Switch>,
    /// Relative error of an integration step [default: 1e-10]
    #[arg(long, value_name = "NUMBER", requires = "plant", allow_negative_numbers = true)]
    pub(crate) tolerance: Option<f64>,
    /// The shared library that contains the engine [default: the one in the folder of this program]
    #[arg(long, value_name = "FILE", requires = "plant")]
    pub(crate) library: Option<PathBuf>,
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

/// Functions that the code contains in addition to inverse dynamics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Function {
    /// Forward kinematics: poses, velocities and Jacobians of all bodies
    Kinematics,
    /// Reactions of all joints, with friction
    Reactions,
    /// Derivatives of the efforts with respect to positions, rates and accelerations
    Derivatives,
    /// Forward dynamics: accelerations from efforts
    Accelerations,
}

/// Environment other than C for which an adapter of the code is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Adapter {
    /// Python, through its module ctypes
    Ctypes,
    /// A component of LinuxCNC
    Linuxcnc,
    /// The self-test on a bare Cortex-M7 in QEMU
    CortexM7,
}

/// Numbers of the model that the code can change at run time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Tunable {
    /// None
    None,
    /// Coefficients of all friction interfaces
    Friction,
    /// Masses of all bodies
    Masses,
}
