//! Position, velocity and acceleration of closed chains.
//!
//! [`Kinematics`] is the kernel: one Newton step, and exact rates and accelerations, over any scalar.
//! [`Assembly`] drives it in `f64`: it finds the first position, follows a motion without changing
//! the assembly mode, and says why where it cannot.

mod assembly;
mod bodies;
mod contradiction;
mod coordinate;
mod dof;
mod error;
mod legs;
mod measure;
mod model;
mod motion_constraints;
mod partial;
mod random_configuration;
mod rotation_vector;
mod system;
mod tracing;

pub use assembly::Assembly;
pub use bodies::{Bodies, State};
pub use coordinate::{AngleOrder, Coordinate, Target};
pub(crate) use dof::{actuator_rate, body_twists};
pub use error::{AssemblyError, Gap, OpenDof};
pub use legs::Legs;
pub(crate) use measure::{deviation, difference};
pub use model::KinematicModel;
pub use motion_constraints::{MotionConstraints, Spin};
pub(crate) use partial::{Missed, RateRows, What, assemble_partly};
pub(crate) use random_configuration::RandomConfiguration;
pub use system::Kinematics;
pub(crate) use system::{closure_error, column_scales};
pub(crate) use tracing::LoopsAt;
