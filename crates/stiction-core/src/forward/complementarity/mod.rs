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

mod alone;
mod laws;
mod newton;
mod problem;
mod residual;
mod sweep;

pub(super) use laws::{Dry, Kind, Smooth};
pub(super) use problem::{Cone, Member};

use super::affine_friction::{InterfaceMode, norm};

/// Laws hold to this part of the largest force.
const SETTLED: f64 = 1e-12;
/// Sweeps before Newton's method is tried first; each time it fails there are more of them.
const SWEEPS: usize = 40;
const ROUNDS: usize = 6;
/// What rates are multiplied by in Newton's method, one after the other, as multiples of what suits the
/// lightest direction of each member: rods between balls spin more easily than they swing, by far.
const STIFFNESSES: [f64; 3] = [1.0, 30.0, 1000.0];
/// The first step of the coefficients, and the smallest, where the solution is followed from none.
const FIRST_PART: f64 = 0.1;
const SMALLEST_PART: f64 = 1e-4;

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

impl Cone<'_> {
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
        worst.map(|member| member.interface)
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

/// What a member of dry friction does where its rates and frictions are these: it slides where its rate is
/// more than `none`.
pub(super) fn mode_of(rates: &[f64], none: f64) -> InterfaceMode {
    let mut begins = [0.0; 3];
    begins[..rates.len()].copy_from_slice(rates);
    let rate = norm(begins);
    if rate > none {
        InterfaceMode::AtLimit(begins.map(|a| a / rate))
    } else {
        InterfaceMode::Sticks
    }
}
