//! All tests of this crate in one program: it is linked once.

mod browser;
#[path = "../../../../crates/stiction-draw/tests/suite/chromium/mod.rs"]
mod chromium;
mod report;
mod sample;
