//! What is told of one instant.

use stiction_core::dynamics::AppliedLoad;
use stiction_core::forward::{Energies, Forward, Instant};
use stiction_core::kinematics::Target;

/// Everything about one instant.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// The mechanism.
    pub forward: &'a Forward,
    /// Everything that is computed at the instant.
    pub instant: &'a Instant,
    /// Work since the start.
    pub energies: &'a Energies,
    /// What the account of energy has lost since the start, J.
    pub energy_error: f64,
    /// How all scalar freedoms of joints move; angles counted on over full turns.
    pub joints: &'a [Target<f64>],
    /// Where actuators are wanted; zeros for those that follow nothing.
    pub wanted: &'a [Target<f64>],
    /// The loads from outside.
    pub loads: &'a [AppliedLoad<f64>],
    /// The largest loop-closure error, m (angles times the characteristic length).
    pub closure: f64,
}
