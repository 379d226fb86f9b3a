//! Inverse dynamics along a motion.

mod certainty;
mod chunks;
mod contributions;
mod efficiency;
mod figures;
mod gathered;
mod joints;
mod motion_scan;
mod motor_curves;
mod motor_summary;
mod motors;
mod run;
mod sample;
pub(crate) mod sides;
mod solving;
mod summary;
mod tables;
mod terminal;
mod uniqueness;
pub(crate) mod verdict;

pub use certainty::{MOST_MARGIN, Margin, OtherSolutions};
pub use efficiency::Backward;
pub use figures::Curves;
pub use run::Phase;
pub use sample::Sample;
pub use summary::Summary;
pub use tables::Tables;
pub use terminal::write_summary;
pub(crate) use uniqueness::SINGULAR;
pub use uniqueness::Singular;
pub use verdict::Verdict;
