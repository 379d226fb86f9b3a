//! Initial guess of the stick-slip modes, based on an approximate solution of the friction laws of
//! all interfaces at rest.
//!
//! Interfaces that accelerate in this solution slide; the others stick. [`super::verify`] checks
//! the guess by exact solutions. Sliding friction may be less than static friction, so the problem
//! is solved again with the sliding friction of the interfaces that slide.

use crate::forward::Forward;
use crate::forward::affine_friction::{InterfaceMode, mode_of, norm};
use crate::forward::complementarity::Members;
use crate::forward::data::{Data, KnownForces};
use crate::friction_problem::complementarity::{DryFriction, MemberLaw};

/// Fraction of the largest acceleration below which the relative acceleration of the surfaces
/// counts as round-off.
const ROUND_OFF: f64 = 1e-9;
/// Friction counts as being at its limit if it differs from the limit by less than this fraction.
const AT_LIMIT: f64 = 1e-7;
/// Largest number of times that the problem is solved again with updated sliding friction.
const PASSES: usize = 8;

/// Modes, frictions and normal loads that satisfy the friction laws approximately.
pub(super) struct Guess {
    pub(super) modes: Vec<InterfaceMode>,
    /// Frictions of the interfaces at rest, and the reactions.
    pub(super) forces: KnownForces,
    /// Normal load of each interface, N.
    pub(super) loads: Vec<f64>,
    /// True if any interface begins to slide.
    pub(super) moves: bool,
    /// True if the friction of any sticking interface is at its limit.
    pub(super) tight: bool,
}

impl Forward {
    /// Guesses the modes and frictions of the interfaces at rest. `bound` is the largest allowed
    /// static friction as a multiple of its limit. Returns `None` if the complementarity solver
    /// finds no solution.
    pub(super) fn guess(
        &self,
        data: &Data,
        modes: &[InterfaceMode],
        resting: &[usize],
        bound: f64,
    ) -> Option<Guess> {
        let (parameters, bodies) = (&self.parameters, &data.bodies);
        let mut free = modes.to_vec();
        for &interface in resting {
            free[interface] = InterfaceMode::AtLimit([0.0; 3]);
        }
        let balance = self.balance(data, &free).ok()?;
        let mut members = Members::new(self, data, &balance);
        for &interface in resting {
            let laws = parameters.interfaces[interface].laws();
            let [forward, backward] = laws.map(|law| bound * law.at_rest());
            let law = MemberLaw::Dry(DryFriction { forward, backward, viscous: 0.0 });
            members.add(interface, law, self.unit_frictions(bodies, interface));
        }
        let mut constant: Vec<_> = self.actuator_wrenches(data).collect();
        for (interface, mode) in free.iter().enumerate() {
            let content = &parameters.interfaces[interface];
            let wrench =
                |part: [f64; 3]| bodies.wrench_of(&self.topology, content, part.map(|x| -x));
            let friction = self.friction(data, interface, *mode);
            if friction.constant != [0.0; 3] {
                let own = wrench(friction.constant);
                constant.push((content.joint, own));
                members.include(interface, own);
            }
            if friction.per_load != [0.0; 3] && !resting.contains(&interface) {
                let law = MemberLaw::Sliding(friction.own);
                members.add(interface, law, [wrench(friction.per_load)]);
            }
        }
        let base = balance.respond(self, data, &constant, true);
        let accelerated = self.accelerated(bodies, &base.accelerations);
        let surface = |interface: usize| self.surface_acceleration(&accelerated, interface);
        let prescribed: Vec<f64> = data.targets.iter().map(|t| t.acceleration).collect();
        let mut problem = members.problem(&base, 1.0, surface, &prescribed);
        let largest = resting.iter().flat_map(|&c| surface(c)).fold(0.0_f64, |m, a| m.max(a.abs()));
        // Without mobility all rates are round-off.
        let can_move = balance.mobility(self.topology.dofs()) > 0;
        let rounding = if can_move { ROUND_OFF * largest } else { f64::INFINITY };
        let mut found = problem.solve(&vec![0.0; members.units.len()])?;
        for _ in 0..PASSES {
            // An interface that slides keeps sliding: its friction is reduced and never increases
            // again.
            let mut lowered = false;
            for member in &mut problem.members {
                let mode = mode_of(&found.rates[member.places.clone()], rounding);
                let MemberLaw::Dry(law) = &mut member.law else { continue };
                if mode == InterfaceMode::Sticks {
                    continue;
                }
                let laws = parameters.interfaces[member.interface].laws();
                let [forward, backward] = laws.map(|law| law.sliding(0.0).coefficient);
                lowered |= law.forward > forward || law.backward > backward;
                law.forward = law.forward.min(forward);
                law.backward = law.backward.min(backward);
            }
            if !lowered {
                break;
            }
            found = problem.solve(&found.amounts)?;
        }
        let mut response = base;
        for (unit, amount) in members.units.iter().zip(&found.amounts) {
            response.add(unit, *amount);
        }
        let frictions = vec![[0.0; 3]; modes.len()];
        let mut guess = Guess {
            modes: modes.to_vec(),
            forces: self.known_forces(frictions, bodies, &response.wrenches),
            loads: vec![0.0; modes.len()],
            moves: false,
            tight: false,
        };
        for (member, load) in problem.members.iter().zip(&found.loads) {
            guess.loads[member.interface] = *load;
            let MemberLaw::Dry(law) = member.law else { continue };
            let places = member.places.clone();
            let mut friction = [0.0; 3];
            friction[..places.len()].copy_from_slice(&found.amounts[places.clone()]);
            let mode = mode_of(&found.rates[places], rounding);
            if mode == InterfaceMode::Sticks {
                let limit = load * law.coefficient(friction[0]);
                guess.tight |= norm(friction) > limit * (1.0 - AT_LIMIT);
            } else {
                guess.moves = true;
            }
            guess.forces.frictions[member.interface] = friction;
            guess.modes[member.interface] = mode;
        }
        Some(guess)
    }
}
