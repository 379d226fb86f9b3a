//! Linear algebra: LU elimination in a fixed order for kernels, and dense and sparse decompositions
//! for analysis.

mod basis;
mod block;
mod blocks;
mod decomposition;
mod elimination_order;
mod hub_cholesky;
mod lanczos;
mod largest;
mod plan;
mod row_space;
mod smallest;
mod sparse;
mod sparse_qr;
mod static_lu;
mod svd;
mod triangular_blocks;
mod vector_history;

pub use basis::Basis;
pub(crate) use block::{BLOCK, Block, Part, add_outer, add_outer_products, add_squares, dot};
pub(crate) use blocks::{BlockCholesky, Slot};
pub use decomposition::{Decomposition, Limit, SparseVector};
pub(crate) use decomposition::{greatest, sum_of, to_dense};
pub(crate) use hub_cholesky::HubCholesky;
pub(crate) use lanczos::{Lanczos, MANY_STEPS, STEPS};
pub(crate) use largest::largest;
pub(crate) use plan::{Entry, Plan, RankDeficient, Scales};
pub(crate) use row_space::RowSpace;
pub use smallest::smallest_singular_value;
pub use sparse::SparseMatrix;
pub(crate) use sparse_qr::{ColumnOrder, SparseQr};
pub(crate) use static_lu::StaticLu;
pub use svd::Svd;
pub(crate) use svd::complement;
pub(crate) use triangular_blocks::triangular_blocks;
pub(crate) use vector_history::VectorHistory;
