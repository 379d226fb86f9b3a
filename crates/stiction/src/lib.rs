//! Inverse and forward dynamics of mechanisms with closed kinematic chains and friction in their joints.
//!
//! Load a model file, choose a motion, and read actuator efforts, joint reactions and joint friction by
//! name. All numbers are in SI units and radians; strings may carry units (`"30 deg"`, `"128.48 mm"`).
//!
//! ```
//! let robot = stiction::Robot::load("examples/pendulum.toml")?;
//! for sample in robot.inverse().motion("swing")?.samples()? {
//!     println!("{} N m", sample?.effort("pivot")?);
//! }
//! let run = robot.forward().at("pivot", 1.0)?.until(10.0).run()?;
//! println!("{} rad after 10 s", run.last()?.position("pivot")?);
//! let report = robot.check()?;
//! println!("{} degree of freedom", report.mobility().instantaneous);
//! # Ok::<(), stiction::Error>(())
//! ```
//!
//! | task | entry |
//! | --- | --- |
//! | efforts, reactions and friction along a motion | [`Robot::inverse`] |
//! | motion under efforts, controllers, loads and locks | [`Robot::forward`] |
//! | forward dynamics step by step, with efforts from the caller | [`Forward::plant`] |
//! | mobility, redundant constraints, singularities | [`Robot::check`] |
//! | efforts at which a robot at rest begins to move | [`Robot::breakaway`] |
//! | positions of rest, and their stability | [`Robot::equilibrium`] |
//! | linear models about an operating point | [`Robot::linearize`] |
//! | efforts in a control loop, without allocation | [`Robot::control_loop`] |
//! | inverse dynamics with friction as source code for a controller | [`Robot::export`] |
//! | control laws with and without friction compensation, simulated | [`Robot::compensation`] |
//! | statistics of many designs | [`Robot::sweep`], [`fn@sweep`] |
//! | efforts, poses, Jacobians, mass matrices of many states | [`Robot::states`] |
//!
//! Every failure has the type [`Error`], which names the place, the value and the limit, and suggests a remedy. No
//! function panics on bad input, and the error for an unknown name suggests the nearest known one:
//!
//! ```
//! let robot = stiction::Robot::builtin("five-bar")?;
//! let error = robot.inverse().load("palyoad").err().ok_or("no error")?;
//! assert!(error.to_string().contains("`palyoad`"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Layers
//!
//! This crate gives access by name to three other crates. [`core`] contains the mechanics and does
//! no input or output; [`format`](mod@format) reads model files; [`run`] moves a model along a
//! motion and writes tables, plots and reports. [`Inverse::job`] and [`Plan::job`] convert a
//! request to a job of [`run`].

mod breakaway;
mod check;
mod compensation;
mod control_loop;
mod convert;
mod coordinates;
mod error;
mod excite;
mod explain;
mod export;
mod files;
pub mod forward;
mod identify;
mod inverse;
mod names;
mod operating_point;
mod paged;
mod plant;
mod request;
mod robot;
mod states;
mod stream;
mod sweep;
mod tabulated;
mod tasks;

pub use breakaway::{Breakaway, Rest, StaticFriction};
pub use check::{Check, Examination, Mobility, Report, Singularity};
pub use compensation::{Compared, Compensation, Compensator, LawResult, Transition};
pub use control_loop::ControlLoop;
pub use convert::{Conversion, Converted};
pub use error::{Error, ErrorKind};
pub use export::{Export, Fmu, PlantExport};
pub use files::ReadProgress;
pub use forward::{Forward, Plan, Run, Simulation};
pub use inverse::{BodyPose, Inverse, InverseDynamics, JointFriction, Reaction, Sample};
pub use operating_point::{Equilibrium, Linearize, Rests};
pub use paged::Paged;
pub use plant::{Plant, Unit, UnitState};
pub use request::{Loaded, Request, Sampled, Samples};
pub use robot::{Import, ModelParts, ModelText, Robot, RobotBuilder};
pub use states::{
    Batch, Compile, Compiled, Coordinate, Derivatives, InverseRows, MotionRows, Outputs, Rows,
    States, Workers, status_name, status_reason,
};
pub use sweep::{Study, Sweep, sweep};
pub use tabulated::{Tabulated, TabulatedSimulation, energy_lost};

pub use stiction_core as core;
pub use stiction_core::dynamics::{Data, FrictionMode, Model, Status};
pub use stiction_core::forward::{EventKind, Method};
pub use stiction_core::mechanism::{
    BodySpec, BushingSpec, DriveTrainSpec, GasSpring, GearingSpec, JointSpec, JointSpringSpec,
    Motor, SpringSpec,
};
pub use stiction_format as format;
pub use stiction_format::{Diagnostic, Diagnostics, gallery};
pub use stiction_program::emit::fmu::Fmi;
pub use stiction_program::emit::{Adapters, Functions, Language, Precision, SourceFile};
pub use stiction_run as run;
pub use stiction_run::forward::Measured;

/// The examples of the project's front page, compiled as tests.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct FrontPage;
