//! All integration tests of this crate in one binary, which links only once.

mod allocation;
mod common;
#[path = "../../../stiction-core/tests/suite/common/counting.rs"]
mod counting;
mod derivatives;
mod emit;
mod feedforward;
mod forward;
mod inverse;
mod kernels;
mod legs;
mod simulations;
