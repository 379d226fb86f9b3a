//! Verdict on a whole motion.

use super::certainty::{Margin, OtherSolutions};
use super::uniqueness::Singular;
use stiction_core::dynamics::{InverseDynamics, Weighting};

/// Verdict on a whole motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Number of samples.
    pub samples: usize,
    /// Notes on differences of the first configuration from `home` and `start`.
    pub assembly_notes: Vec<String>,
    /// Least mobility along the motion left by the constraints, local rotations included.
    pub mobility: usize,
    /// Bodies with a passive rotation about their own axis.
    pub idle_spins: Vec<String>,
    /// Number of redundant constraints and actuators.
    pub redundancy: usize,
    /// Weighting that selects one of the solutions; `None` for the dense fallback.
    pub weighting: Option<Weighting>,
    /// Sliding speed below which friction interfaces are at rest, m/s.
    pub rest_speed: f64,
    /// Greatest coupling of friction and reactions along the motion; the solution is unique below
    /// one. `None` if unknown.
    pub coupling: Option<f64>,
    /// Pairs of neighbouring samples, s, between which the mechanism passes a singular pose without
    /// a finite effort.
    pub passed_singularities: Vec<(f64, f64)>,
    /// Other solutions; the reported one is continued from zero friction.
    pub other_solutions: Option<OtherSolutions>,
    /// Least friction margin to jamming, if requested.
    pub friction_margin: Option<Margin>,
    /// Singular poses at samples whose load happens to be carried.
    pub singular: Option<Singular>,
}

/// Names of the bodies with a passive rotation about their own axis.
pub(crate) fn idle_spins(solver: &InverseDynamics) -> Vec<String> {
    let bodies = solver.mechanism().bodies();
    let spins = solver.constraints().spins();
    spins.iter().map(|spin| bodies[spin.body.0].name.clone()).collect()
}
