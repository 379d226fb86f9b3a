//! Damped least squares (Levenberg 1944, Marquardt 1963) on the position equations of a mechanism.
//!
//! The equations are the errors of loop closure and of prescribed coordinates; the unknowns are
//! small steps of the spanning tree's degrees of freedom. The method needs neither an elimination
//! plan nor a good initial guess, and it tolerates dependent equations.
//!
//! Equation (K5) of the book's theory.

use super::bodies::State;
use super::coordinate::Target;
use super::motion_constraints::MotionConstraints;
use super::system::{Kinematics, column_scales};
use crate::linalg::{ColumnOrder, SparseMatrix, SparseQr};
use crate::parameters::Parameters;
use crate::topology::Topology;
use core::cell::OnceCell;
use nalgebra::DVector;

/// Initial damping of the least-squares steps.
const DAMPING: f64 = 1e-3;
/// Smallest damping of the least-squares steps.
const LEAST_DAMPING: f64 = 1e-15;
/// Damping at which the attempts to find a step that reduces the errors end.
const GREATEST_DAMPING: f64 = 1e12;
/// Factor by which the damping is multiplied after a successful step.
const RELAX: f64 = 0.2;
/// Factor by which the damping is multiplied after a failed step.
const TIGHTEN: f64 = 5.0;
/// Largest permitted component of a step, rad or characteristic lengths. Longer steps could jump to
/// another assembly mode.
const STRIDE: f64 = 0.25;

/// Number of steps after which further steps include a correction for the curvature of the errors.
const SLOW: usize = 20;
/// Largest permitted norm of the correction for curvature, as a fraction of the norm of the step.
const BEND: f64 = 0.375;
/// Length of the finite difference for the curvature along a step, as a fraction of the step.
const PROBE: f64 = 0.1;
/// Maximum number of times that a search leaves a stationary point of the sum of squared errors
/// that is not a minimum.
const STEPS_OFF: usize = 3;

/// Position equations of a mechanism, restricted to selected equations and selected degrees of
/// freedom.
pub(super) struct PositionEquations<'a> {
    topology: &'a Topology,
    parameters: &'a Parameters<f64>,
    constraints: &'a MotionConstraints,
    targets: &'a [Target<f64>],
    /// Indices of the selected equations, each with the factor that scales its error.
    rows: Vec<(usize, f64)>,
    /// Indices of the movable degrees of freedom of the spanning tree, each with its scale factor.
    columns: Vec<(usize, f64)>,
    /// The part of the mechanism on which the selected equations depend; `None` if all bodies are
    /// placed.
    part: Option<Part>,
}

/// Nodes of the spanning tree, parents first, and cut joints.
struct Part {
    nodes: Vec<usize>,
    cuts: Vec<usize>,
}

/// Result of a search for a configuration with zero errors.
pub(super) struct Descent {
    /// Largest remaining scaled error.
    pub(super) error: f64,
    /// Sum of all steps: displacement of each degree of freedom of the spanning tree, rad or m.
    pub(super) moved: Vec<f64>,
    /// Norms of the first two steps, in rad and characteristic lengths.
    first_steps: [f64; 2],
    /// True if the errors have no derivatives at the final configuration.
    pub(super) is_undefined: bool,
}

impl Descent {
    /// Returns `true` if the steps shrink from the beginning, as those of Newton's method near a
    /// simple root. For a quadratic equation, this means that the second step is less than a
    /// quarter of the first one. The other root is then more than about 3.8 times as far from the
    /// start as the root that the method reaches.
    pub(super) fn contracts(&self) -> bool {
        let [first, second] = self.first_steps;
        first < 0.5 && second <= 0.25 * first
    }
}

impl<'a> PositionEquations<'a> {
    /// Creates the equations with all rows and all degrees of freedom selected.
    pub(super) fn new(
        topology: &'a Topology,
        parameters: &'a Parameters<f64>,
        constraints: &'a MotionConstraints,
        targets: &'a [Target<f64>],
    ) -> Self {
        let rows = constraints.row_scales(parameters.length).into_iter().enumerate().collect();
        let columns = column_scales(topology, parameters.length).into_iter().enumerate().collect();
        Self { topology, parameters, constraints, targets, rows, columns, part: None }
    }

    /// Moves only the bodies on which the selected equations depend, if these are equations of cut
    /// joints. All bodies must be placed once before, at any configuration.
    pub(super) fn in_part(mut self) -> Self {
        let all = &self.topology.cuts;
        let count = all.last().map_or(0, |cut| cut.constraints.end);
        if self.rows.iter().all(|(row, _)| *row < count) {
            let rows = self.rows.iter().map(|(row, _)| *row);
            let paths = rows.clone().flat_map(|row| &self.constraints.rows[row].path);
            let mut nodes: Vec<usize> = paths.map(|(node, _)| *node).collect();
            nodes.sort_unstable();
            nodes.dedup();
            let mut cuts: Vec<usize> =
                rows.map(|row| all.partition_point(|cut| cut.constraints.end <= row)).collect();
            cuts.dedup();
            self.part = Some(Part { nodes, cuts });
        }
        self
    }

    /// Multiplies the scale of each equation by `factor`, which receives the index of the equation.
    /// Removes equations with the factor zero.
    pub(super) fn weighted(mut self, factor: impl Fn(usize) -> f64) -> Self {
        self.rows.iter_mut().for_each(|(row, scale)| *scale *= factor(*row));
        self.rows.retain(|(_, scale)| *scale != 0.0);
        self
    }

    /// Fixes all degrees of freedom of the spanning tree for which `moves` returns `false`.
    pub(super) fn moving(mut self, moves: impl Fn(usize) -> bool) -> Self {
        self.columns.retain(|(column, _)| moves(*column));
        self
    }

    pub(super) fn topology(&self) -> &Topology {
        self.topology
    }

    /// Computes the poses of the bodies and returns the scaled errors.
    pub(super) fn errors(
        &self,
        kinematics: &mut Kinematics<f64>,
        state: &State<f64>,
    ) -> DVector<f64> {
        let Self { topology, parameters, .. } = self;
        match &self.part {
            None => kinematics.place(topology, parameters, self.constraints, state, self.targets),
            Some(Part { nodes, cuts }) => {
                kinematics.place_part(topology, parameters, &state.coordinates, (nodes, cuts));
            }
        }
        let errors = kinematics.errors();
        DVector::from_iterator(self.rows.len(), self.rows.iter().map(|(r, s)| errors[*r] * s))
    }

    /// Computes the scaled derivatives of the errors at the last computed poses of the bodies.
    pub(super) fn jacobian(&self, kinematics: &mut Kinematics<f64>) -> SparseMatrix {
        let mut column_of = vec![usize::MAX; self.topology.dofs()];
        self.columns.iter().enumerate().for_each(|(place, (column, _))| column_of[*column] = place);
        let (all, mut own) = (self.constraints.entries(), Vec::new());
        for (place, &(row, scale)) in self.rows.iter().enumerate() {
            let first = all.partition_point(|entry| entry.row < row);
            let (topology, parameters) = (self.topology, self.parameters);
            let at = (row, first);
            let end = kinematics.linearise_row(topology, parameters, self.constraints, at);
            for (entry, value) in all[first..end].iter().zip(&kinematics.entries[first..end]) {
                let column = column_of[entry.column];
                if column != usize::MAX {
                    own.push((place, column, value * scale * self.columns[column].1));
                }
            }
        }
        SparseMatrix::new((self.rows.len(), self.columns.len()), own.into_iter())
    }

    /// Converts a scaled step to displacements of the spanning tree's degrees of freedom, rad or m.
    pub(super) fn unscaled(&self, step: &DVector<f64>) -> Vec<f64> {
        let mut rates = vec![0.0; self.topology.dofs()];
        for (x, (column, scale)) in step.iter().zip(&self.columns) {
            rates[*column] = x * scale;
        }
        rates
    }

    /// Computes half the second derivative of the errors along a step, by a finite difference. A
    /// correction for this curvature makes steps follow the curved valleys of the sum of squared
    /// errors near singular configurations (geodesic acceleration, Transtrum and Sethna 2012).
    fn half_acceleration(
        &self,
        kinematics: &mut Kinematics<f64>,
        state: &State<f64>,
        (jacobian, errors): (&SparseMatrix, &DVector<f64>),
        step: &DVector<f64>,
    ) -> DVector<f64> {
        let mut probe = state.clone();
        probe.advance(self.topology, &self.unscaled(&(step * PROBE)));
        let slope = (self.errors(kinematics, &probe) - errors) / PROBE;
        (slope - DVector::from_vec(jacobian.times(step.as_slice()))) / PROBE
    }

    /// Moves `state` until all scaled errors are below `close`, until the sum of squared errors
    /// stops decreasing at a minimum, or for at most `most` steps.
    pub(super) fn solve(
        &self,
        kinematics: &mut Kinematics<f64>,
        state: &mut State<f64>,
        close: f64,
        most: usize,
    ) -> Descent {
        let mut errors = self.errors(kinematics, state);
        let mut damping = DAMPING;
        let mut sizes = Vec::with_capacity(2);
        let mut moved = vec![0.0; self.topology.dofs()];
        let mut is_undefined = false;
        let damped = DampedSteps::default();
        let mut left = STEPS_OFF;
        let mut stationary: Option<(State<f64>, Vec<f64>, f64)> = None;
        for count in 0..most {
            if errors.is_empty() || self.columns.is_empty() || errors.amax() < close {
                break;
            }
            let jacobian = self.jacobian(kinematics);
            if !jacobian.entries().all(|(.., slope)| slope.is_finite()) {
                is_undefined = true;
                break;
            }
            let mut improved = false;
            while damping < GREATEST_DAMPING {
                let Some(mut step) = damped.step(&jacobian, &errors, damping) else {
                    damping *= 10.0;
                    continue;
                };
                if count >= SLOW {
                    let half =
                        self.half_acceleration(kinematics, state, (&jacobian, &errors), &step);
                    match damped.step(&jacobian, &half, damping) {
                        Some(bend) if bend.norm() <= BEND * step.norm() => step += bend,
                        _ => {
                            damping *= TIGHTEN;
                            continue;
                        }
                    }
                }
                let longest = step.amax();
                if longest > STRIDE {
                    step *= STRIDE / longest;
                }
                let rates = self.unscaled(&step);
                let before = state.clone();
                state.advance(self.topology, &rates);
                let trial = self.errors(kinematics, state);
                if trial.norm_squared() < errors.norm_squared() {
                    improved = trial.norm() < errors.norm() * (1.0 - 1e-12);
                    errors = trial;
                    damping = (damping * RELAX).max(LEAST_DAMPING);
                    if sizes.len() < 2 {
                        sizes.push(step.norm());
                    }
                    moved.iter_mut().zip(&rates).for_each(|(sum, rate)| *sum += rate);
                    break;
                }
                *state = before;
                damping *= TIGHTEN;
            }
            if improved {
                continue;
            }
            let step_off = match left {
                0 => None,
                _ => self.step_off(kinematics, state),
            };
            let Some(step) = step_off else { break };
            left -= 1;
            stationary = Some((state.clone(), moved.clone(), errors.norm()));
            // Later steps do not begin at the start of the search, so their sizes do not indicate
            // contraction.
            sizes.resize(2, f64::INFINITY);
            let rates = self.unscaled(&step);
            state.advance(self.topology, &rates);
            moved.iter_mut().zip(&rates).for_each(|(sum, rate)| *sum += rate);
            errors = self.errors(kinematics, state);
            damping = DAMPING;
        }
        if let Some((before, moved_before, least)) = stationary
            && (errors.norm() >= least || errors.norm().is_nan())
        {
            *state = before;
            moved = moved_before;
        }
        let errors = self.errors(kinematics, state);
        let error = if errors.is_empty() { 0.0 } else { errors.amax() };
        let size = |k: usize| sizes.get(k).copied().unwrap_or(0.0);
        Descent { error, moved, first_steps: [size(0), size(1)], is_undefined }
    }
}

/// Number of columns from which sparse factors are used, because they are then faster than the
/// dense normal matrix.
const LARGE: usize = 60;

/// Computes damped least-squares steps for matrices with the same pattern of nonzeros.
#[derive(Default)]
pub(super) struct DampedSteps {
    order: OnceCell<ColumnOrder>,
}

impl DampedSteps {
    /// Computes the damped step `-(J^T J + d 1)^-1 J^T e` for the Jacobian `J`, the errors `e` and
    /// the damping `d`. Returns `None` if the step cannot be computed.
    pub(super) fn step(
        &self,
        jacobian: &SparseMatrix,
        errors: &DVector<f64>,
        damping: f64,
    ) -> Option<DVector<f64>> {
        match jacobian.ncols() < LARGE {
            true => by_normal_matrix(jacobian, errors, damping),
            false => by_triangular_factor(jacobian, errors, damping, &self.order),
        }
    }
}

/// Computes the damped step from the smaller of the normal matrices `J^T J` and `J J^T`; `None` if
/// this matrix is not positive definite in floating-point arithmetic.
fn by_normal_matrix(
    jacobian: &SparseMatrix,
    errors: &DVector<f64>,
    damping: f64,
) -> Option<DVector<f64>> {
    let is_wide = jacobian.nrows() < jacobian.ncols();
    let mut normal = match is_wide {
        true => jacobian.times_transposed(),
        false => jacobian.transpose().times_transposed(),
    };
    (0..normal.nrows()).for_each(|i| normal[(i, i)] += damping);
    let factor = normal.cholesky()?;
    let product =
        |right: &DVector<f64>| DVector::from_vec(jacobian.transposed_times(right.as_slice()));
    Some(match is_wide {
        true => -product(&factor.solve(errors)),
        false => -factor.solve(&product(errors)),
    })
}

/// Computes the damped step from the triangular factor of the stacked matrices `J` and `sqrt(d) 1`,
/// with the errors as their last column. For chains of bodies, rows of loops and legs, the cost
/// grows linearly with their number. Returns `None` if the step is not finite or the factor is
/// singular.
fn by_triangular_factor(
    jacobian: &SparseMatrix,
    errors: &DVector<f64>,
    damping: f64,
    order: &OnceCell<ColumnOrder>,
) -> Option<DVector<f64>> {
    let (rows, columns) = (jacobian.nrows(), jacobian.ncols());
    let damped = (0..columns).map(|k| (rows + k, k, damping.sqrt()));
    let stacked = || jacobian.entries().chain(damped.clone());
    // Any column order is correct; an order chosen for a pattern with more zeros may be slower.
    let order = order.get_or_init(|| {
        let matrix = SparseMatrix::new((rows + columns, columns), stacked());
        ColumnOrder::one_by_one(&matrix).followed_by_one()
    });
    let right = errors.iter().enumerate().map(|(row, error)| (row, columns, -error));
    let matrix = SparseMatrix::new((rows + columns, columns + 1), stacked().chain(right));
    let factor = SparseQr::new(&matrix, order, 0.0);
    let step = factor.solution_for_last();
    let is_regular = factor.dependent().iter().all(|column| *column == columns);
    (is_regular && step.iter().all(|x| x.is_finite())).then(|| DVector::from_vec(step))
}
