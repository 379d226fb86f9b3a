//! Friction and reactions together, with accelerations unknown.
//!
//! Unknown are the loads `N` of the contacts. All wrenches are affine in them, with the accelerations
//! that they cause, so `N = load(wrench(N))` is a small system for Newton's method.
//!
//! Equation (D3) of the book's theory.

use super::balance::{Balance, Response, Scene};
use super::rub::{Rub, load, most_change, wrench_of};
use crate::dynamics::radius_bound;
use crate::spatial::Wrench;
use nalgebra::{DMatrix, DVector};

/// Newton steps from one start.
const STEPS: usize = 30;
/// Loads are found when none changes by more than this part of the largest: the change is that of the
/// last step, what is left is its square.
const SETTLED: f64 = 1e-13;
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

/// The affine dependence on the loads.
pub(super) struct Coupling<'a> {
    scene: Scene<'a>,
    rubs: &'a [Rub],
    base: Response,
    /// Contacts whose load matters, with the response to one newton of it.
    active: Vec<(usize, Response)>,
}

impl<'a> Coupling<'a> {
    /// `efforts` are those of drives.
    pub(super) fn new(
        scene: Scene<'a>,
        balance: &Balance,
        rubs: &'a [Rub],
        efforts: &[(usize, Wrench<f64>)],
    ) -> Self {
        let contacts = &scene.parameters.contacts;
        let against = |contact: usize, part: [f64; 3]| {
            let content = &contacts[contact];
            let wrench = wrench_of(scene.topology, scene.bodies, content, part.map(|x| -x));
            (content.joint, wrench)
        };
        let mut known = efforts.to_vec();
        let mut active = Vec::new();
        for (contact, rub) in rubs.iter().enumerate() {
            if rub.known != [0.0; 3] {
                known.push(against(contact, rub.known));
            }
            if rub.per_load != [0.0; 3] {
                let unit = [against(contact, rub.per_load)];
                active.push((contact, balance.respond(&scene, &unit, false)));
            }
        }
        let base = balance.respond(&scene, &known, true);
        Self { scene, rubs, base, active }
    }

    fn load(&self, contact: usize, wrench: Wrench<f64>) -> crate::friction::Load<f64> {
        let Scene { parameters, bodies, .. } = self.scene;
        load(parameters, bodies, &parameters.contacts[contact], self.rubs[contact].own, wrench)
    }

    fn joint(&self, contact: usize) -> usize {
        self.scene.parameters.contacts[contact].joint
    }

    fn wrench(&self, joint: usize, loads: &DVector<f64>, part: f64) -> Wrench<f64> {
        let mut sum = self.base.wrenches[joint];
        for ((_, response), load) in self.active.iter().zip(loads.iter()) {
            sum += response.wrenches[joint] * (part * load);
        }
        sum
    }

    /// Loads at a part of the coefficients, near a start; none if they are not found or lie beyond a
    /// point where the determinant vanishes (`connected`).
    fn newton(
        &self,
        start: &DVector<f64>,
        part: f64,
        limit: f64,
        connected: bool,
    ) -> Option<DVector<f64>> {
        let count = self.active.len();
        let mut loads = start.clone();
        let mut before = f64::INFINITY;
        for _ in 0..STEPS {
            let states: Vec<_> = self
                .active
                .iter()
                .map(|&(contact, _)| {
                    self.load(contact, self.wrench(self.joint(contact), &loads, part))
                })
                .collect();
            let misfit = DVector::from_fn(count, |k, _| loads[k] - states[k].value);
            let matrix = DMatrix::from_fn(count, count, |k, l| {
                let joint = self.joint(self.active[k].0);
                let change = states[k].gradient.power(self.active[l].1.wrenches[joint]);
                f64::from(u8::from(k == l)) - part * change
            });
            let factored = matrix.lu();
            let change = factored.solve(&misfit)?;
            loads -= &change;
            let (size, largest) = (change.amax(), loads.amax());
            if !(size.is_finite() && largest < limit) {
                return None;
            }
            let done = size <= SETTLED * largest
                || (size >= before && size <= STAGNATED * largest)
                || largest == 0.0;
            if done {
                let kept = !connected || factored.determinant() > 0.0;
                return kept.then_some(loads);
            }
            before = size;
        }
        None
    }

    fn frictionless_loads(&self) -> DVector<f64> {
        DVector::from_fn(self.active.len(), |k, _| {
            let contact = self.active[k].0;
            self.load(contact, self.base.wrenches[self.joint(contact)]).value
        })
    }

    /// The solution near `known` loads (one for each contact) if there is one there, else the one that is
    /// connected with no friction.
    pub(super) fn solve(&self, known: Option<&[f64]>) -> Result<Coupled, Lost> {
        if self.active.is_empty() {
            return Ok(self.complete(&DVector::zeros(0)));
        }
        let start = self.frictionless_loads();
        let limit = UNBOUNDED * start.amax().max(f64::MIN_POSITIVE);
        let near = known.and_then(|known| {
            let near = DVector::from_fn(self.active.len(), |k, _| known[self.active[k].0]);
            self.newton(&near, 1.0, limit, true)
        });
        let loads = match near {
            Some(loads) => loads,
            None => self.follow(start, limit)?,
        };
        Ok(self.complete(&loads))
    }

    fn complete(&self, loads: &DVector<f64>) -> Coupled {
        let mut response = self.base.clone();
        for ((_, unit), load) in self.active.iter().zip(loads.iter()) {
            response.add(unit, *load);
        }
        let mut all: Vec<f64> = (0..self.rubs.len())
            .map(|contact| self.load(contact, response.wrenches[self.joint(contact)]).value)
            .collect();
        for ((contact, _), load) in self.active.iter().zip(loads.iter()) {
            all[*contact] = *load;
        }
        Coupled { response, loads: all }
    }

    fn follow(&self, start: DVector<f64>, limit: f64) -> Result<DVector<f64>, Lost> {
        let (mut loads, mut part, mut step) = (start.clone(), 0.0, FIRST_PART);
        while part < 1.0 {
            let next = f64::min(part + step, 1.0);
            if let Some(found) = self.newton(&loads, next, limit, true) {
                (loads, part) = (found, next);
                step *= 1.5;
                continue;
            }
            step *= 0.5;
            if step < SMALLEST_STEP {
                let growth = |k: &usize| loads[*k] / (start[*k] + 1e-12 * start.amax());
                let most = (0..loads.len()).max_by(|a, b| growth(a).total_cmp(&growth(b)));
                let contact = most.map_or(0, |k| self.active[k].0);
                return Err(Lost { part, contact });
            }
        }
        Ok(loads)
    }

    /// A bound on how strongly friction and loads are coupled: below one there is one solution and no
    /// other (Banach's theorem, as for inverse dynamics).
    pub(super) fn strength(&self) -> f64 {
        let Scene { parameters, bodies, .. } = self.scene;
        let count = self.active.len();
        let mut matrix = vec![0.0; count * count];
        for (i, (to, _)) in self.active.iter().enumerate() {
            let content = &parameters.contacts[*to];
            for (j, (_, response)) in self.active.iter().enumerate() {
                let change = response.wrenches[content.joint];
                let own = self.rubs[*to].own.coefficient;
                matrix[i * count + j] = most_change(parameters, bodies, content, own, change);
            }
        }
        radius_bound(&matrix, count, &mut Default::default())
    }

    /// Solutions from many starts, as far as they differ from the given one.
    pub(super) fn others(&self, known: &Coupled) -> Vec<Coupled> {
        let start = self.frictionless_loads();
        let size = start.amax().max(f64::MIN_POSITIVE);
        let mut found: Vec<Coupled> = Vec::new();
        let mut random = crate::random::Random::new(1);
        for k in 0..STARTS {
            let reach = size * 3f64.powi(k as i32 / 4 + 1);
            let from = DVector::from_fn(start.len(), |_, _| random.vector().x.abs() * reach);
            let Some(loads) = self.newton(&from, 1.0, UNBOUNDED * size, false) else { continue };
            let other = self.complete(&loads);
            let differs = |a: &Coupled| {
                let largest = a.loads.iter().chain(&other.loads).fold(0.0_f64, |m, x| m.max(*x));
                a.loads.iter().zip(&other.loads).any(|(x, y)| (x - y).abs() > SAME * largest)
            };
            if differs(known) && found.iter().all(differs) {
                found.push(other);
            }
        }
        found
    }
}
