//! Forward dynamics: motion of a mechanism from an initial state.

mod acting_inputs;
mod checkpoint;
mod controller;
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
pub use figures::Curves;
pub use job::{Feed, Job, Start, arrange};
pub use outcome::{Ending, Outcome};
pub use poles::pole;
pub use rows::{Recorder, Rows};
pub use sample::Sample;
pub use summary::Summary;
pub use tables::{Tables, write_events};
pub use terminal::write_summary;
