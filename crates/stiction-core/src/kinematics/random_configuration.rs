//! Generates random configurations that are distant from each other and can be reached from a
//! given configuration by a continuous motion.

use super::bodies::State;
use super::tracing::Loops;
use crate::linalg::{Basis, Decomposition, Limit};
use crate::parameters::Parameters;
use crate::random::Random;
use crate::topology::Topology;
use nalgebra::DVector;

/// Nominal length of a step, in radians and characteristic lengths.
const STRIDE: f64 = 0.1;
/// Number of steps from one returned configuration to the next.
const STRIDES: usize = 8;
/// Maximum number of retries after a failed step. Near the end of the range of motion, only a few
/// directions lead to a successful step.
const TRIES: usize = 6;
/// Right singular vectors of the loop Jacobian are permitted directions of motion if their
/// singular values are below this fraction of the largest singular value.
const OPEN: f64 = 1e-6;

/// Set of random configurations, with their largest distance from the initial configuration.
pub(crate) struct RandomConfiguration {
    /// Configurations with all loops closed. The initial configuration is among them only if no
    /// step from it succeeds, for example if the mechanism is immobile.
    pub(crate) states: Vec<State<f64>>,
    /// Largest distance of a configuration from the initial one, in radians and characteristic
    /// lengths.
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
            // Within one series of steps, the direction is kept: a walk with a new random
            // direction at each step would return repeatedly to its start.
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

/// Takes a random step that keeps the loops closed. Its direction is that of the previous step
/// (`heading`), projected on the permitted directions `open`. If the projection is short or the
/// step fails, random directions are tried. Returns the new state and the scaled step; `None` if
/// all attempts fail.
fn stride(
    loops: &mut Loops<'_>,
    random: &mut Random,
    at: &State<f64>,
    open: &Basis,
    heading: &Option<DVector<f64>>,
) -> Option<(State<f64>, DVector<f64>)> {
    let ahead = heading.as_ref().and_then(|heading| {
        let within = open.projection(heading);
        (within.norm() > 0.5 * heading.norm()).then(|| within.normalize())
    });
    for attempt in 0..=TRIES {
        let direction = match (attempt, &ahead) {
            (0, Some(ahead)) => ahead.clone(),
            _ => random.within(open),
        };
        // With steps of equal length, forward and backward steps along a single degree of freedom
        // could end exactly at the start.
        let step = direction * (STRIDE * (1.0 + 0.5 * random.number()));
        if let Some((next, moved)) = loops.step(at, &step)
            // Reject steps that hardly move, and jumps to another branch of solutions.
            && moved.norm() > 0.2 * STRIDE
            && moved.norm() < 3.0 * STRIDE
        {
            return Some((next, moved));
        }
    }
    None
}

impl Loops<'_> {
    /// Decomposes the scaled loop Jacobian at a configuration; the result contains its rank and
    /// null space.
    pub(super) fn decompose(&mut self, state: &State<f64>, limit: Limit) -> Decomposition {
        self.errors(state);
        let jacobian = self.jacobian();
        let columns: Vec<usize> = (0..jacobian.ncols()).collect();
        Decomposition::new(jacobian, &columns, limit)
    }
}
