//! A position from partial information, and the rows that rates must satisfy there.

use super::assembly::guess;
use super::bodies::State;
use super::coordinate::{Coordinate, Target};
use super::motion_constraints::MotionConstraints;
use super::system::{Kinematics, column_scales};
use crate::linalg::{RowSpace, StaticLu};
use crate::mechanism::{BodyId, Mechanism};
use crate::parameters::Parameters;
use crate::spatial::Pose;
use crate::topology::Topology;
use nalgebra::DVector;

/// Loops are closed and values met below this (rad, or m over the characteristic length).
const MET: f64 = 1e-12;
/// From here on the shortest steps of Newton's method are taken.
const NEAR: f64 = 1e-3;
const STEPS: usize = 500;
/// Rows that add less than this depend on others.
const DEPENDENT: f64 = 1e-10;

/// What is missed, by which amount (m or rad).
pub(crate) struct Missed {
    pub(crate) what: What,
    pub(crate) by: f64,
}

/// What can be missed.
pub(crate) enum What {
    /// The closure of a joint.
    Joint(usize),
    /// What was given, by its place in the list.
    Given(usize),
}

fn what(topology: &Topology, row: usize) -> What {
    let mut first = 0;
    for cut in &topology.cuts {
        first += topology.joint_types[cut.joint].constraints().len();
        if row < first {
            return What::Joint(cut.joint);
        }
    }
    What::Given(row - first)
}

fn targets(values: &[f64]) -> Vec<Target<f64>> {
    values.iter().map(|&value| Target { value, rate: 0.0, acceleration: 0.0 }).collect()
}

/// A state near the model's own guess with loops closed where coordinates have these values. All steps lie
/// in what the rows span: what is not asked for does not move.
pub(crate) fn assemble_partly(
    mechanism: &Mechanism,
    topology: &Topology,
    parameters: &Parameters<f64>,
    initial_poses: &[(BodyId, Pose<f64>)],
    (coordinates, values): (&[Coordinate], &[f64]),
) -> Result<State<f64>, Missed> {
    let mut state = guess(mechanism, topology, parameters, initial_poses);
    let motion_constraints = MotionConstraints::new(topology, coordinates, &[]);
    let mut kinematics = Kinematics::new(topology, &motion_constraints, &StaticLu::default());
    let (targets, columns) = (targets(values), column_scales(topology, parameters.length));
    let scales = motion_constraints.row_scales(parameters.length);
    let n = topology.dofs();
    let measure = |kinematics: &mut Kinematics<f64>, state: &State<f64>| {
        kinematics.place(topology, parameters, &motion_constraints, state, &targets);
        let errors = kinematics.errors().iter().zip(&scales).map(|(e, s)| e * s);
        DVector::from_iterator(scales.len(), errors)
    };
    let mut errors = measure(&mut kinematics, &state);
    let mut damping = 1e-3;
    let mut space = RowSpace::default();
    for _ in 0..STEPS {
        let worst = errors.amax();
        if errors.is_empty() || worst <= 1e-15 || !worst.is_finite() || damping > 1e12 {
            break;
        }
        kinematics.linearise(topology, &motion_constraints);
        let jacobian = kinematics.scaled_matrix(&motion_constraints, &scales, &columns);
        let step: Vec<f64> = if worst < NEAR {
            let by_rows: Vec<f64> = jacobian.transpose().iter().copied().collect();
            space.decompose(&by_rows, errors.len(), n, DEPENDENT);
            space.shortest(errors.as_slice())
        } else {
            let mut normal = jacobian.tr_mul(&jacobian);
            (0..n).for_each(|i| normal[(i, i)] += damping);
            let Some(factor) = normal.cholesky() else {
                damping *= 10.0;
                continue;
            };
            factor.solve(&jacobian.tr_mul(&errors)).iter().copied().collect()
        };
        let step: Vec<f64> = step.iter().zip(&columns).map(|(s, c)| -s * c).collect();
        let before = state.clone();
        state.advance(topology, &step);
        let next = measure(&mut kinematics, &state);
        if next.norm() < errors.norm() {
            errors = next;
            damping = (0.2 * damping).max(1e-15);
        } else {
            state = before;
            if worst < NEAR {
                break;
            }
            damping *= 5.0;
        }
    }
    let errors = measure(&mut kinematics, &state);
    let size = |row: usize| if errors[row].is_nan() { f64::INFINITY } else { errors[row].abs() };
    // What is given and contradicts shows there, not in the loops that it opens.
    let worst = (0..errors.len()).max_by(|a, b| size(*a).total_cmp(&size(*b)));
    let Some(row) = worst.filter(|row| size(*row) > MET) else { return Ok(state) };
    let given = (topology.constraints..errors.len()).max_by(|a, b| size(*a).total_cmp(&size(*b)));
    let row = given.filter(|given| size(*given) > 0.1 * size(row)).unwrap_or(row);
    Err(Missed { what: what(topology, row), by: size(row) / scales[row] })
}

/// Rows over the rates of the tree: those of loops, then those of coordinates whose rates are given.
pub(crate) struct RateRows {
    /// Row by row, scaled, over rates of which lengths count in characteristic lengths.
    pub(crate) matrix: Vec<f64>,
    pub(crate) rights: Vec<f64>,
    pub(crate) scales: Vec<f64>,
}

impl RateRows {
    pub(crate) fn new(
        topology: &Topology,
        parameters: &Parameters<f64>,
        state: &State<f64>,
        (coordinates, rates): (&[Coordinate], &[f64]),
    ) -> Self {
        let motion_constraints = MotionConstraints::new(topology, coordinates, &[]);
        let mut kinematics = Kinematics::new(topology, &motion_constraints, &StaticLu::default());
        let mut here = targets(&vec![0.0; coordinates.len()]);
        kinematics.place(topology, parameters, &motion_constraints, state, &here);
        // Where a coordinate is: its deviation from zero.
        let first = topology.constraints;
        for (target, error) in here.iter_mut().zip(&kinematics.errors()[first..]) {
            target.value = *error;
        }
        kinematics.place(topology, parameters, &motion_constraints, state, &here);
        kinematics.linearise(topology, &motion_constraints);
        let scales = motion_constraints.row_scales(parameters.length);
        let columns = column_scales(topology, parameters.length);
        let jacobian = kinematics.scaled_matrix(&motion_constraints, &scales, &columns);
        let mut rights = vec![0.0; first];
        rights.extend(rates.iter().zip(&scales[first..]).map(|(rate, scale)| rate * scale));
        let matrix = jacobian.transpose().iter().copied().collect();
        Self { matrix, rights, scales }
    }

    /// What a row belongs to.
    pub(crate) fn what(topology: &Topology, row: usize) -> What {
        what(topology, row)
    }
}
