//! Inverse dynamics along a motion: the main job.

pub(crate) mod bodies;
mod certainty;
mod chunks;
pub(crate) mod columns;
mod efficiency;
mod figures;
pub(crate) mod run;
mod shares;
pub(crate) mod statistics;
pub(crate) mod summary;
pub(crate) mod terminal;
mod uniqueness;

pub use bodies::BodyTable;
pub use certainty::{MOST_MARGIN, Margin, OtherSolutions};
pub use columns::{Table, Tables};
pub use efficiency::Backward;
pub use figures::Curves;
pub use run::{Error, Job, Missing, Phase, Sample, Verdict};
pub use shares::ShareTable;
pub use summary::Summary;
pub use terminal::write_summary;
pub use uniqueness::Singular;
