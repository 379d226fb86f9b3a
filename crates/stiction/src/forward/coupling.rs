//! Friction and reactions together, with accelerations unknown.
//!
//! Unknown are the loads `N` of the contacts. All wrenches are affine in them, with the accelerations
//! that they cause, so `N = load(wrench(N))` is a small system for Newton's method.
//!
//! Equation (D3) of the book's theory.

use super::balance::{Balance, Four, Response, Scene, Scratch};
use super::rub::{Rub, load, most_changes, wrench_of};
use crate::dynamics::radius_bound;
use crate::friction::Load;
use crate::scalar::Scalar;
use crate::spatial::{Twist, Vec3, Wrench};

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
const UNBOUNDED: f64 = 1e9;
/// Starts from which other solutions are looked for.
const STARTS: u32 = 24;
/// Solutions that differ by less than this part are one.
const SAME: f64 = 1e-7;

/// Friction has no acceleration for what acts: loads grow without bound on the way to the given
/// coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lost {
    /// The part of the coefficients at which the solution is lost.
    pub(super) part: f64,
    /// The contact whose load grows most.
    pub(super) contact: usize,
}

/// Accelerations and reactions with friction.
#[derive(Clone, Debug, Default)]
pub(super) struct Coupled {
    pub(super) response: Response,
    /// Of each contact, N.
    pub(super) loads: Vec<f64>,
}

/// Room for Newton's method.
#[derive(Clone, Debug, Default)]
struct Room {
    loads: Vec<f64>,
    blocks: Vec<Four>,
    /// First what is missed, then the change.
    change: Vec<f64>,
    matrix: Vec<Four>,
    /// Bounds of how loads change each other.
    changes: Vec<f64>,
    start: Vec<f64>,
    trial: Vec<f64>,
    bounds: [Vec<f64>; 2],
}

/// The affine dependence on the loads.
#[derive(Clone, Debug, Default)]
pub(super) struct Coupling {
    /// Efforts that do not depend on loads.
    known: Vec<(usize, Wrench<f64>)>,
    /// The response to these.
    base: Response,
    /// Contacts whose load matters.
    active: Vec<usize>,
    /// What one newton of their loads exerts.
    units: Vec<(usize, Wrench<f64>)>,
    /// For each of them the six components of its joint's wrench, force first, by one newton of each load; four loads
    /// to a block, the last filled up with zeros.
    influence: Vec<Four>,
    one: Response,
    all: Vec<(usize, Wrench<f64>)>,
    room: Room,
}

/// What the coupling is about.
#[derive(Clone, Copy)]
pub(super) struct Site<'a> {
    pub(super) scene: Scene<'a>,
    pub(super) rubs: &'a [Rub],
}

impl Site<'_> {
    fn load(&self, contact: usize, wrench: Wrench<f64>) -> Load<f64> {
        let Scene { parameters, bodies, .. } = self.scene;
        load(parameters, bodies, &parameters.contacts[contact], self.rubs[contact].own, wrench)
    }

    fn joint(&self, contact: usize) -> usize {
        self.scene.parameters.contacts[contact].joint
    }

    fn against(&self, contact: usize, part: [f64; 3]) -> (usize, Wrench<f64>) {
        let Scene { topology, parameters, bodies, .. } = self.scene;
        let content = &parameters.contacts[contact];
        (content.joint, wrench_of(topology, bodies, content, part.map(|x| -x)))
    }
}

impl Coupling {
    /// Makes it anew; `efforts` are those of drives.
    pub(super) fn update(
        &mut self,
        site: Site<'_>,
        balance: &Balance,
        efforts: &[(usize, Wrench<f64>)],
        scratch: &mut Scratch,
    ) {
        let Self { known, base, active, units, .. } = self;
        known.clear();
        known.extend_from_slice(efforts);
        active.clear();
        units.clear();
        for (contact, rub) in site.rubs.iter().enumerate() {
            if rub.known != [0.0; 3] {
                known.push(site.against(contact, rub.known));
            }
            if rub.per_load != [0.0; 3] {
                units.push(site.against(contact, rub.per_load));
                active.push(contact);
            }
        }
        balance.respond_into(&site.scene, known, true, scratch, base);
        let width = blocks_of(self.active.len());
        self.influence.clear();
        self.influence.resize(6 * self.active.len() * width, Four::zero());
        if !balance.spread.stresses.is_empty() {
            for l in 0..self.active.len() {
                let unit = [self.units[l]];
                balance.respond_into(&site.scene, &unit, false, scratch, &mut self.one);
                let Self { one, influence, .. } = self;
                note(site, &self.active, l, influence, |joint| one.wrenches[joint]);
            }
            return;
        }
        for (k, four) in self.units.chunks(4).enumerate() {
            let wrenches = balance.respond_to_four(&site.scene, four, scratch);
            for lane in 0..four.len() {
                note(site, &self.active, 4 * k + lane, &mut self.influence, |joint| {
                    let Wrench { force, moment } = wrenches[joint];
                    let of = |v: Vec3<Four>| Vec3::new(v.x.0[lane], v.y.0[lane], v.z.0[lane]);
                    Wrench { force: of(force), moment: of(moment) }
                });
            }
        }
    }

    /// The components of the wrench of the `k`-th contact's joint by each load.
    fn of_joint(&self, k: usize) -> impl Iterator<Item = &[Four]> {
        let width = blocks_of(self.active.len());
        self.influence[6 * width * k..6 * width * (k + 1)].chunks_exact(width)
    }

    /// What the joint of the `k`-th of these contacts bears where their loads are a part of these.
    fn wrench(&self, site: Site<'_>, k: usize, loads: &[Four], part: f64) -> Wrench<f64> {
        let mut sums = [0.0; 6];
        for (sum, row) in sums.iter_mut().zip(self.of_joint(k)) {
            let mut lanes = Four::zero();
            row.iter().zip(loads).for_each(|(u, load)| lanes += *u * *load);
            let [a, b, c, d] = lanes.0;
            *sum = part * ((a + b) + (c + d));
        }
        let [force, moment] = [0, 3].map(|i| Vec3::new(sums[i], sums[i + 1], sums[i + 2]));
        self.base.wrenches[site.joint(self.active[k])] + Wrench { force, moment }
    }

    /// Loads at a part of the coefficients, near a start, which they replace; whether they are found and do not
    /// lie beyond a point where the determinant vanishes (`connected`).
    fn newton(
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

    fn frictionless_loads(&self, site: Site<'_>, loads: &mut Vec<f64>) {
        loads.clear();
        loads.extend(
            self.active
                .iter()
                .map(|&contact| site.load(contact, self.base.wrenches[site.joint(contact)]).value),
        );
    }

    /// The solution near `known` loads (one for each contact) if there is one there, else the one that is
    /// connected with no friction.
    pub(super) fn solve(
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
            loads.extend(self.active.iter().map(|&contact| known[contact]));
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

    fn complete(
        &mut self,
        site: Site<'_>,
        balance: &Balance,
        loads: &[f64],
        scratch: &mut Scratch,
        coupled: &mut Coupled,
    ) {
        let Coupled { response, loads: found } = coupled;
        if self.active.is_empty() {
            response.clone_from(&self.base);
        } else {
            self.all.clone_from(&self.known);
            let units = self.units.iter().zip(loads);
            self.all.extend(units.map(|(&(joint, unit), load)| (joint, unit * *load)));
            balance.respond_into(&site.scene, &self.all, true, scratch, response);
        }
        found.clear();
        let mut active = self.active.iter().zip(loads).peekable();
        for contact in 0..site.rubs.len() {
            found.push(match active.next_if(|(next, _)| **next == contact) {
                Some((_, load)) => *load,
                None => site.load(contact, response.wrenches[site.joint(contact)]).value,
            });
        }
    }

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
                let contact = most.map_or(0, |k| self.active[k]);
                result = Err(Lost { part, contact });
                break;
            }
        }
        room.trial = trial;
        result
    }

    /// A bound on how strongly friction and loads are coupled: below one there is one solution and no
    /// other (Banach's theorem, as for inverse dynamics).
    pub(super) fn strength(&mut self, site: Site<'_>) -> f64 {
        let Scene { parameters, bodies, .. } = site.scene;
        let mut room = std::mem::take(&mut self.room);
        let Room { changes, bounds, .. } = &mut room;
        let count = self.active.len();
        changes.clear();
        for (k, &to) in self.active.iter().enumerate() {
            let content = &parameters.contacts[to];
            let own = site.rubs[to].own.coefficient;
            let mut rows: [&[Four]; 6] = [&[]; 6];
            rows.iter_mut().zip(self.of_joint(k)).for_each(|(row, of_joint)| *row = of_joint);
            let wrenches = (0..count).map(|l| {
                let [a, b, c, d, e, f] = rows.map(|row| row[l / 4].0[l % 4]);
                Wrench { force: Vec3::new(a, b, c), moment: Vec3::new(d, e, f) }
            });
            most_changes(parameters, bodies, content, own, wrenches, changes);
        }
        let bound = radius_bound(changes, count, bounds);
        self.room = room;
        bound
    }

    /// Solutions from many starts, as far as they differ from the given one.
    pub(super) fn others(
        &mut self,
        site: Site<'_>,
        balance: &Balance,
        known: &Coupled,
        scratch: &mut Scratch,
    ) -> Vec<Coupled> {
        let mut room = std::mem::take(&mut self.room);
        let mut start = Vec::new();
        self.frictionless_loads(site, &mut start);
        let size = greatest(&start).max(f64::MIN_POSITIVE);
        let mut found: Vec<Coupled> = Vec::new();
        let mut random = crate::random::Random::new(1);
        for k in 0..STARTS {
            let reach = size * 3f64.powi(k as i32 / 4 + 1);
            let mut loads: Vec<f64> =
                start.iter().map(|_| random.vector().x.abs() * reach).collect();
            let limit = UNBOUNDED * size;
            if !self.newton(site, &mut loads, (1.0, limit), false, &mut room) {
                continue;
            }
            let mut other = Coupled::default();
            self.complete(site, balance, &loads, scratch, &mut other);
            let differs = |a: &Coupled| {
                let largest = a.loads.iter().chain(&other.loads).fold(0.0_f64, |m, x| m.max(*x));
                a.loads.iter().zip(&other.loads).any(|(x, y)| (x - y).abs() > SAME * largest)
            };
            if differs(known) && found.iter().all(differs) {
                found.push(other);
            }
        }
        self.room = room;
        found
    }
}

/// How many blocks of four numbers hold so many.
fn blocks_of(count: usize) -> usize {
    count.div_ceil(4).max(1)
}

fn pack(numbers: &[f64], blocks: &mut Vec<Four>) {
    blocks.clear();
    let of = |chunk: &[f64]| Four::from_fn(|l| chunk.get(l).copied().unwrap_or(0.0));
    blocks.extend(numbers.chunks(4).map(of));
}

/// Writes down what one newton of the `l`-th load does to the joints of all.
fn note(
    site: Site<'_>,
    active: &[usize],
    l: usize,
    influence: &mut [Four],
    wrench: impl Fn(usize) -> Wrench<f64>,
) {
    let width = blocks_of(active.len());
    for (of_joint, &contact) in influence.chunks_exact_mut(6 * width).zip(active) {
        let Wrench { force, moment } = wrench(site.joint(contact));
        let components = [force.x, force.y, force.z, moment.x, moment.y, moment.z];
        for (row, component) in of_joint.chunks_exact_mut(width).zip(components) {
            row[l / 4].0[l % 4] = component;
        }
    }
}

/// The largest magnitude; NaN where there is one.
fn greatest(numbers: &[f64]) -> f64 {
    let nan = |a: f64, b: f64| a.is_nan() || b.is_nan();
    numbers.iter().fold(0.0_f64, |m, x| if nan(m, *x) { f64::NAN } else { m.max(x.abs()) })
}

/// Solves a small dense system in place, its rows in blocks of four and taken by their largest entries; whether the
/// determinant is positive, or nothing where the matrix is singular.
fn solve_in_place(matrix: &mut [Four], right: &mut [f64]) -> Option<bool> {
    let n = right.len();
    let width = blocks_of(n);
    let mut positive = true;
    for k in 0..n {
        let (block, lane) = (k / 4, k % 4);
        let mut best = (k, matrix[k * width + block].0[lane].abs());
        for row in k + 1..n {
            let size = matrix[row * width + block].0[lane].abs();
            if size > best.1 {
                best = (row, size);
            }
        }
        if best.0 != k {
            for column in block..width {
                matrix.swap(k * width + column, best.0 * width + column);
            }
            right.swap(k, best.0);
            positive = !positive;
        }
        let (above, below) = matrix.split_at_mut((k + 1) * width);
        let row = &above[k * width + block..];
        let pivot = row[0].0[lane];
        if pivot == 0.0 || pivot.is_nan() {
            return None;
        }
        positive ^= pivot < 0.0;
        let (solved, rest) = right.split_at_mut(k + 1);
        for (other, right) in below.chunks_exact_mut(width).zip(rest) {
            let other = &mut other[block..];
            // What stands before the pivot in its block is not read again.
            let amount = other[0].0[lane] / pivot;
            let amounts = Four::from_f64(amount);
            other.iter_mut().zip(row).for_each(|(x, r)| *x -= amounts * *r);
            *right -= amount * solved[k];
        }
    }
    for k in (0..n).rev() {
        let row = &matrix[k * width..(k + 1) * width];
        let mut sum = right[k];
        for (l, x) in right.iter().enumerate().skip(k + 1) {
            sum -= row[l / 4].0[l % 4] * x;
        }
        right[k] = sum / row[k / 4].0[k % 4];
    }
    Some(positive)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn small_systems_are_solved(
            numbers in prop::collection::vec(-1.0..1.0_f64, 25),
            wanted in prop::collection::vec(-1.0..1.0_f64, 5),
        ) {
            let matrix = DMatrix::from_row_slice(5, 5, &numbers);
            let right = &matrix * DVector::from_column_slice(&wanted);
            let determinant = matrix.determinant();
            prop_assume!(determinant.abs() > 1e-3);
            let (mut work, mut found) = (Vec::new(), right.as_slice().to_vec());
            for row in numbers.chunks(5) {
                let mut blocks = Vec::new();
                pack(row, &mut blocks);
                work.extend(blocks);
            }
            prop_assert_eq!(solve_in_place(&mut work, &mut found), Some(determinant > 0.0));
            prop_assert!(found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-10));
        }
    }
}
