//! Stick onset of plates and balls.
//!
//! Friction of an interface with several degrees of freedom acts along `-v / |v|`. Stick onset is a zero of `|v|`, not
//! a change of sign, and the slower the slip, the faster its direction turns: with the time `s` to the stop the
//! velocity behaves as `s d + s^p e` with some `p > 1`, which is no polynomial. A step therefore ends at a fixed
//! fraction of the remaining time, estimated from the present deceleration. Each such step resembles the previous one
//! on a smaller scale. About twenty of them reduce any speed to a negligible one; by then direction and normal load
//! have reached their values at the stop.

use super::between::Interpolation;
use super::locate::Ending;
use super::{REST, Simulation};
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;

/// A plate or ball is advanced directly to its stop below this fraction of the largest slip speed.
/// The remaining time is then the same fraction of the time that has passed since the largest
/// speed.
pub(super) const SLOW: f64 = 10.0 * REST;
/// Longest step as a fraction of the estimated time to the stop.
const PART: f64 = 0.7;
/// A step may have missed a stop if the slip speed at its end is below this fraction of that at its
/// start and the slip direction has turned by at least a right angle.
pub(super) const PASSED: f64 = 0.25;

/// Approach of a plate or ball to its stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Approach {
    /// Deceleration towards a stop; `most` is the longest step, s.
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
    /// Determines the approach of the plate or ball that stops first; `None` if none decelerates.
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

    /// Advances a plate or ball to its stop, which lies `within` s ahead.
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
        self.last_step.interpolation = Interpolation::Line;
        let arrived = self.arrive(time + within, &y, inputs)?;
        self.commit(&y, arrived);
        self.follow_up(Ending::Stops(interface), time, inputs)
    }
}
