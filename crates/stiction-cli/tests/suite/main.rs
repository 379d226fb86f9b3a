//! All integration tests of this crate in one binary, which is linked only once.

mod breakaway;
mod cases;
mod check;
#[path = "../../../stiction-draw/tests/suite/chromium/mod.rs"]
mod chromium;
mod compare;
mod compensate;
mod convert;
mod excite;
mod export;
mod findings;
mod forward;
mod frictionless;
mod hostile;
mod identify;
mod identify_report;
mod inverse;
mod load_formulas;
mod manners;
mod npz;
mod options;
mod pages;
mod paths;
mod program;
mod spared;
mod study;
mod sweep;
#[path = "../../../../fuzz/src/trials/mod.rs"]
#[allow(unreachable_pub, reason = "the fuzz targets are another crate, which reaches it")]
mod trials;
mod words;
