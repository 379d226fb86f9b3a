//! Stick onset of plates and balls.
//!
//! Friction of a contact with several freedoms is against `v / |v|`. Its stop is a zero of `|v|`, not a change
//! of sign, and on the way there the direction turns the faster the slower it is: in time to the stop `s` the
//! velocity behaves as `s d + s^p e` with some `p > 1`, which is no polynomial. So a step ends at a fixed part
//! of the time that is left, as far as the present deceleration tells it. Each such step is like the one
//! before, on a smaller scale; some twenty of them lead from any speed to one that is nothing, and direction
//! and load of the stop are by then those at its end.

use super::locate::Ending;
use super::{REST, Simulation};
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;

/// Slower than this part of the fastest a plate or ball goes straight to its stop: the stop is then as far off,
/// as part of the time since it was fastest.
pub(super) const SLOW: f64 = 10.0 * REST;
/// Largest step as part of the time to the stop.
const PART: f64 = 0.7;
/// A plate or ball whose direction has turned by a right angle and whose speed is less than this part of what it
/// was may have passed its stop.
pub(super) const PASSED: f64 = 0.25;

/// Approach of a plate or ball to its stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Approach {
    /// It decelerates; the longest step, s.
    Nears { most: f64 },
    /// Its speed is negligible.
    Arrives {
        /// Index of the friction interface.
        interface: usize,
        /// Time to the stop, s.
        within: f64,
    },
}

impl Simulation<'_> {
    /// Finds the decelerating plate or ball that is nearest to its stop.
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
        // Rates fall evenly; of all else, energies among it, what the square of this time adds is nothing.
        let y: Vec<f64> = start.iter().zip(first).map(|(y, rate)| y + within * rate).collect();
        let time = self.now.time;
        let arrived = self.arrive(time + within, &y, inputs)?;
        self.commit(&y, arrived);
        self.follow_up(Ending::Stops(interface), time, inputs)
    }
}
