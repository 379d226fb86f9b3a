//! Tests of identification against the engine and against numbers from the literature.
#![allow(missing_docs)]

mod base;
mod estimate;
mod load_slopes;
mod regressor;
mod robots;
