//! Linear algebra: static elimination for kernels, dense decompositions for analysis.

mod elimination;
mod plan;
mod row_space;
mod smallest;
mod svd;

pub use elimination::Elimination;
pub use plan::{Entry, Plan, RankDeficient, Scales};
pub(crate) use row_space::RowSpace;
pub use smallest::smallest_singular_value;
pub use svd::Svd;
pub(crate) use svd::complement;
