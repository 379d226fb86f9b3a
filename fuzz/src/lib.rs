//! Fuzz targets: properties of every input, and generators of models.

pub mod making;
pub mod trials;
