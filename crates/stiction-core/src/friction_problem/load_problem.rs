//! Friction problem with the normal loads as unknowns. Stick-slip modes and slip directions are
//! given.
//!
//! Equation (D3) of the book's theory.

use super::continuation::{self, Branch, Lock, StepPolicy, fastest_growing};
use super::influence::{Influence, InfluenceMatrix};
use super::newton::{Accepted, NewtonWorkspace, UNBOUNDED};
use super::normal_load::Configuration;
use super::small_system::Four;
use super::uniqueness::{BoundStart, BoundWorkspace, coupling_bound_in_blocks, coupling_bound_of};
use crate::friction::OwnFriction;
use crate::linalg::largest;
use crate::spatial::{Twist, Wrench};

/// Interface whose normal load is an unknown, because its friction depends on this load.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unknown {
    pub(super) interface: usize,
    /// Friction of this interface itself. The normal load of a thread or gear depends on it.
    pub(super) own: OwnFriction<f64>,
    /// Wrench at the joint of the interface, without the friction that depends on normal loads.
    pub(super) base: Wrench<f64>,
}

impl Unknown {
    /// Returns the friction of the interface with `part` times the given friction coefficient.
    pub(super) fn own_at(&self, part: f64) -> OwnFriction<f64> {
        OwnFriction { coefficient: part * self.own.coefficient, ..self.own }
    }
}

/// Problem with the normal loads `N` as unknowns: `N = load(base + influence N)`.
#[derive(Clone, Debug, Default)]
pub(crate) struct LoadProblem {
    pub(super) unknowns: Vec<Unknown>,
    pub(super) influence: InfluenceMatrix,
    /// True if the influence has the opposite sign of [`Self::influence`].
    is_reversed: bool,
}

/// Buffers of the solver, and its result: the normal loads [`Self::loads`], N.
#[derive(Clone, Debug, Default)]
pub(crate) struct LoadWorkspace {
    pub(crate) loads: Vec<f64>,
    /// Number of continuation steps in the last solution; zero if no continuation was needed.
    pub(crate) continuation_steps: usize,
    start: Vec<f64>,
    trial: Vec<f64>,
    newton: NewtonWorkspace,
    bound: BoundWorkspace,
}

impl LoadWorkspace {
    /// Discards the eigenvectors from which the next bound would start.
    pub(crate) fn forget(&mut self) {
        self.bound.start(BoundStart::New);
    }
}

impl LoadProblem {
    /// Removes all unknowns, keeping the buffers.
    pub(crate) fn clear(&mut self) {
        self.unknowns.clear();
    }

    /// Adds the normal load of an interface as an unknown.
    pub(crate) fn add(&mut self, interface: usize, own: OwnFriction<f64>, base: Wrench<f64>) {
        self.unknowns.push(Unknown { interface, own, base });
    }

    /// Stores the influence of each unknown normal load, through the friction that it causes, on
    /// the joint wrenches of all interfaces with unknown loads.
    pub(crate) fn set_influence(&mut self, operator: &mut impl Influence) {
        self.is_reversed = false;
        self.influence.store(self.unknowns.len(), operator);
    }

    /// Stores the influence like [`Self::set_influence`], but four columns at a time.
    /// `of(row, block)` returns the wrench at the joint of unknown `row` per unit of each of the
    /// four unknowns of `block`; the wrench must be zero beyond the last unknown.
    pub(crate) fn set_influence_in_blocks(&mut self, of: impl Fn(usize, usize) -> Wrench<Four>) {
        self.is_reversed = false;
        self.influence.store_blocks(self.unknowns.len(), of);
    }

    /// Reverses the sign of the influence, for friction forces in the opposite directions.
    pub(crate) fn reverse_influence(&mut self) {
        self.is_reversed = !self.is_reversed;
    }

    /// Returns the sign of the influence relative to [`Self::influence`].
    pub(super) fn sense(&self) -> f64 {
        if self.is_reversed { -1.0 } else { 1.0 }
    }

    /// Iterates over the indices of the interfaces whose normal loads are unknowns.
    pub(crate) fn interfaces(&self) -> impl Iterator<Item = usize> {
        self.unknowns.iter().map(|unknown| unknown.interface)
    }

    /// Computes the normal loads, N, for zero friction coefficients, that is, without the friction
    /// that depends on the normal loads.
    pub(crate) fn uncoupled_loads(&self, at: Configuration<'_>, loads: &mut Vec<f64>) {
        loads.clear();
        loads.extend(self.unknowns.iter().map(|unknown| {
            at.normal_load(unknown.interface, unknown.base, unknown.own_at(0.0)).value
        }));
    }

    /// Solves by Newton's method, starting from the `known` normal loads (N, one per interface of
    /// the mechanism). If this finds no solution on the branch that begins at the frictionless
    /// solution, solves by continuation with the step sizes `steps`.
    ///
    /// # Errors
    /// Returns the [`Lock`] at which the continuation ends.
    pub(crate) fn solve(
        &self,
        at: Configuration<'_>,
        known: Option<&[f64]>,
        steps: StepPolicy,
        workspace: &mut LoadWorkspace,
    ) -> Result<(), Lock> {
        let LoadWorkspace { loads, start, trial, newton, continuation_steps, .. } = workspace;
        *continuation_steps = 0;
        loads.clear();
        if self.unknowns.is_empty() {
            return Ok(());
        }
        if let Some(known) = known {
            loads.extend(self.interfaces().map(|interface| known[interface]));
            let limit = Accepted::below(UNBOUNDED * largest(loads));
            if self.newton(at, loads, (1.0, limit), newton).is_some_and(|positive| positive) {
                return Ok(());
            }
        }
        self.uncoupled_loads(at, start);
        loads.clone_from(start);
        let limit = UNBOUNDED * largest(start).max(f64::MIN_POSITIVE);
        let mut branch = LoadBranch { problem: self, at, start, limit, loads, trial, newton };
        let followed = continuation::follow(&mut branch, steps, 1.0);
        *continuation_steps = *followed.as_ref().unwrap_or(&steps.most);
        followed
            .map(|_| ())
            .map_err(|lock| Lock { interface: self.unknowns[lock.interface].interface, ..lock })
    }

    /// Solves by Newton's method from the given normal loads, N. Accepts a solution on any branch;
    /// returns `true` if it finds one.
    pub(crate) fn solve_from(
        &self,
        at: Configuration<'_>,
        loads: &mut [f64],
        accepted: Accepted,
        workspace: &mut LoadWorkspace,
    ) -> bool {
        self.newton(at, loads, (1.0, accepted), &mut workspace.newton).is_some()
    }

    /// Solves the adjoint problem at the solution `loads`. On entry, `weights` contains the
    /// derivatives of a function with respect to the normal loads; on return, the derivatives `y`
    /// of this function with respect to the right-hand sides of the load equations. They satisfy
    /// `(I - J)^T y = weights` with the Jacobian `J` of the load map. Also computes the gradients
    /// of the loads with respect to the joint wrenches. Returns `None` if the system is singular.
    pub(crate) fn adjoint(
        &self,
        at: Configuration<'_>,
        loads: &[f64],
        weights: &mut [f64],
        gradients: &mut Vec<Twist<f64>>,
        workspace: &mut LoadWorkspace,
    ) -> Option<()> {
        self.transposed(at, loads, weights, gradients, &mut workspace.newton)
    }

    /// Computes an upper bound on the coupling of friction and normal loads; see
    /// [`coupling_bound`](super::uniqueness::coupling_bound). Returns the first bound found that is
    /// at most `accepted`, without searching for the smallest bound.
    pub(crate) fn coupling_bound(
        &self,
        at: Configuration<'_>,
        (start, accepted): (BoundStart, f64),
        workspace: &mut LoadWorkspace,
    ) -> f64 {
        let each = self.unknowns.iter().map(|unknown| (unknown.interface, unknown.own.coefficient));
        let bound = &mut workspace.bound;
        bound.start(start);
        bound.accept_up_to(accepted);
        coupling_bound_in_blocks(at, each, &self.influence, bound)
    }

    /// Computes [`Self::coupling_bound`] from the coupling matrix, stored row by row.
    pub(crate) fn coupling_bound_of(
        &self,
        matrix: &[f64],
        (start, accepted): (BoundStart, f64),
        workspace: &mut LoadWorkspace,
    ) -> f64 {
        let bound = &mut workspace.bound;
        bound.start(start);
        bound.accept_up_to(accepted);
        coupling_bound_of(matrix, self.unknowns.len(), bound)
    }
}

/// Solution branch of the normal loads, parametrised by the fraction of the friction coefficients.
struct LoadBranch<'a> {
    problem: &'a LoadProblem,
    at: Configuration<'a>,
    start: &'a [f64],
    limit: f64,
    loads: &'a mut Vec<f64>,
    trial: &'a mut Vec<f64>,
    newton: &'a mut NewtonWorkspace,
}

impl Branch for LoadBranch<'_> {
    fn correct(&mut self, part: f64) -> bool {
        let Self { problem, at, limit, loads, trial, newton, .. } = self;
        trial.clone_from(loads);
        let accepted = Accepted::below(*limit);
        problem.newton(*at, trial, (part, accepted), newton).is_some_and(|positive| positive)
    }

    fn accept(&mut self) {
        std::mem::swap(self.loads, self.trial);
    }

    fn reject(&mut self) {}

    fn fastest_growing(&self) -> usize {
        fastest_growing(self.start, self.loads)
    }
}
