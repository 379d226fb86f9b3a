//! Verdict on the results along a whole motion.

use super::certainty::{Margin, OtherSolutions};
use super::uniqueness::Singular;
use stiction_core::dynamics::{InverseDynamics, Weighting};
use stiction_core::spatial::Vec3;

/// Uniqueness, mobility and singularity of the results along a whole motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Number of samples of the run.
    pub samples: usize,
    /// Notes on differences between the assembled first configuration and the declared `home` and `start`.
    pub assembly_notes: Vec<String>,
    /// Least mobility that the constraints leave at three samples: the first sample and those after
    /// one third and two thirds of the samples. Local rotations are included.
    pub mobility: usize,
    /// Names of the bodies that can rotate freely about their own axes.
    pub idle_spins: Vec<String>,
    /// Index of each of these bodies, and the unit vector along its axis in the axes of the body.
    pub(crate) idle_axes: Vec<(usize, Vec3<f64>)>,
    /// Largest number of redundant constraints and actuators at any sample.
    pub redundancy: usize,
    /// Weighting that selects one of several solutions of the static equilibrium; `None` if the
    /// dense fallback computed the forces.
    pub weighting: Option<Weighting>,
    /// Sliding speed below which friction interfaces are at rest, m/s.
    pub rest_speed: f64,
    /// Largest bound of the coupling of friction and reactions along the motion, dimensionless. If
    /// it is below one, the solution with friction is unique. `None` if the bound is unknown at a
    /// sample.
    pub coupling: Option<f64>,
    /// Pairs of times, s, of neighbouring samples between which the mechanism passes a singular
    /// pose. Near this pose, efforts grow without bound.
    pub passed_singularities: Vec<(f64, f64)>,
    /// Other solutions that satisfy the friction laws, if any were found. The reported solution is
    /// continued from zero friction.
    pub other_solutions: Option<OtherSolutions>,
    /// Least friction margin to jamming, if requested.
    pub friction_margin: Option<Margin>,
    /// Singular poses at which the mechanism can nevertheless carry the load; `None` if no sample
    /// has such a pose.
    pub singular: Option<Singular>,
}

/// Returns the names of the bodies that can rotate freely about their own axes.
pub(crate) fn idle_spins(solver: &InverseDynamics) -> Vec<String> {
    let bodies = solver.mechanism().bodies();
    let spins = solver.constraints().spins();
    spins.iter().map(|spin| bodies[spin.body.0].name.clone()).collect()
}
