//! Architecture singularities: distinguishes mechanisms that are singular in all configurations
//! from mechanisms that are singular only in some configurations.
//!
//! A rank deficiency at a random configuration holds, with probability one, in all configurations
//! that can be reached from it. The reason is that the minors of the Jacobian are analytic
//! functions of the configuration: a minor that does not vanish identically vanishes only on a set
//! of measure zero. The analysis therefore compares singular values at distant random
//! configurations. Extended precision would not help, because the dimensions themselves are known
//! only to sixteen digits.
//!
//! Equation (M8) of the book's theory.

use crate::dynamics::InverseDynamics;
use crate::kinematics::{Coordinate, LoopsAt, RandomConfiguration, State, Target};
use crate::mechanism::JointId;
use crate::parameters::Parameters;
use crate::topology::Topology;

/// Number of random configurations that the analysis computes.
const POSITIONS: usize = 8;
/// Relative singular values below this value are clearly zero.
const ZERO: f64 = 1e-9;
/// Relative singular values above this value are clearly non-zero. Values between [`ROOT_OF_ZERO`]
/// and this value count as non-zero, but leave the rank undecided.
const NOT_ZERO: f64 = 1e-4;
/// Relative singular values up to this value count as zero. Values between [`ZERO`] and this value
/// leave the rank undecided unless at least as many motions are blocked at second order. With such
/// motions, the configuration is accurate only to the square root of round-off.
const ROOT_OF_ZERO: f64 = 1e-6;

/// Generic ranks of constraints and actuators, from random configurations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Architecture {
    /// Number of configurations examined.
    pub positions: usize,
    /// Largest distance of an examined configuration from the solver's configuration, in rad and
    /// characteristic lengths.
    pub reach: f64,
    /// Generic rank of the constraints.
    pub constraints: GenericRank,
    /// Generic rank of constraints and actuators together.
    pub actuated: GenericRank,
    /// Largest index [`actuation_of_motion`] over the examined configurations; `None` if the
    /// mechanism is immobile in all of them.
    pub actuation_of_motion: Option<f64>,
}

/// Rank of a system of equations in a generic configuration: the mobility that the equations
/// permit, and the singular values on either side of the limit between zero and non-zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GenericRank {
    /// Generic instantaneous mobility, including passive spins: the minimum over the examined
    /// configurations.
    pub open: usize,
    /// Smallest singular value that counts as non-zero, relative to the largest one, over the
    /// configurations with the mobility `open`; `None` if all values are zero.
    pub kept: Option<f64>,
    /// Largest singular value that counts as zero, relative to the largest singular value, over the
    /// configurations with the mobility `open`; `None` if no value counts as zero.
    pub dropped: Option<f64>,
    /// True if every singular value is clearly zero or clearly non-zero in at least one of the
    /// configurations with the mobility `open`.
    pub decided: bool,
}

impl Architecture {
    /// Computes the generic ranks from random configurations that can be reached from the solver's
    /// current configuration.
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
                    ROOT_OF_ZERO,
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
            actuation_of_motion: states
                .iter()
                .filter_map(|state| actuation_of_motion_at(topology, parameters, state))
                .max_by(f64::total_cmp),
        }
    }
}

/// Computes the actuation index of the finite motions at the solver's configuration: the smallest
/// change of the actuator coordinates (root of the sum of squares) in a unit motion, with angles in
/// radians and lengths in characteristic lengths. The index is zero if the Jacobian in equation
/// (21) of Zhang et al. 2018 does not exist. If the instantaneous mobility exceeds the finite
/// mobility, the balance has no solution even for a positive index. Returns `None` for an immobile
/// mechanism.
pub fn actuation_of_motion(solver: &InverseDynamics) -> Option<f64> {
    let (topology, parameters) = (solver.topology(), solver.parameters());
    actuation_of_motion_at(topology, parameters, solver.state())
}

fn actuation_of_motion_at(
    topology: &Topology,
    parameters: &Parameters<f64>,
    state: &State<f64>,
) -> Option<f64> {
    let (actuators, targets) = actuators(topology);
    LoopsAt::new(topology, parameters, state, ROOT_OF_ZERO).governed_by(&actuators, &targets)
}

/// Returns the coordinates of all actuators as prescribed coordinates, with zero targets.
fn actuators(topology: &Topology) -> (Vec<Coordinate>, Vec<Target<f64>>) {
    let each = topology.actuators.iter();
    let coordinates: Vec<_> =
        each.map(|a| Coordinate::Joint { joint: JointId(a.joint), dof: a.dof }).collect();
    let at_rest = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
    let targets = vec![at_rest; coordinates.len()];
    (coordinates, targets)
}

impl GenericRank {
    /// Combines the ranks at all configurations. Each configuration is given by its singular values
    /// (one per degree of freedom, largest first) and a function that counts the motions blocked at
    /// second order.
    fn of(positions: impl Iterator<Item = (Vec<f64>, impl FnOnce() -> usize)>) -> Self {
        let mut generic: Option<Self> = None;
        for (values, blocked) in positions {
            // Entries of the matrix are of order one. Dividing by at least one makes the rank zero
            // if all singular values are round-off.
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
            // Clear singular values at one configuration decide, because a value may be small by
            // coincidence at another.
            decided: self.decided || other.decided,
        }
    }
}
