//! Verdict on a whole motion.

use super::certainty::{Margin, OtherSolutions};
use super::uniqueness::Singular;
use stiction_core::dynamics::{InverseDynamics, Weighting};

/// Verdict on a whole motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Number of samples.
    pub samples: usize,
    /// Notes on differences between the assembled first configuration and the declared `home` and `start`.
    pub assembly_notes: Vec<String>,
    /// Least mobility that the constraints leave at any sample, local rotations included.
    pub mobility: usize,
    /// Names of the bodies that can rotate freely about their own axis.
    pub idle_spins: Vec<String>,
    /// Number of redundant constraints and actuators.
    pub redundancy: usize,
    /// Weighting that selects one of several solutions; `None` if the dense fallback computed the forces.
    pub weighting: Option<Weighting>,
    /// Sliding speed below which friction interfaces are at rest, m/s.
    pub rest_speed: f64,
    /// Largest uniqueness bound along the motion. If it is below one, the solution with friction is
    /// unique. `None` if unknown.
    pub coupling: Option<f64>,
    /// Pairs of times, s, of neighbouring samples between which the mechanism passes a singular pose, near which
    /// efforts grow without bound.
    pub passed_singularities: Vec<(f64, f64)>,
    /// Other solutions that satisfy the friction laws, if found. The reported solution is the one continued from zero
    /// friction.
    pub other_solutions: Option<OtherSolutions>,
    /// Least friction margin to jamming, if requested.
    pub friction_margin: Option<Margin>,
    /// Singular poses at samples at which the mechanism carries the load nevertheless.
    pub singular: Option<Singular>,
}

/// Names of the bodies that can rotate freely about their own axis.
pub(crate) fn idle_spins(solver: &InverseDynamics) -> Vec<String> {
    let bodies = solver.mechanism().bodies();
    let spins = solver.constraints().spins();
    spins.iter().map(|spin| bodies[spin.body.0].name.clone()).collect()
}
