//! Linear algebra: static elimination for kernels, dense decompositions for analysis.

mod blocks;
mod elimination;
mod lanczos;
mod plan;
mod row_space;
mod smallest;
mod svd;
mod twofold;

pub(crate) use blocks::{BLOCK, BlockCholesky, Part, Slot};
pub use elimination::Elimination;
pub(crate) use lanczos::Lanczos;
pub use plan::{Entry, Plan, RankDeficient, Scales};
pub(crate) use row_space::RowSpace;
pub use smallest::smallest_singular_value;
pub use svd::Svd;
pub(crate) use svd::complement;
pub(crate) use twofold::Twofold;
