//! What the fuzz targets try, and how they make models.

pub mod making;
pub mod trials;
