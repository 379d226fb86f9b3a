//! Normal loads that are consistent with the friction they cause, by Newton's method.
//!
//! Equation (D3) of the book's theory.

use super::FrictionCoupling;
use crate::dynamics::interfaces::InterfaceState;
use crate::friction_problem::newton::{Accepted, UNBOUNDED};
use crate::friction_problem::normal_load::Configuration;
use crate::friction_problem::small_system::pack;
use crate::linalg::largest;
use crate::spatial::Wrench;

/// Largest error of extrapolated normal loads, relative to the largest load, that is accepted
/// without a Newton step.
const ERROR: f64 = 1e-13;

/// Normal loads from which Newton's method starts.
#[derive(Clone, Copy, Debug)]
pub(in crate::dynamics) enum Start<'a> {
    /// Normal loads of the solution without friction.
    Uncoupled,
    /// Normal loads of the last solution if it has the same number of coupled interfaces, otherwise
    /// frictionless normal loads.
    Last,
    /// Normal loads extrapolated from previous configurations of the present motion.
    Expected,
    /// Normal loads extrapolated from previous configurations of the opposite motion. Without such
    /// configurations, Newton's method starts from reflected normal loads: the frictionless load
    /// plus its difference from the load in the given states, which belong to the present motion.
    Opposite(&'a [InterfaceState<f64>]),
}

impl FrictionCoupling {
    /// Computes the normal loads that are consistent with the friction set by [`Self::act`], by
    /// Newton's method from `start`. Returns false if the method does not converge.
    pub(in crate::dynamics) fn settle(&mut self, at: Configuration<'_>, start: Start<'_>) -> bool {
        let found = match start {
            Start::Last if self.loads.len() == self.unknowns.len() => {
                self.newton(at, 0.0) || self.newton_from_uncoupled(at, None)
            }
            Start::Expected => {
                self.newton_from_expected(at, 0) || self.newton_from_uncoupled(at, None)
            }
            Start::Opposite(states) => {
                self.newton_from_expected(at, 1) || self.newton_from_uncoupled(at, Some(states))
            }
            Start::Last | Start::Uncoupled => self.newton_from_uncoupled(at, None),
        };
        if !found {
            return false;
        }
        let history = match start {
            Start::Expected => Some(0),
            Start::Opposite(_) => Some(1),
            Start::Last | Start::Uncoupled => None,
        };
        if let Some(history) = history.filter(|_| self.keeps_history) {
            self.history[history].add(&self.unknowns, &self.loads);
        }
        self.frictions.clear();
        self.frictions.resize(self.responses.len(), 0.0);
        let mut loads = self.unknowns.iter().zip(&self.loads).peekable();
        for (interface, acting) in self.acting.iter().enumerate() {
            let load = loads.next_if(|(unknown, _)| **unknown == interface);
            let force = acting.resistance.force(load.map_or(0.0, |(_, load)| *load));
            for (component, part) in self.responses.components(interface).zip(acting.parts) {
                self.frictions[component] = part * force;
            }
        }
        true
    }

    /// Runs Newton's method from the normal loads extrapolated from previous configurations.
    /// `history` is 0 for those of the present motion, and 1 for those of the opposite motion.
    fn newton_from_expected(&mut self, at: Configuration<'_>, history: usize) -> bool {
        let Self { history: all, unknowns, loads, strength, .. } = self;
        // The fixed-point map contracts by the factor `strength`, so this residual bounds the error
        // by `ERROR`.
        let residual = ERROR * (1.0 - *strength);
        all[history].predict(unknowns, loads) && self.newton(at, residual)
    }

    /// Runs Newton's method from the frictionless normal loads. If `opposite` is given, starts from
    /// the normal loads of `opposite`, reflected about the frictionless normal loads.
    fn newton_from_uncoupled(
        &mut self,
        at: Configuration<'_>,
        opposite: Option<&[InterfaceState<f64>]>,
    ) -> bool {
        let Self { problem, loads, unknowns, .. } = self;
        problem.uncoupled_loads(at, loads);
        if let Some(opposite) = opposite {
            for (load, &interface) in loads.iter_mut().zip(&*unknowns) {
                *load = (2.0 * *load - opposite[interface].load()).max(0.0);
            }
        }
        self.newton(at, 0.0)
    }

    /// Runs Newton's method from the normal loads in `loads`. `residual` is [`Accepted::residual`].
    fn newton(&mut self, at: Configuration<'_>, residual: f64) -> bool {
        let Self { problem, loads, workspace, .. } = self;
        let most = UNBOUNDED * largest(loads).max(f64::MIN_POSITIVE);
        problem.solve_from(at, loads, Accepted { most, residual }, workspace)
    }

    /// Solves for the present motion after [`Self::begin`], which must have returned a coupling
    /// bound below one. The results are [`Self::present_wrench`] and [`Self::present_loads`].
    /// Returns false if Newton's method fails, or if there are too many interfaces for a dense
    /// problem.
    pub(in crate::dynamics) fn solve_present(&mut self, at: Configuration<'_>) -> bool {
        let settled = self.is_stored && self.settle(at, Start::Expected);
        if settled {
            pack(&self.frictions, &mut self.packed);
        }
        settled
    }

    /// Returns the wrench of a joint with the friction of the last [`Self::solve_present`].
    pub(in crate::dynamics) fn present_wrench(&self, joint: usize) -> Wrench<f64> {
        let mut wrench = self.wrenches[joint];
        self.responses.add_at(joint, &mut wrench, &self.packed);
        wrench
    }

    /// Iterates over the interfaces whose friction depends on the normal load, as pairs of index
    /// and normal load, N.
    pub(in crate::dynamics) fn present_loads(&self) -> impl Iterator<Item = (usize, f64)> {
        self.unknowns.iter().copied().zip(self.loads.iter().copied())
    }
}
