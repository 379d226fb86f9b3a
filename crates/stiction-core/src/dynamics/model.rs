//! Compiled model of a mechanism for inverse dynamics.

use super::plan::BalancePlan;
use crate::kinematics::{KinematicModel, MotionConstraints};
use crate::mechanism::Mechanism;
use crate::parameters::Parameters;
use crate::topology::Topology;
use std::sync::Arc;

/// A mechanism compiled for inverse dynamics with one set of prescribed coordinates, near one
/// position.
///
/// Immutable. Contains the spanning tree, the motion constraints, the static LU factorisation of
/// the rate equations and the plan of the balance; clones share all of them. A computation reads
/// its numbers from [`Parameters`] and writes its results to [`Data`](super::Data).
#[derive(Clone, Debug)]
pub struct Model {
    pub(super) mechanism: Arc<Mechanism>,
    pub(super) kinematic: KinematicModel,
    pub(super) balance: Arc<BalancePlan>,
    pub(super) parameters: Arc<Parameters<f64>>,
}

impl Model {
    /// The mechanism.
    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// Spanning tree and cut joints.
    pub fn topology(&self) -> &Topology {
        &self.kinematic.topology
    }

    /// Loop closures and prescribed coordinates.
    pub fn constraints(&self) -> &MotionConstraints {
        &self.kinematic.constraints
    }

    /// Nominal parameters of the mechanism. A body without inertia about the axis of a local degree of
    /// freedom has additional inertia about it, on which no result depends.
    pub fn parameters(&self) -> &Parameters<f64> {
        &self.parameters
    }

    /// Number of multiply-subtract operations of the static LU factorisations of the rate equations and of
    /// the balance.
    pub fn operations(&self) -> (usize, usize) {
        (self.kinematic.rates.operations(), self.balance.operations())
    }
}
