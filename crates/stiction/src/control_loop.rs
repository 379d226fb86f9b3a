//! Inverse dynamics for control loops. The model is compiled once; calls look up no names, do no
//! input or output, and allocate no memory.

use crate::error::Error;
use crate::robot::Robot;
use stiction_core::dynamics::{Data, Model};

/// Compiled inverse dynamics with the actuators as independent coordinates; see [`Robot::control_loop`].
#[derive(Clone, Debug)]
pub struct ControlLoop {
    /// Compiled model. Evaluations do not change it.
    pub model: Model,
    /// Memory for the state and the results, allocated once.
    pub data: Data<f64>,
    /// Positions of the actuators at the first instant of the default motion, m or rad, in the
    /// order of [`Robot::actuators`]. For a model without motions, the positions of the actuators
    /// at the home position.
    pub position: Vec<f64>,
}

impl ControlLoop {
    /// Compiles a robot at the first instant of its default motion.
    pub(crate) fn new(robot: &Robot) -> Result<Self, Error> {
        Ok(robot.states().compile()?.into_control_loop())
    }
}
