//! Friction at many interfaces that satisfies all friction laws at once: a nonlinear complementarity problem.
//!
//! The unknowns are friction forces `f` at the surfaces. Surface rates `b` (accelerations, or velocities after a step)
//! and joint wrenches are affine in them; normal loads `N` are norms of the wrenches. A dry interface satisfies
//!
//! ```text
//! f = projection of (f + rho b) onto |f| <= mu N(f)
//! ```
//!
//! This equation is Coulomb's law: friction is within its limit if the interface sticks; if it slides,
//! friction equals the limit and opposes the slip. Balls and plates have three components, other
//! interfaces one.
//!
//! The projected Gauss-Seidel method solves one interface after the other; it converges from any
//! start, but slowly. Newton's method on the nonsmooth equations (Alart and Curnier 1991) converges
//! fast near a solution. If self-stresses leave friction indeterminate, its steps have minimum
//! norm, so that it finds a solution near the start. If both methods fail, continuation follows the
//! solution from zero friction.
//!
//! Equation (D5) of the book's theory.

mod laws;
mod local;
mod newton;
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
/// Scalings of the rates in Newton's method, tried in this order. The effective mass of a member is
/// that of its lightest direction, so larger multiples are tried as well: a rod between balls spins
/// far more easily than it swings.
const SCALINGS: [Scaling; 4] = [
    Scaling::EffectiveMass(1.0),
    Scaling::ForcePerRate,
    Scaling::EffectiveMass(30.0),
    Scaling::EffectiveMass(1000.0),
];
/// Step sizes of the continuation from zero friction.
const STEPS: StepPolicy =
    StepPolicy { first: 0.1, growth: 1.5, longest: f64::INFINITY, shortest: 1e-4, most: 300 };

/// Solution of the complementarity problem.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    /// Values of the unknowns, N: friction at the surfaces or, for sliding members, normal loads.
    pub(crate) amounts: Vec<f64>,
    /// Surface rate along each unknown: acceleration, or velocity after a step.
    pub(crate) rates: Vec<f64>,
    /// Normal load of each member, N.
    pub(crate) loads: Vec<f64>,
    /// Largest residual of the friction laws relative to the largest force.
    pub(crate) residual: f64,
    /// True for each member that sticks.
    pub(crate) sticks: Vec<bool>,
}

impl Complementarity<'_> {
    /// Solves the problem, starting from the unknowns `start`. Returns `None` if no solution is
    /// found.
    pub(crate) fn solve(&mut self, start: &[f64]) -> Option<Solution> {
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
        let x = match found {
            Some(x) => x,
            None => self.follow_friction()?,
        };
        Some(self.complete(x))
    }

    /// Returns the interface with the largest residual of its friction law after the projected
    /// Gauss-Seidel method.
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

    /// Runs Newton's method from `start` with one scaling after the other, until it converges.
    /// Returns `None` if all fail.
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

    /// Follows the solution from zero friction to full friction by continuation. Returns `None` if
    /// the continuation fails.
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
        Solution { amounts, rates, loads, residual: relative, sticks: residual.sticks }
    }
}

/// Solution branch, parametrised by the factor on the friction coefficients, from 0 to 1.
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
