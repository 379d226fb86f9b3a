//! Sparse factorisation of the equations of motion, in linear time for serial chains and for chains
//! of loops.
//!
//! The spanning tree is eliminated joint by joint, from its leaves to its roots, with
//! articulated-body inertias (Featherstone 2008, chapter 7); see [`articulated`]. The remaining
//! unknowns are the multipliers of the loop closures. Their system couples two loops only if these
//! loops share bodies, so it is sparse; see [`closures`]. The dense factorisation of
//! [`super::balance`] is the reference in tests. The dense factorisation is also used if a
//! mechanism is not suited to the sparse factorisation, or if the pivots do not show the rank of
//! the constraints clearly.

pub(super) mod articulated;
pub(super) mod closures;
pub(super) mod rows;
mod system;
