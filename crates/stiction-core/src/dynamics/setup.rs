//! What kernels are told beyond numbers.

use super::plan::BalancePlan;
use crate::kinematics::Prescription;
use crate::linalg::Elimination;
use crate::topology::Topology;

/// A mechanism compiled for one prescription: what the kernels are told beyond numbers.
#[derive(Clone, Copy, Debug)]
pub struct Setup<'a> {
    /// The graph.
    pub topology: &'a Topology,
    /// What is prescribed.
    pub prescription: &'a Prescription,
    /// How rates are solved for.
    pub motion: &'a Elimination,
    /// How reactions are solved for.
    pub balance: &'a BalancePlan,
}
