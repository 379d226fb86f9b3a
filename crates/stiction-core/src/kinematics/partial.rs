//! Assembly of a configuration from an incomplete set of prescribed coordinates, and the linear
//! constraints on the rates at this configuration.

use super::assembly::Given;
use super::bodies::State;
use super::coordinate::{Coordinate, Target};
use super::least_squares::PositionEquations;
use super::motion_constraints::MotionConstraints;
use super::system::{Kinematics, column_scales};
use crate::linalg::{RowSpace, StaticLu};
use crate::mechanism::{BodyId, Mechanism};
use crate::parameters::Parameters;
use crate::spatial::Pose;
use crate::topology::Topology;
use nalgebra::DVector;

/// Largest scaled error at which a loop counts as closed and a given value as attained (rad, or m
/// divided by the characteristic length).
pub(super) const MET: f64 = 1e-12;
/// Scaled error below which Newton's method with minimum-norm steps replaces the damped
/// least-squares steps.
const NEAR: f64 = 1e-3;
/// Scaled error at which Newton's method stops.
const ROUND_OFF: f64 = 1e-15;
/// The final damped steps stop when the scaled error is below this fraction of [`MET`].
const FRACTION: f64 = 0.1;
/// Longest accepted step of Newton's method, in radians and characteristic lengths. At a regular
/// configuration with errors below [`NEAR`], shorter steps suffice; near a singular configuration,
/// a longer step would lead to a distant solution.
const LONGEST: f64 = 0.25;
/// Maximum number of damped steps and, separately, of Newton steps.
const STEPS: usize = 500;
/// A row of the Jacobian counts as dependent on other rows if its component orthogonal to them is
/// at most this fraction of the largest row norm (or of 1, if that is greater).
const DEPENDENT: f64 = 1e-10;

/// Condition that the computed configuration violates; `by` is the residual, m or rad.
pub(crate) struct Missed {
    pub(crate) what: What,
    pub(crate) by: f64,
    pub(crate) is_angle: bool,
}

/// Condition that a row of the position or rate equations expresses.
pub(crate) enum What {
    /// Closure of the loop at the cut joint with this index.
    Joint(usize),
    /// Equation of the gearing with this index in the mechanism.
    Gearing(usize),
    /// Given value or rate of the coordinate with this index in the caller's list.
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
    let row = row - first;
    match topology.gearings.get(row) {
        Some(own) => What::Gearing(own.gearing),
        None => What::Given(row - topology.gearings.len()),
    }
}

fn targets(values: &[f64]) -> Vec<Target<f64>> {
    values.iter().map(|&value| Target { value, rate: 0.0, acceleration: 0.0 }).collect()
}

/// Computes a state near the model's reference configuration in which the loops are closed and the
/// listed coordinates have the given values (rad or m). Newton steps have minimum norm, so
/// unrelated coordinates do not move.
///
/// # Errors
/// Returns the condition with the largest residual if not all conditions can be met.
pub(crate) fn assemble_partly(
    mechanism: &Mechanism,
    topology: &Topology,
    parameters: &Parameters<f64>,
    homes: &[(BodyId, Pose<f64>)],
    (coordinates, values): (&[Coordinate], &[f64]),
) -> Result<State<f64>, Missed> {
    let targets = targets(values);
    let given = Given { mechanism, topology, parameters, homes, coordinates, targets: &targets };
    let mut state = given.reference(true).state;
    let motion_constraints = MotionConstraints::new(topology, coordinates, &[]);
    let mut kinematics = Kinematics::new(topology, &motion_constraints, &StaticLu::default());
    let scales = motion_constraints.row_scales(parameters.length);
    let equations = PositionEquations::new(topology, parameters, &motion_constraints, &targets);
    let mut reached = equations.solve(&mut kinematics, &mut state, NEAR, STEPS).error;
    if reached > NEAR {
        // Retry from the start coordinates of the model with the given values as targets.
        let mut other = given.reference(false).state;
        let error = equations.solve(&mut kinematics, &mut other, NEAR, STEPS).error;
        if error < reached {
            (state, reached) = (other, error);
        }
    }
    let mut errors = DVector::zeros(0);
    if reached < NEAR {
        errors = close(&equations, &mut kinematics, &mut state);
    }
    if reached >= NEAR
        || reached.is_nan()
        || errors.iter().any(|error| error.abs() > MET || error.is_nan())
    {
        // Near a singular configuration, only damped steps converge. If the loops cannot close,
        // the damped steps end at the smallest error.
        equations.solve(&mut kinematics, &mut state, FRACTION * MET, STEPS);
        errors = close(&equations, &mut kinematics, &mut state);
    }
    let size = |row: usize| if errors[row].is_nan() { f64::INFINITY } else { errors[row].abs() };
    // Report a contradictory given value rather than the loop that cannot close because of this
    // value.
    let worst = (0..errors.len()).max_by(|a, b| size(*a).total_cmp(&size(*b)));
    let Some(row) = worst.filter(|row| size(*row) > MET) else { return Ok(state) };
    let given = (topology.closures()..errors.len()).max_by(|a, b| size(*a).total_cmp(&size(*b)));
    let row = given.filter(|given| size(*given) > 0.1 * size(row)).unwrap_or(row);
    let is_angle = motion_constraints.are_angles().nth(row).unwrap_or(false);
    Err(Missed { what: what(topology, row), by: size(row) / scales[row], is_angle })
}

/// Closes the loops to round-off by Newton's method with minimum-norm steps, until the errors no
/// longer decrease. Returns the scaled errors (rad, or m divided by the characteristic length).
fn close(
    equations: &PositionEquations<'_>,
    kinematics: &mut Kinematics<f64>,
    state: &mut State<f64>,
) -> DVector<f64> {
    let mut errors = equations.errors(kinematics, state);
    let mut space = RowSpace::default();
    for _ in 0..STEPS {
        if errors.is_empty() || errors.amax() <= ROUND_OFF {
            break;
        }
        let jacobian = equations.jacobian(kinematics);
        let dofs = jacobian.ncols();
        let by_rows: Vec<f64> = jacobian.transpose().to_dense().iter().copied().collect();
        space.decompose(&by_rows, errors.len(), dofs, DEPENDENT);
        let step = -DVector::from_vec(space.shortest(errors.as_slice()));
        let length = step.norm();
        if length > LONGEST || length.is_nan() {
            break;
        }
        let mut next = state.clone();
        next.advance(equations.topology(), &equations.unscaled(&step));
        let next_errors = equations.errors(kinematics, &next);
        let next_norm = next_errors.norm();
        if next_norm >= errors.norm() || next_norm.is_nan() {
            break;
        }
        (*state, errors) = (next, next_errors);
    }
    equations.errors(kinematics, state)
}

/// Linear equations for the rates of the spanning tree: the equations of loops and gearings,
/// followed by those of the coordinates whose rates are given.
pub(crate) struct RateRows {
    /// Scaled matrix in row-major order; its columns belong to rates in rad/s, and to rates of
    /// lengths in characteristic lengths per second.
    pub(crate) matrix: Vec<f64>,
    pub(crate) rights: Vec<f64>,
    pub(crate) scales: Vec<f64>,
    pub(crate) are_angles: Vec<bool>,
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
        // With a target of zero, the error of a coordinate equals its value.
        let first = topology.closures();
        for (target, error) in here.iter_mut().zip(&kinematics.errors()[first..]) {
            target.value = *error;
        }
        kinematics.place(topology, parameters, &motion_constraints, state, &here);
        kinematics.linearise(topology, parameters, &motion_constraints);
        let scales = motion_constraints.row_scales(parameters.length);
        let columns = column_scales(topology, parameters.length);
        let jacobian = kinematics.scaled_matrix(&motion_constraints, &scales, &columns);
        let mut rights = vec![0.0; first];
        rights.extend(rates.iter().zip(&scales[first..]).map(|(rate, scale)| rate * scale));
        let matrix = jacobian.transpose().to_dense().iter().copied().collect();
        let are_angles = motion_constraints.are_angles().collect();
        Self { matrix, rights, scales, are_angles }
    }

    /// Returns the condition that a row of the position or rate equations expresses.
    pub(crate) fn what(topology: &Topology, row: usize) -> What {
        what(topology, row)
    }
}
