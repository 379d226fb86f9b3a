//! What is told of the whole motion.

use super::certainty::{Margin, OtherSolutions};
use super::uniqueness::Singular;
use stiction_core::dynamics::{InverseDynamics, Weighting};

/// What holds along the whole motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Number of samples.
    pub samples: usize,
    /// Notes on the first configuration against `home` and `start`.
    pub assembly_notes: Vec<String>,
    /// Freedoms that the constraints leave, the least along the motion, idle spins included.
    pub mobility: usize,
    /// Idle spins: rotations of bodies about their own axes that nothing determines.
    pub idle_spins: Vec<String>,
    /// Redundant constraints and actuators.
    pub redundancy: usize,
    /// What decides among the solutions; none where the careful path did.
    pub weighting: Option<Weighting>,
    /// Contacts that slide no faster than this count as resting, m/s.
    pub rest_speed: f64,
    /// How strongly friction and reactions are coupled, the most along the motion: below one there
    /// is no other solution than the one given. None where it is not known.
    pub coupling: Option<f64>,
    /// Pairs of neighbouring samples, s, between which the mechanism passes a singular position,
    /// where no finite driving force exists.
    pub passed_singularities: Vec<(f64, f64)>,
    /// Other solutions of friction and reactions that were found. Given is the one that is connected
    /// with no friction.
    pub other_solutions: Option<OtherSolutions>,
    /// How far friction can grow before it locks the mechanism, if that was asked for.
    pub friction_margin: Option<Margin>,
    /// Singular positions at samples, where the load could be carried nevertheless.
    pub singular: Option<Singular>,
}

/// Bodies that turn about their own axes and nothing determines it, by their names.
pub(crate) fn idle_spins(solver: &InverseDynamics) -> Vec<String> {
    let bodies = solver.mechanism().bodies();
    let spins = solver.constraints().spins();
    spins.iter().map(|spin| bodies[spin.body.0].name.clone()).collect()
}
