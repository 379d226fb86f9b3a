//! What is wrong with a choice, if anything is.

use crate::forward::Forward;
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::situation::Situation;
use crate::forward::solve::{Solved, Unsolved};

/// Friction may exceed its limit by this part: rounding of reactions.
const BEYOND: f64 = 1e-10;

/// What is said of a choice.
pub(super) enum Verdict {
    /// It satisfies all laws.
    Stands(Box<Solved>),
    /// This contact does something else.
    Change(usize, InterfaceMode),
}

impl Forward {
    /// Solves a choice and says what is wrong with it. Contacts at their limit that begin to slide are
    /// marked so.
    pub(super) fn judge(
        &self,
        situation: &Situation,
        trial: &mut [InterfaceMode],
        resting: &[usize],
    ) -> Result<Verdict, Unsolved> {
        let (mut solved, turned) = self.turn(situation, trial, resting)?;
        if let Some(interface) = turned {
            return Ok(Verdict::Change(interface, InterfaceMode::Sticks));
        }
        let accelerated = self.accelerated_by(situation, &solved);
        let begins = |c: usize| self.begins(&accelerated, &solved, c).is_some();
        let lets_go = |c: &usize| matches!(trial[*c], InterfaceMode::AtLimit(_)) && begins(*c);
        let slides: Vec<usize> = resting.iter().copied().filter(lets_go).collect();
        if !slides.is_empty() {
            // Sliding friction from here on; with less friction it slides all the more.
            let kept = trial.to_vec();
            for &interface in &slides {
                if let InterfaceMode::AtLimit(direction) = trial[interface] {
                    trial[interface] = InterfaceMode::Slides(direction);
                }
            }
            let (again, turned) = self.turn(situation, trial, resting)?;
            if let Some(interface) = turned {
                trial.copy_from_slice(&kept);
                return Ok(Verdict::Change(interface, InterfaceMode::Sticks));
            }
            solved = again;
        }
        if let Some(less) = self.weaken(situation, trial, resting) {
            solved = less;
        }
        let worst = self.beyond(situation, trial, &solved, resting);
        Ok(match worst {
            None => Verdict::Stands(Box::new(solved)),
            Some((interface, friction)) => {
                // Friction has the sense of the sliding that it resists.
                let size = norm(friction);
                Verdict::Change(interface, InterfaceMode::AtLimit(friction.map(|f| f / size)))
            }
        })
    }

    /// What lets go where its load grows steadily does so without acceleration. If it rubs less in sliding than at
    /// rest it has one all the same: friction at the limit is that of the instant before. Those contacts slide from
    /// here on; none where others hold them.
    fn weaken(
        &self,
        situation: &Situation,
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
            let (solved, turned) = self.turn(situation, &mut slides, resting).ok()?;
            let count = weak.len();
            let accelerated = self.accelerated_by(situation, &solved);
            weak.retain(|&c| turned != Some(c) && self.begins(&accelerated, &solved, c).is_some());
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
    pub(super) fn beyond(
        &self,
        situation: &Situation,
        trial: &[InterfaceMode],
        solved: &Solved,
        resting: &[usize],
    ) -> Option<(usize, [f64; 3])> {
        // What holds a contact may depend on other constraints, and then need not do what is asked of it.
        if !solved.balance.spread.stresses.is_empty() {
            if let Some((interface, way)) = self.gives_way(situation, solved)
                && resting.contains(&interface)
            {
                return Some((interface, way));
            }
            let held =
                resting.iter().filter(|&&interface| trial[interface] == InterfaceMode::Sticks);
            let accelerated = self.accelerated_by(situation, solved);
            let begins = |c: usize| self.begins(&accelerated, solved, c).map(|begins| (c, begins));
            let mut moving = held.filter_map(|&c| begins(c));
            if let Some(found) = moving.next() {
                return Some(found);
            }
        }
        let interfaces = self.interfaces(situation, trial, solved);
        let mut worst: Option<(f64, usize)> = None;
        for &interface in resting {
            if trial[interface] != InterfaceMode::Sticks {
                continue;
            }
            let now = &interfaces[interface];
            let (has, most) = (norm(now.friction), now.limit * situation.overload);
            let beyond = has - most * (1.0 + BEYOND);
            // Forces that are nothing but rounding exceed no limit.
            let size = solved.coupled.response.wrenches.iter().map(|w| w.force.norm());
            let rounding = 1e-13 * size.fold(0.0, f64::max);
            if beyond > rounding {
                let ratio = if most > 0.0 { has / most } else { f64::INFINITY };
                if worst.is_none_or(|(w, _)| ratio > w) {
                    worst = Some((ratio, interface));
                }
            }
        }
        worst.map(|(_, interface)| (interface, interfaces[interface].friction))
    }
}
