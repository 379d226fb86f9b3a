//! The loads: Newton's method, near what is known or along growing coefficients of friction.

use super::fours::{blocks_of, pack, solve_in_place};
use super::{Coupled, Coupling, Site};
use crate::forward::balance::{Balance, Four, Scratch};
use crate::scalar::Scalar;
use crate::spatial::Twist;

/// Newton steps from one start.
const STEPS: usize = 30;
/// Loads are found when none changes by more than this part of the largest: the change is that of the
/// last step, what is left is about its square, rounding even where the system is close to singular.
const SETTLED: f64 = 1e-9;
/// What does not fall any more is rounding, below this.
const STAGNATED: f64 = 1e-10;
/// The first part of the coefficients, and the smallest step of them, where the solution is followed
/// from no friction.
const FIRST_PART: f64 = 0.1;
const SMALLEST_STEP: f64 = 1e-6;
/// Loads grown by this factor count as grown without bound.
pub(super) const UNBOUNDED: f64 = 1e9;

/// Friction has no acceleration for what acts: loads grow without bound on the way to the given
/// coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::forward) struct Lost {
    /// The part of the coefficients at which the solution is lost.
    pub(in crate::forward) part: f64,
    /// The contact whose load grows most.
    pub(in crate::forward) interface: usize,
}

/// Room for Newton's method.
#[derive(Clone, Debug, Default)]
pub(super) struct Room {
    loads: Vec<f64>,
    blocks: Vec<Four>,
    /// First what is missed, then the change.
    change: Vec<f64>,
    matrix: Vec<Four>,
    /// Bounds of how loads change each other.
    pub(super) changes: Vec<f64>,
    start: Vec<f64>,
    trial: Vec<f64>,
    pub(super) bounds: [Vec<f64>; 2],
}

impl Coupling {
    /// Loads at a part of the coefficients, near a start, which they replace; whether they are found and do not
    /// lie beyond a point where the determinant vanishes (`connected`).
    pub(super) fn newton(
        &self,
        site: Site<'_>,
        loads: &mut [f64],
        (part, limit): (f64, f64),
        connected: bool,
        room: &mut Room,
    ) -> bool {
        let width = blocks_of(self.active.len());
        let Room { blocks, change, matrix, .. } = room;
        let mut before = f64::INFINITY;
        for _ in 0..STEPS {
            pack(loads, blocks);
            change.clear();
            matrix.clear();
            matrix.resize(width * loads.len(), Four::zero());
            for (k, row) in matrix.chunks_exact_mut(width).enumerate() {
                let state = site.load(self.active[k], self.wrench(site, k, blocks, part));
                change.push(loads[k] - state.value);
                let Twist { angular, linear } = state.gradient;
                let slopes = [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z];
                for (slope, influence) in slopes.into_iter().zip(self.of_joint(k)) {
                    let slope = Four::from_f64(-part * slope);
                    row.iter_mut().zip(influence).for_each(|(m, u)| *m += slope * *u);
                }
                row[k / 4].0[k % 4] += 1.0;
            }
            let Some(positive) = solve_in_place(matrix, change) else { return false };
            loads.iter_mut().zip(&*change).for_each(|(load, change)| *load -= change);
            let (size, largest) = (greatest(change), greatest(loads));
            if !(size.is_finite() && largest < limit) {
                return false;
            }
            let done = size <= SETTLED * largest
                || (size >= before && size <= STAGNATED * largest)
                || largest == 0.0;
            if done {
                return !connected || positive;
            }
            before = size;
        }
        false
    }

    /// The solution near `known` loads (one for each contact) if there is one there, else the one that is
    /// connected with no friction.
    pub(in crate::forward) fn solve(
        &mut self,
        site: Site<'_>,
        balance: &Balance,
        known: Option<&[f64]>,
        scratch: &mut Scratch,
        coupled: &mut Coupled,
    ) -> Result<(), Lost> {
        let mut room = std::mem::take(&mut self.room);
        let found = self.find(site, known, &mut room);
        if found.is_ok() {
            self.complete(site, balance, &room.loads, scratch, coupled);
        }
        self.room = room;
        found
    }

    fn find(&self, site: Site<'_>, known: Option<&[f64]>, room: &mut Room) -> Result<(), Lost> {
        let mut loads = std::mem::take(&mut room.loads);
        loads.clear();
        let mut found = self.active.is_empty();
        if !found && let Some(known) = known {
            loads.extend(self.active.iter().map(|&interface| known[interface]));
            let limit = UNBOUNDED * greatest(&loads);
            found = self.newton(site, &mut loads, (1.0, limit), true, room);
        }
        let mut result = Ok(());
        if !found {
            let mut start = std::mem::take(&mut room.start);
            self.frictionless_loads(site, &mut start);
            let limit = UNBOUNDED * greatest(&start).max(f64::MIN_POSITIVE);
            result = self.follow(site, &start, limit, &mut loads, room);
            room.start = start;
        }
        room.loads = loads;
        result
    }

    /// From no friction to all of it.
    fn follow(
        &self,
        site: Site<'_>,
        start: &[f64],
        limit: f64,
        loads: &mut Vec<f64>,
        room: &mut Room,
    ) -> Result<(), Lost> {
        loads.clear();
        loads.extend_from_slice(start);
        let mut trial = std::mem::take(&mut room.trial);
        let (mut part, mut step) = (0.0, FIRST_PART);
        let mut result = Ok(());
        while part < 1.0 {
            let next = f64::min(part + step, 1.0);
            trial.clone_from(loads);
            if self.newton(site, &mut trial, (next, limit), true, room) {
                std::mem::swap(loads, &mut trial);
                part = next;
                step *= 1.5;
                continue;
            }
            step *= 0.5;
            if step < SMALLEST_STEP {
                let size = greatest(start);
                let growth = |k: &usize| loads[*k] / (start[*k] + 1e-12 * size);
                let most = (0..loads.len()).max_by(|a, b| growth(a).total_cmp(&growth(b)));
                let interface = most.map_or(0, |k| self.active[k]);
                result = Err(Lost { part, interface });
                break;
            }
        }
        room.trial = trial;
        result
    }
}

/// The largest magnitude; NaN where there is one.
pub(super) fn greatest(numbers: &[f64]) -> f64 {
    let nan = |a: f64, b: f64| a.is_nan() || b.is_nan();
    numbers.iter().fold(0.0_f64, |m, x| if nan(m, *x) { f64::NAN } else { m.max(x.abs()) })
}
