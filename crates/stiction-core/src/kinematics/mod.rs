//! Configuration, velocity and acceleration of mechanisms with closed chains.
//!
//! [`Kinematics`] is the kernel: it computes one Newton step, and exact rates and accelerations,
//! for any scalar type. `Assembly` applies this kernel in `f64`: it computes the initial
//! configuration, tracks a motion within one assembly mode, and reports the causes of failures.

mod assembly;
mod bodies;
mod contradiction;
mod coordinate;
mod dof;
mod error;
mod finite_motion;
mod floating;
mod gearing;
mod kernel_program;
mod least_squares;
mod legs;
mod measure;
mod model;
mod motion_constraints;
mod partial;
mod random_configuration;
mod rotation_vector;
mod stationary;
mod system;
mod tracing;

pub(crate) use assembly::Assembly;
#[doc(hidden)]
pub use assembly::locks;
pub use assembly::{AssemblyReport, Conflict, OpenMode};
pub use bodies::{Bodies, State};
pub use coordinate::{AngleOrder, Coordinate, Target};
pub(crate) use dof::{actuator_rate, body_twists};
pub use error::AssemblyError;
pub use finite_motion::FiniteMotion;
pub(crate) use kernel_program::Results;
pub(crate) use measure::{deviation, difference};
pub(crate) use model::KinematicModel;
pub(crate) use partial::{Missed, RateRows, What, assemble_partly};
pub(crate) use random_configuration::RandomConfiguration;
pub(crate) use rotation_vector::RotationVector;
pub(crate) use system::{closure_error, column_scales};
pub(crate) use tracing::LoopsAt;

// Used by other crates of the project; not part of the stable interface.
#[doc(hidden)]
pub use error::{Gap, OpenDof};
#[doc(hidden)]
pub use kernel_program::{KernelProgram, ProgramMemory, Stage};
#[doc(hidden)]
pub use legs::Legs;
#[doc(hidden)]
pub use measure::measure_motion;
#[doc(hidden)]
pub use motion_constraints::MotionConstraints;
#[doc(hidden)]
pub use system::Kinematics;
