//! Record of one sample of a simulation.

use stiction_core::dynamics::AppliedLoad;
use stiction_core::forward::{Energies, Forward, Instant};
use stiction_core::kinematics::Target;

/// Record of one sample, borrowed from the simulation.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// Model of the mechanism for forward dynamics.
    pub forward: &'a Forward,
    /// State, accelerations, reactions and frictions at the instant.
    pub instant: &'a Instant,
    /// Work since the start, J.
    pub energies: &'a Energies,
    /// Error of the energy balance since the start, J.
    pub energy_error: f64,
    /// Motions of all scalar degrees of freedom of joints; angles count full turns.
    pub joints: &'a [Target<f64>],
    /// Reference motions of the actuators; zeros for those that follow none.
    pub reference: &'a [Target<f64>],
    /// External loads.
    pub loads: &'a [AppliedLoad<f64>],
    /// Largest loop-closure error, m (angles times the characteristic length).
    pub closure: f64,
}
