//! Compiled model of a mechanism for inverse dynamics.

use super::plan::BalancePlan;
use crate::kinematics::{KinematicModel, MotionConstraints};
use crate::mechanism::Mechanism;
use crate::parameters::Parameters;
use crate::topology::Topology;
use std::sync::Arc;

/// Mechanism compiled for inverse dynamics with one set of prescribed coordinates, near one
/// configuration.
///
/// The model is immutable. It contains the spanning tree, the motion constraints, the static LU
/// factorisation of the rate equations and the compiled structure of the balance; clones share all
/// of these. A computation reads its values from [`Parameters`] and writes its results to
/// [`Data`](super::Data).
#[derive(Clone, Debug)]
pub struct Model {
    pub(super) mechanism: Arc<Mechanism>,
    pub(super) kinematic: KinematicModel,
    pub(super) balance: Arc<BalancePlan>,
    pub(super) parameters: Arc<Parameters<f64>>,
}

impl Model {
    /// Returns the mechanism of the model.
    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// Returns the topology: spanning tree and cut joints.
    pub fn topology(&self) -> &Topology {
        &self.kinematic.topology
    }

    /// Returns the motion constraints: loop closures and prescribed coordinates.
    pub fn constraints(&self) -> &MotionConstraints {
        &self.kinematic.constraints
    }

    /// Returns the nominal parameters of the mechanism. If a body has no inertia about the axis of
    /// a local degree of freedom, its parameters contain an added inertia about this axis, on which
    /// no result depends.
    pub fn parameters(&self) -> &Parameters<f64> {
        &self.parameters
    }

    /// Returns the numbers of multiply-subtract operations of the static LU factorisations of the
    /// rate equations and of the balance.
    pub fn operations(&self) -> (usize, usize) {
        (self.kinematic.rates.operations(), self.balance.operations())
    }
}
