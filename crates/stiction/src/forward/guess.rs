//! A first choice of what sticks: frictions within their limits that leave the least acceleration.
//!
//! With the loads as they are, frictions `f` of the contacts at rest that take most from what would
//! accelerate minimise `f^T K f / 2 - a^T f` within their limits, where `a - K f` are the surfaces'
//! accelerations: a convex problem, solved contact by contact (projected Gauss-Seidel), the limits
//! following the loads. What still accelerates then slides, what is within its limit sticks. It is a guess
//! for [`super::stick`], which decides by exact solutions.

use super::Forward;
use super::balance::Response;
use super::evaluate::Ground;
use super::rows::each_freedom;
use super::rub::{Contact, law_of, load, norm, wrench_of};
use crate::friction::OwnFriction;
use crate::spatial::Wrench;

const SWEEPS: usize = 3000;
/// No friction changes by more than this part of the largest.
const SETTLED: f64 = 1e-11;
/// Accelerations and distances to limits below this part are none.
const NONE: f64 = 1e-6;

/// What was guessed.
pub(super) struct Guess {
    pub(super) modes: Vec<Contact>,
    /// Friction at the surface of each contact at rest, N.
    pub(super) shares: Vec<[f64; 3]>,
    /// Whether something begins to slide.
    pub(super) moves: bool,
}

impl Forward {
    /// Modes and frictions of the contacts at rest, if none may bear more than this part of its limit; none
    /// where nothing is found.
    pub(super) fn guess(
        &self,
        ground: &Ground,
        modes: &[Contact],
        resting: &[usize],
        bound: f64,
    ) -> Option<Guess> {
        let (topology, parameters, bodies) = (&self.topology, &self.parameters, &ground.bodies);
        let mut free = modes.to_vec();
        for &contact in resting {
            free[contact] = Contact::AtLimit([0.0; 3]);
        }
        let solved = self.solve(ground, &free, None, false).ok()?;
        let scene = self.scene(ground);
        // Each freedom of each contact at rest: its contact, and the answer to one newton of friction.
        let mut places: Vec<(usize, usize)> = Vec::new();
        let mut answers: Vec<Response> = Vec::new();
        for &contact in resting {
            let content = &parameters.contacts[contact];
            let arms = content.arms(parameters.pitch[content.joint]);
            for place in 0..content.shape.freedoms().len() {
                let mut efforts = [0.0; 3];
                efforts[place] = -arms[place];
                let wrench = wrench_of(topology, bodies, content, efforts);
                places.push((contact, place));
                answers.push(solved.balance.respond(&scene, &[(content.joint, wrench)], false));
            }
        }
        let surface = |accelerations: &[f64], (contact, place): (usize, usize)| {
            let content = &parameters.contacts[contact];
            let arm = content.arms(parameters.pitch[content.joint])[place];
            let freedom = &topology.joint_types[content.joint].freedoms()
                [content.shape.freedoms().start + place];
            let effort = bodies.effort(freedom, content.joint);
            let mut rate = 0.0;
            each_freedom(topology, content.joint, |dof, sign| {
                rate += sign * bodies.screws[dof].power(effort) * accelerations[dof];
            });
            arm * rate
        };
        let count = places.len();
        let taken: Vec<f64> = places
            .iter()
            .flat_map(|&place| answers.iter().map(move |a| (place, a)))
            .map(|(place, answer)| -surface(&answer.accelerations, place))
            .collect();
        let mut left: Vec<f64> = resting
            .iter()
            .flat_map(|&contact| {
                let begins = self.surface_acceleration(ground, &solved, contact);
                let freedoms = parameters.contacts[contact].shape.freedoms().len();
                (0..freedoms).map(move |place| begins[place])
            })
            .collect();
        let free_size = left.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
        let mut friction = vec![0.0; count];
        let mut wrenches: Vec<Wrench<f64>> = solved.coupled.response.wrenches.clone();
        let ranges: Vec<(usize, std::ops::Range<usize>)> = resting
            .iter()
            .scan(0, |first, &contact| {
                let start = *first;
                *first += parameters.contacts[contact].shape.freedoms().len();
                Some((contact, start..*first))
            })
            .collect();
        let limit = |contact: usize, friction: &[f64], wrenches: &[Wrench<f64>]| {
            let content = &parameters.contacts[contact];
            let own = OwnFriction {
                coefficient: 0.0,
                viscous: friction[0].abs(),
                direction: friction[0].signum(),
            };
            let load = load(parameters, bodies, content, own, wrenches[content.joint]).value;
            bound * law_of(content, friction[0]).at_rest() * load
        };
        for _ in 0..SWEEPS {
            let mut change = 0.0_f64;
            for (contact, range) in &ranges {
                let stiffness: f64 = range.clone().map(|i| taken[i * count + i]).sum();
                let most = limit(*contact, &friction[range.clone()], &wrenches);
                let mut next = [0.0; 3];
                for (k, i) in range.clone().enumerate() {
                    let push = if stiffness > 0.0 { left[i] / stiffness } else { 0.0 };
                    next[k] = friction[i] + push;
                }
                let size = norm(next);
                if size > most {
                    next = next.map(|f| f * (most / size));
                }
                for (k, i) in range.clone().enumerate() {
                    let by = next[k] - friction[i];
                    if by == 0.0 {
                        continue;
                    }
                    friction[i] = next[k];
                    change = change.max(by.abs());
                    for (row, left) in left.iter_mut().enumerate() {
                        *left -= taken[row * count + i] * by;
                    }
                    for (sum, unit) in wrenches.iter_mut().zip(&answers[i].wrenches) {
                        *sum += *unit * by;
                    }
                }
            }
            let largest = friction.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
            if change <= SETTLED * largest || !change.is_finite() {
                break;
            }
        }
        if !friction.iter().chain(&left).all(|x| x.is_finite()) {
            return None;
        }
        let mut guess = modes.to_vec();
        let mut shares = vec![[0.0; 3]; modes.len()];
        let mut moves = false;
        for (contact, range) in ranges {
            let (mut begins, mut has) = ([0.0; 3], [0.0; 3]);
            for (k, i) in range.clone().enumerate() {
                (begins[k], has[k]) = (left[i], friction[i]);
            }
            let rate = norm(begins);
            shares[contact] = has;
            moves |= rate > NONE * free_size;
            guess[contact] = if rate > NONE * free_size {
                Contact::AtLimit(begins.map(|a| a / rate))
            } else {
                Contact::Sticks
            };
        }
        Some(Guess { modes: guess, shares, moves })
    }
}
