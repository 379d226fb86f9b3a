//! Position, velocity and acceleration of closed chains.
//!
//! [`Kinematics`] is the kernel: one Newton step, and exact rates and accelerations, over any scalar.
//! [`Assembly`] drives it in `f64`: it finds the first position, follows a motion without changing
//! the assembly mode, and says why where it cannot.

mod assembly;
mod bodies;
mod contradiction;
mod coordinate;
mod error;
mod freedom;
mod legs;
mod measure;
mod partial;
mod prescription;
mod rotation_vector;
mod system;
mod tracing;
mod wander;

pub use assembly::Assembly;
pub use bodies::{Bodies, State};
pub use coordinate::{AngleOrder, Coordinate, Target};
pub use error::{AssemblyError, Gap, OpenFreedom};
pub(crate) use freedom::{actuator_rate, body_twists};
pub use legs::Legs;
pub(crate) use measure::{deviation, difference};
pub(crate) use partial::{Missed, RateRows, What, assemble_partly};
pub use prescription::{Prescription, Spin};
pub use system::Kinematics;
pub(crate) use system::{closure_error, column_scales};
pub(crate) use tracing::LoopsAt;
pub(crate) use wander::Wander;
