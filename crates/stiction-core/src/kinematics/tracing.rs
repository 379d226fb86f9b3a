//! Determines finite mobility by tracing motions over a finite distance.
//!
//! A motion is open at first order if the loop errors have no first derivative along it. It is open
//! at second order if the second derivatives of the loop errors also vanish for suitable
//! accelerations; otherwise it is blocked at second order. Scaled displacements, rates and errors
//! are measured in radians and characteristic lengths.
//!
//! Equation (M3) of the book's theory.

use super::bodies::State;
use super::coordinate::{Coordinate, Target};
use super::finite_motion::{Path, farthest};
use super::least_squares::DampedSteps;
use super::motion_constraints::MotionConstraints;
use super::system::{Kinematics, column_scales};
use crate::linalg::{
    Basis, Decomposition, Limit, SparseMatrix, SparseVector, StaticLu, Svd, complement,
};
use crate::parameters::Parameters;
use crate::random::Random;
use crate::topology::Topology;
use nalgebra::{DMatrix, DVector};

/// Length of a step that tests a motion, in radians and characteristic lengths. After a step along
/// a blocked motion, closing the loops leaves a displacement that depends on the closure tolerance.
/// The displacement is about the square root of this tolerance if the motion is blocked at second
/// order, and about the fourth root, 6e-4, if it is blocked at fourth order.
const STEP: f64 = 4e-3;
/// Length of the step away from a possible intersection of branches of motion, in radians and
/// characteristic lengths. Near an intersection, the radius of curvature of a branch is about its
/// distance from the intersection. Over a [`STEP`], a branch therefore deviates by about
/// `STEP / AWAY` of the step.
const AWAY: f64 = 0.1;
/// Scaled error (rad, or m divided by the characteristic length) below which the loops count as
/// closed.
const CLOSED: f64 = 1e-13;
/// Maximum number of corrections that close the loops after a step.
const CORRECTIONS: usize = 400;
/// Bounds on the ratio of the error after a correction to the error before it. Below the first
/// bound, the correction is repeated with more damping; above the second, later corrections have
/// less damping. This keeps corrections short. For the equations `x^2 = 0` and `x y = 0`, long
/// corrections would lead straight to the origin, although y is free; short corrections lead to the
/// line `x = 0`.
const GENTLY: (f64, f64) = (0.25, 0.6);
/// Scaled error below which the bounds [`GENTLY`] do not apply. At this error, displacements along
/// blocked motions have decreased to about 1e-3, far below those along free motions.
const NEAR: f64 = 1e-6;
/// A displacement that remains after closing the loops counts as motion if it exceeds this fraction
/// of the step. The curvature of a motion causes a smaller spurious displacement (about 0.04), and
/// so does a blocked motion (at most 0.14, see [`STEP`]).
const MOVES: f64 = 0.2;

/// Minimum length of a path that counts as a finite motion, in radians and characteristic lengths.
const FINITE: f64 = 0.2;
/// Number of independent motions of a mechanism above which random motions replace a basis. A body
/// has at most six independent motions; twice as many random motions determine them well.
const FEW_MOTIONS: usize = 12;
/// Maximum number of directions open at second order along which a motion is traced.
const DIRECTIONS: usize = 4;

/// Loop equations of a mechanism, optionally with the equations of prescribed coordinates.
pub(super) struct Loops<'a> {
    topology: &'a Topology,
    parameters: &'a Parameters<f64>,
    motion_constraints: MotionConstraints,
    targets: Vec<Target<f64>>,
    kinematics: Kinematics<f64>,
    rows: Vec<f64>,
    columns: Vec<f64>,
    pub(super) damped: DampedSteps,
}

/// Loop equations at a configuration, with their singular value decomposition.
pub(crate) struct LoopsAt<'a> {
    loops: Loops<'a>,
    state: &'a State<f64>,
    /// Singular value decomposition of the scaled loop Jacobian.
    decomposition: Decomposition,
    /// Number of linearly independent loop equations.
    pub(crate) rank: usize,
    negligible: f64,
    /// Orthonormal basis of the instantaneous motions (scaled), which are open at first order.
    open: Basis,
    /// Displacement to the branch of motion with the greatest finite mobility, scaled; `None`
    /// before [`Self::finite_mobility`] finds a motion.
    traced: Option<DVector<f64>>,
}

impl<'a> LoopsAt<'a> {
    /// Decomposes the loop equations at a state. Singular values below `negligible` times the
    /// largest one (or times 1, if that is greater) count as zero.
    pub(crate) fn new(
        topology: &'a Topology,
        parameters: &'a Parameters<f64>,
        state: &'a State<f64>,
        negligible: f64,
    ) -> Self {
        let mut loops = Loops::new(topology, parameters, &[], &[]);
        // All entries are round-off in a loop without constraints, such as two prismatic joints
        // along one axis, so the limit must not depend on the largest entry alone.
        let decomposition = loops.decompose(state, Limit::OfOrderOne(negligible));
        let rank = decomposition.rank();
        let open = decomposition.orthonormal_null_space(rank);
        Self { loops, state, decomposition, rank, negligible, open, traced: None }
    }

    /// Computes the singular values of the combined equations of loops and `coordinates` at a
    /// configuration, largest first, one for each degree of freedom of the spanning tree. Values
    /// below `negligible` times the largest one (or times 1, if that is greater) count as zero. For
    /// large systems only a few values are computed, see [`Decomposition::values`].
    pub(crate) fn singular_values_with(
        topology: &Topology,
        parameters: &Parameters<f64>,
        state: &State<f64>,
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
        negligible: f64,
    ) -> Vec<f64> {
        let mut loops = Loops::new(topology, parameters, coordinates, targets);
        loops.decompose(state, Limit::OfOrderOne(negligible)).values()
    }

    /// Returns the smallest singular value that counts as non-zero and the largest one that counts
    /// as zero, both divided by the largest singular value. `None` replaces a value that does not
    /// exist.
    pub(crate) fn gap(&self) -> (Option<f64>, Option<f64>) {
        let Some(last) = self.rank.checked_sub(1) else { return (None, None) };
        let relative = |k| self.decomposition.value(k) / self.decomposition.largest();
        let dropped = (self.rank < self.loops.columns.len()).then(|| relative(self.rank));
        (Some(relative(last)), dropped)
    }

    /// Returns the instantaneous mobility: the number of independent motions that are open at first
    /// order.
    pub(crate) fn mobility(&self) -> usize {
        self.loops.columns.len() - self.rank
    }

    /// Determines the finite mobility, the number of independent motions over a finite distance.
    /// Takes small steps from a generic configuration in directions open at first order, closes the
    /// loops, and counts the independent displacements that remain.
    pub(crate) fn finite_mobility(&mut self) -> usize {
        let Self { loops, state, open, .. } = self;
        // If the loop equations are independent, each instantaneous motion extends to a finite one.
        if open.is_empty() || self.rank == loops.topology.closures() {
            return open.len();
        }
        let mut random = Random::new(1);
        // At an intersection of branches, the instantaneous mobility exceeds the mobility of each
        // branch, so step away first. Branches may differ in mobility; for each mobility, keep the
        // configuration with the longest remaining step.
        let mut branches: Vec<Branch> = Vec::new();
        for _ in 0..2 * open.len() + 6 {
            let Some((reached, displacement)) = loops.step(state, &(random.within(open) * AWAY))
            else {
                continue;
            };
            // A step that returns to its start belongs to no branch.
            let moved = displacement.norm() / AWAY;
            if moved <= 0.5 * MOVES {
                continue;
            }
            // Loops are closed to 1e-13. Singular values of a double root are accurate only to the
            // square root of this tolerance.
            let limit = Limit::OfOrderOne(self.negligible.max(1e-6));
            let decomposition = loops.decompose(&reached, limit);
            let open = decomposition.orthonormal_null_space(decomposition.rank());
            match branches.iter_mut().find(|known| known.open.len() == open.len()) {
                Some(known) if known.moved >= moved => {}
                Some(known) => *known = Branch { moved, displacement, reached, open },
                None => branches.push(Branch { moved, displacement, reached, open }),
            }
        }
        let mut count = 0;
        for branch in branches {
            let motions = loops.motions_at(&branch, &mut random);
            if motions > count {
                (count, self.traced) = (motions, Some(branch.displacement));
            }
        }
        count
    }

    /// Traces a motion over a finite distance: first toward the branch that
    /// [`Self::finite_mobility`] found, then in directions that are open at second order. Returns
    /// the body that moves farthest on the longest path, its displacement in m and rad, and the
    /// largest loop error along the path (rad and characteristic lengths). `None` if the loop
    /// equations are independent, or if no such motion exists.
    pub(crate) fn finite_motion(&mut self) -> Option<(usize, f64, f64, f64)> {
        if self.open.is_empty() || self.rank == self.loops.topology.closures() {
            return None;
        }
        let mut directions: Vec<DVector<f64>> = self.traced.clone().into_iter().collect();
        let to_second = self.open_to_second();
        directions.extend((0..to_second.len().min(DIRECTIONS)).map(|k| to_second.vector(k)));
        let Self { loops, state, .. } = self;
        let mut best: Option<Path> = None;
        for direction in directions {
            let path = loops.follow(state, &direction);
            if path.length > FINITE && best.as_ref().is_none_or(|best| path.length > best.length) {
                best = Some(path);
            }
        }
        let path = best?;
        loops.errors(&path.state);
        let reached = loops.kinematics.bodies.clone();
        loops.errors(state);
        let (body, moved, turned) =
            farthest(&loops.kinematics.bodies, &reached, loops.parameters.length)?;
        Some((body, moved, turned, path.closure))
    }

    /// Finds the motions that are open at first order, as rates of the spanning tree. Some of these
    /// motions are blocked at second order: the loop equations are dependent along them, but the
    /// second derivatives are incompatible. The second derivatives along the self-stresses of the
    /// loops are exact quadratic forms. If these forms are indefinite, branches of motion meet, and
    /// the returned `to_second` contains too few motions.
    pub(crate) fn open_motions(&mut self) -> OpenMotions {
        let to_second = self.open_to_second();
        let columns = &self.loops.columns;
        let rates = |scaled: &DVector<f64>| -> Vec<f64> {
            scaled.iter().zip(columns).map(|(rate, scale)| rate * scale).collect()
        };
        let spanning = |basis: &Basis| -> Vec<Vec<f64>> {
            let motions = match basis.len() <= FEW_MOTIONS {
                true => basis.dense(),
                false => Random::new(3).sums(basis.vectors(), columns.len(), FEW_MOTIONS),
            };
            motions.iter().map(rates).collect()
        };
        OpenMotions {
            all: spanning(&self.open),
            to_second: spanning(&to_second),
            second_order: to_second.len(),
        }
    }

    /// Computes the smallest change of the `coordinates` over all unit motions that are open at
    /// second order. The change is the root of the sum of squares, scaled. `None` if no motion is
    /// open at second order.
    pub(crate) fn governed_by(
        &mut self,
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
    ) -> Option<f64> {
        let basis = self.open_to_second();
        if basis.is_empty() {
            return None;
        }
        let loops = &self.loops;
        let mut with = Loops::new(loops.topology, loops.parameters, coordinates, targets);
        with.errors(self.state);
        let jacobian = with.jacobian();
        let first = jacobian.nrows() - coordinates.len();
        let entries = basis.vectors().iter().enumerate().flat_map(|(column, motion)| {
            let rates = jacobian.times_sparse(motion).split_off(first);
            rates.into_iter().enumerate().map(move |(row, rate)| (row, column, rate))
        });
        let rates = SparseMatrix::new((coordinates.len(), basis.len()), entries);
        let motions: Vec<usize> = (0..basis.len()).collect();
        let rates = Decomposition::new(rates, &motions, Limit::OfOrderOne(self.negligible));
        Some(rates.value(motions.len() - 1))
    }

    /// Finds the motions that are open at first order and blocked at second order.
    pub(crate) fn blocked_motions(&mut self) -> Vec<BlockedMotion> {
        let to_second = self.open_to_second();
        let blocked = complement(&self.open, &to_second);
        let Self { loops, state, .. } = self;
        let each = blocked.iter().map(|scaled| {
            loops.errors(state);
            let biases = loops.second_derivatives(scaled);
            let (rows, columns) = (&loops.rows, &loops.columns);
            BlockedMotion {
                rates: scaled.iter().zip(columns).map(|(rate, scale)| rate * scale).collect(),
                biases: biases.iter().zip(rows).map(|(bias, scale)| bias / scale).collect(),
            }
        });
        each.collect()
    }

    /// Computes an orthonormal basis of the scaled motions that are open at second order.
    fn open_to_second(&mut self) -> Basis {
        let Self { loops, state, open, .. } = self;
        loops.errors(state);
        let count = open.len();
        let transposed = loops.jacobian().transpose();
        let equations: Vec<usize> = (0..transposed.ncols()).collect();
        let limit = Limit::OfOrderOne(self.negligible);
        let stresses: Vec<SparseVector> = match self.rank < equations.len() {
            true => Decomposition::new(transposed, &equations, limit).null_space(self.rank),
            false => Vec::new(),
        };
        if stresses.is_empty() {
            return open.clone();
        }
        let open = open.dense();
        let pure: Vec<DVector<f64>> = open.iter().map(|d| loops.second_derivatives(d)).collect();
        // The quadratic forms of all self-stresses, one below the other.
        let mut forms = DMatrix::zeros(count * stresses.len(), count);
        for i in 0..count {
            for j in i..count {
                // (x + y)^2 - x^2 - y^2 = 2 x y.
                let mixed = if i == j {
                    pure[i].clone()
                } else {
                    let sum = loops.second_derivatives(&(&open[i] + &open[j]));
                    (sum - &pure[i] - &pure[j]) * 0.5
                };
                for (k, stress) in stresses.iter().enumerate() {
                    let value = stress.iter().map(|&(row, x)| x * mixed[row]).sum::<f64>();
                    forms[(k * count + i, j)] = value;
                    forms[(k * count + j, i)] = value;
                }
            }
        }
        let forms = Svd::new(&forms);
        // Second derivatives of unit motions, in characteristic lengths, are of order one.
        let blocked = forms.singular_values.iter().filter(|&&value| value > 1e-6).count();
        let own = forms.null_space(blocked);
        let own: Vec<_> =
            own.iter().map(|amounts| self.open.sum(amounts.iter().copied())).collect();
        Basis::of_dense(&own, loops.columns.len())
    }
}

/// A motion that is open at first order and blocked at second order.
pub(crate) struct BlockedMotion {
    /// Rates of the spanning tree in this motion, rad/s or m/s.
    pub(crate) rates: Vec<f64>,
    /// Second derivatives of the loop errors along the motion, rad/s^2 or m/s^2.
    pub(crate) biases: Vec<f64>,
}

/// Configuration on a branch of motion, reached by a step from the initial configuration.
struct Branch {
    /// Norm of the displacement that remains after closing the loops, as a fraction of the step.
    moved: f64,
    /// Scaled displacement from the initial configuration.
    displacement: DVector<f64>,
    reached: State<f64>,
    /// Basis of the scaled instantaneous motions at this configuration.
    open: Basis,
}

/// Motions that are open at first order, as rates of the spanning tree (rad/s or m/s). A basis of
/// many motions is replaced by [`FEW_MOTIONS`] random ones, in which each body has, with probability
/// one, all its independent motions.
pub(crate) struct OpenMotions {
    /// All motions that are open at first order.
    pub(crate) all: Vec<Vec<f64>>,
    /// The motions that are also open at second order.
    pub(crate) to_second: Vec<Vec<f64>>,
    /// Number of independent motions that are also open at second order.
    pub(crate) second_order: usize,
}

impl<'a> Loops<'a> {
    /// Creates the loop equations and those of the prescribed `coordinates`, with one target for
    /// each coordinate.
    pub(super) fn new(
        topology: &'a Topology,
        parameters: &'a Parameters<f64>,
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
    ) -> Self {
        let motion_constraints = MotionConstraints::new(topology, coordinates, &[]);
        let kinematics = Kinematics::new(topology, &motion_constraints, &StaticLu::default());
        let rows = motion_constraints.row_scales(parameters.length);
        let columns = column_scales(topology, parameters.length);
        let targets = targets.to_vec();
        let damped = DampedSteps::default();
        Self {
            topology,
            parameters,
            motion_constraints,
            targets,
            kinematics,
            rows,
            columns,
            damped,
        }
    }

    /// Computes the poses of the bodies and returns the scaled errors of all equations.
    pub(super) fn errors(&mut self, state: &State<f64>) -> DVector<f64> {
        let Self { topology, parameters, motion_constraints, targets, .. } = self;
        self.kinematics.place(topology, parameters, motion_constraints, state, targets);
        let errors = self.kinematics.errors().iter().zip(&self.rows).map(|(e, s)| e * s);
        DVector::from_iterator(self.rows.len(), errors)
    }

    /// Computes the scaled Jacobian of the errors at the last computed poses of the bodies.
    pub(super) fn jacobian(&mut self) -> SparseMatrix {
        self.kinematics.linearise(self.topology, self.parameters, &self.motion_constraints);
        self.kinematics.scaled_matrix(&self.motion_constraints, &self.rows, &self.columns)
    }

    /// Computes the scaled second derivatives of the errors for constant rates of the spanning tree
    /// (`rates`, scaled), at the last computed poses of the bodies.
    fn second_derivatives(&mut self, rates: &DVector<f64>) -> DVector<f64> {
        let rates: Vec<f64> = rates.iter().zip(&self.columns).map(|(r, c)| r * c).collect();
        self.kinematics.bodies.move_with(self.topology, &rates);
        let biases = self.kinematics.closure_biases(
            self.topology,
            self.parameters,
            &self.motion_constraints,
        );
        DVector::from_iterator(
            self.rows.len(),
            biases.iter().zip(&self.rows).map(|(bias, scale)| bias * scale),
        )
    }

    /// Takes steps in random open directions from the configuration on a branch, closes the loops,
    /// and counts the independent displacements that remain.
    fn motions_at(&mut self, branch: &Branch, random: &mut Random) -> usize {
        let Branch { reached, open, .. } = branch;
        let mut left = Vec::new();
        for _ in 0..2 * open.len() + 6 {
            let step = random.within(open) * STEP;
            if let Some((_, moved)) = self.step(reached, &step) {
                left.push(moved / STEP);
            }
        }
        if left.is_empty() {
            return 0;
        }
        // Along each open direction, the random steps have similar components on average.
        let each = (left.len() as f64 / open.len() as f64).sqrt();
        let spread = Svd::new(&DMatrix::from_columns(&left));
        let limit = MOVES * each;
        let counted = spread.singular_values.iter().filter(|&&value| value > limit).count();
        // If the radius of curvature of a path is comparable to the step, the curvature adds a
        // spurious displacement; the count is limited to the instantaneous mobility.
        counted.min(open.len())
    }

    /// Takes a scaled step and closes the loops with damped least-squares corrections. Returns the
    /// state and the total displacement (scaled); `None` if the loops remain open.
    pub(super) fn step(
        &mut self,
        from: &State<f64>,
        step: &DVector<f64>,
    ) -> Option<(State<f64>, DVector<f64>)> {
        let mut state = from.clone();
        let mut moved = step.clone();
        self.advance(&mut state, step);
        let mut errors = self.errors(&state);
        let mut damping = 1.0;
        for _ in 0..CORRECTIONS {
            if errors.amax() < CLOSED {
                return Some((state, moved));
            }
            let jacobian = self.jacobian();
            let Some(correction) = self.damped.step(&jacobian, &errors, damping) else {
                damping *= 10.0;
                continue;
            };
            let mut next = state.clone();
            self.advance(&mut next, &correction);
            let next_errors = self.errors(&next);
            let part = next_errors.norm() / errors.norm();
            let (too_fast, fast_enough) = if errors.amax() > NEAR { GENTLY } else { (0.0, 0.0) };
            if part >= 1.0 || part < too_fast {
                self.errors(&state);
                damping *= 4.0;
                if damping > 1e6 {
                    break;
                }
                continue;
            }
            (state, errors) = (next, next_errors);
            moved += correction;
            if errors.amax() < NEAR {
                damping = damping.min(1e-12);
            }
            if part > fast_enough {
                // Corrections of dependent equations always require some damping.
                damping = (damping * 0.25).max(1e-15);
            }
        }
        None
    }

    pub(super) fn advance(&self, state: &mut State<f64>, step: &DVector<f64>) {
        let step: Vec<f64> = step.iter().zip(&self.columns).map(|(s, c)| s * c).collect();
        state.advance(self.topology, &step);
    }
}
