//! Studies: a mechanism carried along a motion, with tables, a summary and plots of what it needs.
//!
//! Nothing here opens files or talks to a terminal; results go to whoever asks.

pub mod breakaway;
pub mod check;
pub mod drawing;
pub mod exchange;
pub mod figure;
pub mod forward;
mod instants;
pub mod inverse;
mod names;
mod numbers;
mod page;
pub mod report;
mod statistics;
mod table;
mod undetermined;
pub mod zhang2018;

pub use instants::{Instants, InstantsError};
