//! What kernels are told beyond numbers.

use super::plan::BalancePlan;
use crate::kinematics::MotionConstraints;
use crate::linalg::StaticLu;
use crate::topology::Topology;

/// A mechanism compiled for one prescription: what the kernels are told beyond numbers.
#[derive(Clone, Copy, Debug)]
pub struct Setup<'a> {
    /// The graph.
    pub topology: &'a Topology,
    /// What is prescribed.
    pub motion_constraints: &'a MotionConstraints,
    /// How rates are solved for.
    pub motion: &'a StaticLu,
    /// How reactions are solved for.
    pub balance: &'a BalancePlan,
}
