//! Tests of the playground: its answers, its page, and both in a browser.

mod answers;
mod browser;
#[path = "../../../stiction-draw/tests/suite/chromium/mod.rs"]
mod chromium;
