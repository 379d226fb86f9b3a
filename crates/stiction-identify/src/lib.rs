//! Identification of inertia and friction of mechanisms with closed loops from measured motions and
//! efforts. No I/O, no clock, no threads.
//!
//! Efforts of a mechanism are linear in its inertial parameters and in friction whose normal loads
//! are known. A [`Regressor`] computes the columns of this linear function along a motion,
//! [`BaseParameters`] finds the combinations of parameters that a motion can determine, and
//! [`Problem`] estimates them by weighted, robust least squares within the physical region. A prior
//! pulls the estimates towards the model. The strength of the prior is the most probable one for the
//! data.

mod apply;
mod base;
mod block;
mod estimate;
mod folds;
mod load_slopes;
mod motions;
mod parameter;
mod period;
pub mod physical;
mod regressor;
mod repetition;
mod rows;
mod slip;
mod solved;
mod verdict;

pub use apply::applied;
pub use base::{BaseParameters, Combination};
pub use block::{Block, Dwells};
pub use estimate::{
    Candidate, Estimate, Extension, Inequality, LeftOut, Options, Problem, Residuals,
};
pub use load_slopes::LoadSlopes;
pub use parameter::{Choice, INERTIA_ENTRIES, Kind, Parameter, catalogue};
pub use regressor::{Columns, Regressor, Unsuitable};
pub use rows::Rows;
pub use slip::Rest;
pub use solved::Solved;
pub use verdict::{Evidence, FitVerdict, Verdict};
