//! All integration tests of this crate in one binary, which links only once.

mod allocation;
mod bodies;
mod breakaway;
mod browser;
#[path = "../../../stiction-draw/tests/suite/chromium/mod.rs"]
mod chromium;
mod common;
mod contributions;
#[path = "../../../stiction-core/tests/suite/common/counting.rs"]
mod counting;
mod determinant;
mod differentials;
mod drawing;
mod drive_trains;
mod elastic;
mod exchange;
mod forward;
mod friction;
mod gallery;
mod gear_losses;
mod gearings;
mod identities;
mod indeterminate;
mod joints;
mod large;
mod laws;
#[path = "../../../stiction-core/tests/suite/common/mod.rs"]
mod mechanisms;
mod mjcf;
mod mobility;
mod motion;
mod payload;
mod pose;
mod prescribed_motors;
mod references;
mod reports;
mod round_trip;
mod shared_motors;
mod singularities;
mod spelling;
mod spinning_rotors;
mod stored;
mod symmetry;
mod threads;
mod verdicts;
mod warm_starts;
