//! Limit of the preload of sticking mechanisms close to singular positions.

use super::verify::Verdict;
use crate::forward::Forward;
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::balance::reactions;
use crate::forward::data::{Data, KnownForces};
use crate::forward::instant::InterfaceSample;
use crate::forward::solve::Solved;
use crate::kinematics::Bodies;
use crate::spatial::Wrench;

/// Largest normal load that is accepted, relative to the largest normal load with the least
/// preload.
const GROWTH: f64 = 100.0;
/// Largest weight of reactions that is tried.
pub(super) const FIRST: f64 = 1e-2;
/// Ratio of a weight and the previous one. The preload grows at most by the inverse square of this
/// ratio, four.
const RATIO: f64 = 0.5;
/// Largest number of weights that are tried.
const TRIALS: usize = 30;

impl Forward {
    /// Replaces the least static frictions of a sticking mechanism by frictions with less preload
    /// if the normal loads are much larger than necessary.
    ///
    /// Close to a singular position, a tiny change of static friction changes the normal loads by
    /// many orders of magnitude, so frictions alone do not determine reasonable normal loads. But
    /// the frictions that hold the mechanism require a preload there, because their limits are
    /// proportional to the normal loads. Reactions are therefore added to the minimised sum, with
    /// the next smaller weight than the largest one for which all friction laws are satisfied. From
    /// then on, as in an elastic mechanism, the preload stays: reactions and frictions deviate as
    /// little as possible from this solution. `permanent` is the number of constraints that are
    /// redundant even if nothing sticks.
    pub(in crate::forward) fn limit_preload(
        &self,
        data: &mut Data,
        trial: &mut [InterfaceMode],
        (resting, permanent): (&[usize], usize),
        solved: Solved,
    ) -> Solved {
        if solved.balance.redundant() <= permanent {
            return solved;
        }
        let largest = |s: &Solved| s.coupled.loads.iter().fold(0.0_f64, |m, x| m.max(*x));
        let before = data.distribution.clone();
        data.distribution.refer_to_zero();
        data.distribution.reaction_weight = FIRST;
        let least = self.solve(data, trial, None, false);
        if least.is_ok_and(|least| largest(&solved) > GROWTH * largest(&least))
            && let Some(preloaded) = self.least_preload(data, trial, resting)
        {
            self.refer_to(data, trial, &preloaded);
            if let Ok(Verdict::Stands(preloaded)) = self.verify(data, trial, resting)
                && largest(&preloaded) < largest(&solved)
            {
                return *preloaded;
            }
        }
        data.distribution = before;
        solved
    }

    /// Searches for the largest weight of reactions with which all interfaces can stick, and
    /// returns the solution with the next smaller weight.
    fn least_preload(
        &self,
        data: &mut Data,
        trial: &mut [InterfaceMode],
        resting: &[usize],
    ) -> Option<Solved> {
        let mut found = None;
        let mut weight = FIRST;
        for _ in 0..TRIALS {
            data.distribution.reaction_weight = weight;
            weight *= RATIO;
            let verdict = self.verify(data, trial, resting);
            match (verdict, found.is_some()) {
                (Ok(Verdict::Stands(solved)), true) => return Some(*solved),
                (Ok(Verdict::Stands(solved)), false) => found = Some(*solved),
                (_, true) => break,
                (_, false) => {}
            }
        }
        found
    }

    /// Makes the frictions and reactions of a solution the references of the distribution.
    fn refer_to(&self, data: &mut Data, modes: &[InterfaceMode], solved: &Solved) {
        let mut interfaces = Vec::with_capacity(modes.len());
        self.interfaces_into(data, modes, solved, &mut interfaces);
        let sticks = |sample: &InterfaceSample| sample.interface == InterfaceMode::Sticks;
        let frictions =
            interfaces.iter().map(|i| if sticks(i) { i.friction } else { [0.0; 3] }).collect();
        let forces = self.known_forces(frictions, &data.bodies, &solved.coupled.response.wrenches);
        data.distribution.refer_to(&forces, FIRST);
    }

    /// Returns frictions, and the reactions that act together with them.
    pub(in crate::forward) fn known_forces(
        &self,
        frictions: Vec<[f64; 3]>,
        bodies: &Bodies<f64>,
        wrenches: &[Wrench<f64>],
    ) -> KnownForces {
        let mut numbers = Vec::new();
        reactions((self, bodies), wrenches, |number| numbers.push(number));
        KnownForces { frictions, reactions: numbers }
    }
}
