//! Tests of the crate in one binary, which is linked once.

mod browser;
mod chromium;
