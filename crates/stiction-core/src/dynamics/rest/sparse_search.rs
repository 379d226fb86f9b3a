//! Search for the extreme efforts as in `rest::search`, for mechanisms with many interfaces.
//!
//! Only the interfaces whose friction can change an effort take part in the search for its extreme
//! values, and the equations of their normal loads are solved in block triangular form. The time
//! therefore grows with the number of nonzero responses.
//!
//! Equation (R1) of the book's theory.

use super::bounds::{Extreme, Goal, StaticFriction};
use super::couplings::Couplings;
use super::search::{StaticProblem, acting_with, extreme_of};
use crate::dynamics::balance::{Four, WIDTH};
use crate::dynamics::coupling::{Acting, FrictionCoupling};
use crate::dynamics::inverse::Inverse;
use crate::dynamics::responses::{Influences, Responses};
use crate::dynamics::settings::Settings;
use crate::friction::OwnFriction;
use crate::friction_problem::normal_load::Configuration;
use crate::friction_problem::triangular_loads::{LoadEquations, TriangularLoads};
use crate::scalar::Scalar;
use crate::spatial::{Twist, Vec3, Wrench};
use crate::topology::Topology;
use core::ops::Range;

/// Search for extreme efforts over the static friction forces of the interfaces at rest.
pub(super) struct SparseSearch<'a> {
    inverse: &'a Inverse<f64>,
    topology: &'a Topology,
    settings: &'a Settings,
    /// Group of each interface in [`Couplings::groups`].
    group_of: Vec<usize>,
    friction: RegionFriction<'a>,
    loads: TriangularLoads,
    /// Place of the first friction component of each interface that takes part among those of all
    /// of them.
    starts: Vec<usize>,
    /// Interfaces whose normal loads are unknowns, group by group.
    unknowns: Vec<usize>,
    /// Number of unknowns up to the end of each group.
    ends: Vec<usize>,
    /// Largest normal load of all interfaces without friction, N: loads that are much smaller are
    /// round-off.
    largest_load: f64,
    /// Derivatives of the effort with respect to the normal loads.
    weights: Vec<f64>,
    /// Change of the effort through the normal loads, per newton of each component.
    powers: Vec<Four>,
}

/// Friction of the interfaces that take part, and the wrenches that it causes.
struct RegionFriction<'a> {
    at: Configuration<'a>,
    responses: &'a Responses,
    influences: &'a Influences,
    /// Joint wrenches and efforts without friction.
    frictionless: (&'a [Wrench<f64>], &'a [f64]),
    /// Interfaces that take part, in ascending order.
    interfaces: Vec<usize>,
    /// Friction that acts at each interface of the mechanism.
    acting: Vec<Acting>,
    /// Friction force of each component, N, in blocks of four; zero outside the region.
    amounts: Vec<Four>,
    /// Index of each interface in the unknowns; `usize::MAX` if its load is not an unknown.
    places: Vec<usize>,
}

impl RegionFriction<'_> {
    /// Sets the friction forces of an interface for the normal load `load`, N.
    fn set(&mut self, interface: usize, load: f64) {
        let Acting { resistance, parts, .. } = self.acting[interface];
        let force = resistance.force(load);
        for (k, part) in self.responses.components(interface).zip(parts) {
            self.amounts[k / WIDTH].0[k % WIDTH] = part * force;
        }
    }

    /// Computes the wrench at the joint of an interface.
    fn wrench(&self, interface: usize) -> Wrench<f64> {
        let joint = self.at.joint(interface);
        let mut change = Wrench::<Four>::zero();
        for &block in self.influences.at(interface) {
            change += *self.responses.block(block, joint) * self.amounts[block];
        }
        let sum = |x: Four| (x.0[0] + x.0[1]) + (x.0[2] + x.0[3]);
        let [force, moment] =
            [change.force, change.moment].map(|v| Vec3::new(sum(v.x), sum(v.y), sum(v.z)));
        self.frictionless.0[joint] + Wrench { force, moment }
    }

    /// Computes an effort, N or N m.
    fn effort(&self, actuator: usize) -> f64 {
        let components = self.interfaces.iter().flat_map(|&own| self.responses.components(own));
        let change = components
            .map(|k| self.responses.effort(k, actuator) * self.amounts[k / WIDTH].0[k % WIDTH]);
        self.frictionless.1[actuator] + change.sum::<f64>()
    }
}

/// Equations of the normal loads of the interfaces in `unknowns`.
struct Equations<'a, 'b> {
    friction: &'b mut RegionFriction<'a>,
    unknowns: &'b [usize],
}

impl LoadEquations for Equations<'_, '_> {
    fn set_loads(&mut self, loads: &[f64]) {
        for (&interface, load) in self.unknowns.iter().zip(loads) {
            self.friction.set(interface, *load);
        }
    }

    fn load(&self, unknown: usize) -> (f64, Twist<f64>) {
        let interface = self.unknowns[unknown];
        let Acting { resistance, sense, .. } = self.friction.acting[interface];
        let (coefficient, constant) = (resistance.coefficient, resistance.constant);
        let own = OwnFriction { coefficient, constant, direction: sense };
        let wrench = self.friction.wrench(interface);
        let load = self.friction.at.normal_load(interface, wrench, own);
        (load.value, load.gradient)
    }

    fn slopes(&self, unknown: usize, gradient: Twist<f64>, mut put: impl FnMut(usize, f64)) {
        let RegionFriction { at, responses, influences, acting, places, .. } = &*self.friction;
        let joint = at.joint(self.unknowns[unknown]);
        for &block in influences.at(self.unknowns[unknown]) {
            let powers = gradient.lift::<Four>().power(*responses.block(block, joint));
            for (lane, power) in powers.0.into_iter().enumerate() {
                let component = WIDTH * block + lane;
                if component >= responses.len() {
                    break;
                }
                let interface = responses.interface(component);
                let place = places[interface];
                if place != usize::MAX {
                    let first = responses.components(interface).start;
                    let Acting { resistance, parts, .. } = acting[interface];
                    put(place, power * parts[component - first] * resistance.coefficient);
                }
            }
        }
    }
}

impl<'a> SparseSearch<'a> {
    /// Prepares a search at the configuration for which `coupling` contains responses with joint
    /// wrenches. `influences` and `couplings` must belong to these responses.
    pub(super) fn new(
        coupling: &'a FrictionCoupling,
        (inverse, topology): (&'a Inverse<f64>, &'a Topology),
        at: Configuration<'a>,
        settings: &'a Settings,
        (influences, couplings): (&'a Influences, &'a Couplings),
    ) -> Self {
        let responses = coupling.known_responses();
        let states = inverse.interfaces();
        let blocks = vec![Four::zero(); responses.len().div_ceil(WIDTH)];
        let mut group_of = vec![0; states.len()];
        for (group, members) in couplings.groups().iter().enumerate() {
            members.iter().for_each(|member| group_of[*member] = group);
        }
        let friction = RegionFriction {
            at,
            responses,
            influences,
            frictionless: coupling.frictionless(),
            interfaces: Vec::new(),
            acting: states.iter().map(|state| Acting::of(state, [0.0; 3])).collect(),
            amounts: blocks.clone(),
            places: vec![usize::MAX; states.len()],
        };
        let loads = (0..states.len()).map(|interface| {
            let wrench = friction.wrench(interface);
            at.normal_load(interface, wrench, OwnFriction::none()).value
        });
        let largest_load = loads.fold(0.0, f64::max);
        Self {
            inverse,
            topology,
            settings,
            group_of,
            largest_load,
            friction,
            loads: TriangularLoads::default(),
            starts: Vec::new(),
            unknowns: Vec::new(),
            ends: Vec::new(),
            weights: Vec::new(),
            powers: blocks,
        }
    }

    /// Finds the largest and the smallest value of an effort that static friction can cause, one for
    /// each of the two goals. `region` lists the interfaces whose friction can change the effort, in
    /// ascending order, and `released` those at rest, with zero static friction. `None` if Newton's
    /// method fails.
    pub(super) fn extremes(
        &mut self,
        goals: [Goal; 2],
        region: &[usize],
        released: &[StaticFriction],
    ) -> Option<[Extreme; 2]> {
        self.friction.interfaces.clear();
        self.friction.interfaces.extend_from_slice(region);
        self.starts.clear();
        self.starts.extend(region.iter().scan(0, |next, &interface| {
            let first = *next;
            *next += self.friction.responses.components(interface).len();
            Some(first)
        }));
        let own = |interface: &usize| {
            let place = released.binary_search_by_key(interface, |friction| friction.interface);
            place.ok().map(|place| released[place])
        };
        let released: Vec<StaticFriction> = region.iter().filter_map(own).collect();
        self.settle(&released, true)?;
        let mut slopes = Vec::new();
        self.slopes(goals[0].actuator, &mut slopes)?;
        let [greatest, least] = goals.map(|goal| extreme_of(self, goal, &released, &slopes));
        let found = [greatest?, least?];
        // The friction of one region must not act in another one.
        for &interface in region {
            for k in self.friction.responses.components(interface) {
                self.friction.amounts[k / WIDTH].0[k % WIDTH] = 0.0;
            }
            self.friction.places[interface] = usize::MAX;
        }
        Some(found)
    }

    /// Sets the unknown normal loads to those without the friction that depends on them.
    fn start_uncoupled(&mut self) {
        let Self { friction, unknowns, loads, .. } = self;
        unknowns.iter().for_each(|interface| friction.set(*interface, 0.0));
        loads.start(unknowns.iter().map(|&interface| {
            let Acting { resistance, sense, .. } = friction.acting[interface];
            let (coefficient, constant) = (0.0, resistance.constant);
            let own = OwnFriction { coefficient, constant, direction: sense };
            friction.at.normal_load(interface, friction.wrench(interface), own).value
        }));
    }
}

impl StaticProblem for SparseSearch<'_> {
    fn settle(&mut self, frictions: &[StaticFriction], is_new: bool) -> Option<()> {
        let Self { inverse, topology, settings, friction, unknowns, ends, largest_load, .. } = self;
        let largest_load = *largest_load;
        let mut next = frictions.iter().peekable();
        for k in 0..friction.interfaces.len() {
            let interface = friction.interfaces[k];
            let held = next.next_if(|friction| friction.interface == interface);
            let held = held.map(|friction| friction.direction);
            let known = (*inverse, *topology, friction.at, *settings);
            friction.acting[interface] = acting_with(known, interface, held);
            friction.places[interface] = usize::MAX;
            friction.set(interface, 0.0);
        }
        unknowns.clear();
        let is_coupled = |interface: &usize| friction.acting[*interface].is_coupled();
        unknowns.extend(friction.interfaces.iter().copied().filter(is_coupled));
        unknowns.sort_by_key(|interface| self.group_of[*interface]);
        ends.clear();
        for (place, interface) in unknowns.iter().enumerate() {
            friction.places[*interface] = place;
            let group = self.group_of[*interface];
            let is_last = unknowns.get(place + 1).is_none_or(|next| self.group_of[*next] != group);
            ends.extend(is_last.then_some(place + 1));
        }
        let mut equations = Equations { friction, unknowns };
        let is_cold = is_new || !self.loads.fits(equations.unknowns.len());
        if is_cold {
            self.start_uncoupled();
            equations = Equations { friction: &mut self.friction, unknowns: &self.unknowns };
        }
        if self.loads.solve(&mut equations, &self.ends, largest_load) {
            return Some(());
        }
        if is_cold {
            return None;
        }
        self.start_uncoupled();
        let mut equations = Equations { friction: &mut self.friction, unknowns: &self.unknowns };
        self.loads.solve(&mut equations, &self.ends, largest_load).then_some(())
    }

    fn slopes(&mut self, actuator: usize, slopes: &mut Vec<f64>) -> Option<()> {
        let Self { friction, unknowns, ends, loads, weights, powers, .. } = self;
        weights.clear();
        weights.extend(unknowns.iter().map(|&interface| {
            let Acting { resistance, parts, .. } = friction.acting[interface];
            let components = friction.responses.components(interface).zip(parts);
            let sum = components.map(|(k, part)| friction.responses.effort(k, actuator) * part);
            sum.sum::<f64>() * resistance.coefficient
        }));
        loads.adjoint(&mut Equations { friction, unknowns }, ends, weights)?;
        for &interface in &friction.interfaces {
            for k in friction.responses.components(interface) {
                powers[k / WIDTH] = Four::zero();
            }
        }
        for ((&interface, gradient), weight) in
            unknowns.iter().zip(loads.gradients()).zip(&*weights)
        {
            let (joint, gain) = (friction.at.joint(interface), *gradient * *weight);
            for &block in friction.influences.at(interface) {
                powers[block] += gain.lift::<Four>().power(*friction.responses.block(block, joint));
            }
        }
        slopes.clear();
        for &interface in &friction.interfaces {
            let own = OwnFriction::none();
            let load = friction.at.normal_load(interface, friction.wrench(interface), own).value;
            let limit = friction.acting[interface].resistance.force(load);
            slopes.extend(friction.responses.components(interface).map(|k| {
                let change = powers[k / WIDTH].0[k % WIDTH];
                (friction.responses.effort(k, actuator) + change) * limit
            }));
        }
        Some(())
    }

    fn components(&self, interface: usize) -> Range<usize> {
        let place = self.friction.interfaces.partition_point(|other| *other < interface);
        let first = self.starts[place];
        first..first + self.friction.responses.components(interface).len()
    }

    fn effort(&self, actuator: usize) -> f64 {
        self.friction.effort(actuator)
    }
}
