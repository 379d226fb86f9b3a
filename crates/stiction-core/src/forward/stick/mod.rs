//! Which contacts at rest stick and which begin to slide: a search among accelerations.
//!
//! A contact that sticks bears no more than its limit; one that begins to slide does so against its
//! friction. All contacts at rest are tried sticking first, so what can stay does. Then, one by one, what
//! is beyond its limit lets go, and what would slide back is held again. Where that goes in circles, all
//! choices are looked through, as far as they are not too many.
//!
//! Equation (D4) of the book's theory.

mod judge;
mod turn;

use super::Forward;
use super::affine_friction::{InterfaceMode, norm};
use super::error::ForwardError;
use super::guess::Guess;
use super::situation::Situation;
use super::solve::{Solved, Unsolved};
use judge::Verdict;
use std::collections::HashSet;

/// All choices of so many contacts are looked through.
const MOST: u32 = 7;
/// Changes of one contact at a time.
const CHANGES: usize = 60;
/// What can bear less than this part of the most is taken to bear this much, so that numbers stay good.
const LEAST_GRIP: f64 = 1e-6;
/// Where frictions that share a load have no room left, they may exceed their limits by this part: else
/// they would have to be shared anew at every moment until something slides.
const LITTLE: f64 = 1e-5;
/// Parts of the limits within which frictions that hold are looked for.
const BOUNDS: [f64; 5] = [0.9, 0.99, 0.999, 0.9999, 1.0];
/// Directions that differ by less than this are one.
const ALIGNED: f64 = 1e-6;

/// A choice that satisfies all laws.
pub(super) struct Choice {
    pub(super) modes: Vec<InterfaceMode>,
    pub(super) solved: Solved,
}

impl Forward {
    /// Chooses for the contacts at rest; all others keep their modes.
    pub(super) fn choose(
        &self,
        situation: &mut Situation,
        modes: &[InterfaceMode],
        resting: &[usize],
    ) -> Result<Choice, ForwardError> {
        let permanent = self.grip(situation, modes, resting);
        situation.shares = vec![[0.0; 3]; modes.len()];
        situation.overload = 1.0;
        let mut trial = trial_of(modes, resting);
        if let Ok(Verdict::Stands(solved)) = self.judge(situation, &mut trial, resting) {
            return Ok(Choice { modes: trial, solved: *solved });
        }
        // The rule's shares are beyond limits, or something must slide: frictions of all at once.
        let most = self.guess(situation, modes, resting, 1.0);
        if let Some(guess) = &most
            && guess.moves
            && let Some(choice) = self.take(situation, guess, resting)
        {
            return Ok(choice);
        }
        let all = self.solve(situation, &trial_of(modes, resting), None, false);
        let shared = all.is_ok_and(|all| all.balance.spread.stresses.len() > permanent);
        if shared && most.as_ref().is_some_and(|guess| !guess.moves) {
            // All can stick, within their limits with some room if possible.
            for bound in BOUNDS {
                let Some(guess) = self.guess(situation, modes, resting, bound) else { continue };
                if guess.moves {
                    continue;
                }
                if let Some(choice) = self.take(situation, &guess, resting) {
                    return Ok(choice);
                }
            }
        }
        situation.shares = vec![[0.0; 3]; modes.len()];
        situation.overload = 1.0;
        let (mut guilty, mut failure) = (resting.first().copied().unwrap_or(0), None);
        match self.improve(situation, trial_of(modes, resting), resting) {
            Ok(choice) => return Ok(choice),
            Err(Stuck { interface, unsolved }) => {
                guilty = interface.unwrap_or(guilty);
                failure = unsolved.map(|u| self.unsolved(situation.time, u)).or(failure);
            }
        }
        if let Some(choice) = self.look_through(situation, modes, resting) {
            return Ok(choice);
        }
        let joint = self.joint_name(self.parameters.interfaces.get(guilty).map_or(0, |c| c.joint));
        Err(failure.unwrap_or(ForwardError::NoChoice { time: situation.time, joint }))
    }

    /// How much friction each contact at rest can bear, from the loads where all of them slide without it.
    /// Also how many constraints are redundant then.
    fn grip(&self, situation: &mut Situation, modes: &[InterfaceMode], resting: &[usize]) -> usize {
        let interfaces = &self.parameters.interfaces;
        situation.grips = vec![1.0; interfaces.len()];
        let mut free = modes.to_vec();
        for &interface in resting {
            free[interface] = InterfaceMode::AtLimit([0.0; 3]);
        }
        let Ok(solved) = self.solve(situation, &free, None, false) else { return 0 };
        let redundant = solved.balance.spread.stresses.len();
        let limits: Vec<f64> = interfaces
            .iter()
            .zip(&solved.coupled.loads)
            .map(|(interface, load)| interface.law.at_rest() * load)
            .collect();
        let largest = limits.iter().fold(0.0_f64, |m, l| m.max(*l));
        if largest > 0.0 && largest.is_finite() {
            situation.grips = limits.iter().map(|l| (l / largest).max(LEAST_GRIP)).collect();
        }
        redundant
    }

    /// A guess, if all laws are satisfied where it is solved exactly, or with few changes.
    fn take(&self, situation: &mut Situation, guess: &Guess, resting: &[usize]) -> Option<Choice> {
        situation.shares.clone_from(&guess.shares);
        situation.overload = if guess.tight { 1.0 + LITTLE } else { 1.0 };
        let found = self.as_it_is(situation, guess, resting);
        let found = found.or_else(|| self.improve(situation, guess.modes.clone(), resting).ok());
        if found.is_none() {
            situation.shares.fill([0.0; 3]);
            situation.overload = 1.0;
        }
        found
    }

    /// A choice whose directions are right already: nothing is turned, all is checked.
    fn as_it_is(&self, situation: &Situation, guess: &Guess, resting: &[usize]) -> Option<Choice> {
        let mut modes = guess.modes.clone();
        for &interface in resting {
            if let InterfaceMode::AtLimit(direction) = modes[interface] {
                modes[interface] = InterfaceMode::Slides(direction);
            }
        }
        let solved = self.solve(situation, &modes, Some(&guess.loads), true).ok()?;
        let accelerated = self.accelerated_by(situation, &solved);
        for &interface in resting {
            let InterfaceMode::Slides(direction) = modes[interface] else { continue };
            let Some(begins) = self.begins(&accelerated, &solved, interface) else {
                modes[interface] = InterfaceMode::AtLimit(direction);
                continue;
            };
            let size = norm(begins);
            let turned = norm([0, 1, 2].map(|i| begins[i] / size - direction[i]));
            if turned > ALIGNED {
                return None;
            }
        }
        self.beyond(situation, &modes, &solved, resting)
            .is_none()
            .then_some(Choice { modes, solved })
    }

    /// Changes one contact after the other until all laws are satisfied.
    fn improve(
        &self,
        situation: &Situation,
        mut trial: Vec<InterfaceMode>,
        resting: &[usize],
    ) -> Result<Choice, Stuck> {
        let mut seen = HashSet::new();
        let mut guilty = None;
        for _ in 0..CHANGES {
            if !seen.insert(pattern(&trial, resting)) {
                break;
            }
            match self.judge(situation, &mut trial, resting) {
                Ok(Verdict::Stands(solved)) => return Ok(Choice { modes: trial, solved: *solved }),
                Ok(Verdict::Change(interface, mode)) => {
                    guilty = Some(interface);
                    trial[interface] = mode;
                }
                Err(unsolved) => return Err(Stuck { interface: guilty, unsolved: Some(unsolved) }),
            }
        }
        Err(Stuck { interface: guilty, unsolved: None })
    }

    /// All choices of sticking, sliding forward or backward, the most sticking first.
    fn look_through(
        &self,
        situation: &Situation,
        modes: &[InterfaceMode],
        resting: &[usize],
    ) -> Option<Choice> {
        let count = resting.len() as u32;
        if count == 0 || count > MOST {
            return None;
        }
        let single = |c: &usize| self.parameters.interfaces[*c].shape.has_one_dof();
        if !resting.iter().all(single) {
            return None;
        }
        let mut numbers: Vec<u32> = (0..3_u32.pow(count)).collect();
        let sliding = |mut number: u32| {
            let mut sum = 0;
            while number > 0 {
                sum += u32::from(!number.is_multiple_of(3));
                number /= 3;
            }
            sum
        };
        numbers.sort_by_key(|&n| sliding(n));
        for mut number in numbers {
            let mut trial = modes.to_vec();
            for &interface in resting {
                trial[interface] = match number % 3 {
                    0 => InterfaceMode::Sticks,
                    1 => InterfaceMode::AtLimit([1.0, 0.0, 0.0]),
                    _ => InterfaceMode::AtLimit([-1.0, 0.0, 0.0]),
                };
                number /= 3;
            }
            if let Ok(Verdict::Stands(solved)) = self.judge(situation, &mut trial, resting) {
                return Some(Choice { modes: trial, solved: *solved });
            }
        }
        None
    }
}

/// All contacts at rest sticking.
fn trial_of(modes: &[InterfaceMode], resting: &[usize]) -> Vec<InterfaceMode> {
    let mut trial = modes.to_vec();
    for &interface in resting {
        trial[interface] = InterfaceMode::Sticks;
    }
    trial
}

/// Where the search ended without a choice.
struct Stuck {
    interface: Option<usize>,
    unsolved: Option<Unsolved>,
}

fn pattern(modes: &[InterfaceMode], resting: &[usize]) -> Vec<i64> {
    let of = |interface: &usize| match modes[*interface] {
        InterfaceMode::Smooth | InterfaceMode::Sticks => 0,
        InterfaceMode::Slides(d) | InterfaceMode::AtLimit(d) => {
            1 + d.iter().fold(0, |sum, x| 1000 * sum + (x * 400.0).round() as i64 + 400)
        }
    };
    resting.iter().map(of).collect()
}
