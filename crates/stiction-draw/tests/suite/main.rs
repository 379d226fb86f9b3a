//! All integration tests of this crate in one binary, which is linked only once.

mod browser;
mod chromium;
