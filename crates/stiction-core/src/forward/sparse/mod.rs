//! Sparse solution of the balance, in linear time for chains and for rows of loops.
//!
//! The tree is eliminated joint by joint, from its ends to its roots, with articulated inertias (Featherstone 2008,
//! chapter 7); see [`articulated`]. The remaining unknowns are the multipliers of the loop closures. Their system
//! couples two loops only if these share bodies, so it is sparse; see [`closures`]. The dense decomposition of
//! [`super::balance`] is the reference in tests. It replaces this solution if the structure of a mechanism does not
//! suit it, or if the pivots do not decide the rank.

pub(super) mod articulated;
pub(super) mod closures;
pub(super) mod rows;
