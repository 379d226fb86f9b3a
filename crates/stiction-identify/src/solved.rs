//! Forces at one instant, solved with converged friction.

use stiction_core::dynamics::Data;
use stiction_core::kinematics::State;

/// Solution of the forces at one instant, with converged friction.
#[derive(Clone, Debug)]
pub struct Solved {
    /// Normal load of each friction interface, N.
    pub loads: Vec<f64>,
    /// Velocity of each friction interface, m/s.
    pub(crate) velocities: Vec<f64>,
    /// State of the mechanism.
    pub(crate) state: State<f64>,
    /// Number of steps in which friction converged.
    pub(crate) steps: usize,
}

impl Solved {
    pub(crate) fn of(data: &Data<f64>) -> Self {
        Self {
            loads: data.friction().iter().map(|own| own.load).collect(),
            velocities: data.friction().iter().map(|own| own.velocity).collect(),
            state: data.state.clone(),
            steps: data.inverse.friction_steps(),
        }
    }
}
