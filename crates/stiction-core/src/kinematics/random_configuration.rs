//! Random configurations, far from each other, all reached from one.

use super::bodies::State;
use super::tracing::Loops;
use crate::linalg::Svd;
use crate::parameters::Parameters;
use crate::random::Random;
use crate::topology::Topology;
use nalgebra::DVector;

/// Size of a stride, angles in radians, lengths in units of the characteristic length.
const STRIDE: f64 = 0.1;
/// Strides from one position to the next.
const STRIDES: usize = 8;
/// Tries of a stride; where motion ends, few directions go on.
const TRIES: usize = 6;
/// Singular values, relative to the largest, below this leave a motion open.
const OPEN: f64 = 1e-6;

/// Positions and how far they go.
pub(crate) struct RandomConfiguration {
    /// The positions; the first is not the one of departure, unless nothing moves.
    pub(crate) states: Vec<State<f64>>,
    /// The greatest distance of any of them from the position of departure.
    pub(crate) reach: f64,
}

impl RandomConfiguration {
    /// `count` positions, reached from `state` in random directions with all loops closed.
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
            // A walk at random keeps coming back; one direction for each position does not.
            let mut heading: Option<DVector<f64>> = None;
            for _ in 0..STRIDES {
                let svd = loops.svd(&at);
                let open = svd.null_space(svd.rank(OPEN));
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

/// A stride on, in the direction of the last one as far as that is open, or in a new one.
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
        // Strides of equal length could return to the start along a single degree of freedom.
        let step = direction * (STRIDE * (1.0 + 0.5 * random.number()));
        if let Some((next, moved)) = loops.step(at, &step)
            // Blocked steps come back, and jumps lead to another branch.
            && moved.norm() > 0.2 * STRIDE
            && moved.norm() < 3.0 * STRIDE
        {
            return Some((next, moved));
        }
    }
    None
}

impl Loops<'_> {
    /// Decomposes the equations at a position.
    pub(super) fn svd(&mut self, state: &State<f64>) -> Svd {
        self.errors(state);
        Svd::new(&self.jacobian())
    }
}
