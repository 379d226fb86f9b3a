//! All integration tests of this crate in one binary, which links only once.

mod allocation;
mod bodies;
mod breakaway;
mod browser;
#[path = "../../../stiction-draw/tests/suite/chromium/mod.rs"]
mod chromium;
mod common;
#[path = "../../../stiction-core/tests/suite/common/counting.rs"]
mod counting;
mod determinant;
mod drawing;
mod drive_trains;
mod exchange;
mod forward;
mod friction;
mod gallery;
mod identities;
mod indeterminate;
mod joints;
mod laws;
#[path = "../../../stiction-core/tests/suite/common/mod.rs"]
mod mechanisms;
mod mjcf;
mod mobility;
mod motion;
mod payload;
mod pose;
mod references;
mod shares;
mod singularities;
mod spelling;
mod stored;
mod symmetry;
mod threads;
mod verdicts;
