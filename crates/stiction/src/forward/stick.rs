//! Which contacts at rest stick and which begin to slide: a search among accelerations.
//!
//! A contact that sticks bears no more than its limit; one that begins to slide does so against its
//! friction. All contacts at rest are tried sticking first, so what can stay does. Then, one by one, what
//! is beyond its limit lets go, and what would slide back is held again. Where that goes in circles, all
//! choices are looked through, as far as they are not too many.
//!
//! Equation (D4) of the book's theory.

use super::Forward;
use super::error::ForwardError;
use super::ground::Ground;
use super::guess::Guess;
use super::rub::{Contact, law_of, norm};
use super::solve::{Solved, Unsolved};
use std::collections::HashSet;

/// Friction may exceed its limit by this part: rounding of reactions.
const BEYOND: f64 = 1e-10;
/// Accelerations below this part of the largest are none.
const STILL: f64 = 1e-10;
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
/// Directions are found when they turn by less than this; passes for that.
const TURNED: f64 = 1e-12;
/// Directions that differ by less than this are one.
const ALIGNED: f64 = 1e-6;
const TURNS: usize = 40;

/// A choice that satisfies all laws.
pub(super) struct Choice {
    pub(super) modes: Vec<Contact>,
    pub(super) solved: Solved,
}

impl Forward {
    /// Chooses for the contacts at rest; all others keep their modes.
    pub(super) fn choose(
        &self,
        ground: &mut Ground,
        modes: &[Contact],
        resting: &[usize],
    ) -> Result<Choice, ForwardError> {
        let permanent = self.grip(ground, modes, resting);
        ground.shares = vec![[0.0; 3]; modes.len()];
        ground.overload = 1.0;
        let mut trial = trial_of(modes, resting);
        if let Ok(Verdict::Stands(solved)) = self.judge(ground, &mut trial, resting) {
            return Ok(Choice { modes: trial, solved: *solved });
        }
        // The rule's shares are beyond limits, or something must slide: frictions of all at once.
        let most = self.guess(ground, modes, resting, 1.0);
        if let Some(guess) = &most
            && guess.moves
            && let Some(choice) = self.take(ground, guess, resting)
        {
            return Ok(choice);
        }
        let all = self.solve(ground, &trial_of(modes, resting), None, false);
        let shared = all.is_ok_and(|all| all.balance.spread.stresses.len() > permanent);
        if shared && most.as_ref().is_some_and(|guess| !guess.moves) {
            // All can stick, within their limits with some room if possible.
            for bound in BOUNDS {
                let Some(guess) = self.guess(ground, modes, resting, bound) else { continue };
                if guess.moves {
                    continue;
                }
                if let Some(choice) = self.take(ground, &guess, resting) {
                    return Ok(choice);
                }
            }
        }
        ground.shares = vec![[0.0; 3]; modes.len()];
        ground.overload = 1.0;
        let (mut guilty, mut failure) = (resting.first().copied().unwrap_or(0), None);
        match self.improve(ground, trial_of(modes, resting), resting) {
            Ok(choice) => return Ok(choice),
            Err(Stuck { contact, unsolved }) => {
                guilty = contact.unwrap_or(guilty);
                failure = unsolved.map(|u| self.unsolved(ground.time, u)).or(failure);
            }
        }
        if let Some(choice) = self.look_through(ground, modes, resting) {
            return Ok(choice);
        }
        let joint = self.joint_name(self.parameters.contacts.get(guilty).map_or(0, |c| c.joint));
        Err(failure.unwrap_or(ForwardError::NoChoice { time: ground.time, joint }))
    }

    /// How much friction each contact at rest can bear, from the loads where all of them slide without it.
    /// Also how many constraints are redundant then.
    fn grip(&self, ground: &mut Ground, modes: &[Contact], resting: &[usize]) -> usize {
        let contacts = &self.parameters.contacts;
        ground.grips = vec![1.0; contacts.len()];
        let mut free = modes.to_vec();
        for &contact in resting {
            free[contact] = Contact::AtLimit([0.0; 3]);
        }
        let Ok(solved) = self.solve(ground, &free, None, false) else { return 0 };
        let redundant = solved.balance.spread.stresses.len();
        let limits: Vec<f64> = contacts
            .iter()
            .zip(&solved.coupled.loads)
            .map(|(contact, load)| contact.law.at_rest() * load)
            .collect();
        let largest = limits.iter().fold(0.0_f64, |m, l| m.max(*l));
        if largest > 0.0 && largest.is_finite() {
            ground.grips = limits.iter().map(|l| (l / largest).max(LEAST_GRIP)).collect();
        }
        redundant
    }

    /// A guess, if all laws are satisfied where it is solved exactly, or with few changes.
    fn take(&self, ground: &mut Ground, guess: &Guess, resting: &[usize]) -> Option<Choice> {
        ground.shares.clone_from(&guess.shares);
        ground.overload = if guess.tight { 1.0 + LITTLE } else { 1.0 };
        let found = self.as_it_is(ground, guess, resting);
        let found = found.or_else(|| self.improve(ground, guess.modes.clone(), resting).ok());
        if found.is_none() {
            ground.shares.fill([0.0; 3]);
            ground.overload = 1.0;
        }
        found
    }

    /// A choice whose directions are right already: nothing is turned, all is checked.
    fn as_it_is(&self, ground: &Ground, guess: &Guess, resting: &[usize]) -> Option<Choice> {
        let mut modes = guess.modes.clone();
        for &contact in resting {
            if let Contact::AtLimit(direction) = modes[contact] {
                modes[contact] = Contact::Slides(direction);
            }
        }
        let solved = self.solve(ground, &modes, Some(&guess.loads), true).ok()?;
        for &contact in resting {
            let Contact::Slides(direction) = modes[contact] else { continue };
            let Some(begins) = self.begins(ground, &solved, contact) else {
                modes[contact] = Contact::AtLimit(direction);
                continue;
            };
            let size = norm(begins);
            let turned = norm([0, 1, 2].map(|i| begins[i] / size - direction[i]));
            if turned > ALIGNED {
                return None;
            }
        }
        self.beyond(ground, &modes, &solved, resting).is_none().then_some(Choice { modes, solved })
    }

    /// Changes one contact after the other until all laws are satisfied.
    fn improve(
        &self,
        ground: &Ground,
        mut trial: Vec<Contact>,
        resting: &[usize],
    ) -> Result<Choice, Stuck> {
        let mut seen = HashSet::new();
        let mut guilty = None;
        for _ in 0..CHANGES {
            if !seen.insert(pattern(&trial, resting)) {
                break;
            }
            match self.judge(ground, &mut trial, resting) {
                Ok(Verdict::Stands(solved)) => return Ok(Choice { modes: trial, solved: *solved }),
                Ok(Verdict::Change(contact, mode)) => {
                    guilty = Some(contact);
                    trial[contact] = mode;
                }
                Err(unsolved) => return Err(Stuck { contact: guilty, unsolved: Some(unsolved) }),
            }
        }
        Err(Stuck { contact: guilty, unsolved: None })
    }

    /// All choices of sticking, sliding forward or backward, the most sticking first.
    fn look_through(
        &self,
        ground: &Ground,
        modes: &[Contact],
        resting: &[usize],
    ) -> Option<Choice> {
        let count = resting.len() as u32;
        if count == 0 || count > MOST {
            return None;
        }
        let single = |c: &usize| self.parameters.contacts[*c].shape.has_one_freedom();
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
            for &contact in resting {
                trial[contact] = match number % 3 {
                    0 => Contact::Sticks,
                    1 => Contact::AtLimit([1.0, 0.0, 0.0]),
                    _ => Contact::AtLimit([-1.0, 0.0, 0.0]),
                };
                number /= 3;
            }
            if let Ok(Verdict::Stands(solved)) = self.judge(ground, &mut trial, resting) {
                return Some(Choice { modes: trial, solved: *solved });
            }
        }
        None
    }

    /// Solves a choice and says what is wrong with it. Contacts at their limit that begin to slide are
    /// marked so.
    fn judge(
        &self,
        ground: &Ground,
        trial: &mut [Contact],
        resting: &[usize],
    ) -> Result<Verdict, Unsolved> {
        let (mut solved, turned) = self.turn(ground, trial, resting)?;
        if let Some(contact) = turned {
            return Ok(Verdict::Change(contact, Contact::Sticks));
        }
        let slides: Vec<usize> = resting
            .iter()
            .copied()
            .filter(|&c| {
                matches!(trial[c], Contact::AtLimit(_)) && self.begins(ground, &solved, c).is_some()
            })
            .collect();
        if !slides.is_empty() {
            // Sliding friction from here on; with less friction it slides all the more.
            let kept = trial.to_vec();
            for &contact in &slides {
                if let Contact::AtLimit(direction) = trial[contact] {
                    trial[contact] = Contact::Slides(direction);
                }
            }
            let (again, turned) = self.turn(ground, trial, resting)?;
            if let Some(contact) = turned {
                trial.copy_from_slice(&kept);
                return Ok(Verdict::Change(contact, Contact::Sticks));
            }
            solved = again;
        }
        if let Some(less) = self.weaken(ground, trial, resting) {
            solved = less;
        }
        let worst = self.beyond(ground, trial, &solved, resting);
        Ok(match worst {
            None => Verdict::Stands(Box::new(solved)),
            Some((contact, friction)) => {
                // Friction has the sense of the sliding that it resists.
                let size = norm(friction);
                Verdict::Change(contact, Contact::AtLimit(friction.map(|f| f / size)))
            }
        })
    }

    /// What lets go where its load grows steadily does so without acceleration. If it rubs less in sliding than at
    /// rest it has one all the same: friction at the limit is that of the instant before. Those contacts slide from
    /// here on; none where others hold them.
    fn weaken(&self, ground: &Ground, trial: &mut [Contact], resting: &[usize]) -> Option<Solved> {
        let mut weak = resting.to_vec();
        weak.retain(|&c| match trial[c] {
            Contact::AtLimit(d) => {
                !law_of(&self.parameters.contacts[c], d[0]).slides_as_at_its_limit()
            }
            _ => false,
        });
        while !weak.is_empty() {
            let mut slides = trial.to_vec();
            for &contact in &weak {
                if let Contact::AtLimit(direction) = trial[contact] {
                    slides[contact] = Contact::Slides(direction);
                }
            }
            let (solved, turned) = self.turn(ground, &mut slides, resting).ok()?;
            let count = weak.len();
            weak.retain(|&c| turned != Some(c) && self.begins(ground, &solved, c).is_some());
            if weak.len() < count {
                continue;
            }
            if turned.is_none() {
                trial.copy_from_slice(&slides);
            }
            return turned.is_none().then_some(solved);
        }
        None
    }

    /// The contact that is farthest beyond its limit though it sticks, and its friction. Or one that cannot be
    /// held at all, and where it goes: at a dead centre a slider stands, but the motion of all else moves it on.
    fn beyond(
        &self,
        ground: &Ground,
        trial: &[Contact],
        solved: &Solved,
        resting: &[usize],
    ) -> Option<(usize, [f64; 3])> {
        // What holds a contact may depend on other constraints, and then need not do what is asked of it.
        if !solved.balance.spread.stresses.is_empty() {
            if let Some((contact, way)) = self.gives_way(ground, solved)
                && resting.contains(&contact)
            {
                return Some((contact, way));
            }
            let held = resting.iter().filter(|&&contact| trial[contact] == Contact::Sticks);
            let mut moving = held.filter_map(|&c| self.begins(ground, solved, c).map(|a| (c, a)));
            if let Some(found) = moving.next() {
                return Some(found);
            }
        }
        let contacts = self.contacts(ground, trial, solved);
        let mut worst: Option<(f64, usize)> = None;
        for &contact in resting {
            if trial[contact] != Contact::Sticks {
                continue;
            }
            let moment = &contacts[contact];
            let (has, most) = (norm(moment.friction), moment.limit * ground.overload);
            let beyond = has - most * (1.0 + BEYOND);
            // Forces that are nothing but rounding exceed no limit.
            let size = solved.coupled.response.wrenches.iter().map(|w| w.force.norm());
            let rounding = 1e-13 * size.fold(0.0, f64::max);
            if beyond > rounding {
                let ratio = if most > 0.0 { has / most } else { f64::INFINITY };
                if worst.is_none_or(|(w, _)| ratio > w) {
                    worst = Some((ratio, contact));
                }
            }
        }
        worst.map(|(_, contact)| (contact, contacts[contact].friction))
    }

    /// Solves with the directions of all that begins to slide; those of balls and plates turn until they
    /// are those of the acceleration. Also a contact that would slide back.
    fn turn(
        &self,
        ground: &Ground,
        trial: &mut [Contact],
        resting: &[usize],
    ) -> Result<(Solved, Option<usize>), Unsolved> {
        for pass in 0..TURNS {
            let solved = self.solve(ground, trial, None, true)?;
            let mut turned = 0.0_f64;
            for &contact in resting {
                let (Contact::AtLimit(direction) | Contact::Slides(direction)) = trial[contact]
                else {
                    continue;
                };
                let Some(begins) = self.begins(ground, &solved, contact) else { continue };
                let along: f64 = begins.iter().zip(direction).map(|(a, d)| a * d).sum();
                let single = self.parameters.contacts[contact].shape.has_one_freedom();
                if along < 0.0 && (single || pass > 3) {
                    return Ok((solved, Some(contact)));
                }
                if single {
                    continue;
                }
                let next = self.direction(ground, &solved, contact, begins);
                turned = turned.max(norm([0, 1, 2].map(|i| next[i] - direction[i])));
                trial[contact] = match trial[contact] {
                    Contact::Slides(_) => Contact::Slides(next),
                    _ => Contact::AtLimit(next),
                };
            }
            if turned < TURNED || pass + 1 == TURNS {
                return Ok((solved, None));
            }
        }
        let solved = self.solve(ground, trial, None, true)?;
        Ok((solved, None))
    }

    /// The direction in which a ball or plate begins to slide, other contacts and its load as they are.
    /// With `K`, what one newton of friction takes from the surface's acceleration, that without
    /// friction `a`, and friction of size `c`, it is `d = (x + c K)^-1 a` with the acceleration `x` that
    /// makes it of length one.
    fn direction(
        &self,
        ground: &Ground,
        solved: &Solved,
        contact: usize,
        begins: [f64; 3],
    ) -> [f64; 3] {
        let content = &self.parameters.contacts[contact];
        let arms = content.arms(self.parameters.pitch[content.joint]);
        let scene = self.scene(ground);
        let mut taken = nalgebra::Matrix3::zeros();
        for (column, wrench) in self.unit_frictions(ground, contact).into_iter().enumerate() {
            let response = solved.balance.respond(&scene, &[(content.joint, wrench)], false);
            for row in 0..3 {
                taken[(row, column)] =
                    -self.surface_rate(ground, &response.accelerations, contact, row);
            }
        }
        let load = solved.coupled.loads[contact];
        let rub = &solved.rubs[contact];
        let friction: [f64; 3] =
            [0, 1, 2].map(|i| (rub.known[i] + rub.per_load[i] * load) / arms[i]);
        let size = norm(friction);
        let free = nalgebra::Vector3::from(begins) + taken * nalgebra::Vector3::from(friction);
        let along = |x: f64| {
            let matrix = taken * size + nalgebra::Matrix3::identity() * x;
            matrix.lu().solve(&free).unwrap_or_else(nalgebra::Vector3::zeros)
        };
        // Between none and all of the acceleration without friction.
        let (mut low, mut high) = (0.0, free.norm());
        for _ in 0..2000 {
            let middle = if low > 0.0 { (low * high).sqrt() } else { 1e-3 * high };
            if !(middle > low && middle < high) || high < 1e-300 {
                break;
            }
            if along(middle).norm() > 1.0 {
                low = middle
            } else {
                high = middle
            }
            if low > 0.0 && high - low <= 1e-15 * high {
                break;
            }
        }
        let found = along(high);
        let length = found.norm();
        if length > 0.0 { (found / length).into() } else { begins.map(|b| b / norm(begins)) }
    }

    /// The acceleration of a contact's surface, m/s^2, where it is more than rounding.
    fn begins(&self, ground: &Ground, solved: &Solved, contact: usize) -> Option<[f64; 3]> {
        let accelerations = &solved.coupled.response.accelerations;
        let begins = self.surface_acceleration(ground, accelerations, contact);
        (norm(begins) > self.rounding_of_beginnings(accelerations, contact)).then_some(begins)
    }

    /// Accelerations of a contact's surface up to this, m/s^2, are rounding.
    pub(super) fn rounding_of_beginnings(&self, accelerations: &[f64], contact: usize) -> f64 {
        let parameters = &self.parameters;
        let content = &parameters.contacts[contact];
        let largest = accelerations
            .iter()
            .zip(&self.columns)
            .fold(parameters.gravity.norm() / parameters.length, |m, (a, c)| m.max((a / c).abs()));
        let arm = content.arms(parameters.pitch[content.joint])[0].min(parameters.length);
        STILL * largest * arm
    }
}

/// All contacts at rest sticking.
fn trial_of(modes: &[Contact], resting: &[usize]) -> Vec<Contact> {
    let mut trial = modes.to_vec();
    for &contact in resting {
        trial[contact] = Contact::Sticks;
    }
    trial
}

/// Where the search ended without a choice.
struct Stuck {
    contact: Option<usize>,
    unsolved: Option<Unsolved>,
}

enum Verdict {
    Stands(Box<Solved>),
    Change(usize, Contact),
}

fn pattern(modes: &[Contact], resting: &[usize]) -> Vec<i64> {
    let of = |contact: &usize| match modes[*contact] {
        Contact::Smooth | Contact::Sticks => 0,
        Contact::Slides(d) | Contact::AtLimit(d) => {
            1 + d.iter().fold(0, |sum, x| 1000 * sum + (x * 400.0).round() as i64 + 400)
        }
    };
    resting.iter().map(of).collect()
}
