//! Linear algebra: static elimination for kernels, dense decompositions for analysis.

mod dense;
mod elimination;
mod plan;

pub use dense::null_space;
pub use elimination::Elimination;
pub use plan::{Entry, Plan, RankDeficient, Scales};
