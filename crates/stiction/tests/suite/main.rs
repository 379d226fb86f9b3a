//! Tests of the library with access by name: closed forms, streams, messages.

mod compensation;
mod control;
mod filter;
mod folder;
mod forward;
mod inverse;
mod messages;
mod ranges;
mod rest;
mod states;
mod stream;
mod sweep;

use stiction::Robot;

/// A pendulum: 2 kg at 0.4 m below a pivot of radius 8 mm with a friction coefficient of 0.1.
fn pendulum() -> Robot {
    Robot::parse(include_str!("../../examples/pendulum.toml")).unwrap()
}

const MASS: f64 = 2.0;
const LENGTH: f64 = 0.4;
const GRAVITY: f64 = 9.81;
/// Moment of inertia about the pivot, kg m².
const INERTIA: f64 = 1e-3 + MASS * LENGTH * LENGTH;
const FRICTION_ARM: f64 = 0.1 * 8e-3;
