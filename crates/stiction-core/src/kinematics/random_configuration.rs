//! Random configurations that are distant from each other and reachable from a given configuration.

use super::bodies::State;
use super::tracing::Loops;
use crate::linalg::{Decomposition, Limit};
use crate::parameters::Parameters;
use crate::random::Random;
use crate::topology::Topology;
use nalgebra::DVector;

/// Size of a step, in radians and characteristic lengths.
const STRIDE: f64 = 0.1;
/// Number of steps from one configuration to the next.
const STRIDES: usize = 8;
/// Maximum number of retries after a failed step. Near the end of the range of motion, few
/// directions succeed.
const TRIES: usize = 6;
/// Singular vectors with singular values below this fraction of the largest value are permitted
/// motions.
const OPEN: f64 = 1e-6;

/// Random configurations, and the largest distance of any of them from the initial configuration.
pub(crate) struct RandomConfiguration {
    /// Configurations with all loops closed. The initial configuration appears only if no step from
    /// it succeeds, for example if the mechanism is immobile.
    pub(crate) states: Vec<State<f64>>,
    /// Largest distance of a configuration from the initial one, in rad and characteristic lengths.
    pub(crate) reach: f64,
}

impl RandomConfiguration {
    /// Computes `count` configurations with all loops closed, starting from `state` and moving in
    /// random directions.
    pub(crate) fn new(
        topology: &Topology,
        parameters: &Parameters<f64>,
        state: &State<f64>,
        count: usize,
    ) -> Self {
        let mut loops = Loops::new(topology, parameters, &[], &[]);
        let mut random = Random::new(7);
        let mut at = state.clone();
        let mut away = DVector::zeros(topology.dofs());
        let mut reach = 0.0_f64;
        let mut states = Vec::with_capacity(count);
        for _ in 0..count {
            // A random walk returns repeatedly to its start; steps that keep one direction between
            // configurations do not.
            let mut heading: Option<DVector<f64>> = None;
            for _ in 0..STRIDES {
                let decomposition = loops.decompose(&at, Limit::OfLargest(OPEN));
                let open = decomposition.orthonormal_null_space(decomposition.rank());
                if open.is_empty() {
                    break;
                }
                let Some((next, moved)) = stride(&mut loops, &mut random, &at, &open, &heading)
                else {
                    break;
                };
                at = next;
                away += &moved;
                heading = Some(moved);
            }
            reach = reach.max(away.norm());
            states.push(at.clone());
        }
        Self { states, reach }
    }
}

/// Takes a random step that keeps the loops closed. The direction is that of the last step
/// (`heading`), projected on the permitted directions `open`, or a random one if the projection is
/// short.
fn stride(
    loops: &mut Loops<'_>,
    random: &mut Random,
    at: &State<f64>,
    open: &[DVector<f64>],
    heading: &Option<DVector<f64>>,
) -> Option<(State<f64>, DVector<f64>)> {
    let ahead = heading.as_ref().and_then(|heading| {
        let basis = nalgebra::DMatrix::from_columns(open);
        let within = &basis * basis.tr_mul(heading);
        (within.norm() > 0.5 * heading.norm()).then(|| within.normalize())
    });
    for attempt in 0..=TRIES {
        let direction = match (attempt, &ahead) {
            (0, Some(ahead)) => ahead.clone(),
            _ => random.within(open),
        };
        // Steps of equal length could return to the start along a single degree of freedom.
        let step = direction * (STRIDE * (1.0 + 0.5 * random.number()));
        if let Some((next, moved)) = loops.step(at, &step)
            // Reject blocked steps, which return, and jumps to another branch.
            && moved.norm() > 0.2 * STRIDE
            && moved.norm() < 3.0 * STRIDE
        {
            return Some((next, moved));
        }
    }
    None
}

impl Loops<'_> {
    /// Computes the rank and the null space of the scaled loop Jacobian at a configuration.
    pub(super) fn decompose(&mut self, state: &State<f64>, limit: Limit) -> Decomposition {
        self.errors(state);
        let jacobian = self.jacobian();
        let columns: Vec<usize> = (0..jacobian.ncols()).collect();
        Decomposition::new(jacobian, &columns, limit)
    }
}
