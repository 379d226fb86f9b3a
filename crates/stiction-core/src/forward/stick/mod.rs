//! Decision between stick and slip: searches for modes of the interfaces at rest that satisfy all
//! friction laws.
//!
//! The friction of a sticking interface must lie within its limit, and an interface at slip onset
//! must accelerate against its friction. The search first assumes that all interfaces at rest
//! stick. If this fails, a complementarity problem proposes modes, see [`guess`], and exact
//! solutions verify the proposed modes. If this also fails, the search changes one mode at a time:
//! an interface beyond its limit slips, and an interface that would slide against its direction
//! sticks.
//!
//! Equation (D4) of the book's theory.

mod directions;
mod guess;
mod instantaneous_lock;
mod preload;
mod verify;

use super::Forward;
use super::affine_friction::{InterfaceMode, norm};
use super::data::{Data, FrictionDistribution, KnownForces};
use super::error::ForwardError;
use super::solve::{Solved, Unsolved};
use guess::Guess;
use std::collections::HashSet;
use verify::Verdict;
pub(super) use verify::rounding_of_friction;

/// Largest number of steps in a mode search; each step changes the mode of one interface.
const CHANGES: usize = 60;
/// Smallest friction scale of an interface, relative to the largest friction scale. This bound
/// limits the condition number of the linear systems. The friction scale is the estimated friction
/// limit, see [`FrictionDistribution::scales`].
const SMALLEST_SCALE: f64 = 1e-6;
/// Relative amount by which statically indeterminate frictions may exceed their limits. Without
/// this allowance the frictions would have to be redistributed at every instant until an interface
/// slides.
const ALLOWANCE: f64 = 1e-5;
/// Upper bounds of static friction that are tried in turn, as fractions of the friction limits.
const BOUNDS: [f64; 5] = [0.9, 0.99, 0.999, 0.9999, 1.0];
/// Weights of reactions that are tried if frictions and reactions are known: close to a singular
/// position frictions alone do not determine the normal loads, see [`Forward::limit_preload`].
const WEIGHTS: [f64; 2] = [0.0, preload::LARGEST_WEIGHT];
/// Two unit vectors of direction count as equal if they differ by less than this value.
const ALIGNED: f64 = 1e-6;

/// Modes that satisfy all friction laws, and the corresponding solution.
pub(super) struct Choice {
    pub(super) modes: Vec<InterfaceMode>,
    pub(super) solved: Solved,
}

impl Forward {
    /// Chooses modes for the interfaces at rest, whose indices are in `resting`; all other
    /// interfaces keep their modes. `known` are forces of a mechanism at rest that may hold it.
    ///
    /// # Errors
    /// [`ForwardError::NoChoice`] if no modes are found, or the error of the last trial if the
    /// equations of motion have no solution in its modes.
    pub(super) fn choose(
        &self,
        data: &mut Data,
        modes: &[InterfaceMode],
        resting: &[usize],
        known: Option<KnownForces>,
    ) -> Result<Choice, ForwardError> {
        data.limit_factor = 1.0;
        let mut trial = all_sticking(modes, resting);
        // A preload stays as long as it holds the mechanism.
        if data.distribution.reaction_weight > 0.0
            && let Ok(Verdict::Stands(solved)) = self.verify(data, &mut trial, resting)
        {
            return Ok(Choice { modes: trial, solved: *solved });
        }
        data.distribution = FrictionDistribution::even(modes.len());
        let permanent = self.set_friction_scales(data, modes, resting);
        if let Ok(Verdict::Stands(solved)) = self.verify(data, &mut trial, resting) {
            let solved = self.limit_preload(data, &mut trial, (resting, permanent), *solved);
            return Ok(Choice { modes: trial, solved });
        }
        // Statically indeterminate frictions may hold the mechanism although the least-norm frictions exceed a limit.
        if let Some(forces) = known {
            for weight in WEIGHTS {
                data.distribution.refer_to(&forces, weight);
                for limit_factor in [1.0, 1.0 + ALLOWANCE] {
                    data.limit_factor = limit_factor;
                    if let Ok(Verdict::Stands(solved)) = self.verify(data, &mut trial, resting)
                        && solved.balance.redundant() > permanent
                    {
                        let at_rest = (resting, permanent);
                        let solved = self.limit_preload(data, &mut trial, at_rest, *solved);
                        return Ok(Choice { modes: trial, solved });
                    }
                }
            }
            data.distribution.refer_to_zero();
            data.limit_factor = 1.0;
        }
        // With all interfaces sticking, a friction exceeds its limit, or an interface must slide:
        // the friction laws of all interfaces must be solved together.
        let guess = self.guess(data, modes, resting, 1.0);
        if let Some(guess) = &guess
            && guess.moves
            && let Some(choice) = self.adopt(data, guess, resting)
        {
            return Ok(choice);
        }
        let all = self.solve(data, &all_sticking(modes, resting), None, false);
        let shared = all.is_ok_and(|all| all.balance.redundant() > permanent);
        if shared && guess.as_ref().is_some_and(|guess| !guess.moves) {
            // All interfaces can stick, but their frictions are statically indeterminate: prefers
            // frictions with a margin to their limits.
            for bound in BOUNDS {
                let Some(guess) = self.guess(data, modes, resting, bound) else { continue };
                if guess.moves {
                    continue;
                }
                if let Some(choice) = self.adopt(data, &guess, resting) {
                    return Ok(choice);
                }
            }
        }
        data.distribution.refer_to_zero();
        data.limit_factor = 1.0;
        let (mut blocking, mut failure) = (resting.first().copied().unwrap_or(0), None);
        match self.improve(data, all_sticking(modes, resting), resting) {
            Ok(choice) => return Ok(choice),
            Err(NoModes { interface, unsolved }) => {
                blocking = interface.unwrap_or(blocking);
                failure = unsolved.map(|u| self.unsolved(data.time, u)).or(failure);
            }
        }
        let joint =
            self.joint_name(self.parameters.interfaces.get(blocking).map_or(0, |c| c.joint));
        Err(failure.unwrap_or(ForwardError::NoChoice { time: data.time, joint }))
    }

    /// Computes the friction scales of the interfaces from the normal loads that result if the
    /// interfaces at rest exert no friction. Returns the number of constraints that remain
    /// redundant if none of these interfaces sticks.
    fn set_friction_scales(
        &self,
        data: &mut Data,
        modes: &[InterfaceMode],
        resting: &[usize],
    ) -> usize {
        let interfaces = &self.parameters.interfaces;
        let mut free = modes.to_vec();
        for &interface in resting {
            free[interface] = InterfaceMode::AtLimit([0.0; 3]);
        }
        let Ok(solved) = self.solve(data, &free, None, false) else { return 0 };
        let redundant = solved.balance.redundant();
        let limits: Vec<f64> = interfaces
            .iter()
            .zip(&solved.coupled.loads)
            .map(|(interface, load)| interface.law.at_rest() * load)
            .collect();
        let largest = limits.iter().fold(0.0_f64, |m, l| m.max(*l));
        if largest > 0.0 && largest.is_finite() {
            data.distribution.scales =
                limits.iter().map(|l| (l / largest).max(SMALLEST_SCALE)).collect();
        }
        redundant
    }

    /// Accepts a guess if its exact solution satisfies all friction laws, either at once or after a
    /// few changes of modes.
    fn adopt(&self, data: &mut Data, guess: &Guess, resting: &[usize]) -> Option<Choice> {
        data.limit_factor = if guess.tight { 1.0 + ALLOWANCE } else { 1.0 };
        // The reactions of a mechanism that moves change, and are no references for long.
        let weights = if guess.moves { &WEIGHTS[..1] } else { &WEIGHTS[..] };
        for &weight in weights {
            data.distribution.refer_to(&guess.forces, weight);
            let found = self.confirm(data, guess, resting);
            if found.is_some() {
                return found;
            }
        }
        data.distribution.refer_to(&guess.forces, 0.0);
        let found = self.improve(data, guess.modes.clone(), resting).ok();
        if found.is_none() {
            data.distribution.refer_to_zero();
            data.limit_factor = 1.0;
        }
        found
    }

    /// Accepts a guess if its exact solution satisfies all friction laws with unchanged directions
    /// of slip.
    fn confirm(&self, data: &Data, guess: &Guess, resting: &[usize]) -> Option<Choice> {
        let mut modes = guess.modes.clone();
        for &interface in resting {
            if let InterfaceMode::AtLimit(direction) = modes[interface] {
                modes[interface] = InterfaceMode::Slides(direction);
            }
        }
        let solved = self.solve(data, &modes, Some(&guess.loads), true).ok()?;
        let accelerated = self.accelerated_by(data, &solved);
        for &interface in resting {
            let InterfaceMode::Slides(direction) = modes[interface] else { continue };
            let Some(onset) = self.slip_onset(&accelerated, &solved, interface) else {
                modes[interface] = InterfaceMode::AtLimit(direction);
                continue;
            };
            let size = norm(onset);
            let turned = norm([0, 1, 2].map(|i| onset[i] / size - direction[i]));
            if turned > ALIGNED {
                return None;
            }
        }
        self.beyond_limit(data, &modes, &solved, resting)
            .is_none()
            .then_some(Choice { modes, solved })
    }

    /// Changes the mode of one interface at a time until all friction laws are satisfied. Stops if
    /// modes repeat or after [`CHANGES`] steps.
    fn improve(
        &self,
        data: &Data,
        mut trial: Vec<InterfaceMode>,
        resting: &[usize],
    ) -> Result<Choice, NoModes> {
        let mut seen = HashSet::new();
        let mut blocking = None;
        for _ in 0..CHANGES {
            if !seen.insert(pattern(&trial, resting)) {
                break;
            }
            match self.verify(data, &mut trial, resting) {
                Ok(Verdict::Stands(solved)) => {
                    return Ok(self.without_idle_slip(
                        data,
                        Choice { modes: trial, solved: *solved },
                        resting,
                    ));
                }
                Ok(Verdict::Change(interface, mode)) => {
                    blocking = Some(interface);
                    trial[interface] = mode;
                }
                Err(unsolved) => {
                    return Err(NoModes { interface: blocking, unsolved: Some(unsolved) });
                }
            }
        }
        Err(NoModes { interface: blocking, unsolved: None })
    }
}

impl Forward {
    /// Returns a choice in which interfaces at rest stick that do not begin to slide in `choice`, as
    /// far as this satisfies all friction laws. On the way to modes without contradiction, such an
    /// interface may have slipped in place of another one; it would then slide at the velocity of
    /// round-off, with its full friction.
    fn without_idle_slip(&self, data: &Data, choice: Choice, resting: &[usize]) -> Choice {
        let accelerated = self.accelerated_by(data, &choice.solved);
        let mut trial = choice.modes.clone();
        for &interface in resting {
            if self.slip_onset(&accelerated, &choice.solved, interface).is_none() {
                trial[interface] = InterfaceMode::Sticks;
            }
        }
        while trial != choice.modes {
            match self.verify(data, &mut trial, resting) {
                Ok(Verdict::Stands(solved)) => return Choice { modes: trial, solved: *solved },
                Ok(Verdict::Change(interface, _))
                    if trial[interface] != choice.modes[interface] =>
                {
                    trial[interface] = choice.modes[interface];
                }
                _ => break,
            }
        }
        choice
    }
}

/// Returns a copy of the modes in which all interfaces at rest stick.
fn all_sticking(modes: &[InterfaceMode], resting: &[usize]) -> Vec<InterfaceMode> {
    let mut trial = modes.to_vec();
    for &interface in resting {
        trial[interface] = InterfaceMode::Sticks;
    }
    trial
}

/// Result of a failed search for modes.
struct NoModes {
    interface: Option<usize>,
    unsolved: Option<Unsolved>,
}

/// Returns a key that identifies the modes of the interfaces at rest; directions are rounded to a
/// few digits.
fn pattern(modes: &[InterfaceMode], resting: &[usize]) -> Vec<i64> {
    let of = |interface: &usize| match modes[*interface] {
        InterfaceMode::Smooth | InterfaceMode::Sticks => 0,
        InterfaceMode::Slides(d) | InterfaceMode::AtLimit(d) => {
            1 + d.iter().fold(0, |sum, x| 1000 * sum + (x * 400.0).round() as i64 + 400)
        }
    };
    resting.iter().map(of).collect()
}
