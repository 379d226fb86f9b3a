//! Linear algebra: static elimination for kernels, dense decompositions for analysis.

mod elimination;
mod plan;
mod svd;

pub use elimination::Elimination;
pub use plan::{Entry, Plan, RankDeficient, Scales};
pub use svd::Svd;
