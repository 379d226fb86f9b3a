//! The balance of all bodies at one position, dense: what joints and actuators can carry there, how uniquely, and how
//! near that is to its end.
//!
//! Forces of inertia count as loads (D'Alembert), so what is said holds for a mechanism that moves.

mod distance;
mod load;
pub mod newton_euler;
mod rank;
mod singularity_distances;
mod weakest;

pub use distance::{Constraints, Distances, JointLoad};
pub(crate) use load::demand_of_motion;
pub use load::{AppliedLoad, LoadAxes};
pub(crate) use rank::DETERMINED;
pub use rank::{InfeasibleLoad, NullDirection, RANK_TOLERANCE, StaticSolution, Statics};
pub use singularity_distances::SingularityDistances;
pub use weakest::{GainedTwist, IdleAxis};
