//! Friction interfaces in prescribed joints: the prescribed motion determines stick, slip and direction.

use super::{REST, Simulation};
use crate::forward::Forward;
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::inputs::Inputs;
use crate::kinematics::Target;

/// How far ahead of an instant at rest it is looked where to a prescribed motion begins, s.
const AHEAD: f64 = 1e-6;
/// What is prescribed moves if it does so by more than this many characteristic lengths per second: less is
/// rounding of whatever computes it.
const MOVES: f64 = 1e-13;

impl Forward {
    /// Where in the list of prescribed actuators those of a contact's freedoms are, if it is led by them alone.
    pub(in crate::forward) fn leaders(&self, interface: usize) -> Option<Vec<usize>> {
        let content = &self.parameters.interfaces[interface];
        let leader = |dof: usize| {
            self.prescribed.iter().position(|&actuator| {
                let at = self.topology.actuators[actuator];
                (at.joint, at.dof) == (content.joint, dof)
            })
        };
        content.shape.dofs().map(leader).collect()
    }

    /// The velocity of the surface of a contact that is led, m/s.
    fn led_velocity(
        &self,
        interface: usize,
        leaders: &[usize],
        targets: &[Target<f64>],
    ) -> [f64; 3] {
        let content = &self.parameters.interfaces[interface];
        let arms = content.arms(self.parameters.pitch[content.joint]);
        let mut velocity = [0.0; 3];
        for ((v, arm), leader) in velocity.iter_mut().zip(arms).zip(leaders) {
            *v = arm * targets[*leader].rate;
        }
        velocity
    }

    /// What a contact at rest does that is led by prescribed motions; none if it is not.
    pub(super) fn led(
        &self,
        interface: usize,
        (time, fastest): (f64, f64),
        inputs: &mut dyn Inputs,
    ) -> Option<InterfaceMode> {
        let leaders = self.leaders(interface)?;
        let least = self.least_led(fastest);
        for ahead in [0.0, AHEAD] {
            let targets = self.targets(time + ahead, inputs);
            let velocity = self.led_velocity(interface, &leaders, &targets);
            let speed = norm(velocity);
            if speed > least {
                return Some(InterfaceMode::Slides(velocity.map(|v| v / speed)));
            }
        }
        Some(InterfaceMode::Sticks)
    }

    fn least_led(&self, fastest: f64) -> f64 {
        (REST * fastest).max(MOVES * self.parameters.length)
    }
}

impl Simulation<'_> {
    /// The part of a step at which a contact that is led and was at rest moves, if it does at its end.
    pub(super) fn is_led_away(
        &self,
        interface: usize,
        (time, step): (f64, f64),
        inputs: &mut dyn Inputs,
    ) -> Option<f64> {
        let leaders = self.model.leaders(interface)?;
        let least = self.model.least_led(self.fastest);
        let mut moves = |part: f64| {
            let targets = self.model.targets(time + part * step, inputs);
            norm(self.model.led_velocity(interface, &leaders, &targets)) > least
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
