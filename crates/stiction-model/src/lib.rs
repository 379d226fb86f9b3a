//! The model file.

mod course;
mod diagnostic;
mod document;
mod expression;
mod fields;
pub mod gallery;
mod measure;
mod model;
mod read;
mod source;

pub use course::Course;
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use fields::json_schema;
pub use model::{AppliedWrench, Leg, LoadCase, Model, Motion};
pub use read::read;
pub use source::{Place, Source};
