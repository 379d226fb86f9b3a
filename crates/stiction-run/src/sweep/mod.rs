//! Studies of many designs: each design has its own values of the varied keys, and its run yields
//! values of the objectives.
//!
//! A [`Design`] returns the values of the varied keys in each row, independently of all other rows.
//! [`Objectives`] receives the samples of a run and computes statistics of their columns.
//! [`in_order`] computes rows on several threads. The caller reads the model of each row, since
//! only the caller knows where the model comes from.

mod column;
mod design;
mod direction_numbers;
mod figures;
mod findings;
mod latin_hypercube;
mod objective;
mod page;
mod remarks;
mod row;
mod sobol;
mod statistic;
mod table;
mod verdicts;

pub use crate::ordered::in_order;
pub use design::{Design, DesignError};
pub use figures::Pictures;
pub use findings::Findings;
pub use objective::Objectives;
pub use page::draw_report;
pub use row::{Row, Status};
pub use table::{DesignTable, Record, Table, fields, header};
