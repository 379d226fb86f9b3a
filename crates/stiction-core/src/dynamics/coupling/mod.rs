//! Coupling of friction and normal loads, computed from the effects of unit friction forces: a
//! bound on the coupling, and friction forces that are consistent with the normal loads they cause.
//!
//! Equations (F6), (F7) and (D3) of the book's theory.

mod acting;
mod influence;
mod opposite;
mod settle;
mod slopes;

pub(super) use acting::Acting;
pub(super) use settle::Start;

use super::balance::{Four, UnitFriction, UnitResponses, WIDTH};
use super::interfaces::InterfaceState;
use super::inverse::Inverse;
use super::load_history::LoadHistory;
use super::model::Model;
use super::responses::Responses;
use crate::friction::{OwnFriction, Resistance};
use crate::friction_problem::load_problem::{LoadProblem, LoadWorkspace};
use crate::friction_problem::normal_load::Configuration;
use crate::friction_problem::small_system::pack;
use crate::friction_problem::uniqueness::{self, BoundStart, BoundWorkspace};
use crate::kinematics::{Bodies, Results};
use crate::parameters::Parameters;
use crate::spatial::{Twist, Wrench};
use influence::{ComputedInfluence, StoredInfluence};

/// Largest number of interfaces for which the effects of all unit friction forces are stored and
/// the normal loads are computed as a dense problem. The cost grows with the cube of the number of
/// interfaces.
const DENSE: usize = 64;

/// Motion at a configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sense {
    Present,
    /// Motion with all rates reversed.
    Opposite,
}

/// Responses to unit friction forces and the forces without friction at one configuration, with
/// buffers for computing friction forces.
#[derive(Clone, Debug, Default)]
pub(super) struct FrictionCoupling {
    responses: Responses,
    /// True if the responses belong to the present configuration.
    is_current: bool,
    /// True if the responses contain joint wrenches.
    is_stored: bool,
    /// True if `problem` contains the influence of the friction in the present motion.
    is_present: bool,
    /// Joint wrenches without friction.
    wrenches: Vec<Wrench<f64>>,
    /// Actuator efforts without friction.
    efforts: Vec<f64>,
    acting: Vec<Acting>,
    /// Changes of the joint wrenches due to the friction that does not depend on normal loads.
    constant_changes: Vec<Wrench<f64>>,
    /// Indices of the interfaces whose friction depends on the normal load.
    unknowns: Vec<usize>,
    /// Normal loads of the interfaces in `unknowns`, N.
    loads: Vec<f64>,
    /// Normal loads at previous configurations: those of the present motion, and those of the
    /// opposite motion.
    history: [LoadHistory; 2],
    /// True if normal loads at previous configurations are stored as starting values. Otherwise
    /// solutions do not depend on previous configurations.
    keeps_history: bool,
    /// Friction force of each friction component, N.
    frictions: Vec<f64>,
    start: Vec<Wrench<f64>>,
    problem: LoadProblem,
    workspace: LoadWorkspace,
    /// Buffers for the coupling bound of the opposite motion, whose eigenvectors are different.
    opposite: LoadWorkspace,
    bound: BoundWorkspace,
    /// Largest coupling bound that is accepted without refinement; see [`Self::accept_up_to`].
    accepted: f64,
    /// Friction force of each component per newton of normal load, in blocks of four components.
    factors: Vec<Four>,
    /// Friction force of each component, N, in blocks of four components.
    packed: Vec<Four>,
    /// Coupling bound computed last, by [`Self::begin`] for the present motion or by
    /// [`Self::reversed_efforts`] for the opposite motion.
    strength: f64,
    /// Derivatives of an effort with respect to the normal loads.
    weights: Vec<f64>,
    gradients: Vec<Twist<f64>>,
    gains: Vec<Twist<f64>>,
}

impl FrictionCoupling {
    /// Marks the responses as invalid, after a change of the configuration.
    pub(super) fn leave(&mut self) {
        (self.is_current, self.is_present) = (false, false);
    }

    /// Copies joint wrenches and efforts from `inverse`, a frictionless solution at a new
    /// configuration, and marks the responses as invalid.
    pub(super) fn start_from(&mut self, inverse: &Inverse<f64>) {
        self.leave();
        self.wrenches.clear();
        self.wrenches.extend_from_slice(inverse.joint_wrenches());
        self.efforts.clear();
        self.efforts.extend_from_slice(inverse.efforts());
    }

    /// Returns the responses at the configuration of `inverse`, including joint wrenches if
    /// `with_wrenches`.
    pub(super) fn responses(
        &mut self,
        inverse: &Inverse<f64>,
        model: &Model,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        with_wrenches: bool,
    ) -> &Responses {
        if !self.is_current || with_wrenches && !self.is_stored {
            let ignore = |_: usize, _: &[UnitFriction], _: &UnitResponses| {};
            self.responses.update(inverse, model, parameters, bodies, with_wrenches, ignore);
            (self.is_current, self.is_stored) = (true, with_wrenches);
        }
        &self.responses
    }

    /// Returns the responses of the last [`Self::responses`].
    pub(super) fn known_responses(&self) -> &Responses {
        &self.responses
    }

    /// Returns the joint wrenches and the actuator efforts without friction.
    pub(super) fn frictionless(&self) -> (&[Wrench<f64>], &[f64]) {
        (&self.wrenches, &self.efforts)
    }

    /// Computes the responses to unit friction forces, and returns the bound on the coupling of
    /// friction and normal loads. If the bound is below one, the solution is unique. `inverse`
    /// contains the frictionless solution.
    pub(super) fn begin(
        &mut self,
        inverse: &Inverse<f64>,
        model: &Model,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
    ) -> f64 {
        self.start_from(inverse);
        let at = Configuration { parameters, bodies };
        let states = inverse.interfaces();
        if states.len() <= DENSE {
            self.responses(inverse, model, parameters, bodies, true);
            return self.begin_with_responses(states, at, None);
        }
        let Self { unknowns, responses, bound, .. } = self;
        unknowns.clear();
        unknowns.extend((0..states.len()).filter(|&interface| {
            let state = &states[interface];
            state.sliding > 0.0 && state.resistance.coefficient > 0.0
        }));
        let each =
            unknowns.iter().map(|&unknown| (unknown, states[unknown].resistance.coefficient));
        let mut influence = ComputedInfluence { responses, inverse, model, at, unknowns };
        if !self.keeps_history {
            bound.start(BoundStart::New);
        }
        bound.accept_up_to(self.accepted);
        let strength = uniqueness::coupling_bound(at, each, &mut influence, bound);
        (self.is_current, self.is_stored) = (!self.unknowns.is_empty(), false);
        self.strength = strength;
        strength
    }

    /// Reads the responses from the results of a recorded program, and returns the bound on the
    /// coupling like [`Self::begin`]. `inverse` contains the frictionless solution, in which all
    /// interfaces slide.
    pub(super) fn begin_by_program(
        &mut self,
        inverse: &Inverse<f64>,
        model: &Model,
        at: Configuration<'_>,
        numbers: &mut Results<'_>,
    ) -> f64 {
        self.start_from(inverse);
        self.responses.read(inverse, model, numbers);
        (self.is_current, self.is_stored) = (true, true);
        let states = inverse.interfaces();
        let matrix = numbers.take(states.len() * states.len());
        self.begin_with_responses(states, at, Some(matrix))
    }

    /// Sets the friction of the present motion, and returns the bound on the coupling. `matrix` is
    /// the coupling matrix of all interfaces, if it is known.
    fn begin_with_responses(
        &mut self,
        states: &[InterfaceState<f64>],
        at: Configuration<'_>,
        matrix: Option<&[f64]>,
    ) -> f64 {
        self.act(states.iter().map(|state| Acting::of(state, [0.0; 3])), at);
        self.is_present = true;
        let squared = self.unknowns.len().pow(2);
        let matrix = matrix.filter(|matrix| matrix.len() == squared);
        self.strength = self.coupling_bound(at, matrix, Sense::Present);
        self.strength
    }

    /// Returns true if the responses of this many interfaces are stored.
    pub(super) fn stores(interfaces: usize) -> bool {
        interfaces <= DENSE
    }

    /// Computes the bound on the coupling between normal loads and the friction set by
    /// [`Self::act`] for the motion `sense`.
    fn coupling_bound(
        &mut self,
        at: Configuration<'_>,
        matrix: Option<&[f64]>,
        sense: Sense,
    ) -> f64 {
        let Self { problem, workspace, opposite, keeps_history, accepted, .. } = self;
        let workspace = match sense {
            Sense::Present => workspace,
            Sense::Opposite => opposite,
        };
        let start = if *keeps_history { BoundStart::Last } else { BoundStart::New };
        match matrix {
            Some(matrix) => problem.coupling_bound_of(matrix, (start, *accepted), workspace),
            None => problem.coupling_bound(at, (start, *accepted), workspace),
        }
    }

    /// Makes [`Self::begin`] accept any coupling bound up to `bound` instead of refining it to the
    /// smallest bound.
    pub(super) fn accept_up_to(&mut self, bound: f64) {
        self.accepted = bound;
    }

    /// Sets the friction that acts at each interface, and sets up the equations for the normal
    /// loads.
    pub(super) fn act(&mut self, acting: impl Iterator<Item = Acting>, at: Configuration<'_>) {
        self.set_unknowns(acting, at);
        self.set_influence(at);
    }

    /// Sets the friction that acts at each interface, and the unknown normal loads with the
    /// wrenches that do not depend on them.
    fn set_unknowns(&mut self, acting: impl Iterator<Item = Acting>, at: Configuration<'_>) {
        self.acting.clear();
        self.acting.extend(acting);
        let Self { responses, frictions, packed, constant_changes, .. } = self;
        frictions.clear();
        for (interface, acting) in self.acting.iter().enumerate() {
            let constant = acting.resistance.constant;
            let components = responses.components(interface).zip(acting.parts);
            frictions.extend(components.map(|(_, part)| part * constant));
        }
        pack(frictions, packed);
        constant_changes.clear();
        constant_changes.resize(self.wrenches.len(), Wrench::zero());
        responses.add_to(constant_changes, packed);
        self.add_unknowns(at);
    }

    /// Adds the normal loads on which friction depends to the problem, with the wrenches that do
    /// not depend on them.
    fn add_unknowns(&mut self, at: Configuration<'_>) {
        let Self { problem, unknowns, .. } = self;
        unknowns.clear();
        problem.clear();
        for (interface, acting) in self.acting.iter().enumerate() {
            if acting.is_coupled() {
                let Resistance { coefficient, constant } = acting.resistance;
                let own = OwnFriction { coefficient, constant, direction: acting.sense };
                let joint = at.joint(interface);
                let base = self.wrenches[joint] + self.constant_changes[joint];
                unknowns.push(interface);
                problem.add(interface, own, base);
            }
        }
    }

    /// Computes the influence of the unknown normal loads on the joint wrenches.
    fn set_influence(&mut self, at: Configuration<'_>) {
        self.is_present = false;
        let Self { responses, problem, unknowns, .. } = self;
        let (acting, parameters) = (&*self.acting, at.parameters);
        if unknowns.len() == responses.len() {
            // All interfaces are coupled and have one component, so the blocks are the same as
            // those of the responses.
            let factor = |acting: &Acting| acting.parts[0] * acting.resistance.coefficient;
            let factors = &mut self.factors;
            factors.clear();
            factors.extend(
                acting
                    .chunks(WIDTH)
                    .map(|acting| Four::from_fn(|lane| acting.get(lane).map_or(0.0, factor))),
            );
            problem.set_influence_in_blocks(|row, block| {
                *responses.block(block, at.joint(row)) * factors[block]
            });
            return;
        }
        problem.set_influence(&mut StoredInfluence { responses, acting, unknowns, parameters });
    }

    /// Enables the use of normal loads at previous configurations as starting values.
    pub(super) fn keep_history(&mut self) {
        self.keeps_history = true;
    }

    /// Discards the normal loads and eigenvectors of previous configurations, so that the next
    /// solution does not depend on them.
    pub(super) fn forget(&mut self) {
        self.history.iter_mut().for_each(LoadHistory::forget);
        let Self { workspace, opposite, bound, .. } = self;
        [workspace, opposite].into_iter().for_each(LoadWorkspace::forget);
        bound.start(BoundStart::New);
    }

    /// Returns true if all interfaces with friction slide.
    pub(super) fn has_only_sliding_friction(&self) -> bool {
        self.acting.iter().all(|acting| {
            let Resistance { coefficient, constant } = acting.resistance;
            acting.parts[0] == 1.0 || (coefficient == 0.0 && constant == 0.0)
        })
    }

    /// Computes the wrenches of all joints with the friction of the last [`Self::settle`].
    pub(super) fn joint_wrenches(&mut self) -> &[Wrench<f64>] {
        self.start.clone_from(&self.wrenches);
        pack(&self.frictions, &mut self.packed);
        self.responses.add_to(&mut self.start, &self.packed);
        &self.start
    }

    /// Returns the effort of an actuator with the friction of the last [`Self::settle`], N or N m.
    pub(super) fn effort(&self, actuator: usize) -> f64 {
        let each = self.frictions.iter().enumerate();
        let change = each.map(|(k, friction)| self.responses.effort(k, actuator) * friction);
        self.efforts[actuator] + change.sum::<f64>()
    }

    /// Returns the index range of the friction components of an interface.
    pub(super) fn components(&self, interface: usize) -> core::ops::Range<usize> {
        self.responses.components(interface)
    }
}
