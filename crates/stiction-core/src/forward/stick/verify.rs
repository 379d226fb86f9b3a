//! Verification of stick-slip modes against the friction laws.

use crate::forward::Forward;
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::data::Data;
use crate::forward::solve::{Solved, Unsolved};
use crate::spatial::Wrench;

/// Fraction of the friction limit below which an excess of friction over the limit counts as
/// round-off of the reactions.
const EXCESS: f64 = 1e-10;

/// Round-off of frictions and friction limits, as a fraction of the largest joint force.
const ROUNDING: f64 = 1e-13;

/// Returns an excess of friction over its limit, N, that may be round-off of the joint forces. A
/// joint without load has a friction limit of the same size.
pub(in crate::forward) fn rounding_of_friction(wrenches: &[Wrench<f64>]) -> f64 {
    ROUNDING * wrenches.iter().map(|w| w.force.norm()).fold(0.0, f64::max)
}

/// Result of the verification of a set of modes.
pub(super) enum Verdict {
    /// The modes satisfy all friction laws.
    Stands(Box<Solved>),
    /// The interface with the given index must change to the given mode.
    Change(usize, InterfaceMode),
}

impl Forward {
    /// Solves the equations of motion for given modes of the interfaces at rest and checks the
    /// friction laws. Interfaces at their limit that begin to slide get the mode slip in `trial`.
    pub(super) fn verify(
        &self,
        data: &Data,
        trial: &mut [InterfaceMode],
        resting: &[usize],
    ) -> Result<Verdict, Unsolved> {
        let (mut solved, reversed) = self.solve_directions(data, trial, resting)?;
        if let Some(interface) = reversed {
            return Ok(Verdict::Change(interface, InterfaceMode::Sticks));
        }
        let accelerated = self.accelerated_by(data, &solved);
        let begins = |c: usize| self.slip_onset(&accelerated, &solved, c).is_some();
        let slips = |c: &usize| matches!(trial[*c], InterfaceMode::AtLimit(_)) && begins(*c);
        let slides: Vec<usize> = resting.iter().copied().filter(slips).collect();
        if !slides.is_empty() {
            // Repeats the solution with sliding friction for these interfaces. If their sliding
            // friction is less than their static friction, they accelerate even more.
            let kept = trial.to_vec();
            for &interface in &slides {
                if let InterfaceMode::AtLimit(direction) = trial[interface] {
                    trial[interface] = InterfaceMode::Slides(direction);
                }
            }
            let (again, reversed) = self.solve_directions(data, trial, resting)?;
            if let Some(interface) = reversed {
                trial.copy_from_slice(&kept);
                return Ok(Verdict::Change(interface, InterfaceMode::Sticks));
            }
            solved = again;
        }
        if let Some(weaker) = self.weaken(data, trial, resting) {
            solved = weaker;
        }
        let worst = self.beyond_limit(data, trial, &solved, resting);
        Ok(match worst {
            None => Verdict::Stands(Box::new(solved)),
            Some((interface, friction)) => {
                // Friction has the sign of the slip that it opposes.
                let size = norm(friction);
                Verdict::Change(interface, InterfaceMode::AtLimit(friction.map(|f| f / size)))
            }
        })
    }

    /// Changes interfaces at their limit to slip if their sliding friction is less than their
    /// static friction. At slip onset under a slowly changing load, the acceleration is zero with
    /// friction at the static limit, but not with sliding friction. Returns the solution with the
    /// changed modes, or `None` if no mode is changed, for example because other constraints
    /// prevent the slip.
    fn weaken(
        &self,
        data: &Data,
        trial: &mut [InterfaceMode],
        resting: &[usize],
    ) -> Option<Solved> {
        let mut weak = resting.to_vec();
        weak.retain(|&c| match trial[c] {
            InterfaceMode::AtLimit(d) => {
                !self.parameters.interfaces[c].law_towards(d[0]).slides_as_at_its_limit()
            }
            _ => false,
        });
        while !weak.is_empty() {
            let mut slides = trial.to_vec();
            for &interface in &weak {
                if let InterfaceMode::AtLimit(direction) = trial[interface] {
                    slides[interface] = InterfaceMode::Slides(direction);
                }
            }
            let (solved, reversed) = self.solve_directions(data, &mut slides, resting).ok()?;
            let count = weak.len();
            let accelerated = self.accelerated_by(data, &solved);
            weak.retain(|&c| {
                reversed != Some(c) && self.slip_onset(&accelerated, &solved, c).is_some()
            });
            if weak.len() < count {
                continue;
            }
            if reversed.is_none() {
                trial.copy_from_slice(&slides);
            }
            return reversed.is_none().then_some(solved);
        }
        None
    }

    /// Finds the sticking interface whose friction exceeds its limit by the largest ratio, and
    /// returns the index and the friction of this interface. If an interface cannot stick, for
    /// example a slider at a dead centre, which is at rest only for an instant, returns this
    /// interface and the direction of its motion instead.
    pub(super) fn beyond_limit(
        &self,
        data: &Data,
        trial: &[InterfaceMode],
        solved: &Solved,
        resting: &[usize],
    ) -> Option<(usize, [f64; 3])> {
        // The row of a sticking interface may depend on other constraints, and may then be
        // violated.
        if solved.balance.is_redundant() {
            if let Some((interface, direction)) = self.instantaneous_lock(data, solved)
                && resting.contains(&interface)
            {
                return Some((interface, direction));
            }
            let sticking =
                resting.iter().filter(|&&interface| trial[interface] == InterfaceMode::Sticks);
            let accelerated = self.accelerated_by(data, solved);
            let onset = |c: usize| self.slip_onset(&accelerated, solved, c).map(|onset| (c, onset));
            let mut moving = sticking.filter_map(|&c| onset(c));
            if let Some(found) = moving.next() {
                return Some(found);
            }
        }
        let mut interfaces = Vec::with_capacity(trial.len());
        self.interfaces_into(data, trial, solved, &mut interfaces);
        let rounding = rounding_of_friction(&solved.coupled.response.wrenches);
        let mut worst: Option<(f64, usize)> = None;
        for &interface in resting {
            if trial[interface] != InterfaceMode::Sticks {
                continue;
            }
            let now = &interfaces[interface];
            let (friction, limit) = (norm(now.friction), now.limit * data.limit_factor);
            let excess = friction - limit * (1.0 + EXCESS);
            if excess > rounding {
                let ratio = if limit > 0.0 { friction / limit } else { f64::INFINITY };
                if worst.is_none_or(|(w, _)| ratio > w) {
                    worst = Some((ratio, interface));
                }
            }
        }
        worst.map(|(_, interface)| (interface, interfaces[interface].friction))
    }
}
