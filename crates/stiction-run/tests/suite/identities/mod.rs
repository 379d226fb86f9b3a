//! Laws of mechanics on random mechanisms of every class.
//!
//! Each law is a function of a [`specimen::Specimen`]. Where one does not hold, the specimen is made smaller as long as
//! it still does not, and what is left is written down as a model file: a counterexample to look at, and to
//! give to the program. `STICTION_CASES` says how many specimens of each class to try.

mod balances;
mod changes;
mod friction;
mod harness;
mod inertia;
mod richness;
mod selftest;
mod shrink;
mod solve;
mod specimen;
