//! Stick onset of plates and balls.
//!
//! Friction of an interface with several degrees of freedom acts along `-v / |v|`. Stick onset is a
//! zero of `|v|`, not a change of sign, and the slower the slip, the faster its direction turns:
//! with the time `s` to the stop the velocity behaves as `s d + s^p e` with some `p > 1`, which is
//! no polynomial. A step therefore ends at a fixed fraction of the remaining time, estimated from
//! the present deceleration. Each such step is similar to the one before on a smaller scale. About
//! twenty of them reduce any speed to a negligible one; by then direction and normal load have
//! reached their values at the stop.

use super::between::Course;
use super::locate::Ending;
use super::{REST, Simulation};
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;

/// Below this fraction of the largest slip speed a plate or ball is advanced directly to its stop.
/// The remaining time is then the same fraction of the time since it was fastest.
pub(super) const SLOW: f64 = 10.0 * REST;
/// Largest step as a fraction of the time to the stop.
const PART: f64 = 0.7;
/// If the slip direction has turned by a right angle and the speed is below this fraction of the
/// earlier speed, the step may have missed a stop.
pub(super) const PASSED: f64 = 0.25;

/// Approach of a plate or ball to its stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Approach {
    /// Deceleration towards a stop, with the longest step, s.
    Nears { most: f64 },
    /// Arrival at a stop: the speed is negligible.
    Arrives {
        /// Index of the friction interface.
        interface: usize,
        /// Time to the stop, s.
        within: f64,
    },
}

impl Simulation<'_> {
    /// How the plate or ball that comes to rest next approaches its stop; `None` if none decelerates.
    pub(super) fn approach(&self) -> Option<Approach> {
        let mut most = f64::INFINITY;
        for (interface, mode) in self.modes.iter().enumerate() {
            let single = self.model.parameters.interfaces[interface].shape.has_one_dof();
            if single || !matches!(mode, InterfaceMode::Slides(_)) {
                continue;
            }
            let velocity = self.now.interfaces[interface].velocity;
            let speed = norm(velocity);
            if speed <= 0.0 {
                continue;
            }
            let change = self.model.surface_acceleration(&self.now.bodies, interface);
            let along = velocity.iter().zip(change).map(|(v, a)| v * a).sum::<f64>() / speed;
            let slows = -along;
            if slows <= 0.0 {
                continue;
            }
            let within = speed / slows;
            if speed <= SLOW * self.fastest {
                let turns = [0, 1, 2].map(|k| change[k] - along * velocity[k] / speed);
                if norm(turns) < slows {
                    return Some(Approach::Arrives { interface, within });
                }
                continue;
            }
            most = most.min(PART * within);
        }
        most.is_finite().then_some(Approach::Nears { most })
    }

    /// Advances a plate or ball to its stop, `within` s from now.
    pub(super) fn come_to_rest(
        &mut self,
        interface: usize,
        within: f64,
        (start, first): (&[f64], &[f64]),
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        // Rates decrease linearly; second-order changes of all other quantities are negligible over
        // this time.
        let y: Vec<f64> = start.iter().zip(first).map(|(y, rate)| y + within * rate).collect();
        let time = self.now.time;
        self.last_step.course = Course::Line;
        let arrived = self.arrive(time + within, &y, inputs)?;
        self.commit(&y, arrived);
        self.follow_up(Ending::Stops(interface), time, inputs)
    }
}
