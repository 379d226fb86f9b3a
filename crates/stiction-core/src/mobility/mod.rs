//! Mobility analysis, instantaneous at a position and over finite distances, by dense decompositions.

mod architecture;
mod clearance;
mod count;
mod words;

pub use crate::kinematics::FiniteMotion;
pub use architecture::Architecture;
pub use count::{FiniteMobility, Mobility};

// Used by the project's other crates; no part of the stable interface.
#[doc(hidden)]
pub use architecture::{GenericRank, actuation_of_motion};
#[doc(hidden)]
pub use clearance::{Play, blocked_motions};
#[doc(hidden)]
pub use count::BodyDofs;
