//! Force and moment balance of all bodies at one configuration, solved as one linear system: forces
//! of joints and actuators, their uniqueness, and singularity indices.
//!
//! Inertia forces are included as loads (d'Alembert's principle), so the results also hold for
//! moving mechanisms.

mod distance;
mod least_index;
mod load;
#[doc(hidden)]
pub mod newton_euler;
mod prediction;
mod rank;
mod singularity_distances;
mod weakest;

pub use distance::Distances;
pub use load::{AppliedLoad, LoadAxes};
pub(crate) use load::{act_alike, demand_of_motion};
pub(crate) use rank::DETERMINED;
pub(crate) use rank::InfeasibleLoad;
pub use singularity_distances::{SingularityDistances, SingularityIndex};
pub(crate) use weakest::IdleAxis;

// Used by other crates of the project; not part of the stable interface.
#[doc(hidden)]
pub use distance::{Constraints, JointLoad, leg_distance};
#[doc(hidden)]
pub use least_index::{LeastIndex, least_index};
#[doc(hidden)]
pub use rank::{NullDirection, Statics};
#[doc(hidden)]
pub use weakest::GainedTwist;
