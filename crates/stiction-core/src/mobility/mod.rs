//! Mobility analysis by dense decompositions: instantaneous mobility at a configuration, and
//! mobility over finite distances.

mod architecture;
mod clearance;
mod count;
mod words;

pub use crate::kinematics::FiniteMotion;
pub use architecture::Architecture;
pub use count::{FiniteMobility, Mobility};

// Used by other crates of the project; not part of the stable interface.
#[doc(hidden)]
pub use architecture::{GenericRank, actuation_of_motion};
#[doc(hidden)]
pub use clearance::{Play, blocked_motions};
#[doc(hidden)]
pub use count::BodyDofs;
