//! Straight-line programs for one mechanism, recorded from the kernels that serve all.
//!
//! The kernels of `stiction` are written once, over any scalar, and never branch on values. Run over a
//! scalar that records ([`recorded`]), they give an expression graph ([`graph`]). Nodes that mean the
//! same are found by their values at random states and become one ([`meaning`]): what is zero for this
//! mechanism vanishes, what is known twice is computed once. What is left is compiled ([`code`],
//! [`allocate`], [`encode`]) to machine code in registers as wide as the processor has
//! ([`machine`]), or interpreted where that cannot be.

mod allocate;
mod code;
mod encode;
mod graph;
mod inverse;
mod machine;
mod meaning;
mod recipe;
mod recorded;
mod run;
mod samples;

pub use inverse::{InverseProgram, Memory};
