//! Solution of the balance in linear time for chains and rows of loops.
//!
//! The tree is eliminated joint by joint, from its ends to its roots, with articulated inertias
//! (Featherstone 2008, chapter 7); see [`articulated`]. What remains are the multipliers of the loop
//! closures. Two of them meet only if their loops share bodies, so their system is sparse; see
//! [`closures`]. The dense decomposition of [`super::balance`] is the oracle in tests, and the
//! solution wherever this one does not apply or its pivots do not decide about ranks.

pub(super) mod articulated;
pub(super) mod closures;
pub(super) mod rows;
