//! Tests of the crate in one binary, which is linked once.

mod browser;
#[path = "../../../../crates/stiction-draw/tests/suite/chromium/mod.rs"]
mod chromium;
mod report;
mod sample;
