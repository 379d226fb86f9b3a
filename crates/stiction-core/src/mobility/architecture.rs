//! Architecture singularity: distinguishes singularity in every position from singularity at one.
//!
//! A rank that is short at a position taken at random is short, with probability one, in all
//! positions that can be reached from it: minors are analytic functions of the position, and those
//! that do not vanish identically vanish on a set of measure zero. So positions are taken at random,
//! far from each other, and their singular values compared. More digits in the arithmetic would
//! not add truth: the dimensions themselves are known to sixteen.
//!
//! Equation (M8) of the book's theory.

use crate::dynamics::InverseDynamics;
use crate::kinematics::{Coordinate, LoopsAt, RandomConfiguration, State, Target};
use crate::mechanism::JointId;
use crate::parameters::Parameters;
use crate::topology::Topology;

/// Positions taken.
const POSITIONS: usize = 8;
/// Singular values, relative to the largest, below this are zero.
const ZERO: f64 = 1e-9;
/// Above this they are not.
const NOT_ZERO: f64 = 1e-4;
/// Between `ZERO` and this they are zero where a motion is blocked to second order: such a position is
/// found to the square root of rounding only. Otherwise what is between is not decided.
const ROOT_OF_ZERO: f64 = 1e-6;

/// Generic ranks, at random positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Architecture {
    /// Number of positions examined.
    pub positions: usize,
    /// Distance of the farthest position from the first, rad and characteristic lengths.
    pub reach: f64,
    /// Of the constraints alone.
    pub constraints: GenericRank,
    /// Of constraints and actuators together.
    pub actuated: GenericRank,
    /// The best [`governance`] of all positions.
    pub governance: Option<f64>,
}

/// A rank in general.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GenericRank {
    /// Motions that are left open to first order: the fewest at any of the positions, idle spins
    /// included.
    pub open: usize,
    /// Of all the positions with so many the least singular value that counts, relative to the
    /// largest; none if nothing counts.
    pub kept: Option<f64>,
    /// The greatest that does not count; none if all count.
    pub dropped: Option<f64>,
    /// All singular values are clearly zero or clearly not.
    pub decided: bool,
}

impl Architecture {
    /// Examines random positions that can be reached from the solver's present one.
    pub fn of(solver: &InverseDynamics) -> Self {
        let (topology, parameters) = (solver.topology(), solver.parameters());
        let state = solver.state();
        let RandomConfiguration { states, reach } =
            RandomConfiguration::new(topology, parameters, state, POSITIONS);
        let (actuators, targets) = actuators(topology);
        let rank = |coordinates: &[Coordinate], targets: &[Target<f64>]| {
            let each = states.iter().map(|state| {
                let values = LoopsAt::singular_values_with(
                    topology,
                    parameters,
                    state,
                    coordinates,
                    targets,
                );
                (values, || {
                    LoopsAt::new(topology, parameters, state, ROOT_OF_ZERO).blocked_motions().len()
                })
            });
            GenericRank::of(each)
        };
        Self {
            positions: states.len(),
            reach,
            constraints: rank(&[], &[]),
            actuated: rank(&actuators, &targets),
            governance: states
                .iter()
                .filter_map(|state| governance_at(topology, parameters, state))
                .max_by(f64::total_cmp),
        }
    }
}

/// Singularity index of the actuators with respect to finite motions from the solver's position: the least
/// displacement of all actuators together in such a motion of size one (angles in radians, lengths in units
/// of the characteristic length). It is the paper's question whether the Jacobian of its equation (21)
/// exists; where more is free to first order, the balance has no answer even if this is not zero.
/// None if nothing moves.
pub fn governance(solver: &InverseDynamics) -> Option<f64> {
    let (topology, parameters) = (solver.topology(), solver.parameters());
    governance_at(topology, parameters, solver.state())
}

fn governance_at(
    topology: &Topology,
    parameters: &Parameters<f64>,
    state: &State<f64>,
) -> Option<f64> {
    let (actuators, targets) = actuators(topology);
    LoopsAt::new(topology, parameters, state, ROOT_OF_ZERO).governed_by(&actuators, &targets)
}

/// All actuators as prescribed coordinates, and values for them.
fn actuators(topology: &Topology) -> (Vec<Coordinate>, Vec<Target<f64>>) {
    let each = topology.actuators.iter();
    let coordinates: Vec<_> =
        each.map(|a| Coordinate::Joint { joint: JointId(a.joint), dof: a.dof }).collect();
    let at_rest = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
    let targets = vec![at_rest; coordinates.len()];
    (coordinates, targets)
}

impl GenericRank {
    /// From the singular values at each position, one for each degree of freedom, largest first, and a
    /// function that counts the motions blocked to second order there.
    fn of(positions: impl Iterator<Item = (Vec<f64>, impl FnOnce() -> usize)>) -> Self {
        let mut generic: Option<Self> = None;
        for (values, blocked) in positions {
            // Entries are of order one: where all are rounding, nothing counts.
            let largest = values.first().copied().unwrap_or(0.0).max(1.0);
            let relative = |value: &f64| value / largest;
            let values: Vec<f64> = values.iter().map(relative).collect();
            let within = |low: f64, high: f64| {
                values.iter().filter(|&&value| value > low && value <= high).count()
            };
            let rank = within(ROOT_OF_ZERO, f64::INFINITY);
            let roots = within(ZERO, ROOT_OF_ZERO);
            let here = Self {
                open: values.len() - rank,
                kept: rank.checked_sub(1).map(|last| values[last]),
                dropped: values.get(rank).copied(),
                decided: within(ROOT_OF_ZERO, NOT_ZERO) == 0 && (roots == 0 || roots <= blocked()),
            };
            generic = Some(match generic {
                Some(known) if known.open < here.open => known,
                Some(known) if known.open == here.open => known.and(here),
                _ => here,
            });
        }
        generic.unwrap_or(Self { open: 0, kept: None, dropped: None, decided: true })
    }

    fn and(self, other: Self) -> Self {
        let both = |a: Option<f64>, b: Option<f64>, f: fn(f64, f64) -> f64| match (a, b) {
            (Some(a), Some(b)) => Some(f(a, b)),
            (a, b) => a.or(b),
        };
        Self {
            open: self.open,
            kept: both(self.kept, other.kept, f64::min),
            dropped: both(self.dropped, other.dropped, f64::max),
            // One clear position decides: at others something may happen to be small.
            decided: self.decided || other.decided,
        }
    }
}
