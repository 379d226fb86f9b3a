//! Laws of mechanics on random mechanisms of every class.
//!
//! Each law is a function of a [`specimen::Specimen`]. If a law fails, the specimen is reduced as
//! long as the law still fails, and the result is written as a model file: a counterexample to
//! examine, and to run with the program. `STICTION_CASES` sets the number of specimens of each
//! class.

mod balances;
mod changes;
mod friction;
mod gearings;
mod harness;
mod inertia;
mod richness;
mod selftest;
mod shrink;
mod solve;
mod specimen;
