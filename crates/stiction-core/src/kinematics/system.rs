//! Linear system for the rates and accelerations of the spanning tree and for Newton corrections of
//! its configuration.
//!
//! The rows are the constraints of all cut joints, the gearings, the prescribed coordinates, and
//! the passive spins. The columns are the degrees of freedom of the spanning tree. Each row except
//! those of gearings is a wrench that acts on some bodies; an entry is the power of this wrench on
//! the unit twist of a degree of freedom. Rows of gearings contain the coefficients of the gearing.
//!
//! Equation (K4) of the book's theory.

use super::bodies::{Bodies, State};
use super::coordinate::{Coordinate, Target};
use super::measure;
use super::model::KinematicModel;
use super::motion_constraints::MotionConstraints;
use super::rotation_vector::{Orientation, RotationVector};
use crate::linalg::{Entry, Plan, RankDeficient, Scales, SparseMatrix, StaticLu};
use crate::parameters::Parameters;
use crate::scalar::{Lanes, Scalar};
use crate::spatial::{Vec3, Wrench};
use crate::topology::{Cut, Topology};

/// Computes the prescribed orientation from the three components of a rotation vector. `places` are
/// the indices of these components in `targets`.
fn reference_orientation<T: Scalar>(targets: &[Target<T>], places: [usize; 3]) -> Orientation<T> {
    let [x, y, z] = places.map(|place| targets[place]);
    Orientation::of(
        Vec3::new(x.value, y.value, z.value),
        Vec3::new(x.rate, y.rate, z.rate),
        Vec3::new(x.acceleration, y.acceleration, z.acceleration),
    )
}

/// Returns the scale factors of the columns: `length` (m) for translations and 1 for rotations. The
/// factors make rates of lengths and rates of angles comparable.
pub(crate) fn column_scales(topology: &Topology, length: f64) -> Vec<f64> {
    let translates = |tree_dof: &crate::topology::TreeDof| topology.tree_dof_translates(tree_dof);
    topology
        .tree_dofs
        .iter()
        .map(|tree_dof| if translates(tree_dof) { length } else { 1.0 })
        .collect()
}

/// Motion of all bodies at one instant, with the buffers of the linear system that determines this
/// motion.
#[derive(Clone, Debug)]
pub struct Kinematics<T> {
    /// Poses, twists and accelerations of all bodies.
    pub bodies: Bodies<T>,
    /// Errors of all rows, m or rad: first those of cut joints and gearings, then the deviations
    /// from prescribed coordinates, and last zeros for passive spins.
    errors: Vec<T>,
    covectors: Vec<Wrench<T>>,
    pub(super) entries: Vec<T>,
    factors: Vec<T>,
    right: Vec<T>,
    /// Copy of the right-hand side before the system is solved. Empty for scalar types without
    /// derivatives.
    right_before: Vec<T>,
    step: Vec<T>,
    closures: usize,
    /// Sign of the determinant, from the last factorisation by [`Self::differentiate`] or
    /// [`Self::factor_here`].
    sign: T,
    /// True if `factors` and `sign` belong to the configuration for which rates were last computed.
    is_factored: bool,
    /// True if `errors` belong to the poses of the bodies.
    has_errors: bool,
}

impl<T: Scalar> Kinematics<T> {
    /// Allocates all buffers for a mechanism with the given motion constraints. `program`
    /// determines the size of the factors.
    pub(crate) fn new(
        topology: &Topology,
        motion_constraints: &MotionConstraints,
        program: &StaticLu,
    ) -> Self {
        let zeros = |n| vec![T::zero(); n];
        Self {
            bodies: Bodies::new(topology),
            errors: zeros(motion_constraints.rows.len()),
            covectors: vec![Wrench::zero(); motion_constraints.rows.len()],
            entries: zeros(motion_constraints.entries.len()),
            factors: zeros(program.values()),
            right: zeros(motion_constraints.rows.len()),
            right_before: zeros(if T::has_slope() { motion_constraints.rows.len() } else { 0 }),
            step: zeros(topology.dofs()),
            closures: motion_constraints.closures,
            sign: T::one(),
            is_factored: false,
            has_errors: false,
        }
    }

    /// Returns the largest error over all cut joints and gearings, m. Angular errors are multiplied
    /// by `length` (m).
    pub(crate) fn closure_error(&self, motion_constraints: &MotionConstraints, length: f64) -> f64 {
        let errors = self.errors[..self.closures].iter().zip(&motion_constraints.rows);
        largest_in_metres(errors.map(|(error, row)| (error.largest(), row.is_angle)), length)
    }

    /// Returns the largest magnitude of the errors of loop closure and of the deviations from
    /// prescribed coordinates, m or rad.
    pub fn largest_error(&self) -> f64 {
        largest(&self.errors)
    }

    /// Returns the largest error of any row, with lengths divided by `length` and angles in rad.
    /// NaN if any error is NaN.
    pub(crate) fn scaled_error(&self, constraints: &MotionConstraints, length: f64) -> f64 {
        let rows = self.errors.iter().zip(&constraints.rows);
        let errors = rows.map(|(error, row)| {
            let size = error.largest();
            if row.is_angle { size } else { size / length }
        });
        errors.fold(0.0, |max, e| if e > max || e.is_nan() { e } else { max })
    }

    /// Yields the errors of all rows in row order, with lengths divided by `length` and angles in
    /// rad.
    pub fn scaled_errors<'a>(
        &'a self,
        constraints: &'a MotionConstraints,
        length: f64,
    ) -> impl Iterator<Item = T> + 'a {
        let scales = constraints.row_scales(length);
        self.errors.iter().zip(scales).map(|(error, scale)| *error * T::from_f64(scale))
    }

    /// Returns the reciprocal pivots of the last factorisation of the rate equations, in the order
    /// of elimination.
    pub(crate) fn reciprocal_pivots(&self, model: &KinematicModel) -> Vec<T> {
        model.rates.pivots().map(|place| self.factors[place]).collect()
    }

    /// Returns the errors of all rows in row order, m or rad.
    pub(super) fn errors(&self) -> &[T] {
        &self.errors
    }

    /// Computes the poses of the bodies, and the errors and wrenches of all rows, for the given
    /// state.
    pub(super) fn place(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        motion_constraints: &MotionConstraints,
        state: &State<T>,
        targets: &[Target<T>],
    ) {
        self.bodies.place(topology, parameters, &state.coordinates);
        self.has_errors = true;
        let mut row = 0;
        for cut in &topology.cuts {
            row = self.measure_cut(topology, parameters, cut, row);
        }
        for gearing in &topology.gearings {
            self.errors[row] = gearing.error(parameters, &state.coordinates);
            row += 1;
        }
        let coordinates =
            motion_constraints.coordinates.iter().zip(&motion_constraints.orientations);
        let coordinates = coordinates.zip(&motion_constraints.differences).zip(targets);
        let mut angles = None;
        for (((&coordinate, &orientation), &difference), target) in coordinates {
            (self.errors[row], self.covectors[row]) = match (coordinate, orientation) {
                (Coordinate::RotationVector { body, axis }, Some(places)) => {
                    let ground = self.bodies.pose[0];
                    let found = measure::seen_from(ground, self.bodies.pose[body.0]);
                    let reference = reference_orientation(targets, places).rotation;
                    let error = RotationVector::of(found * reference.transpose()).value;
                    (error.component(axis), Wrench::couple(ground.rotation.columns[axis]))
                }
                _ => {
                    let measured = measure::measure(
                        coordinate,
                        topology,
                        parameters,
                        (&self.bodies, &mut angles),
                        &state.coordinates,
                    );
                    let error = measure::deviation(difference, measured.value, target.value);
                    (error, measured.covector)
                }
            };
            row += 1;
        }
        for spin in &motion_constraints.spins {
            let axis = self.bodies.pose[spin.body.0].rotation * spin.axis.lift();
            self.errors[row] = T::zero();
            self.covectors[row] = Wrench::couple(axis);
            row += 1;
        }
    }

    /// Computes the errors and wrenches of the rows of a cut joint, of which `row` is the first.
    /// Returns the index of the row after them.
    #[inline]
    fn measure_cut(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        cut: &Cut,
        mut row: usize,
    ) -> usize {
        let joint_type = topology.joint_types[cut.joint];
        let (j, k) = (self.bodies.frame_j[cut.joint], self.bodies.frame_k[cut.joint]);
        let pitch = parameters.pitch[cut.joint];
        let (misfit, _) = joint_type.misfit(j.inverse() * k, pitch);
        for (error, constraint) in misfit.into_iter().zip(joint_type.constraints()) {
            self.errors[row] = error;
            self.covectors[row] = constraint.wrench(&j, &k, pitch);
            row += 1;
        }
        row
    }

    /// Computes the errors and wrenches of the rows of some cut joints from the coordinates of the
    /// `nodes` on the paths of these rows, parents first. The errors only depend on the relative
    /// poses of the bodies on a path, so other bodies may be at an earlier configuration, but all
    /// must have been placed once.
    pub(super) fn place_part(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        coordinates: &[T],
        (nodes, cuts): (&[usize], &[usize]),
    ) {
        self.has_errors = false;
        for &node in nodes {
            self.bodies.place_node(topology, parameters, coordinates, &topology.nodes[node]);
        }
        for cut in cuts.iter().map(|cut| &topology.cuts[*cut]) {
            self.bodies.place_cut(topology, parameters, cut);
            self.measure_cut(topology, parameters, cut, cut.constraints.start);
        }
    }

    /// Computes the entries of the system matrix at the configuration of the last [`Self::place`].
    pub(super) fn linearise(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        motion_constraints: &MotionConstraints,
    ) {
        let mut entry = 0;
        for row in 0..motion_constraints.rows.len() {
            entry = self.linearise_row(topology, parameters, motion_constraints, (row, entry));
        }
    }

    /// Computes the entries of a row of the system matrix at the configuration of the last
    /// [`Self::place`]; `entry` is the index of the first one. Returns the index after the last one.
    #[inline]
    pub(super) fn linearise_row(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        motion_constraints: &MotionConstraints,
        (row, mut entry): (usize, usize),
    ) -> usize {
        let (row, covector) = (&motion_constraints.rows[row], self.covectors[row]);
        if let Some(gearing) = row.gearing {
            let gearing = &topology.gearings[gearing];
            for tree_dof in gearing.tree_dofs(topology) {
                self.entries[entry] = gearing.coefficient(parameters, tree_dof);
                entry += 1;
            }
            return entry;
        }
        for &(node, sign) in &row.path {
            let sign = T::from_f64(sign);
            for tree_dof in topology.nodes[node].tree_dofs.clone() {
                self.entries[entry] = self.bodies.screws[tree_dof].power(covector) * sign;
                entry += 1;
            }
        }
        entry
    }

    /// Takes one Newton step that reduces the errors of loop closure and of the prescribed
    /// coordinates. Afterwards, [`Self::largest_error`] returns the error before the step.
    pub fn approach(
        &mut self,
        model: &KinematicModel,
        parameters: &Parameters<T>,
        state: &mut State<T>,
        targets: &[Target<T>],
    ) {
        let KinematicModel { topology, constraints, .. } = model;
        self.place(topology, parameters, constraints, state, targets);
        self.approach_here(model, parameters, state);
    }

    /// Takes one Newton step from the configuration of the last [`Self::place`].
    pub(super) fn approach_here(
        &mut self,
        model: &KinematicModel,
        parameters: &Parameters<T>,
        state: &mut State<T>,
    ) {
        let KinematicModel { topology, constraints, rates: program } = model;
        self.linearise(topology, parameters, constraints);
        program.factor(&self.entries, &mut self.factors);
        self.is_factored = false;
        self.approach_again(model, state);
    }

    /// Takes another Newton step with the matrix of the last factorisation and the errors of the
    /// last [`Self::place`].
    pub(super) fn approach_again(&mut self, model: &KinematicModel, state: &mut State<T>) {
        for (right, error) in self.right.iter_mut().zip(&self.errors) {
            *right = -*error;
        }
        model.rates.solve(&self.factors, &mut self.right, &mut self.step);
        state.advance(&model.topology, &self.step);
    }

    /// Computes rates and accelerations at the current configuration, which must satisfy loop
    /// closure and prescribed coordinates. Also updates the body poses and the closure errors.
    pub fn differentiate(
        &mut self,
        model: &KinematicModel,
        parameters: &Parameters<T>,
        state: &mut State<T>,
        targets: &[Target<T>],
    ) {
        self.place(&model.topology, parameters, &model.constraints, state, targets);
        self.differentiate_here(model, parameters, state, targets);
    }

    /// Computes rates and accelerations at the configuration of the last [`Self::place`].
    pub(super) fn differentiate_here(
        &mut self,
        model: &KinematicModel,
        parameters: &Parameters<T>,
        state: &mut State<T>,
        targets: &[Target<T>],
    ) {
        let KinematicModel { topology, constraints, rates: program } = model;
        self.linearise(topology, parameters, constraints);
        self.sign = program.factor(&self.entries, &mut self.factors);
        self.is_factored = true;

        self.right_of_rates(constraints, targets);
        self.solve(constraints, program, &mut state.rates);
        self.bodies.move_with(topology, &state.rates);

        self.right_of_accelerations(topology, parameters, constraints, targets);
        self.solve(constraints, program, &mut state.accelerations);
        self.bodies.accelerate(topology, &state.accelerations);
    }

    /// Computes twists and accelerations of the bodies from known rates and accelerations of the
    /// spanning tree, at the configuration of the last [`Self::place`]. Solves no equations.
    pub(super) fn move_with(&mut self, topology: &Topology, state: &State<T>) {
        self.is_factored = false;
        self.bodies.move_with(topology, &state.rates);
        self.bodies.accelerate(topology, &state.accelerations);
    }

    /// Marks factors, and errors if `with_places` is true, as those of another configuration, after
    /// a program has computed the motion of the bodies.
    pub(super) fn take_over(&mut self, with_places: bool) {
        self.is_factored = false;
        self.has_errors &= !with_places;
    }

    /// Returns `true` if the errors of the rows belong to the poses of the bodies.
    pub(crate) fn has_errors(&self) -> bool {
        self.has_errors
    }

    /// Factors the equations at the configuration for which rates were last computed, unless they
    /// are factored already.
    pub(crate) fn factor_here(&mut self, model: &KinematicModel, parameters: &Parameters<T>) {
        if !self.is_factored {
            self.linearise(&model.topology, parameters, &model.constraints);
            self.sign = model.rates.factor(&self.entries, &mut self.factors);
            self.is_factored = true;
        }
    }

    /// Returns `true` if the last factorisation belongs to the configuration for which rates were
    /// last computed.
    pub(super) fn is_factored(&self) -> bool {
        self.is_factored
    }

    /// Solves the system for the right-hand side set before. For scalar types with derivatives, the
    /// derivatives follow from the residual with the solution held constant (equation (P8) of the
    /// book's theory).
    fn solve(
        &mut self,
        motion_constraints: &MotionConstraints,
        program: &StaticLu,
        solution: &mut [T],
    ) {
        if T::has_slope() {
            self.right_before.copy_from_slice(&self.right);
        }
        program.solve(&self.factors, &mut self.right, solution);
        if T::has_slope() {
            solution.iter_mut().for_each(|value| *value = value.held());
            self.right.copy_from_slice(&self.right_before);
            for (entry, value) in motion_constraints.entries.iter().zip(&self.entries) {
                self.right[entry.row] -= *value * solution[entry.column];
            }
            program.solve(&self.factors, &mut self.right, &mut self.step);
            for (value, step) in solution.iter_mut().zip(&self.step) {
                *value += *step;
            }
        }
    }

    /// Sets the right-hand side for the rates of the spanning tree: zero for loops, gearings and
    /// passive spins, and the prescribed rates for the prescribed coordinates.
    pub(super) fn right_of_rates(
        &mut self,
        motion_constraints: &MotionConstraints,
        targets: &[Target<T>],
    ) {
        let closures = self.closures;
        self.right.fill(T::zero());
        let coordinates =
            motion_constraints.coordinates.iter().zip(&motion_constraints.orientations);
        let coordinates = coordinates.zip(targets);
        for (right, ((&coordinate, &orientation), target)) in
            self.right[closures..].iter_mut().zip(coordinates)
        {
            *right = match (coordinate, orientation) {
                (Coordinate::RotationVector { axis, .. }, Some(places)) => {
                    reference_orientation(targets, places).rate.component(axis)
                }
                _ => target.rate,
            };
        }
    }

    /// Returns the right-hand side of the system as last set, one value for each row.
    pub(super) fn right_hand_side(&self) -> &[T] {
        &self.right
    }

    /// Sets the right-hand side for the accelerations of the spanning tree: prescribed
    /// accelerations (zero for loops, gearings and passive spins), minus the velocity terms of the
    /// second derivatives.
    pub(super) fn right_of_accelerations(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        motion_constraints: &MotionConstraints,
        targets: &[Target<T>],
    ) {
        let mut row = 0;
        for cut in &topology.cuts {
            let (predecessor, successor) = topology.ends[cut.joint];
            let bias = &self.bodies.bias;
            let own = self.bodies.joint_bias(topology, parameters, cut.joint);
            let open = bias[successor] - bias[predecessor] - own;
            for _ in topology.joint_types[cut.joint].constraints() {
                self.right[row] = -open.power(self.covectors[row]);
                row += 1;
            }
        }
        for _ in &topology.gearings {
            self.right[row] = T::zero();
            row += 1;
        }
        let coordinates =
            motion_constraints.coordinates.iter().zip(&motion_constraints.orientations);
        let mut angles = None;
        for ((&coordinate, &orientation), target) in coordinates.zip(targets) {
            let covector = self.covectors[row];
            self.right[row] = match (coordinate, orientation) {
                (Coordinate::RotationVector { body, axis }, Some(places)) => {
                    reference_orientation(targets, places).acceleration.component(axis)
                        - self.bodies.bias[body.0].power(covector)
                }
                _ => {
                    let at = (&self.bodies, &mut angles);
                    target.acceleration
                        - measure::bias(coordinate, topology, parameters, at, covector)
                }
            };
            row += 1;
        }
        for spin in &motion_constraints.spins {
            self.right[row] = -self.bodies.bias[spin.body.0].power(self.covectors[row]);
            row += 1;
        }
    }

    /// Computes the velocity terms of the second derivatives of the loop errors, one for each
    /// equation of loops and gearings. The twists of the bodies must be up to date.
    pub(super) fn closure_biases(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        motion_constraints: &MotionConstraints,
    ) -> Vec<T> {
        self.right_of_accelerations(topology, parameters, motion_constraints, &[]);
        self.right[..self.closures].iter().map(|right| -*right).collect()
    }

    /// Returns the sign of the determinant of the system at the last factorisation by
    /// [`Self::differentiate`] or [`Self::factor_here`]. The elimination order determines a
    /// constant factor, 1 or -1.
    pub(crate) fn sign(&self) -> T {
        self.sign
    }

    /// Returns the sign of the determinant of the system at the current configuration, computed
    /// with the elimination order of `program`, which may be any factorisation compiled for this
    /// system. `None` if the numbers of rows or columns differ.
    pub(crate) fn sign_by(&self, program: &StaticLu) -> Option<T> {
        let fits = program.rows() == self.errors.len() && program.columns() == self.step.len();
        let mut factors = vec![T::zero(); program.values()];
        fits.then(|| program.factor(&self.entries, &mut factors))
    }

    /// Computes the rates of the spanning tree for a unit rate of one prescribed coordinate and
    /// zero rates of all other prescribed coordinates and spins. Call [`Self::differentiate`]
    /// before.
    pub(crate) fn response_to_coordinate(
        &mut self,
        model: &KinematicModel,
        coordinate: usize,
        rates: &mut [T],
    ) {
        debug_assert!(coordinate < model.constraints.coordinates().len());
        self.right.fill(T::zero());
        self.right[self.closures + coordinate] = T::one();
        self.solve(&model.constraints, &model.rates, rates);
    }

    /// Computes the accelerations of the spanning tree for a unit acceleration of one passive spin,
    /// with zero accelerations of all other spins and prescribed coordinates and without velocity
    /// terms. Call [`Self::differentiate`] before.
    pub(crate) fn response_to_spin(
        &mut self,
        model: &KinematicModel,
        spin: usize,
        accelerations: &mut [T],
    ) {
        let constraints = &model.constraints;
        self.right.fill(T::zero());
        self.right[constraints.rows.len() - constraints.spins.len() + spin] = T::one();
        self.solve(constraints, &model.rates, accelerations);
    }
}

/// Number of prescribed coordinates whose responses are computed together.
const WIDTH: usize = 4;

impl Kinematics<f64> {
    /// Computes the rates of the spanning tree for a unit rate of each prescribed coordinate, with
    /// zero rates of all other prescribed coordinates and spins. Calls `take` with the index of
    /// each coordinate and the rates. Call [`Self::differentiate`] before.
    pub(crate) fn responses_to_coordinates(
        &self,
        model: &KinematicModel,
        mut take: impl FnMut(usize, &[f64]),
    ) {
        let count = model.constraints.coordinates().len();
        let mut right = vec![Lanes::<f64, WIDTH>::zero(); self.right.len()];
        let mut solution = vec![Lanes::zero(); self.step.len()];
        let mut rates = vec![0.0; self.step.len()];
        for first in (0..count).step_by(WIDTH) {
            right.fill(Lanes::zero());
            let last = (first + WIDTH).min(count);
            for coordinate in first..last {
                right[self.closures + coordinate].0[coordinate - first] = 1.0;
            }
            model.rates.solve_lanes(&self.factors, &mut right, &mut solution);
            for coordinate in first..last {
                let lanes = rates.iter_mut().zip(&solution);
                lanes.for_each(|(rate, lanes)| *rate = lanes.0[coordinate - first]);
                take(coordinate, &rates);
            }
        }
    }

    /// Chooses independent rows and the elimination order of the system by the values of its
    /// entries. Call [`Self::linearise`] before.
    ///
    /// # Errors
    /// Returns [`RankDeficient`] if loops and prescribed coordinates leave some degrees of freedom
    /// of the spanning tree undetermined.
    pub(super) fn plan(
        &self,
        topology: &Topology,
        motion_constraints: &MotionConstraints,
        length: f64,
    ) -> Result<Plan, RankDeficient> {
        let rows = motion_constraints.row_scales(length);
        let columns = column_scales(topology, length);
        let scales = Scales { rows: &rows, columns: &columns };
        let (count, dofs) = (motion_constraints.row_count(), topology.dofs());
        Plan::new(count, dofs, motion_constraints.entries(), &self.entries, scales)
    }

    /// Returns the matrix of the system, with rows and columns multiplied by the scale factors
    /// `rows` and `columns`. Call [`Self::linearise`] before.
    pub(super) fn scaled_matrix(
        &self,
        motion_constraints: &MotionConstraints,
        rows: &[f64],
        columns: &[f64],
    ) -> SparseMatrix {
        let entries = motion_constraints.entries.iter().zip(&self.entries).map(|(entry, value)| {
            let &Entry { row, column, .. } = entry;
            (row, column, value * rows[row] * columns[column])
        });
        SparseMatrix::new((rows.len(), columns.len()), entries)
    }
}

/// Returns the largest loop-closure error, m: over all cut joints at the given body poses, and over
/// all gearings at the given coordinates of the spanning tree. Angular errors are multiplied by the
/// characteristic length.
pub(crate) fn closure_error(
    topology: &Topology,
    parameters: &Parameters<f64>,
    (bodies, coordinates): (&Bodies<f64>, &[f64]),
) -> f64 {
    let errors = topology.cuts.iter().flat_map(|cut| {
        let joint_type = topology.joint_types[cut.joint];
        let relative = bodies.frame_j[cut.joint].inverse() * bodies.frame_k[cut.joint];
        let (misfit, _) = joint_type.misfit(relative, parameters.pitch[cut.joint]);
        let constraints = joint_type.constraints().iter();
        misfit.into_iter().zip(constraints).map(|(error, row)| (error.largest(), row.is_moment()))
    });
    let gearings = topology
        .gearings
        .iter()
        .map(|gearing| (gearing.error(parameters, coordinates).largest(), !gearing.is_length));
    largest_in_metres(errors.chain(gearings), parameters.length)
}

/// Returns the largest error, m. Each item is the magnitude of an error and a flag that is `true`
/// for an angle; angles are multiplied by `length` (m).
fn largest_in_metres(errors: impl Iterator<Item = (f64, bool)>, length: f64) -> f64 {
    let in_metres = errors.map(|(size, is_angle)| size * if is_angle { length } else { 1.0 });
    // Propagate NaN.
    in_metres.fold(0.0, |max, e| if e > max || e.is_nan() { e } else { max })
}

fn largest<T: Scalar>(values: &[T]) -> f64 {
    let mut worst = 0.0;
    for value in values {
        let size = value.largest();
        // Propagate NaN.
        if size > worst || size.is_nan() {
            worst = size;
        }
        if worst.is_nan() {
            break;
        }
    }
    worst
}
