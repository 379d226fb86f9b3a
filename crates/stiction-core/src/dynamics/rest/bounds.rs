//! Effort intervals: bounds of the efforts over all admissible static friction forces of interfaces
//! at rest.
//!
//! Equation (R1) of the book's theory.

use super::map::FrictionMap;
use super::outer::outer_changes;
use super::search::Search;
use super::sparse_search::SparseSearch;
use crate::dynamics::continuation;
use crate::dynamics::coupling::FrictionCoupling;
use crate::dynamics::forces::Forces;
use crate::dynamics::inverse::Inverse;
use crate::dynamics::model::Model;
use crate::dynamics::responses::Influences;
use crate::dynamics::settings::{FrictionMode, Settings};
use crate::friction::InterfaceShape;
use crate::friction_problem::normal_load::Configuration;
use crate::kinematics::Kinematics;
use crate::parameters::Parameters;
use crate::statics::AppliedLoad;

/// Step of the finite differences, as a fraction of the static friction limit: small enough to
/// leave normal forces almost unchanged, and large enough to exceed round-off.
const PROBE: f64 = 1e-3;
/// Largest number of updates of the directions of static friction in the search for an extreme
/// effort.
const ROUNDS: usize = 4;
/// Two directions count as equal if their unit vectors differ by less than this value in each
/// component.
const SAME: f64 = 1e-6;

/// Configuration of a mechanism, with everything needed to solve the balance for different static
/// friction.
pub(in crate::dynamics) struct Position<'a> {
    pub(in crate::dynamics) model: &'a Model,
    pub(in crate::dynamics) parameters: &'a Parameters<f64>,
    pub(in crate::dynamics) kinematics: &'a mut Kinematics<f64>,
    pub(in crate::dynamics) loads: &'a [AppliedLoad<f64>],
    pub(in crate::dynamics) settings: &'a Settings,
}

/// Static friction of one interface at rest, at its limit in the given direction; zero if the
/// direction is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StaticFriction {
    pub(super) interface: usize,
    pub(super) direction: [f64; 3],
    /// True if the direction is prescribed and the search must not change it.
    pub(super) fixed: bool,
}

impl StaticFriction {
    pub(super) fn is_near(&self, other: &Self) -> bool {
        let pairs = self.direction.iter().zip(&other.direction);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < SAME
    }

    /// Returns static friction in the direction of `components`, one per DOF of the interface.
    /// Returns a copy of `self` if the direction is prescribed.
    pub(super) fn towards(&self, components: impl Iterator<Item = f64>) -> Self {
        if self.fixed {
            return *self;
        }
        let mut direction = [0.0; 3];
        direction.iter_mut().zip(components).for_each(|(own, component)| *own = component);
        // An interface with one DOF has only two directions.
        let size = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
        let over = if size > 0.0 { 1.0 / size } else { 0.0 };
        Self { direction: direction.map(|d| d * over), ..*self }
    }
}

/// Computes the interval of each effort over all admissible static friction forces of the
/// interfaces at rest. The efforts in `forces` do not change.
///
/// Static friction is any force up to the limit for the normal force of the same interface, in any
/// direction. For each effort, the friction of every interface at rest is set to its limit in the
/// direction that increases (decreases) the effort most. The coupled problem is solved again, and
/// the directions are updated until they no longer change. The bounds are therefore attained. They
/// are exact if the sign of the change of an effort with each friction force does not depend on the
/// other friction forces, which is the case without strong coupling. A bound is infinite if the
/// forces diverge during this search, for example if friction can lock the mechanism.
pub(in crate::dynamics) fn bound_efforts(
    forces: &mut Forces,
    inverse: &mut Inverse<f64>,
    mut position: Position<'_>,
    coupling: &mut FrictionCoupling,
) {
    forces.close_bounds();
    let resting: Vec<usize> = (0..position.parameters.interfaces.len())
        .filter(|&interface| {
            let state = &inverse.interfaces()[interface];
            // The normal force may be zero only because no other interface has friction yet.
            state.sliding == 0.0 && state.resistance.coefficient > 0.0
        })
        .collect();
    if !inverse.has_friction() || resting.is_empty() {
        return;
    }
    let released: Vec<StaticFriction> = resting
        .iter()
        .map(|&interface| StaticFriction { interface, direction: [0.0; 3], fixed: false })
        .collect();
    let Position { model, parameters, settings, .. } = position;
    let at = Configuration { parameters, bodies: &position.kinematics.bodies };
    coupling.responses(inverse, model, parameters, at.bodies, true);
    let responses = coupling.known_responses();
    let influences = Influences::new(responses, parameters);
    let map = FrictionMap::new(inverse, (responses, &influences), parameters, at.bodies, settings);
    let couplings = map.couplings();
    let changes = outer_changes(&map, &couplings, forces.efforts.len());
    let goals: Vec<Goal> = (0..forces.efforts.len())
        .flat_map(|actuator| [1.0, -1.0].map(|sense| (actuator, sense)))
        .map(|(actuator, sense)| Goal { actuator, sense, before: forces.efforts[actuator] })
        .collect();
    // Outer bounds exist only if the coupling is so weak that the solution is unique for each
    // static friction.
    let is_thread = |friction: &StaticFriction| {
        parameters.interfaces[friction.interface].shape == InterfaceShape::Thread
    };
    let is_weak = changes.is_some()
        && settings.friction == FrictionMode::Converged
        && !released.iter().any(is_thread);
    let topology = model.topology();
    let is_sparse = !FrictionCoupling::stores(parameters.interfaces.len());
    let extremes: Option<Vec<Extreme>> = match (is_weak, is_sparse) {
        (false, _) => None,
        (true, false) => {
            let released = &released;
            let mut search = Search { coupling, inverse, topology, at, settings, released };
            search.extremes(&goals, forces.efforts.len())
        }
        (true, true) => {
            let reach = |goal: Goal| map.reach(&map.slopes(goal.actuator), couplings.influencing());
            let (known, bounds) = ((&*inverse, topology), (&influences, &couplings));
            let mut search = SparseSearch::new(coupling, known, at, settings, bounds);
            let pairs = goals.as_chunks().0.iter();
            let each = pairs.map(|pair| search.extremes(*pair, &reach(pair[0]), &released));
            each.collect::<Option<Vec<_>>>().map(|each| each.into_iter().flatten().collect())
        }
    };
    let extremes = extremes.unwrap_or_else(|| {
        let slopes = probe(inverse, &position, &released);
        let each = goals
            .iter()
            .map(|goal| extreme(inverse, &mut position, &released, &slopes, *goal))
            .collect();
        set_static_frictions(inverse, &released);
        resolve(inverse, &mut position);
        each
    });
    for (goal, found) in goals.iter().zip(extremes) {
        let (low, high) = &mut forces.effort_bounds[goal.actuator];
        (*low, *high) = (low.min(found.least), high.max(found.greatest));
    }
    forces.certify_bounds(changes);
}

/// Smallest and largest value of an effort found during a search.
pub(super) struct Extreme {
    pub(super) least: f64,
    pub(super) greatest: f64,
}

/// Goal of the search: the largest (`sense` 1) or smallest (`sense` -1) value of the effort of an
/// actuator. `before` is the value at the start of the search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Goal {
    pub(super) actuator: usize,
    pub(super) sense: f64,
    pub(super) before: f64,
}

/// Finds the largest (smallest) effort that static friction can cause, starting from the static
/// friction `start`. `slopes` are the effort changes for `start`, as computed by [`probe`].
/// Prescribed directions do not change.
pub(super) fn extreme(
    inverse: &mut Inverse<f64>,
    position: &mut Position<'_>,
    start: &[StaticFriction],
    slopes: &[Vec<Vec<f64>>],
    goal: Goal,
) -> Extreme {
    let Goal { actuator, sense, before } = goal;
    let mut found = Extreme { least: f64::INFINITY, greatest: f64::NEG_INFINITY };
    let mut frictions = start.to_vec();
    for round in 0..ROUNDS {
        let next = if round == 0 {
            steepest(&frictions, slopes, actuator, sense)
        } else {
            steepest(&frictions, &probe(inverse, position, &frictions), actuator, sense)
        };
        if next.iter().zip(&frictions).all(|(next, friction)| next.is_near(friction)) {
            break;
        }
        frictions = next;
        set_static_frictions(inverse, &frictions);
        let settled = resolve(inverse, position);
        let mut drive = inverse.efforts()[actuator];
        if !settled {
            drive = if drive < before { f64::NEG_INFINITY } else { f64::INFINITY };
        }
        found = Extreme { least: found.least.min(drive), greatest: found.greatest.max(drive) };
        if !settled {
            break;
        }
    }
    found
}

pub(super) fn set_static_frictions(inverse: &mut Inverse<f64>, frictions: &[StaticFriction]) {
    for &StaticFriction { interface, direction, .. } in frictions {
        inverse.set_static_friction(interface, direction);
    }
}

/// Solves for all forces with the static friction set in `inverse`. Returns false if the forces
/// diverge; `inverse` then contains the forces at which the continuation ended.
pub(super) fn resolve(inverse: &mut Inverse<f64>, position: &mut Position<'_>) -> bool {
    let Position { model, parameters, kinematics, loads, settings } = position;
    inverse.solve(model, parameters, kinematics, loads, settings);
    if inverse.friction_settled(settings) && inverse.is_balanced(model, parameters) {
        return true;
    }
    let outcome =
        continuation::follow_friction(inverse, model, parameters, kinematics, loads, settings, 1.0);
    if outcome.is_err() {
        inverse.finish_friction(model, parameters, &kinematics.bodies);
    }
    outcome.is_ok()
}

/// Computes the sensitivity of each effort to each component of the static friction of each
/// interface, as `slopes[interface][component][actuator]`. The values are central differences for a
/// change of the component by a fixed fraction of the friction limit, not divided by this change.
pub(super) fn probe(
    inverse: &mut Inverse<f64>,
    position: &Position<'_>,
    frictions: &[StaticFriction],
) -> Vec<Vec<Vec<f64>>> {
    let Position { model, parameters, kinematics, settings, .. } = position;
    let mut slopes = Vec::with_capacity(frictions.len());
    for &StaticFriction { interface, direction, .. } in frictions {
        let dofs = parameters.interfaces[interface].shape.dofs().len();
        let of_component = |component: usize| {
            let [ahead, back] = [PROBE, -PROBE].map(|part| {
                let mut moved = direction;
                moved[component] += part;
                inverse.set_static_friction(interface, moved);
                inverse.update_static_friction(model, parameters, &kinematics.bodies, settings);
                inverse.efforts().to_vec()
            });
            ahead.iter().zip(&back).map(|(ahead, back)| ahead - back).collect()
        };
        slopes.push((0..dofs).map(of_component).collect());
        inverse.set_static_friction(interface, direction);
    }
    inverse.update_static_friction(model, parameters, &kinematics.bodies, settings);
    slopes
}

/// Returns, for each interface, the direction of static friction that increases (`sense` 1) or
/// decreases (`sense` -1) the effort of `actuator` most.
fn steepest(
    frictions: &[StaticFriction],
    slopes: &[Vec<Vec<f64>>],
    actuator: usize,
    sense: f64,
) -> Vec<StaticFriction> {
    let direction_of = |(friction, slopes): (&StaticFriction, &Vec<Vec<f64>>)| {
        friction.towards(slopes.iter().map(|slope| sense * slope[actuator]))
    };
    frictions.iter().zip(slopes).map(direction_of).collect()
}
