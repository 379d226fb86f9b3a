//! Kinematic part of a compiled model: topology, motion constraints, and LU factorisation of the
//! equations for the rates.

use super::motion_constraints::MotionConstraints;
use crate::linalg::StaticLu;
use crate::topology::Topology;
use std::sync::Arc;

/// Kinematics of a mechanism, compiled for one set of prescribed coordinates near one
/// configuration.
///
/// The model is immutable and independent of the mechanism's numerical parameters, so it can be
/// used with every scalar type and every set of [`Parameters`](crate::parameters::Parameters).
/// Clones share their data by reference counting.
#[derive(Clone, Debug)]
pub struct KinematicModel {
    /// Spanning tree and cut joints.
    pub(crate) topology: Arc<Topology>,
    /// Constraints of the rate equations: loop closures, gearings, prescribed coordinates, and
    /// passive spins whose rate is set to zero.
    pub(crate) constraints: Arc<MotionConstraints>,
    /// Static LU factorisation of the rate equations.
    pub(crate) rates: Arc<StaticLu>,
}

impl KinematicModel {
    /// Returns the spanning tree and cut joints.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Returns the constraints on the motion: loop closures, gearings, prescribed coordinates, and
    /// passive spins whose rate is set to zero.
    pub fn constraints(&self) -> &MotionConstraints {
        &self.constraints
    }
}
