//! Divergence guard: stops when speeds exceed physical limits.
//!
//! Unstable controllers and unbounded efforts can increase speeds without limit while the steps
//! become ever smaller. The guard uses the speed of light, a limit that is valid for every
//! mechanism.

use super::Simulation;
use crate::dynamics::SpringFault;
use crate::forward::error::ForwardError;

/// Speed of light, m/s.
const SPEED_OF_LIGHT: f64 = 299_792_458.0;

impl Simulation<'_> {
    /// Checks that no body exceeds the speed of light, either by the velocity of its centre of mass
    /// or by its angular velocity times the characteristic length, and that no bushing or joint
    /// spring is rotated too far.
    pub(super) fn check_speeds(&self) -> Result<(), ForwardError> {
        let parameters = &self.model.parameters;
        let bodies = &self.now.bodies;
        let turned = SpringFault::first_turned(&self.model.topology, parameters, bodies);
        if let Some((spring, Some(problem))) =
            turned.map(|fault| fault.in_words(self.model.simulated()))
        {
            return Err(ForwardError::Spring { time: self.now.time, spring, problem });
        }
        for (body, (twist, pose)) in bodies.twist.iter().zip(&bodies.pose).enumerate() {
            let velocity = twist.velocity_at(pose.apply(parameters.com[body]));
            let speed = velocity.norm().max(twist.angular.norm() * parameters.length);
            if speed > SPEED_OF_LIGHT {
                let body = self.model.simulated().bodies()[body].name.clone();
                return Err(ForwardError::Runaway { time: self.now.time, body, speed });
            }
        }
        Ok(())
    }
}
