//! The paper, equation by equation: Zhang Y., Jin P., Gong J., Liu Q. (2018), Dynamic Modeling of 3-RPS
//! Parallel Robot Considering Joint Friction.
//!
//! Closed formulas of this one robot live here, where they stand beside the engine that serves every
//! mechanism and do not help it.

mod friction;
mod kinematics;
mod lagrangian;
mod reactions;
mod robot;

#[cfg(test)]
mod tests;
