//! Stick, slip and slip direction of friction interfaces in joints with prescribed motion. The
//! prescribed motion determines all three.

use super::{REST, Simulation};
use crate::forward::Forward;
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::inputs::Inputs;
use crate::kinematics::Target;
use core::ops::Range;

/// Time, s, after which the direction of a prescribed motion that starts from rest is sampled.
const AHEAD: f64 = 1e-6;
/// Smallest prescribed rate that counts as motion, characteristic lengths per second. Smaller rates
/// are round-off of the input.
const MOVES: f64 = 1e-13;

impl Forward {
    /// Returns the indices of the degrees of freedom of an interface, counted within the interface.
    fn places(&self, interface: usize) -> Range<usize> {
        0..self.parameters.interfaces[interface].shape.dofs().len()
    }

    /// Returns true if all degrees of freedom of an interface are prescribed.
    pub(in crate::forward) fn is_prescribed_interface(&self, interface: usize) -> bool {
        self.places(interface).all(|place| self.is_prescribed_place(interface, place))
    }

    /// Returns true if any degree of freedom of an interface is prescribed.
    fn is_partly_prescribed(&self, interface: usize) -> bool {
        self.places(interface).any(|place| self.is_prescribed_place(interface, place))
    }

    /// Returns the sliding velocity of an interface along its prescribed degrees of freedom, m/s,
    /// for given targets. Components along other degrees of freedom are zero.
    fn prescribed_slip_velocity(&self, interface: usize, targets: &[Target<f64>]) -> [f64; 3] {
        let mut velocity = [0.0; 3];
        for (place, own) in self.places(interface).zip(&mut velocity) {
            let rate = self.prescribed_rate(interface, place, |target| targets[target].rate);
            *own = rate.unwrap_or(0.0);
        }
        velocity
    }

    /// Returns the mode of an interface at rest if the prescribed motion determines the mode.
    /// Returns `None` if the prescribed degrees of freedom of the interface are at rest and other
    /// degrees of freedom are not prescribed, or if no degree of freedom is prescribed.
    pub(super) fn prescribed_mode(
        &self,
        interface: usize,
        (time, fastest): (f64, f64),
        inputs: &mut dyn Inputs,
    ) -> Option<InterfaceMode> {
        if !self.is_partly_prescribed(interface) {
            return None;
        }
        let least = self.least_prescribed_speed(fastest);
        for ahead in [0.0, AHEAD] {
            let targets = self.targets(time + ahead, inputs);
            let velocity = self.prescribed_slip_velocity(interface, &targets);
            let speed = norm(velocity);
            if speed > least {
                return Some(InterfaceMode::Slides(velocity.map(|v| v / speed)));
            }
        }
        self.is_prescribed_interface(interface).then_some(InterfaceMode::Sticks)
    }

    /// Returns true if all prescribed coordinates are at rest, both at `time` and [`AHEAD`] seconds
    /// later. Returns false if no coordinate is prescribed.
    fn is_prescribed_at_rest(&self, (time, fastest): (f64, f64), inputs: &mut dyn Inputs) -> bool {
        let least = self.least_prescribed_speed(fastest);
        !self.prescribed.is_empty()
            && [0.0, AHEAD].iter().all(|ahead| {
                let targets = self.targets(time + ahead, inputs);
                let speeds = self.prescribed.iter().zip(&targets).map(|(&actuator, target)| {
                    let at = self.topology.actuators[actuator];
                    let translates =
                        self.topology.joint_types[at.joint].dofs()[at.dof].translates();
                    target.rate.abs() * if translates { 1.0 } else { self.parameters.length }
                });
                speeds.fold(0.0, f64::max) <= least
            })
    }

    fn least_prescribed_speed(&self, fastest: f64) -> f64 {
        (REST * fastest).max(MOVES * self.parameters.length)
    }
}

impl Simulation<'_> {
    /// Returns true if an interface whose mode is slip is at rest because the prescribed motion has
    /// come to rest. The sliding velocity of such an interface reaches zero without a change of
    /// sign.
    pub(super) fn rests_as_prescribed(&self, inputs: &mut dyn Inputs) -> bool {
        let place = (self.now.time, self.fastest);
        let accelerations = &self.now.state.accelerations;
        let is_still = |&interface: &usize| {
            let begins = self.model.surface_acceleration(&self.now.bodies, interface);
            matches!(self.modes[interface], InterfaceMode::Slides(_))
                && norm(self.now.interfaces[interface].velocity) <= REST * self.fastest
                && norm(begins) <= self.model.rounding_of_onset(accelerations, interface)
        };
        (0..self.modes.len()).filter(is_still).any(|interface| {
            match self.model.is_prescribed_interface(interface) {
                true => {
                    let mode = self.model.prescribed_mode(interface, place, inputs);
                    mode == Some(InterfaceMode::Sticks)
                }
                false => self.model.is_prescribed_at_rest(place, inputs),
            }
        })
    }

    /// Finds the fraction of a step at which an interface in a joint with prescribed motion begins
    /// to slip. Returns `None` if the interface does not slip at the end of the step.
    pub(super) fn prescribed_slip_onset(
        &self,
        interface: usize,
        (time, step): (f64, f64),
        inputs: &mut dyn Inputs,
    ) -> Option<f64> {
        if !self.model.is_partly_prescribed(interface) {
            return None;
        }
        let least = self.model.least_prescribed_speed(self.fastest);
        let mut moves = |part: f64| {
            let targets = self.model.targets(time + part * step, inputs);
            norm(self.model.prescribed_slip_velocity(interface, &targets)) > least
        };
        if !moves(1.0) {
            return None;
        }
        let (mut low, mut high) = (0.0, 1.0);
        while (high - low) * step > 4.0 * f64::EPSILON * (time + step).abs() && high - low > 1e-15 {
            let middle = 0.5 * (low + high);
            if moves(middle) { high = middle } else { low = middle }
        }
        Some(high)
    }
}
