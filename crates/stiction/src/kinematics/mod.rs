//! Position, velocity and acceleration of closed chains.

mod coordinate;

pub use coordinate::{AngleOrder, Coordinate, Target};
