//! Coupling of friction and normal loads, computed from the effects of unit friction forces: a
//! bound on the coupling, and friction forces that are consistent with the normal loads they cause.
//!
//! Equations (F6), (F7) and (D3) of the book's theory.

use super::balance::{Four, UnitFriction, UnitResponses, WIDTH};
use super::interfaces::InterfaceState;
use super::inverse::Inverse;
use super::load_history::LoadHistory;
use super::model::Model;
use super::responses::Responses;
use crate::friction::{OwnFriction, Resistance};
use crate::friction_problem::influence::Influence;
use crate::friction_problem::load_problem::{LoadProblem, LoadWorkspace};
use crate::friction_problem::newton::{Accepted, UNBOUNDED, largest};
use crate::friction_problem::normal_load::Configuration;
use crate::friction_problem::small_system::pack;
use crate::friction_problem::uniqueness::{self, BoundStart, BoundWorkspace};
use crate::kinematics::{Bodies, Results};
use crate::parameters::{InterfaceParameters, Parameters};
use crate::spatial::{Twist, Wrench};

/// Largest number of interfaces for which the effects of all unit friction forces are stored and
/// the normal loads are computed as a dense problem. The cost grows with the cube of the number of
/// interfaces.
const DENSE: usize = 64;

/// Largest error of extrapolated normal loads, relative to the largest load, that is accepted
/// without a Newton step.
const ERROR: f64 = 1e-13;

/// Friction that acts at one interface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Acting {
    pub(super) resistance: Resistance<f64>,
    pub(super) sense: f64,
    /// Components of the friction along the DOFs of an interface at rest, as fractions of the
    /// friction force. The first component is 1 for a sliding interface, and -1 for one in the
    /// opposite motion.
    pub(super) parts: [f64; 3],
}

impl Acting {
    /// Creates the kinetic friction of a sliding interface or, for an interface at rest, the static
    /// friction with the components `held` (fractions of the friction limit).
    pub(super) fn of(state: &InterfaceState<f64>, held: [f64; 3]) -> Self {
        let slides = state.sliding > 0.0;
        let parts = if slides { [1.0, 0.0, 0.0] } else { held };
        Self { resistance: state.resistance, sense: state.sense, parts }
    }

    /// Creates the friction that acts at an interface in the opposite motion. An interface at rest
    /// has no friction.
    fn reversed(state: &InterfaceState<f64>, interface: &InterfaceParameters<f64>) -> Self {
        let reversed = state.reversed(interface);
        let parts = if state.sliding > 0.0 { [-1.0, 0.0, 0.0] } else { [0.0; 3] };
        Self { resistance: reversed.resistance, sense: reversed.sense, parts }
    }

    pub(super) fn is_coupled(&self) -> bool {
        self.resistance.coefficient > 0.0 && self.parts != [0.0; 3]
    }
}

/// Normal loads from which Newton's method starts.
#[derive(Clone, Copy, Debug)]
pub(super) enum Start<'a> {
    /// Normal loads of the solution without friction.
    Uncoupled,
    /// Normal loads of the last solution if it has the same number of coupled interfaces, otherwise
    /// frictionless normal loads.
    Last,
    /// Normal loads extrapolated from previous configurations of the present motion.
    Expected,
    /// Normal loads extrapolated from previous configurations of the opposite motion. Without such
    /// configurations, Newton's method starts from reflected normal loads: the frictionless load
    /// plus its difference from the load in the given states, which belong to the present motion.
    Opposite(&'a [InterfaceState<f64>]),
}

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

/// Change of the joint wrenches per newton of normal load at each coupled interface, due to
/// friction. It is computed from stored responses.
struct StoredInfluence<'a> {
    responses: &'a Responses,
    acting: &'a [Acting],
    unknowns: &'a [usize],
    parameters: &'a Parameters<f64>,
}

impl Influence for StoredInfluence<'_> {
    fn visit(&mut self, mut put: impl FnMut(usize, usize, Wrench<f64>)) {
        let Self { responses, acting, unknowns, parameters } = self;
        for (column, &from) in unknowns.iter().enumerate() {
            let Acting { resistance, parts, .. } = acting[from];
            for (row, &to) in unknowns.iter().enumerate() {
                let joint = parameters.interfaces[to].joint;
                let mut sum = Wrench::zero();
                for (component, part) in responses.components(from).zip(parts) {
                    sum += responses.wrench(component, joint) * (part * resistance.coefficient);
                }
                put(row, column, sum);
            }
        }
    }
}

/// Change of the joint wrenches per newton of normal load at each sliding interface, due to
/// friction. It is evaluated while the responses are computed, so that the responses need not be
/// stored.
struct ComputedInfluence<'a> {
    responses: &'a mut Responses,
    inverse: &'a Inverse<f64>,
    model: &'a Model,
    at: Configuration<'a>,
    unknowns: &'a [usize],
}

impl Influence for ComputedInfluence<'_> {
    fn visit(&mut self, mut put: impl FnMut(usize, usize, Wrench<f64>)) {
        let Self { responses, inverse, model, at, unknowns } = self;
        let Configuration { parameters, bodies } = *at;
        // Components and unknowns are in the order of the interfaces.
        let mut column = 0;
        responses.update(inverse, model, parameters, bodies, false, |_, units, responses| {
            for (lane, unit) in units.iter().enumerate() {
                if unknowns.get(column) != Some(&unit.interface) {
                    continue;
                }
                let coefficient = inverse.interfaces()[unit.interface].resistance.coefficient;
                for (row, &to) in unknowns.iter().enumerate() {
                    let wrench = responses.wrenches[at.joint(to)].lane(lane);
                    put(row, column, wrench * coefficient);
                }
                column += 1;
            }
        });
    }
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

    /// Reverses the friction set by [`Self::act`]. `acting` is the friction in the opposite motion,
    /// which must have the same magnitudes.
    fn reverse(&mut self, acting: impl Iterator<Item = Acting>, at: Configuration<'_>) {
        self.acting.clear();
        self.acting.extend(acting);
        self.constant_changes.iter_mut().for_each(|change| *change = -*change);
        self.add_unknowns(at);
        self.problem.reverse_influence();
        self.is_present = false;
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

    /// Computes the normal loads that are consistent with the friction set by [`Self::act`], by
    /// Newton's method from `start`. Returns false if the method does not converge.
    pub(super) fn settle(&mut self, at: Configuration<'_>, start: Start<'_>) -> bool {
        let found = match start {
            Start::Last if self.loads.len() == self.unknowns.len() => {
                self.newton(at, 0.0) || self.newton_from_uncoupled(at, None)
            }
            Start::Expected => {
                self.newton_from_expected(at, 0) || self.newton_from_uncoupled(at, None)
            }
            Start::Opposite(states) => {
                self.newton_from_expected(at, 1) || self.newton_from_uncoupled(at, Some(states))
            }
            Start::Last | Start::Uncoupled => self.newton_from_uncoupled(at, None),
        };
        if !found {
            return false;
        }
        let history = match start {
            Start::Expected => Some(0),
            Start::Opposite(_) => Some(1),
            Start::Last | Start::Uncoupled => None,
        };
        if let Some(history) = history.filter(|_| self.keeps_history) {
            self.history[history].add(&self.unknowns, &self.loads);
        }
        self.frictions.clear();
        self.frictions.resize(self.responses.len(), 0.0);
        let mut loads = self.unknowns.iter().zip(&self.loads).peekable();
        for (interface, acting) in self.acting.iter().enumerate() {
            let load = loads.next_if(|(unknown, _)| **unknown == interface);
            let force = acting.resistance.force(load.map_or(0.0, |(_, load)| *load));
            for (component, part) in self.responses.components(interface).zip(acting.parts) {
                self.frictions[component] = part * force;
            }
        }
        true
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

    /// Runs Newton's method from the normal loads extrapolated from previous configurations.
    /// `history` is 0 for those of the present motion, and 1 for those of the opposite motion.
    fn newton_from_expected(&mut self, at: Configuration<'_>, history: usize) -> bool {
        let Self { history: all, unknowns, loads, strength, .. } = self;
        // The fixed-point map contracts by the factor `strength`, so this residual bounds the error
        // by `ERROR`.
        let residual = ERROR * (1.0 - *strength);
        all[history].predict(unknowns, loads) && self.newton(at, residual)
    }

    /// Solves for the present motion after [`Self::begin`], which must have returned a coupling
    /// bound below one. The results are [`Self::present_wrench`] and [`Self::present_loads`].
    /// Returns false if Newton's method fails, or if there are too many interfaces for a dense
    /// problem.
    pub(super) fn solve_present(&mut self, at: Configuration<'_>) -> bool {
        let settled = self.is_stored && self.settle(at, Start::Expected);
        if settled {
            pack(&self.frictions, &mut self.packed);
        }
        settled
    }

    /// Returns the wrench of a joint with the friction of the last [`Self::solve_present`].
    pub(super) fn present_wrench(&self, joint: usize) -> Wrench<f64> {
        let mut wrench = self.wrenches[joint];
        self.responses.add_at(joint, &mut wrench, &self.packed);
        wrench
    }

    /// Iterates over the interfaces whose friction depends on the normal load, as pairs of index
    /// and normal load, N.
    pub(super) fn present_loads(&self) -> impl Iterator<Item = (usize, f64)> {
        self.unknowns.iter().copied().zip(self.loads.iter().copied())
    }

    /// Returns true if all interfaces with friction slide.
    pub(super) fn has_only_sliding_friction(&self) -> bool {
        self.acting.iter().all(|acting| {
            let Resistance { coefficient, constant } = acting.resistance;
            acting.parts[0] == 1.0 || (coefficient == 0.0 && constant == 0.0)
        })
    }

    /// Runs Newton's method from the frictionless normal loads. If `opposite` is given, starts from
    /// the normal loads of `opposite`, reflected about the frictionless normal loads.
    fn newton_from_uncoupled(
        &mut self,
        at: Configuration<'_>,
        opposite: Option<&[InterfaceState<f64>]>,
    ) -> bool {
        let Self { problem, loads, unknowns, .. } = self;
        problem.uncoupled_loads(at, loads);
        if let Some(opposite) = opposite {
            for (load, &interface) in loads.iter_mut().zip(&*unknowns) {
                *load = (2.0 * *load - opposite[interface].load()).max(0.0);
            }
        }
        self.newton(at, 0.0)
    }

    /// Runs Newton's method from the normal loads in `loads`. `residual` is [`Accepted::residual`].
    fn newton(&mut self, at: Configuration<'_>, residual: f64) -> bool {
        let Self { problem, loads, workspace, .. } = self;
        let most = UNBOUNDED * largest(loads).max(f64::MIN_POSITIVE);
        problem.solve_from(at, loads, Accepted { most, residual }, workspace)
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

    /// Computes the efforts in the opposite motion, N or N m, at the configuration, accelerations
    /// and loads of the present motion. `None` if the efforts may not be unique, if Newton's method
    /// fails, or if no responses are stored.
    pub(super) fn reversed_efforts(
        &mut self,
        states: &[InterfaceState<f64>],
        at: Configuration<'_>,
    ) -> Option<Vec<f64>> {
        if !(self.is_current && self.is_stored) {
            return None;
        }
        let interfaces = &at.parameters.interfaces;
        let reversed = states.iter().zip(interfaces).map(|(s, i)| Acting::reversed(s, i));
        let is_constant = |interface: &InterfaceParameters<f64>| {
            interface.law.is_constant() && interface.backward.is_none()
        };
        if self.is_present && interfaces.iter().all(is_constant) {
            // All friction coefficients are the same in both directions.
            self.reverse(reversed, at);
        } else {
            self.act(reversed, at);
        }
        // With a separate friction law for backward sliding, the opposite motion has different
        // coefficients.
        let has_other_law = interfaces.iter().any(|interface| interface.backward.is_some());
        if has_other_law {
            self.strength = self.coupling_bound(at, None, Sense::Opposite);
            if self.strength >= 1.0 {
                return None;
            }
        }
        let settled = self.settle(at, Start::Opposite(states));
        let efforts = (0..self.efforts.len()).map(|actuator| self.effort(actuator));
        settled.then(|| efforts.collect())
    }

    /// Computes the derivative of an effort with respect to each component of static friction, in
    /// units of the friction limit, at the solution of [`Self::settle`]. The derivative is zero for
    /// sliding interfaces. `None` if the coupling is singular.
    pub(super) fn slopes(
        &mut self,
        actuator: usize,
        at: Configuration<'_>,
        slopes: &mut Vec<f64>,
    ) -> Option<()> {
        self.joint_wrenches();
        let Self { responses, acting, unknowns, problem, workspace, weights, .. } = self;
        // Change of the effort per newton of each normal load.
        weights.clear();
        weights.extend(unknowns.iter().map(|&interface| {
            let Acting { resistance, parts, .. } = acting[interface];
            let components = responses.components(interface).zip(parts);
            let sum = components.map(|(k, part)| responses.effort(k, actuator) * part);
            sum.sum::<f64>() * resistance.coefficient
        }));
        problem.adjoint(at, &self.loads, weights, &mut self.gradients, workspace)?;
        // Derivative of the effort with respect to the wrench of each joint.
        let gains = &mut self.gains;
        gains.clear();
        gains.resize(self.start.len(), Twist::zero());
        for ((&unknown, gradient), weight) in unknowns.iter().zip(&self.gradients).zip(&*weights) {
            gains[at.joint(unknown)] += *gradient * *weight;
        }
        let powers = &mut self.packed;
        responses.powers(gains, powers);
        slopes.clear();
        for component in 0..responses.len() {
            let interface = responses.interface(component);
            let acting = &acting[interface];
            let wrench = self.start[at.joint(interface)];
            let load = at.normal_load(interface, wrench, OwnFriction::none()).value;
            let change = powers[component / WIDTH].0[component % WIDTH];
            let slope = responses.effort(component, actuator) + change;
            slopes.push(slope * acting.resistance.force(load));
        }
        Some(())
    }

    /// Returns the index range of the friction components of an interface.
    pub(super) fn components(&self, interface: usize) -> core::ops::Range<usize> {
        self.responses.components(interface)
    }
}
