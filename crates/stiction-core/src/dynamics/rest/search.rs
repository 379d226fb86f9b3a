//! Search for the extreme efforts over all admissible static friction forces, based on the effects
//! of unit friction forces. The coupling must be so weak that the solution is unique for each
//! static friction.
//!
//! Equation (R1) of the book's theory.

use super::bounds::{Extreme, Goal, StaticFriction};
use crate::dynamics::coupling::{Acting, FrictionCoupling, Start};
use crate::dynamics::inverse::Inverse;
use crate::dynamics::settings::Settings;
use crate::friction_problem::normal_load::Configuration;
use crate::topology::Topology;

/// Largest number of updates of the directions of static friction. The limit is larger than that in
/// `rest::bounds`, because an update here is cheaper than a complete solution there.
pub(super) const ROUNDS: usize = 16;

/// Search for extreme efforts over the static friction forces of the interfaces at rest.
pub(super) struct Search<'a> {
    pub(super) coupling: &'a mut FrictionCoupling,
    pub(super) inverse: &'a Inverse<f64>,
    pub(super) topology: &'a Topology,
    pub(super) at: Configuration<'a>,
    pub(super) settings: &'a Settings,
    /// Interfaces at rest, with zero static friction, from which each search starts.
    pub(super) released: &'a [StaticFriction],
}

impl Search<'_> {
    /// Finds the largest (smallest) efforts that static friction can cause, one for each goal. The
    /// derivatives of the efforts are exact, from the adjoint of the coupled problem. Friction
    /// forces that satisfy all friction laws attain each result. `None` if Newton's method fails.
    pub(super) fn extremes(&mut self, goals: &[Goal], efforts: usize) -> Option<Vec<Extreme>> {
        // All searches start without static friction.
        self.settle(self.released, Start::Uncoupled)?;
        let mut released = vec![Vec::new(); efforts];
        for (actuator, slopes) in released.iter_mut().enumerate() {
            self.coupling.slopes(actuator, self.at, slopes)?;
        }
        goals.iter().map(|goal| self.extreme(*goal, &released[goal.actuator])).collect()
    }

    /// Finds the largest (smallest) value of an effort. `released` contains the derivatives of the
    /// effort with respect to the static friction, at zero static friction.
    fn extreme(&mut self, goal: Goal, released: &[f64]) -> Option<Extreme> {
        let mut found = Extreme { least: f64::INFINITY, greatest: f64::NEG_INFINITY };
        let mut frictions = self.released.to_vec();
        let mut slopes = released.to_vec();
        for round in 0..ROUNDS {
            if round > 0 {
                self.coupling.slopes(goal.actuator, self.at, &mut slopes)?;
            }
            let next: Vec<StaticFriction> = frictions
                .iter()
                .map(|friction| {
                    let own = &slopes[self.coupling.components(friction.interface)];
                    friction.towards(own.iter().map(|slope| goal.sense * slope))
                })
                .collect();
            if next.iter().zip(&frictions).all(|(next, friction)| next.is_near(friction)) {
                break;
            }
            frictions = next;
            // Directions change little after the first update.
            let start = if round == 0 { Start::Uncoupled } else { Start::Last };
            self.settle(&frictions, start)?;
            let effort = self.coupling.effort(goal.actuator);
            let Extreme { least, greatest } = found;
            found = Extreme { least: least.min(effort), greatest: greatest.max(effort) };
        }
        Some(found)
    }

    /// Solves the coupled problem with the static friction in `frictions`; `None` if Newton's
    /// method fails.
    fn settle(&mut self, frictions: &[StaticFriction], start: Start<'_>) -> Option<()> {
        let Self { inverse, topology, at, settings, .. } = *self;
        let mut next = frictions.iter().peekable();
        let acting = (0..inverse.interfaces().len()).map(|interface| {
            let friction = next.next_if(|friction| friction.interface == interface);
            let held = friction.map(|friction| friction.direction);
            acting_with((inverse, topology, at, settings), interface, held)
        });
        self.coupling.act(acting, at);
        self.coupling.settle(at, start).then_some(())
    }
}

/// Returns the friction that acts at an interface: static friction in the direction `held` or, if
/// it is `None`, the kinetic friction of a sliding interface and none of an interface at rest.
pub(super) fn acting_with(
    (inverse, topology, at, settings): (&Inverse<f64>, &Topology, Configuration<'_>, &Settings),
    interface: usize,
    held: Option<[f64; 3]>,
) -> Acting {
    let state = &inverse.interfaces()[interface];
    let Some(held) = held else { return Acting::of(state, [0.0; 3]) };
    // The friction limit may depend on the direction.
    let mut state = *state;
    let content = &at.parameters.interfaces[interface];
    let pitch = at.parameters.pitch[content.joint];
    state.update_slip(topology, content, pitch, at.bodies, settings.rest_speed, held);
    Acting::of(&state, held)
}
