//! What can move and what cannot, here and beyond this position: analysis by dense decompositions.

mod architecture;
mod clearance;
mod count;
mod words;

pub use architecture::{Architecture, GenericRank, governance};
pub use clearance::{Play, blocked_motions};
pub use count::{BodyDofs, Mobility};
