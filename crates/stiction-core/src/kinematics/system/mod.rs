//! Linear system for the rates and accelerations of the spanning tree and for Newton corrections of
//! its configuration.
//!
//! The rows are the constraints of all cut joints, the gearings, the prescribed coordinates, and
//! the passive spins. The columns are the degrees of freedom of the spanning tree. Each row except
//! those of gearings is a wrench that acts on some bodies; an entry is the power of this wrench on
//! the unit twist of a degree of freedom. Rows of gearings contain the coefficients of the gearing.
//!
//! Equation (K4) of the book's theory.

mod errors;
mod planning;
mod responses;
mod right_sides;

pub(crate) use errors::closure_error;
pub(crate) use planning::column_scales;

use super::bodies::{Bodies, State};
use super::coordinate::{Coordinate, Target};
use super::measure;
use super::model::KinematicModel;
use super::motion_constraints::MotionConstraints;
use super::rotation_vector::{Orientation, RotationVector};
use crate::linalg::StaticLu;
use crate::parameters::Parameters;
use crate::scalar::Scalar;
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

    /// Returns the reciprocal pivots of the last factorisation of the rate equations, in the order
    /// of elimination.
    pub(crate) fn reciprocal_pivots(&self, model: &KinematicModel) -> Vec<T> {
        model.rates.pivots().map(|place| self.factors[place]).collect()
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
            self.subtract_product(motion_constraints, solution);
            program.solve(&self.factors, &mut self.right, &mut self.step);
            for (value, step) in solution.iter_mut().zip(&self.step) {
                *value += *step;
            }
        }
    }

    /// Subtracts the product of the system matrix and `solution` from the right-hand side.
    pub(super) fn subtract_product(
        &mut self,
        motion_constraints: &MotionConstraints,
        solution: &[T],
    ) {
        for (entry, value) in motion_constraints.entries.iter().zip(&self.entries) {
            self.right[entry.row] -= *value * solution[entry.column];
        }
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
}
