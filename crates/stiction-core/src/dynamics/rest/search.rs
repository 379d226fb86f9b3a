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
use core::ops::Range;

/// Largest number of updates of the directions of static friction. The limit is larger than that in
/// `rest::bounds`, because an update here is cheaper than a complete solution there.
const ROUNDS: usize = 16;

/// Coupled problem of normal loads and friction at rest, for given static friction.
pub(super) trait StaticProblem {
    /// Solves the problem: from the normal loads without friction if `is_new`, otherwise from those
    /// of the last solution. `None` if Newton's method fails.
    fn settle(&mut self, frictions: &[StaticFriction], is_new: bool) -> Option<()>;

    /// Computes the derivative of an effort with respect to each component of static friction, in
    /// units of the friction limit, at the solution. `None` if the coupling is singular.
    fn slopes(&mut self, actuator: usize, slopes: &mut Vec<f64>) -> Option<()>;

    /// Returns the places of the components of an interface in [`Self::slopes`].
    fn components(&self, interface: usize) -> Range<usize>;

    /// Returns an effort at the solution, N or N m.
    fn effort(&self, actuator: usize) -> f64;
}

/// Finds the largest (smallest) value of an effort by repeatedly turning static friction along the
/// derivatives of the effort, which are exact, from the adjoint of the coupled problem. `released`
/// contains the interfaces at rest with zero static friction, and `slopes` the derivatives there.
/// `None` if the problem has no solution or no derivatives.
pub(super) fn extreme_of(
    problem: &mut impl StaticProblem,
    goal: Goal,
    released: &[StaticFriction],
    slopes: &[f64],
) -> Option<Extreme> {
    let mut found = Extreme { least: f64::INFINITY, greatest: f64::NEG_INFINITY };
    let mut frictions = released.to_vec();
    let mut slopes = slopes.to_vec();
    for round in 0..ROUNDS {
        if round > 0 {
            problem.slopes(goal.actuator, &mut slopes)?;
        }
        let next: Vec<StaticFriction> = frictions
            .iter()
            .map(|friction| {
                let own = &slopes[problem.components(friction.interface)];
                friction.towards(own.iter().map(|slope| goal.sense * slope))
            })
            .collect();
        if next.iter().zip(&frictions).all(|(next, friction)| next.is_near(friction)) {
            break;
        }
        frictions = next;
        // Directions change little after the first update.
        problem.settle(&frictions, round == 0)?;
        let effort = problem.effort(goal.actuator);
        let Extreme { least, greatest } = found;
        found = Extreme { least: least.min(effort), greatest: greatest.max(effort) };
    }
    Some(found)
}

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
    /// Finds the largest (smallest) efforts that static friction can cause, one for each goal.
    /// Friction forces that satisfy all friction laws attain each result. `None` if Newton's method
    /// fails.
    pub(super) fn extremes(&mut self, goals: &[Goal], efforts: usize) -> Option<Vec<Extreme>> {
        // All searches start without static friction.
        self.settle(self.released, true)?;
        let mut released = vec![Vec::new(); efforts];
        for (actuator, slopes) in released.iter_mut().enumerate() {
            self.slopes(actuator, slopes)?;
        }
        let at_rest = self.released;
        goals
            .iter()
            .map(|goal| extreme_of(self, *goal, at_rest, &released[goal.actuator]))
            .collect()
    }
}

impl StaticProblem for Search<'_> {
    fn settle(&mut self, frictions: &[StaticFriction], is_new: bool) -> Option<()> {
        let Self { inverse, topology, at, settings, .. } = *self;
        let mut next = frictions.iter().peekable();
        let acting = (0..inverse.interfaces().len()).map(|interface| {
            let friction = next.next_if(|friction| friction.interface == interface);
            let held = friction.map(|friction| friction.direction);
            acting_with((inverse, topology, at, settings), interface, held)
        });
        self.coupling.act(acting, at);
        let start = if is_new { Start::Uncoupled } else { Start::Last };
        self.coupling.settle(at, start).then_some(())
    }

    fn slopes(&mut self, actuator: usize, slopes: &mut Vec<f64>) -> Option<()> {
        self.coupling.slopes(actuator, self.at, slopes)
    }

    fn components(&self, interface: usize) -> Range<usize> {
        self.coupling.components(interface)
    }

    fn effort(&self, actuator: usize) -> f64 {
        self.coupling.effort(actuator)
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
