//! Where a motion has left what mechanics is about.
//!
//! Controllers that are not stable and efforts that grow without bound make speeds that double from step to step. Steps
//! become ever shorter, and numbers lose their meaning long before they are infinite. There is no limit that a
//! mechanism would not have from its material first, but one that holds for all of them.

use super::Simulation;
use crate::forward::error::ForwardError;

/// m/s.
const SPEED_OF_LIGHT: f64 = 299_792_458.0;

impl Simulation<'_> {
    /// No body may be faster than light, be it by turning.
    pub(super) fn check_speeds(&self) -> Result<(), ForwardError> {
        let parameters = &self.model.parameters;
        let bodies = &self.now.bodies;
        for (body, (twist, pose)) in bodies.twist.iter().zip(&bodies.pose).enumerate() {
            let velocity = twist.velocity_at(pose.apply(parameters.com[body]));
            let speed = velocity.norm().max(twist.angular.norm() * parameters.length);
            if speed > SPEED_OF_LIGHT {
                let body = self.model.mechanism.bodies()[body].name.clone();
                return Err(ForwardError::Runaway { time: self.now.time, body, speed });
            }
        }
        Ok(())
    }
}
