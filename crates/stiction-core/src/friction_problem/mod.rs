//! Coupled problem of friction and the joint reactions that determine the friction limits. Both
//! inverse and forward dynamics use this module.
//!
//! A friction interface carries a normal load `N`, and its friction is affine in `N`. All joint
//! wrenches are affine in the friction forces. If all coefficients of friction are multiplied by
//! `s`, the normal loads satisfy
//!
//! ```text
//! N = load(w),    w = w_0 + s A N
//! ```
//!
//! Here `w` are the joint wrenches, `w_0` their parts that do not depend on `N`, and `A` is the
//! influence of the normal loads, through friction, on the joint wrenches. `load` is a norm of the
//! wrench and therefore nonlinear.
//!
//! | module | content |
//! | --- | --- |
//! | [`normal_load`] | normal load of an interface under its joint's wrench |
//! | [`influence`] | operator `A`, applied column by column or stored as a matrix |
//! | [`load_problem`] | problem with the normal loads as unknowns |
//! | [`fixed_point`] | fixed-point iteration on the normal loads, without an influence matrix |
//! | [`newton`] | Newton's method on the normal loads, from an initial guess |
//! | [`triangular_loads`] | Newton's method on many normal loads in block triangular form |
//! | [`continuation`] | solution connected with the frictionless solution, by increasing `s` from zero |
//! | [`uniqueness`] | bound on the coupling below which the solution is unique |
//! | [`complementarity`] | friction vectors with unknown stick-slip modes of the interfaces |
//!
//! The callers provide the equations of motion: the sparse balance of inverse dynamics, the dense
//! Newton-Euler system, or the decomposed balance of forward dynamics.
//!
//! Equations (F5) to (F8), (D3) and (D5) of the book's theory.

pub(crate) mod complementarity;
pub(crate) mod continuation;
pub(crate) mod fixed_point;
pub(crate) mod influence;
pub(crate) mod load_problem;
pub(crate) mod newton;
pub(crate) mod normal_load;
pub(crate) mod small_system;
pub(crate) mod surface_vector;
pub(crate) mod triangular_loads;
pub(crate) mod uniqueness;
