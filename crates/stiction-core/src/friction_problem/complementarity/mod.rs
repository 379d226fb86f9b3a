//! Friction at several interfaces that must satisfy all friction laws simultaneously: a nonlinear
//! complementarity problem.
//!
//! The unknowns are the friction forces `f` at the surfaces. The surface rates `b` (accelerations,
//! or velocities after a time step) and the joint wrenches are affine in `f`; the normal loads `N`
//! are norms of the wrenches. A dry interface satisfies
//!
//! ```text
//! f = projection of (f + rho b) onto |f| <= mu N(f)
//! ```
//!
//! with a positive factor `rho`. This equation is Coulomb's law: friction is within its limit if
//! the interface sticks; if it slides, friction equals the limit and opposes the slip. Balls and
//! plates have three components of `f`, other interfaces have one.
//!
//! The projected Gauss-Seidel method solves one interface after the other; it converges from any
//! start, but slowly. Newton's method on the nonsmooth equations (Alart and Curnier 1991) converges
//! fast near a solution. If self-stresses leave friction indeterminate, Newton steps have minimum
//! norm, so that the method finds a solution near the start. If both methods fail, continuation
//! increases the friction coefficients from zero, or follows a path from large coefficients, with which
//! everything sticks.
//!
//! Equation (D5) of the book's theory.

mod laws;
mod local;
mod newton;
mod path;
mod problem;
mod projection;
mod residual;

pub(crate) use laws::{DryFriction, MemberLaw, SmoothFriction};
use problem::Scaling;
pub(crate) use problem::{Complementarity, Member};

use super::continuation::{self, Branch, StepPolicy};

/// The iteration has converged if the residual of the friction laws, relative to the largest force,
/// is at most this value.
const SETTLED: f64 = 1e-12;
/// Number of Gauss-Seidel sweeps over all interfaces before Newton's method is tried again. The
/// number doubles after each failure.
const SWEEPS: usize = 40;
/// Largest number of alternations between Gauss-Seidel sweeps and Newton's method.
const ROUNDS: usize = 6;
/// Scalings of the surface rates that Newton's method tries, in this order. The effective mass of a
/// member is that of its lightest direction. Larger multiples are tried as well, because the
/// effective masses in different directions may differ: a rod between balls spins far more easily
/// than it swings.
const SCALINGS: [Scaling; 4] = [
    Scaling::EffectiveMass(1.0),
    Scaling::ForcePerRate,
    Scaling::EffectiveMass(30.0),
    Scaling::EffectiveMass(1000.0),
];
/// Step sizes of the continuation from zero to full friction.
const STEPS: StepPolicy =
    StepPolicy { first: 0.1, growth: 1.5, longest: f64::INFINITY, shortest: 1e-4, most: 300 };

/// Solution of the complementarity problem.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    /// Values of the unknowns, N: friction at the surfaces or, for sliding members, normal loads.
    pub(crate) amounts: Vec<f64>,
    /// Surface rate in the direction of each friction unknown: acceleration, m/s^2, or velocity
    /// after a time step, m/s.
    pub(crate) rates: Vec<f64>,
    /// Normal load of each member, N.
    pub(crate) loads: Vec<f64>,
    /// Largest residual of the friction laws relative to the largest force.
    pub(crate) residual: f64,
    /// Largest surface rate of a sticking interface relative to the largest frictionless rate.
    /// [`Self::residual`] permits large rates if the forces are much larger.
    pub(crate) residual_slip: f64,
    /// For each member, `true` if its interface sticks; always `false` without dry friction.
    pub(crate) sticks: Vec<bool>,
}

impl Complementarity<'_> {
    /// Solves the problem, starting from the values `start` of the unknowns. Returns `None` if no
    /// solution is found.
    pub(crate) fn solve(&mut self, start: &[f64]) -> Option<Solution> {
        self.solve_near(start).or_else(|| self.solve_by_continuation())
    }

    /// Solves the problem by Newton's method and the projected Gauss-Seidel method, starting from the
    /// values `start` of the unknowns. Returns `None` if both fail.
    pub(crate) fn solve_near(&mut self, start: &[f64]) -> Option<Solution> {
        if self.count() == 0 {
            return Some(self.complete(Vec::new()));
        }
        let mut x = start.to_vec();
        let mut found = self.newton_from(&x);
        for round in 0..ROUNDS {
            if found.is_some() {
                break;
            }
            self.project(&mut x, 1.0, SWEEPS << round);
            if x.iter().any(|x| !x.is_finite()) {
                break;
            }
            found = self.newton_from(&x);
        }
        found.map(|x| self.complete(x))
    }

    /// Solves the problem by continuation, from zero friction or else from stick. Returns `None` if
    /// both fail.
    pub(crate) fn solve_by_continuation(&self) -> Option<Solution> {
        let x = self.follow_friction().or_else(|| self.follow_path())?;
        Some(self.complete(x))
    }

    /// Solves the problem by continuation from friction with which everything sticks, see [`path`].
    /// Statically indeterminate frictions are then nearly the least ones, so that this solution
    /// contains no large self-stress. Returns `None` if the continuation fails.
    pub(crate) fn solve_from_stick(&self) -> Option<Solution> {
        self.follow_path().map(|x| self.complete(x))
    }

    /// Returns the index of the interface that violates its friction law most after a run of the
    /// projected Gauss-Seidel method from the values `start` of the unknowns.
    pub(crate) fn worst(&self, start: &[f64]) -> Option<usize> {
        let mut x = start.to_vec();
        self.project(&mut x, 1.0, 4 * SWEEPS);
        if x.iter().any(|x| !x.is_finite()) {
            x.fill(0.0);
        }
        let values = self.residual(&x, 1.0, None).values;
        let residual = |member: &&Member| {
            values[member.places.clone()].iter().fold(0.0_f64, |m, v| m.max(v.abs()))
        };
        let worst = self.members.iter().max_by(|a, b| residual(a).total_cmp(&residual(b)));
        worst.map(|member| member.interface)
    }

    /// Runs Newton's method from `start`, trying one scaling after the other until it converges.
    /// Returns `None` if it fails with all scalings.
    fn newton_from(&mut self, start: &[f64]) -> Option<Vec<f64>> {
        let mut found = None;
        for scaling in SCALINGS {
            self.scaling = scaling;
            let mut trial = start.to_vec();
            if self.newton(&mut trial, 1.0) && trial.iter().all(|x| x.is_finite()) {
                found = Some(trial);
                break;
            }
        }
        self.scaling = Scaling::EffectiveMass(1.0);
        found
    }

    /// Computes the solution by continuation from zero to full friction. Returns `None` if the
    /// continuation fails.
    fn follow_friction(&self) -> Option<Vec<f64>> {
        let x = vec![0.0; self.count()];
        let mut branch = FrictionBranch { problem: self, trial: x.clone(), x };
        continuation::follow(&mut branch, STEPS, 1.0).ok().map(|_| branch.x)
    }

    fn complete(&self, amounts: Vec<f64>) -> Solution {
        let residual = self.residual(&amounts, 1.0, None);
        let relative = residual.relative();
        let rates = self.rates(&amounts);
        let loads = (0..self.members.len())
            .map(|m| self.load(m, &amounts, self.wrench(m, &amounts)).value)
            .collect();
        let sticks: Vec<bool> = residual.excess.iter().map(|excess| *excess <= 0.0).collect();
        let stuck = self.members.iter().zip(&sticks).filter(|(_, sticks)| **sticks);
        let fastest = stuck.flat_map(|(member, _)| &rates[member.places.clone()]);
        let fastest = fastest.fold(0.0_f64, |m, rate| m.max(rate.abs()));
        let free = self.free.iter().fold(f64::MIN_POSITIVE, |m, rate| m.max(rate.abs()));
        Solution {
            amounts,
            rates,
            loads,
            residual: relative,
            residual_slip: fastest / free,
            sticks,
        }
    }
}

/// Solution branch of the complementarity problem.
struct FrictionBranch<'a> {
    problem: &'a Complementarity<'a>,
    x: Vec<f64>,
    trial: Vec<f64>,
}

impl Branch for FrictionBranch<'_> {
    fn correct(&mut self, part: f64) -> bool {
        let Self { problem, x, trial } = self;
        trial.clone_from(x);
        let mut found = problem.newton(trial, part);
        if !found {
            trial.clone_from(x);
            problem.project(trial, part, 4 * SWEEPS);
            found = problem.newton(trial, part);
        }
        found && trial.iter().all(|x| x.is_finite())
    }

    fn accept(&mut self) {
        std::mem::swap(&mut self.x, &mut self.trial);
    }

    fn reject(&mut self) {}

    fn fastest_growing(&self) -> usize {
        0
    }
}
