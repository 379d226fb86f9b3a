//! Kinematic part of a compiled model: topology, motion constraints, and factorisation of the rate
//! equations.

use super::motion_constraints::MotionConstraints;
use crate::linalg::StaticLu;
use crate::topology::Topology;
use std::sync::Arc;

/// Kinematics of a mechanism, compiled for one set of prescribed coordinates near one
/// configuration.
///
/// Immutable and independent of the mechanism's numerical parameters, so it can be used with every
/// scalar type and every set of [`Parameters`](crate::parameters::Parameters). Clones share all
/// parts.
#[derive(Clone, Debug)]
pub struct KinematicModel {
    /// Spanning tree and cut joints.
    pub(crate) topology: Arc<Topology>,
    /// Constraints of the rate equations: loop closures, gearings, prescribed coordinates and
    /// locked passive spins.
    pub(crate) constraints: Arc<MotionConstraints>,
    /// Static LU factorisation of the rate equations.
    pub(crate) rates: Arc<StaticLu>,
}

impl KinematicModel {
    /// Spanning tree and cut joints.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Constraints on the motion: loop closures, gearings and prescribed coordinates.
    pub fn constraints(&self) -> &MotionConstraints {
        &self.constraints
    }
}
