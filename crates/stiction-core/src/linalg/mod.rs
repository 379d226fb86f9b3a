//! Linear algebra: static elimination for kernels, dense decompositions for analysis.

mod blocks;
mod lanczos;
mod plan;
mod row_space;
mod smallest;
mod static_lu;
mod svd;
mod twofold;

pub(crate) use blocks::{BLOCK, BlockCholesky, Part, Slot, add_outer, dot};
pub(crate) use lanczos::Lanczos;
pub(crate) use plan::{Entry, Plan, RankDeficient, Scales};
pub(crate) use row_space::RowSpace;
pub use smallest::smallest_singular_value;
pub(crate) use static_lu::StaticLu;
pub use svd::Svd;
pub(crate) use svd::complement;
pub(crate) use twofold::Twofold;
