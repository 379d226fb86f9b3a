//! Degrees of freedom, counted three ways.

use crate::dynamics::InverseDynamics;
use crate::kinematics::{finite_mobility, loop_singular_values};
use crate::mechanism::Mechanism;

/// Singular values of the loops' equations below this, relative to the largest, count as zero.
/// Matrices are scaled to entries of order one, positions are closed to 1e-13.
const NEGLIGIBLE: f64 = 1e-9;

/// How many degrees of freedom a mechanism has, idle spins included.
#[derive(Clone, Debug, PartialEq)]
pub struct Mobility {
    /// By counting bodies and joint freedoms (Gruebler, Kutzbach): right if all constraints are
    /// independent.
    pub gruebler: i64,
    /// At this position, to first order.
    pub instantaneous: usize,
    /// Motions of finite size from this position, traced.
    pub finite: usize,
    /// Constraints that depend on others at this position.
    pub redundant_constraints: usize,
    /// The smallest singular value that counts as one and the largest that counts as zero, both
    /// relative to the largest of all: the gap that decides. None where there is no such value.
    pub gap: (Option<f64>, Option<f64>),
}

impl Mechanism {
    /// The count of Gruebler and Kutzbach in space: six for each moving body, less what each joint
    /// holds.
    pub fn gruebler(&self) -> i64 {
        let held: usize = self.joints().iter().map(|j| j.joint_type.constraints().len()).sum();
        6 * (self.bodies().len() as i64 - 1) - held as i64
    }
}

impl Mobility {
    /// At the solver's present position.
    pub fn of(solver: &InverseDynamics) -> Self {
        let (topology, parameters) = (solver.topology(), solver.parameters());
        let state = solver.assembly().state();
        let values = loop_singular_values(topology, parameters, state);
        let largest = values.first().copied().unwrap_or(0.0);
        let rank = values.iter().filter(|&&s| s > NEGLIGIBLE * largest).count();
        let relative = |index: usize| values.get(index).map(|value| value / largest);
        let gruebler = solver.mechanism().gruebler();
        let instantaneous = topology.freedoms() - rank;
        Self {
            gruebler,
            instantaneous,
            finite: finite_mobility(topology, parameters, state, NEGLIGIBLE),
            redundant_constraints: (instantaneous as i64 - gruebler).unsigned_abs() as usize,
            gap: if rank == 0 {
                (None, None)
            } else {
                (relative(rank - 1), relative(rank).filter(|_| largest > 0.0))
            },
        }
    }
}
