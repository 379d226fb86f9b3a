//! What can move and what cannot: analysis by dense decompositions.

mod architecture;
mod clearance;
mod count;
mod distance;
mod proximity;
mod statics;
mod weakest;
mod words;

pub use architecture::{Architecture, GenericRank, governance};
pub use clearance::{Play, blocked_motions};
pub use count::{BodyFreedoms, Mobility};
pub use distance::{Constraints, Distances, JointLoad};
pub use proximity::Proximity;
pub(crate) use statics::DETERMINED;
pub use statics::{Carried, NullDirection, RANK_TOLERANCE, Statics, Uncarried};
pub use weakest::{IdleAxis, ToldMotion};
pub use words::describe_motion;
