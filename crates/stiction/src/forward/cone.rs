//! Frictions of many contacts that satisfy all laws at once, each bounded by its own contact's load.
//!
//! Unknown are frictions `f` at the surfaces. Rates `b` of the surfaces (accelerations, or velocities at
//! the end of a step) and all loads `N` are affine in them but for the loads' own norms. A dry contact
//! has
//!
//! ```text
//! f = the nearest to (f + rho b) with |f| <= mu N(f)
//! ```
//!
//! which says all of Coulomb's law: it holds within its limit where it does not slide, it is at its limit
//! and against the sliding where it does. Balls and plates have three components, others one.
//!
//! First contact by contact (projected Gauss-Seidel), which goes downhill from anywhere but slowly, then
//! all at once by Newton's method on the nonsmooth equations (Alart and Curnier 1991), which is fast near
//! a solution. Steps are the shortest where self-stresses leave frictions open, so what is found is near
//! where it began. Where both fail the solution is followed from no friction.
//!
//! Equation (D5) of the book's theory.

use super::balance::Response;
use super::rub::{Contact, load, norm};
use crate::friction::OwnFriction;
use crate::kinematics::Bodies;
use crate::linalg::RowSpace;
use crate::parameters::Parameters;
use crate::spatial::Wrench;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// Laws hold to this part of the largest force.
pub(super) const SETTLED: f64 = 1e-12;
/// What does not get better than this is rounding.
const STAGNATED: f64 = 1e-9;
/// Sweeps before Newton's method is tried first; each time it fails there are more of them.
const SWEEPS: usize = 40;
const ROUNDS: usize = 6;
const NEWTON: usize = 40;
const HALVINGS: usize = 10;
/// What rates are multiplied by in Newton's method, one after the other, as multiples of what suits the
/// lightest direction of each member: rods between balls spin more easily than they swing, by far.
const STIFFNESSES: [f64; 3] = [1.0, 30.0, 1000.0];
/// Rows of Newton's matrix that add less than this depend on others.
const DEPENDENT: f64 = 1e-11;
/// Rates below this part of the largest without friction are rounding.
const ROUNDING: f64 = 1e-14;
/// The first step of the coefficients, and the smallest, where the solution is followed from none.
const FIRST_PART: f64 = 0.1;
const SMALLEST_PART: f64 = 1e-4;

/// What kind of law a member obeys.
#[derive(Clone, Debug)]
pub(super) enum Kind {
    /// Dry friction with these coefficients for the two senses, and what is viscous, N s/m.
    Dry { forward: f64, backward: f64, viscous: f64 },
    /// It slides for sure: the unknown is its load, what it does is in its unit.
    Slides(OwnFriction<f64>),
    /// A smooth law of the rate.
    Smooth(Box<dyn Smooth>),
}

/// Friction as a smooth function of the sliding velocity.
pub(super) trait Smooth: std::fmt::Debug {
    /// Friction at the surface under a load.
    fn friction(&self, load: f64, velocity: [f64; 3]) -> [f64; 3];
    fn boxed(&self) -> Box<dyn Smooth>;
}

impl Clone for Box<dyn Smooth> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// One contact.
#[derive(Clone, Debug)]
pub(super) struct Member {
    pub(super) contact: usize,
    /// Its unknowns.
    pub(super) places: Range<usize>,
    pub(super) kind: Kind,
}

/// The problem.
pub(super) struct Cone<'a> {
    pub(super) parameters: &'a Parameters<f64>,
    pub(super) bodies: &'a Bodies<f64>,
    pub(super) members: Vec<Member>,
    /// Of each unknown the rate where none of them acts; not read for those that slide.
    pub(super) free: Vec<f64>,
    /// Row by row: by how much each rate changes with each unknown.
    pub(super) change: Vec<f64>,
    /// The wrench of each member's joint where none of them acts.
    pub(super) base: Vec<Wrench<f64>>,
    /// Row by row: by how much the wrench of each member's joint changes with each unknown.
    pub(super) push: Vec<Wrench<f64>>,
    /// Rates of what holds may be missed by this inverse factor more than forces; none may where it is
    /// infinite.
    pub(super) slack: f64,
    /// Of members with several components, how they alone change their own rates.
    own: Vec<Option<Own>>,
    /// What rates are multiplied by, as a multiple of the usual.
    stiffness: f64,
}

/// The block of one member: `rates = free - V diag(values) V^T friction`, `V` orthogonal.
struct Own {
    vectors: Matrix3<f64>,
    values: Vector3<f64>,
}

impl Own {
    fn of(change: &[f64], places: &Range<usize>, n: usize) -> Self {
        let count = places.len();
        let entry = |i: usize, j: usize| match (i < count, j < count) {
            (true, true) => -change[(places.start + i) * n + places.start + j],
            _ => 0.0,
        };
        // Symmetric but for rounding.
        let block = Matrix3::from_fn(|i, j| 0.5 * (entry(i, j) + entry(j, i)));
        let eigen = block.symmetric_eigen();
        let least = 1e-13 * eigen.eigenvalues.amax();
        let values = eigen.eigenvalues.map(|value| if value > least { value } else { 0.0 });
        Self { vectors: eigen.eigenvectors, values }
    }

    /// Coulomb's law of this member alone: friction `g`, at most `most`, where the rate without any of it is
    /// `free`; near `before` where it holds.
    fn settle(&self, free: [f64; 3], most: f64, viscous: f64, before: [f64; 3]) -> [f64; 3] {
        if most <= 0.0 {
            return [0.0; 3];
        }
        // With viscous friction, too, rates are less and harder to change.
        let less = self.values.map(|w| 1.0 / (1.0 + viscous * w));
        let values = self.values.component_mul(&less);
        let free = (self.vectors.transpose() * Vector3::from(free)).component_mul(&less);
        let before = self.vectors.transpose() * Vector3::from(before);
        let holding = Vector3::from_fn(|k, _| match values[k] {
            0.0 => before[k],
            w => free[k] / w,
        });
        let bounded = |g: Vector3<f64>| g.norm() <= most;
        let none = values.iter().zip(free.iter()).all(|(w, b)| *w > 0.0 || *b == 0.0);
        if none && bounded(holding) {
            return (self.vectors * holding).into();
        }
        // It slides at the speed `x` in the direction `d`: `(x + most W) d = free`.
        let along = |x: f64| {
            Vector3::from_fn(|k, _| {
                let by = x + most * values[k];
                if by > 0.0 { free[k] / by } else { 0.0 }
            })
        };
        let (mut low, mut high) = (0.0, free.norm());
        if along(0.0).norm() > 1.0 || !none {
            for _ in 0..200 {
                let middle = if low > 0.0 { (low * high).sqrt() } else { 1e-3 * high };
                if !(middle > low && middle < high) || high < 1e-300 || high - low <= 1e-15 * high {
                    break;
                }
                if along(middle).norm() > 1.0 { low = middle } else { high = middle }
            }
        } else {
            high = 0.0;
        }
        (self.vectors * (along(high) * most)).into()
    }
}

/// What was found.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// Frictions at the surfaces, and loads of what slides.
    pub(super) amounts: Vec<f64>,
    /// Rates of the surfaces.
    pub(super) rates: Vec<f64>,
    /// Of each member.
    pub(super) loads: Vec<f64>,
    /// By how much the laws are missed at most, as part of the largest force.
    pub(super) missed: f64,
    /// Whether each member holds.
    pub(super) holds: Vec<bool>,
}

struct Residual {
    values: Vec<f64>,
    scale: f64,
    /// The rates of what holds as part of the largest, times the slack; of all else infinite.
    rates: Vec<f64>,
    holds: Vec<bool>,
}

impl Residual {
    fn square(&self) -> f64 {
        self.values.iter().map(|x| x * x).sum()
    }
    fn missed(&self) -> f64 {
        let each = self.values.iter().zip(&self.rates);
        let worst = each.fold(0.0_f64, |m, (x, rate)| m.max(x.abs().min(rate * self.scale)));
        let sound = self.values.iter().all(|x| x.is_finite()) && self.scale.is_finite();
        if !sound {
            f64::INFINITY
        } else if worst == 0.0 {
            0.0
        } else {
            worst / self.scale
        }
    }
}

impl<'a> Cone<'a> {
    pub(super) fn new(
        parameters: &'a Parameters<f64>,
        bodies: &'a Bodies<f64>,
        members: Vec<Member>,
        free: Vec<f64>,
        change: Vec<f64>,
        (base, units): (&Response, &[Response]),
    ) -> Self {
        let joint = |member: &Member| parameters.contacts[member.contact].joint;
        let push = members
            .iter()
            .flat_map(|member| units.iter().map(move |unit| unit.wrenches[joint(member)]))
            .collect();
        let base = members.iter().map(|member| base.wrenches[joint(member)]).collect();
        let slack = f64::INFINITY;
        let n = free.len();
        let own = |member: &Member| {
            let dry = matches!(member.kind, Kind::Dry { .. });
            (dry && member.places.len() > 1).then(|| Own::of(&change, &member.places, n))
        };
        let own = members.iter().map(own).collect();
        Self { parameters, bodies, members, free, change, base, push, slack, own, stiffness: 1.0 }
    }

    fn count(&self) -> usize {
        self.free.len()
    }

    fn rates(&self, amounts: &[f64]) -> Vec<f64> {
        let n = self.count();
        let each = self.free.iter().zip(self.change.chunks_exact(n.max(1)));
        each.map(|(free, row)| free + row.iter().zip(amounts).map(|(a, b)| a * b).sum::<f64>())
            .collect()
    }

    fn wrench(&self, member: usize, amounts: &[f64]) -> Wrench<f64> {
        let n = self.count();
        let push = &self.push[member * n..(member + 1) * n];
        let mut sum = self.base[member];
        for (unit, amount) in push.iter().zip(amounts) {
            sum += *unit * *amount;
        }
        sum
    }

    fn load(
        &self,
        member: usize,
        amounts: &[f64],
        wrench: Wrench<f64>,
    ) -> crate::friction::Load<f64> {
        let Member { contact, places, kind } = &self.members[member];
        let own = match kind {
            Kind::Slides(own) => *own,
            _ => {
                let friction = amounts[places.start];
                OwnFriction {
                    coefficient: 0.0,
                    viscous: friction.abs(),
                    direction: friction.signum(),
                }
            }
        };
        load(self.parameters, self.bodies, &self.parameters.contacts[*contact], own, wrench)
    }

    /// What rates are multiplied by, for numbers of the size of forces.
    fn softness(&self, places: &Range<usize>) -> f64 {
        let n = self.count();
        let stiffness: f64 = places.clone().map(|i| -self.change[i * n + i]).sum();
        if stiffness > 0.0 { self.stiffness / stiffness } else { 0.0 }
    }

    /// How the laws are missed, coefficients of friction being `part` of their values; and how that
    /// changes with the unknowns.
    fn residual(&self, x: &[f64], part: f64, mut matrix: Option<&mut Vec<f64>>) -> Residual {
        let n = self.count();
        let mut rates = self.rates(x);
        // Rates that are rounding are none: short steps would make large forces of them.
        let largest = self.free.iter().fold(0.0_f64, |m, rate| m.max(rate.abs()));
        rates.iter_mut().filter(|rate| rate.abs() < ROUNDING * largest).for_each(|r| *r = 0.0);
        let mut values = vec![0.0; n];
        let mut slow = vec![f64::INFINITY; n];
        let mut all_hold = vec![false; self.members.len()];
        let mut scale = x.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
        if let Some(matrix) = matrix.as_deref_mut() {
            matrix.clear();
            matrix.resize(n * n, 0.0);
        }
        for (index, member) in self.members.iter().enumerate() {
            let places = member.places.clone();
            let count = places.len();
            let load = self.load(index, x, self.wrench(index, x));
            let push = &self.push[index * n..(index + 1) * n];
            let with_load = |j: usize| load.gradient.power(push[j]);
            match &member.kind {
                Kind::Slides(_) => {
                    // Its unit is that of the full coefficient.
                    let i = places.start;
                    scale = scale.max(load.value.abs());
                    values[i] = x[i] - part * load.value;
                    if let Some(matrix) = matrix.as_deref_mut() {
                        for j in 0..n {
                            matrix[i * n + j] = f64::from(u8::from(i == j)) - part * with_load(j);
                        }
                    }
                }
                Kind::Smooth(law) => {
                    let mut velocity = [0.0; 3];
                    velocity[..count].copy_from_slice(&rates[places.clone()]);
                    let at = |load: f64, v: [f64; 3]| law.friction(load, v).map(|f| part * f);
                    let friction = at(load.value, velocity);
                    let unit = at(load.value + 1.0, velocity);
                    for (k, i) in places.clone().enumerate() {
                        values[i] = x[i] - friction[k];
                    }
                    let Some(matrix) = matrix.as_deref_mut() else { continue };
                    let step = 1e-7 * norm(velocity).max(1e-6);
                    let mut slope = [[0.0; 3]; 3];
                    for m in 0..count {
                        let (mut ahead, mut behind) = (velocity, velocity);
                        ahead[m] += step;
                        behind[m] -= step;
                        let (ahead, behind) = (at(load.value, ahead), at(load.value, behind));
                        for k in 0..count {
                            slope[k][m] = (ahead[k] - behind[k]) / (2.0 * step);
                        }
                    }
                    for (k, i) in places.clone().enumerate() {
                        for j in 0..n {
                            let mut entry = f64::from(u8::from(i == j));
                            for (m, from) in places.clone().enumerate() {
                                entry -= slope[k][m] * self.change[from * n + j];
                            }
                            entry -= (unit[k] - friction[k]) * with_load(j);
                            matrix[i * n + j] = entry;
                        }
                    }
                }
                Kind::Dry { forward, backward, viscous } => {
                    let softness = self.softness(&places);
                    let mut dry = [0.0; 3];
                    let mut tried = [0.0; 3];
                    for (k, i) in places.clone().enumerate() {
                        dry[k] = x[i] - viscous * rates[i];
                        tried[k] = dry[k] + softness * rates[i];
                    }
                    let coefficient = part * if tried[0] < 0.0 { backward } else { forward };
                    let most = coefficient * load.value;
                    scale = scale.max(most.abs());
                    let size = norm(tried);
                    let holds = size <= most;
                    all_hold[index] = holds;
                    for (k, i) in places.clone().enumerate() {
                        if holds && largest > 0.0 {
                            let part = rates[i].abs() / largest;
                            slow[i] = if part > 0.0 { self.slack * part } else { 0.0 };
                        }
                        values[i] = if holds {
                            -softness * rates[i]
                        } else if most > 0.0 {
                            dry[k] - most * tried[k] / size
                        } else {
                            dry[k]
                        };
                    }
                    let Some(matrix) = matrix.as_deref_mut() else { continue };
                    for j in 0..n {
                        let rate = |i: usize| self.change[i * n + j];
                        let own = |i: usize| f64::from(u8::from(i == j)) - viscous * rate(i);
                        if holds {
                            for i in places.clone() {
                                matrix[i * n + j] = -softness * rate(i);
                            }
                            continue;
                        }
                        if most <= 0.0 {
                            for i in places.clone() {
                                matrix[i * n + j] = own(i);
                            }
                            continue;
                        }
                        let along: f64 = places
                            .clone()
                            .enumerate()
                            .map(|(k, i)| tried[k] / size * (own(i) + softness * rate(i)))
                            .sum();
                        let grows = coefficient * with_load(j);
                        for (k, i) in places.clone().enumerate() {
                            let unit = tried[k] / size;
                            let across = own(i) + softness * rate(i) - unit * along;
                            matrix[i * n + j] = own(i) - grows * unit - most / size * across;
                        }
                    }
                }
            }
        }
        Residual { values, scale, rates: slow, holds: all_hold }
    }

    /// Contact by contact, the rates and loads following.
    fn sweep(&self, x: &mut [f64], part: f64, sweeps: usize) {
        let n = self.count();
        let mut rates = self.rates(x);
        let mut wrenches: Vec<Wrench<f64>> =
            (0..self.members.len()).map(|m| self.wrench(m, x)).collect();
        for _ in 0..sweeps {
            let mut change = 0.0_f64;
            for (index, member) in self.members.iter().enumerate() {
                let places = member.places.clone();
                let count = places.len();
                let load = self.load(index, x, wrenches[index]).value;
                let softness = self.softness(&places);
                let mut next = [0.0; 3];
                match &member.kind {
                    Kind::Slides(_) => next[0] = part * load,
                    Kind::Dry { forward, backward, viscous } => {
                        let more = softness + viscous;
                        if let Some(own) = &self.own[index] {
                            // All of its components at once: inertias may differ by orders of magnitude.
                            let (mut free, mut before) = ([0.0; 3], [0.0; 3]);
                            for (k, i) in places.clone().enumerate() {
                                free[k] = rates[i];
                                for j in places.clone() {
                                    free[k] -= self.change[i * n + j] * x[j];
                                }
                                before[k] = x[i] - viscous * rates[i];
                            }
                            let most = (part * forward * load).max(0.0);
                            let dry = own.settle(free, most, *viscous, before);
                            // `rate = (1 + viscous W)^-1 (free - W dry)`.
                            let vectors = &own.vectors;
                            let (free, dry) = (Vector3::from(free), Vector3::from(dry));
                            let (f, d) = (vectors.transpose() * free, vectors.transpose() * dry);
                            let rate = Vector3::from_fn(|k, _| {
                                let w = own.values[k];
                                (f[k] - w * d[k]) / (1.0 + viscous * w)
                            });
                            next = (dry + vectors * rate * *viscous).into();
                        } else {
                            for (k, i) in places.clone().enumerate() {
                                next[k] = x[i] - viscous * rates[i] + more * rates[i];
                            }
                            let coefficient = part * if next[0] < 0.0 { backward } else { forward };
                            let most = (coefficient * load).max(0.0);
                            let size = norm(next);
                            if size > most {
                                next = next.map(|f| f * (most / size));
                            }
                            if *viscous > 0.0 && softness > 0.0 {
                                for (k, i) in places.clone().enumerate() {
                                    // Where none of its friction acts the rate is this.
                                    let free = rates[i] + x[i] / softness;
                                    let rate =
                                        (free - next[k] / softness) / (1.0 + viscous / softness);
                                    next[k] += viscous * rate;
                                }
                            }
                        }
                    }
                    Kind::Smooth(law) => {
                        let mut free = [0.0; 3];
                        let mut velocity = [0.0; 3];
                        for (k, i) in places.clone().enumerate() {
                            velocity[k] = rates[i];
                            free[k] = rates[i] + if softness > 0.0 { x[i] / softness } else { 0.0 };
                        }
                        next =
                            settle(&**law, part * load.max(0.0), free, softness, velocity, count);
                    }
                }
                for (k, i) in places.clone().enumerate() {
                    let by = next[k] - x[i];
                    if by == 0.0 {
                        continue;
                    }
                    x[i] = next[k];
                    change = change.max(by.abs());
                    for (rate, row) in rates.iter_mut().zip(self.change.chunks_exact(n)) {
                        *rate += row[i] * by;
                    }
                    for (wrench, push) in wrenches.iter_mut().zip(self.push.chunks_exact(n)) {
                        *wrench += push[i] * by;
                    }
                }
            }
            let largest = x.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
            if change <= 1e-3 * SETTLED * largest || !change.is_finite() {
                break;
            }
        }
    }

    /// Newton's method; whether it ends at a solution.
    fn newton(&self, x: &mut Vec<f64>, part: f64) -> bool {
        let n = self.count();
        let (mut matrix, mut space) = (Vec::new(), RowSpace::default());
        let mut now = self.residual(x, part, Some(&mut matrix));
        for _ in 0..NEWTON {
            if now.missed() <= SETTLED {
                return true;
            }
            if !now.missed().is_finite() || matrix.iter().any(|x| !x.is_finite()) {
                return false;
            }
            space.decompose(&matrix, n, n, DEPENDENT);
            let step = space.shortest(&now.values);
            let mut better = None;
            let mut by = 1.0;
            for _ in 0..HALVINGS {
                let trial: Vec<f64> = x.iter().zip(&step).map(|(x, s)| x - by * s).collect();
                let there = self.residual(&trial, part, None);
                if there.square() < (1.0 - 0.1 * by) * now.square() {
                    better = Some(trial);
                    break;
                }
                by *= 0.5;
            }
            let Some(trial) = better else { return now.missed() <= STAGNATED };
            *x = trial;
            now = self.residual(x, part, Some(&mut matrix));
        }
        now.missed() <= STAGNATED
    }

    /// Frictions that satisfy all laws with this part of the coefficients, from a start; none where none
    /// are found.
    pub(super) fn solve(&mut self, start: &[f64], part: f64) -> Option<Found> {
        if self.count() == 0 {
            return Some(self.complete(Vec::new(), part));
        }
        let mut x = start.to_vec();
        let mut found = self.newton_from(&x, part);
        for round in 0..ROUNDS {
            if found.is_some() {
                break;
            }
            self.sweep(&mut x, part, SWEEPS << round);
            if x.iter().any(|x| !x.is_finite()) {
                break;
            }
            found = self.newton_from(&x, part);
        }
        let x = match found {
            Some(x) => x,
            None => self.follow(part)?,
        };
        Some(self.complete(x, part))
    }

    /// The contact whose law is missed most where going contact by contact ends, if any is.
    pub(super) fn worst(&self, start: &[f64]) -> Option<usize> {
        let mut x = start.to_vec();
        self.sweep(&mut x, 1.0, 4 * SWEEPS);
        if x.iter().any(|x| !x.is_finite()) {
            x.fill(0.0);
        }
        let values = self.residual(&x, 1.0, None).values;
        let missed = |member: &&Member| {
            values[member.places.clone()].iter().fold(0.0_f64, |m, v| m.max(v.abs()))
        };
        let worst = self.members.iter().max_by(|a, b| missed(a).total_cmp(&missed(b)));
        worst.map(|member| member.contact)
    }

    /// Newton's method from a start with one stiffness after the other.
    fn newton_from(&mut self, start: &[f64], part: f64) -> Option<Vec<f64>> {
        let mut found = None;
        for stiffness in STIFFNESSES {
            self.stiffness = stiffness;
            let mut trial = start.to_vec();
            if self.newton(&mut trial, part) && trial.iter().all(|x| x.is_finite()) {
                found = Some(trial);
                break;
            }
        }
        self.stiffness = 1.0;
        found
    }

    /// From no friction to all of it.
    fn follow(&self, part: f64) -> Option<Vec<f64>> {
        let mut x = vec![0.0; self.count()];
        let (mut reached, mut step) = (0.0, FIRST_PART);
        while reached < 1.0 {
            let next = f64::min(reached + step, 1.0);
            let mut trial = x.clone();
            let mut found = self.newton(&mut trial, next * part);
            if !found {
                trial.clone_from(&x);
                self.sweep(&mut trial, next * part, 4 * SWEEPS);
                found = self.newton(&mut trial, next * part);
            }
            if found && trial.iter().all(|x| x.is_finite()) {
                (x, reached) = (trial, next);
                step *= 1.5;
                continue;
            }
            step *= 0.5;
            if step < SMALLEST_PART {
                return None;
            }
        }
        Some(x)
    }

    fn complete(&self, amounts: Vec<f64>, part: f64) -> Found {
        let residual = self.residual(&amounts, part, None);
        let missed = residual.missed();
        let rates = self.rates(&amounts);
        let loads = (0..self.members.len())
            .map(|m| self.load(m, &amounts, self.wrench(m, &amounts)).value)
            .collect();
        Found { amounts, rates, loads, missed, holds: residual.holds }
    }
}

/// Friction of a smooth law where the velocity is `free - friction / softness`.
fn settle(
    law: &dyn Smooth,
    load: f64,
    free: [f64; 3],
    softness: f64,
    start: [f64; 3],
    count: usize,
) -> [f64; 3] {
    if softness <= 0.0 {
        return law.friction(load, start);
    }
    // The friction grows with the velocity, so half of the change is always a step forward.
    let mut velocity = start;
    let mut damping = 1.0;
    let mut before = f64::INFINITY;
    for _ in 0..30 {
        let friction = law.friction(load, velocity);
        let mut off = [0.0; 3];
        for k in 0..count {
            off[k] = velocity[k] - free[k] + friction[k] / softness;
        }
        let size = norm(off);
        if size <= 1e-12 * norm(free) {
            break;
        }
        // The slope along the error.
        let step = 1e-6 * size;
        let ahead = law.friction(load, [0, 1, 2].map(|k| velocity[k] + step * off[k] / size));
        let slope: f64 = (0..count).map(|k| (ahead[k] - friction[k]) / step * off[k] / size).sum();
        if size > before {
            damping *= 0.5;
        }
        before = size;
        let by = damping / (1.0 + slope.max(0.0) / softness);
        for k in 0..count {
            velocity[k] -= by * off[k];
        }
    }
    let mut friction = [0.0; 3];
    for k in 0..count {
        friction[k] = (free[k] - velocity[k]) * softness;
    }
    friction
}

/// What a member of dry friction does where its rates and frictions are these: it slides where its rate is
/// more than `none`.
pub(super) fn mode_of(rates: &[f64], none: f64) -> Contact {
    let mut begins = [0.0; 3];
    begins[..rates.len()].copy_from_slice(rates);
    let rate = norm(begins);
    if rate > none { Contact::AtLimit(begins.map(|a| a / rate)) } else { Contact::Sticks }
}
