//! A first choice of what sticks: frictions of all contacts at rest that satisfy the laws at once.
//!
//! See [`super::cone`]. What still accelerates then slides, what does not sticks. It is a guess for
//! [`super::stick`], which decides by exact solutions. What begins to slide has the friction of sliding, which
//! may be less: then the frictions are found again.

use super::Forward;
use super::affine_friction::{InterfaceMode, norm};
use super::balance::{Balance, Response};
use super::complementarity::{Cone, Dry, Kind, Member, mode_of};
use super::constraint_jacobian::Rows;
use super::situation::Situation;

/// Accelerations below this part are none.
const NONE: f64 = 1e-9;
/// Friction this close to its limit has no room.
const NO_ROOM: f64 = 1e-7;
/// The friction of sliding is put in so often at most.
const PASSES: usize = 8;

/// What was guessed.
pub(super) struct Guess {
    pub(super) modes: Vec<InterfaceMode>,
    /// Friction at the surface of each contact at rest, N.
    pub(super) shares: Vec<[f64; 3]>,
    /// Of each contact, N.
    pub(super) loads: Vec<f64>,
    /// Whether something begins to slide.
    pub(super) moves: bool,
    /// Whether something that sticks is at its limit.
    pub(super) tight: bool,
}

impl Forward {
    /// Modes and frictions of the contacts at rest, if none may bear more than this part of its limit; none
    /// where nothing is found.
    pub(super) fn guess(
        &self,
        situation: &Situation,
        modes: &[InterfaceMode],
        resting: &[usize],
        bound: f64,
    ) -> Option<Guess> {
        let (parameters, bodies) = (&self.parameters, &situation.bodies);
        let mut free = modes.to_vec();
        for &interface in resting {
            free[interface] = InterfaceMode::AtLimit([0.0; 3]);
        }
        let scene = self.scene(situation);
        let (held, _) = self.held(&situation.targets, &free, &situation.grips, &situation.shares);
        let rows = Rows::new(&self.topology, parameters, bodies, &held);
        let balance = Balance::new(&scene, rows).ok()?;
        let (affine_frictions, mut known) = self.acting(situation, &free);
        let mut members = Vec::new();
        let mut units: Vec<Response> = Vec::new();
        for &interface in resting {
            let content = &parameters.interfaces[interface];
            let [forward, backward] = content.laws().map(|law| bound * law.at_rest());
            let kind = Kind::Dry(Dry { forward, backward, viscous: 0.0 });
            let first = units.len();
            for wrench in self.unit_frictions(bodies, interface) {
                units.push(balance.respond(&scene, &[(content.joint, wrench)], false));
            }
            members.push(Member { interface, places: first..units.len(), kind });
        }
        for (interface, rub) in affine_frictions.iter().enumerate() {
            let content = &parameters.interfaces[interface];
            let against = |part: [f64; 3]| {
                let wrench = bodies.wrench_of(&self.topology, content, part.map(|x| -x));
                (content.joint, wrench)
            };
            if rub.known != [0.0; 3] {
                known.push(against(rub.known));
            }
            if rub.per_load != [0.0; 3] && !resting.contains(&interface) {
                let first = units.len();
                units.push(balance.respond(&scene, &[against(rub.per_load)], false));
                let kind = Kind::Slides(rub.own);
                members.push(Member { interface, places: first..first + 1, kind });
            }
        }
        let base = balance.respond(&scene, &known, true);
        let count = units.len();
        let (mut begins, mut change) = (vec![0.0; count], vec![0.0; count * count]);
        let beginning = self.accelerated(bodies, &base.accelerations);
        for member in members.iter().filter(|m| !matches!(m.kind, Kind::Slides(_))) {
            let own = self.surface_acceleration(&beginning, member.interface);
            for (place, i) in member.places.clone().enumerate() {
                begins[i] = own[place];
                for (j, unit) in units.iter().enumerate() {
                    change[i * count + j] =
                        self.surface_rate(bodies, &unit.accelerations, member.interface, place);
                }
            }
        }
        let free_size = begins.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
        // Where nothing can move all rates are rounding.
        let can_move = balance.mobility(self.topology.dofs()) > 0;
        let none = if can_move { NONE * free_size } else { f64::INFINITY };
        let mut cone = Cone::new(parameters, bodies, members, begins, change, (&base, &units));
        let mut found = cone.solve(&vec![0.0; count], 1.0)?;
        for _ in 0..PASSES {
            // Once it slides it slides for good: its friction is no more than it was.
            let mut more = false;
            for member in &mut cone.members {
                let rate = mode_of(&found.rates[member.places.clone()], none);
                let Kind::Dry(Dry { forward, backward, .. }) = &mut member.kind else { continue };
                if rate == InterfaceMode::Sticks {
                    continue;
                }
                let content = &parameters.interfaces[member.interface];
                let [ahead, behind] = content.laws().map(|law| law.sliding(0.0).coefficient);
                more |= *forward > ahead || *backward > behind;
                (*forward, *backward) = (forward.min(ahead), backward.min(behind));
            }
            if !more {
                break;
            }
            found = cone.solve(&found.amounts, 1.0)?;
        }
        let mut guess = modes.to_vec();
        let mut shares = vec![[0.0; 3]; modes.len()];
        let mut loads = vec![0.0; modes.len()];
        let (mut moves, mut tight) = (false, false);
        for (member, load) in cone.members.iter().zip(&found.loads) {
            loads[member.interface] = *load;
            let Kind::Dry(law) = member.kind else { continue };
            let places = member.places.clone();
            let mut has = [0.0; 3];
            has[..places.len()].copy_from_slice(&found.amounts[places.clone()]);
            let mode = mode_of(&found.rates[places], none);
            if mode == InterfaceMode::Sticks {
                let most = load * law.coefficient(has[0]);
                tight |= norm(has) > most * (1.0 - NO_ROOM);
            } else {
                moves = true;
            }
            shares[member.interface] = has;
            guess[member.interface] = mode;
        }
        Some(Guess { modes: guess, shares, loads, moves, tight })
    }
}
