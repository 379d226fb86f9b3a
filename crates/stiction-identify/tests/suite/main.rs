//! Tests of identification against inverse dynamics and against numbers from the literature.
#![allow(missing_docs)]

mod base;
mod estimate;
mod load_slopes;
mod regressor;
mod robots;
