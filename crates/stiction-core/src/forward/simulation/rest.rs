//! Stick onset of plates and balls.
//!
//! The friction of an interface with several degrees of freedom acts along `-v / |v|`. Stick onset
//! is a zero of `|v|`, not a change of sign, and the direction turns faster as the slip becomes
//! slower: as a function of the remaining time `s`, the velocity behaves like `s d + s^p e` with
//! constant vectors `d` and `e` and an exponent `p > 1` that is in general no integer. Therefore a
//! step ends at a fixed fraction of the remaining time, which is estimated from the present
//! deceleration. Each of these steps is similar to the previous one on a smaller scale. About
//! twenty steps reduce any speed to a negligible value; direction and normal load have then
//! converged to their values at the stop.

use super::between::Interpolation;
use super::locate::Ending;
use super::{REST, Simulation};
use crate::forward::affine_friction::{InterfaceMode, dot, norm};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;

/// A plate or ball is advanced directly to its stop if its speed is below this fraction of the
/// largest sliding velocity. At constant deceleration, the remaining time is then about the same
/// fraction of the time since the largest velocity.
pub(super) const SLOW: f64 = 10.0 * REST;
/// Longest step as a fraction of the estimated time to the stop.
const PART: f64 = 0.7;
/// A step may have missed a stop if the sliding speed at its end is below this fraction of the
/// speed at its start, and the direction of slip has turned by at least a right angle.
pub(super) const PASSED: f64 = 0.25;

/// Approach of a sliding plate or ball to its stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Approach {
    /// At least one plate or ball decelerates towards a stop; `most` is the longest allowed length
    /// of the next step, s.
    Nears { most: f64 },
    /// The speed of a plate or ball is negligible, so that the next step ends at its stop.
    Arrives {
        /// Index of the friction interface.
        interface: usize,
        /// Time until the stop, s.
        within: f64,
    },
}

impl Simulation<'_> {
    /// Determines the approach of the plate or ball that will stop first; `None` if no plate or
    /// ball decelerates.
    pub(super) fn approach(&self) -> Option<Approach> {
        let mut most = f64::INFINITY;
        for (interface, mode) in self.modes.iter().enumerate() {
            let single = self.model.parameters.interfaces[interface].shape.has_one_dof();
            let InterfaceMode::Slides(direction) = *mode else { continue };
            let velocity = self.now.interfaces[interface].velocity;
            let speed = norm(velocity);
            // Where slip has just reversed, the velocity that is left is round-off.
            if single || dot(velocity, direction) <= 0.0 {
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

    /// Advances a plate or ball to its stop, which lies `within` seconds ahead.
    pub(super) fn come_to_rest(
        &mut self,
        interface: usize,
        within: f64,
        (start, first): (&[f64], &[f64]),
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        // The sliding velocity decreases linearly to zero. Second-order changes of all other
        // quantities are negligible within this short time.
        let y: Vec<f64> = start.iter().zip(first).map(|(y, rate)| y + within * rate).collect();
        let time = self.now.time;
        self.last_step.interpolation = Interpolation::Line;
        let arrived = self.arrive(time + within, &y, inputs)?;
        self.commit(&y, arrived);
        self.follow_up(Ending::Stops(interface), time, inputs)
    }
}
