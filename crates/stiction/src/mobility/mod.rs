//! What can move and what cannot: analysis by dense decompositions.

mod count;
mod distance;
mod statics;
mod words;

pub use count::{BodyFreedoms, Mobility};
pub use distance::{Constraints, Distances, JointLoad};
pub(crate) use statics::DETERMINED;
pub use statics::{Carried, RANK_TOLERANCE, Statics, Uncarried};
pub use words::describe_motion;
