//! Forward dynamics: what a mechanism does, from a start on.

mod acting;
mod controller;
mod events;
mod figures;
mod guide;
mod job;
mod mark;
mod rows;
mod run;
mod start;
mod summary;
mod tables;
mod terminal;
mod wanted;

pub use figures::Curves;
pub use job::{Feed, Job, Start, arrange};
pub use mark::checksum;
pub use rows::{Layout, Rows, Scribe};
pub use run::{Ending, Error, Mark, Outcome, Sample};
pub use summary::Summary;
pub use tables::{Tables, read_rows, write_events};
pub use terminal::write_summary;
