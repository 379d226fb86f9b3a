//! What can move and what cannot: analysis by dense decompositions.

mod statics;
mod words;

pub use statics::{Carried, RANK_TOLERANCE, Statics, Uncarried};
pub use words::describe_motion;
