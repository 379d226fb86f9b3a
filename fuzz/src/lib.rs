//! Properties that must hold for every input, and generators of models, for the fuzz targets.

pub mod making;
pub mod trials;
