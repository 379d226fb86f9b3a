//! Forward dynamics: motion of a mechanism from an initial state.

mod acting_inputs;
mod checkpoint;
mod controller;
mod error;
mod events;
mod figures;
mod guide;
mod job;
mod motors;
mod outcome;
mod poles;
mod reference;
mod rows;
mod run;
mod sample;
mod start;
mod summary;
mod tables;
mod terminal;

pub use checkpoint::{Figures, Mark, checksum};
pub use error::Error;
pub use figures::Curves;
pub use job::{Feed, Job, Start, arrange};
pub use outcome::{Ending, Outcome};
pub use poles::pole;
pub use rows::{Layout, Rows, Scribe};
pub use sample::Sample;
pub use summary::Summary;
pub use tables::{Tables, read_rows, write_events};
pub use terminal::write_summary;
