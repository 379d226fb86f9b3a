//! Studies of many designs: which values the varied keys take, and what is measured of each run.
//!
//! A [`Design`] gives the values of every row, independent of all other rows. [`Objectives`] measure a run along
//! its motion: they are a sink of its samples. [`in_order`] computes rows on several threads. Reading the model
//! of a row is left to the caller, who knows where models come from.

mod column;
mod design;
mod direction_numbers;
mod figures;
mod findings;
mod latin_hypercube;
mod objective;
mod page;
mod row;
mod sobol;
mod statistic;
mod table;

pub use crate::ordered::in_order;
pub use design::{Design, DesignError};
pub use figures::Pictures;
pub use findings::Findings;
pub use objective::Objectives;
pub use page::draw_report;
pub use row::{Row, Status};
pub use table::{DesignTable, Record, Table, fields, header};
