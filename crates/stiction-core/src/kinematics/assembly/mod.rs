//! Assembly of a mechanism at prescribed coordinates, and tracking along a motion.
//!
//! Equation (K5) of the book's theory.

mod check;
mod checkpoint;
mod extrapolation;
mod following;
mod known_poses;
mod locks;
mod metric;
mod missing_poses;
mod newton;
mod planning;
mod prescribed_pose;
mod program;
mod reference;
mod report;
mod search;
mod singular_instant;
mod ties;
mod twin;

pub(super) use reference::Given;
pub use report::{AssemblyReport, Conflict, OpenMode};

use super::bodies::{Bodies, State};
use super::coordinate::{Coordinate, Target};
use super::error::AssemblyError;
use super::kernel_program::ProgramAtState;
use super::model::KinematicModel;
use super::motion_constraints::MotionConstraints;
use super::system::Kinematics;
use crate::mechanism::{BodyId, Mechanism};
use crate::parameters::Parameters;
use crate::spatial::Pose;
use crate::topology::Topology;
use check::{check_existence, check_targets};
use extrapolation::Extrapolation;
use following::on_the_way;
use std::sync::Arc;

/// Tolerance of loop closure and prescribed values: lengths divided by the characteristic length,
/// angles in rad. The round-off of a chain of poses is about 1e-16.
const CLOSED: f64 = 1e-14;
/// Closure tolerance near a singular configuration, which magnifies round-off.
const CLOSED_AT_WORST: f64 = 1e-12;
/// Largest closure error of a search that has found a singular configuration. Near a singular
/// configuration, a search stops at about 1e-12, because the errors there decrease with the square
/// of the distance to the solution.
const SINGULAR: f64 = 1e-10;

/// Mechanism at a configuration that closes the loops and satisfies the prescribed coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Assembly {
    model: KinematicModel,
    kinematics: Kinematics<f64>,
    state: State<f64>,
    /// State before the last step.
    before: State<f64>,
    /// State before [`Self::before`]; updated only if extrapolation is active.
    before_last: State<f64>,
    /// State at the beginning of the last motion that was followed.
    start: State<f64>,
    /// Last state with finite coordinates in the iterations of Newton's method.
    sound: State<f64>,
    predicted: State<f64>,
    trial: Bodies<f64>,
    step: Vec<f64>,
    targets: Vec<Target<f64>>,
    /// Targets before the last step.
    passed: Vec<Target<f64>>,
    extrapolation: Extrapolation,
    /// Recorded program that computes rates, accelerations and the motion of the bodies.
    program: Option<ProgramAtState>,
    row_scales: Vec<f64>,
    /// Coordinates of the spanning tree for which the rate equations were compiled.
    planned_at: Vec<f64>,
    body_names: Vec<String>,
    joint_names: Vec<String>,
    /// Number of elimination plans compiled so far.
    plans: u64,
    report: AssemblyReport,
}

/// Finds coordinates, with their values, that lock all instantaneous motions left undetermined by
/// the prescribed coordinates at the configuration near the given one. Returns an empty list if the
/// prescribed coordinates determine the motion and the configuration is regular.
///
/// # Errors
/// [`AssemblyError::Gap`] if the loops do not close at that configuration.
///
/// # Panics
/// Panics unless there is one target for each coordinate, and all named bodies, joints and degrees
/// of freedom exist.
#[doc(hidden)]
pub fn locks(
    mechanism: &Mechanism,
    initial_poses: &[(BodyId, Pose<f64>)],
    coordinates: &[Coordinate],
    targets: &[Target<f64>],
) -> Result<Vec<(Coordinate, f64)>, AssemblyError> {
    check_existence(mechanism, initial_poses, coordinates);
    let body_names: Vec<_> = mechanism.bodies().iter().map(|b| b.name.clone()).collect();
    check_targets(&body_names, coordinates, targets)?;
    let (topology, parameters) = (Topology::new(mechanism), Parameters::new(mechanism));
    let (topology, parameters, homes) = (&topology, &parameters, initial_poses);
    Given { mechanism, topology, parameters, homes, coordinates, targets }.locks()
}

impl Assembly {
    /// Assembles the mechanism at `targets`, one for each of `coordinates`. The search starts from
    /// the mechanism's start coordinates and from the guessed poses in `initial_poses` (in the
    /// ground's frame).
    ///
    /// # Errors
    /// See [`AssemblyError`].
    ///
    /// # Panics
    /// Panics unless there is one target for each coordinate, and all named bodies, joints and
    /// degrees of freedom exist.
    pub(crate) fn new(
        mechanism: &Mechanism,
        topology: &Arc<Topology>,
        parameters: &Parameters<f64>,
        initial_poses: &[(BodyId, Pose<f64>)],
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
    ) -> Result<Self, AssemblyError> {
        let body_names: Vec<_> = mechanism.bodies().iter().map(|b| b.name.clone()).collect();
        let gearings = mechanism.gearings().iter().map(|gearing| gearing.name.clone());
        let joint_names: Vec<_> =
            mechanism.joints().iter().map(|j| j.name.clone()).chain(gearings).collect();
        check_existence(mechanism, initial_poses, coordinates);
        check_targets(&body_names, coordinates, targets)?;
        let state = State::new(topology);
        let model = KinematicModel {
            topology: Arc::clone(topology),
            constraints: Arc::new(MotionConstraints::new(topology, coordinates, &[])),
            rates: Arc::default(),
        };
        let kinematics = Kinematics::new(topology, &model.constraints, &model.rates);
        let mut assembly = Self {
            kinematics,
            before: state.clone(),
            before_last: state.clone(),
            start: state.clone(),
            sound: state.clone(),
            predicted: state.clone(),
            state,
            trial: Bodies::new(topology),
            step: vec![0.0; topology.dofs()],
            model,
            targets: targets.to_vec(),
            passed: targets.to_vec(),
            extrapolation: Extrapolation::default(),
            program: None,
            row_scales: Vec::new(),
            planned_at: Vec::new(),
            body_names,
            joint_names,
            plans: 0,
            report: AssemblyReport::default(),
        };
        assembly.planned_at.clone_from(&assembly.state.coordinates);
        let homes = initial_poses;
        let given = Given { mechanism, topology, parameters, homes, coordinates, targets };
        assembly.assemble(parameters, &given)?;
        assembly.differentiate(parameters);
        assembly.agree(parameters)?;
        Ok(assembly)
    }

    /// Enables extrapolation from the last three configurations while tracking a motion. The
    /// round-off of results then depends on the previous configurations.
    pub(crate) fn extrapolate(&mut self) {
        self.extrapolation.activate();
    }

    /// Comparison of the first assembled configuration with the reference configuration.
    pub(crate) fn report(&self) -> &AssemblyReport {
        &self.report
    }

    /// Prescribed coordinates and locked local degrees of freedom.
    pub(crate) fn motion_constraints(&self) -> &MotionConstraints {
        &self.model.constraints
    }

    /// Compiled kinematics for the present configuration.
    pub(crate) fn model(&self) -> &KinematicModel {
        &self.model
    }

    /// Poses, velocities and accelerations of all bodies at the present instant.
    pub(crate) fn kinematics(&self) -> &Kinematics<f64> {
        &self.kinematics
    }

    /// Coordinates, rates and accelerations of the spanning tree at the present instant.
    pub(crate) fn state(&self) -> &State<f64> {
        &self.state
    }

    /// Targets of the prescribed coordinates at the present instant.
    pub(crate) fn targets(&self) -> &[Target<f64>] {
        &self.targets
    }

    /// Resets the accelerations of all bodies to those without the spin accelerations that the
    /// dynamics added.
    pub(crate) fn forget_spins(&mut self) {
        if !self.model.constraints.spins().is_empty() {
            self.kinematics.bodies.accelerate(&self.model.topology, &self.state.accelerations);
        }
    }

    /// Returns the compiled kinematics, and the motion of all bodies, which the dynamics update.
    pub(crate) fn parts(&mut self) -> (&KinematicModel, &mut Kinematics<f64>) {
        (&self.model, &mut self.kinematics)
    }

    /// Number of elimination plans compiled so far.
    pub(crate) fn plans(&self) -> u64 {
        self.plans
    }

    /// Copies the state and the targets of another assembly with the same elimination plan. Does
    /// not update the poses and twists of the bodies; a following call of [`Self::reverse`] does.
    pub(crate) fn go_to(&mut self, other: &Self) {
        self.extrapolation.forget();
        self.state.clone_from(&other.state);
        self.targets.copy_from_slice(&other.targets);
    }

    /// Reverses all rates at the current configuration without changing the accelerations.
    pub(crate) fn reverse(&mut self, parameters: &Parameters<f64>) {
        self.extrapolation.forget();
        self.targets.iter_mut().for_each(|target| target.rate = -target.rate);
        // The equations do not determine the rates at a singular configuration.
        self.state.rates.iter_mut().for_each(|rate| *rate = -*rate);
        self.place(parameters);
        let Self { kinematics, model, state, .. } = self;
        kinematics.move_with(&model.topology, state);
        kinematics.factor_here(model, parameters);
    }

    /// Moves to new targets near the present ones by Newton's method from the present
    /// configuration, extrapolated with its rates over `ahead` seconds. Unlike [`Self::follow`], this
    /// method does not check that the assembly mode stays the same.
    ///
    /// # Errors
    /// See [`AssemblyError`]; after an error the configuration is unchanged.
    ///
    /// # Panics
    /// Panics unless there is one target for each prescribed coordinate.
    pub(crate) fn move_to(
        &mut self,
        parameters: &Parameters<f64>,
        ahead: f64,
        targets: &[Target<f64>],
    ) -> Result<(), AssemblyError> {
        check_targets(&self.body_names, self.model.constraints.coordinates(), targets)?;
        self.extrapolation.forget();
        self.before.clone_from(&self.state);
        self.passed.copy_from_slice(&self.targets);
        self.targets.copy_from_slice(targets);
        let extrapolates = ahead != 0.0 && self.is_determined();
        if extrapolates {
            let changes = self.step.iter_mut().zip(&self.state.rates);
            changes.for_each(|(change, rate)| *change = ahead * rate);
            self.state.advance(&self.model.topology, &self.step);
        }
        let mut outcome = self.settle(parameters);
        if extrapolates && outcome.is_err() {
            self.state.clone_from(&self.before);
            outcome = self.settle(parameters);
        }
        if outcome.is_err() {
            // The search ended with open loops, for which no forces are defined.
            self.state.clone_from(&self.before);
            self.targets.copy_from_slice(&self.passed);
            // The search may have replaced the elimination plan.
            let is_sound = self.differentiates(parameters) && self.agree(parameters).is_ok();
            if !is_sound && self.plan(parameters).is_ok() {
                self.differentiate(parameters);
            }
        }
        outcome
    }

    /// Moves to known coordinates, rates and accelerations of the spanning tree, for which the
    /// loops must be closed and the prescribed coordinates must equal `targets`. Returns `false`,
    /// without moving, if the loops are open.
    pub(crate) fn return_to(
        &mut self,
        parameters: &Parameters<f64>,
        [coordinates, rates, accelerations]: [&[f64]; 3],
        targets: &[Target<f64>],
    ) -> bool {
        let count = self.model.constraints.coordinates().len();
        let dofs = self.state.rates.len();
        if coordinates.len() != self.state.coordinates.len()
            || targets.len() != count
            || [rates.len(), accelerations.len()] != [dofs; 2]
        {
            return false;
        }
        self.extrapolation.forget();
        self.before.clone_from(&self.state);
        self.passed.copy_from_slice(&self.targets);
        self.state.coordinates.copy_from_slice(coordinates);
        self.targets.copy_from_slice(targets);
        if self.moves_by_program(true) {
            return true;
        }
        let closed = CLOSED_AT_WORST.max(self.state.round_off());
        let arrived = self.place(parameters) < closed;
        if arrived {
            self.state.rates.copy_from_slice(rates);
            self.state.accelerations.copy_from_slice(accelerations);
            let Self { kinematics, model, state, .. } = self;
            kinematics.move_with(&model.topology, state);
            if !model.constraints.spins().is_empty() {
                // The dynamics compute the accelerations due to passive spins with the factors of
                // the rate equations.
                kinematics.factor_here(model, parameters);
            }
        } else {
            self.state.clone_from(&self.before);
            self.targets.copy_from_slice(&self.passed);
            self.differentiate(parameters);
        }
        arrived
    }

    /// Sets all rates and accelerations to zero at the present configuration.
    pub(crate) fn stop(&mut self, parameters: &Parameters<f64>) {
        self.extrapolation.forget();
        for target in &mut self.targets {
            (target.rate, target.acceleration) = (0.0, 0.0);
        }
        self.differentiate(parameters);
    }

    /// Runs Newton's method from the current state to the current targets, then computes rates and
    /// accelerations. If Newton's method fails, starts a search; if the results violate a
    /// constraint, compiles a new elimination plan.
    fn settle(&mut self, parameters: &Parameters<f64>) -> Result<(), AssemblyError> {
        let arrived = self.newton(parameters);
        if !arrived {
            self.reassemble(parameters).map_err(on_the_way)?;
        }
        let differentiates = match arrived {
            true => self.differentiates_here(parameters),
            false => self.differentiates(parameters),
        };
        if differentiates {
            let agreed = self.agree(parameters);
            // A plan compiled far from this configuration may omit rows that are independent here,
            // or lose digits.
            if agreed.is_err() && self.plan(parameters).is_ok() && self.differentiates(parameters) {
                return self.agree(parameters);
            }
            return agreed;
        }
        // The loops are closed, but the configuration is singular: rates do not exist or are not
        // unique.
        self.state.rates.fill(0.0);
        self.state.accelerations.fill(0.0);
        let planned = self.plan(parameters).map_err(on_the_way);
        planned.and(Err(AssemblyError::Undetermined { open: Vec::new() }))
    }

    /// Solves for rates and accelerations; returns `false` if they are not finite.
    fn differentiates(&mut self, parameters: &Parameters<f64>) -> bool {
        self.differentiate(parameters);
        self.is_differentiated()
    }

    /// Solves for rates and accelerations at the solution of [`Self::newton`], reusing the poses
    /// computed there. Returns `false` if rates or accelerations are not finite.
    fn differentiates_here(&mut self, parameters: &Parameters<f64>) -> bool {
        if self.moves_by_program(false) {
            return self.is_differentiated();
        }
        let Self { kinematics, model, state, targets, .. } = self;
        kinematics.differentiate_here(model, parameters, state, targets);
        self.is_differentiated()
    }

    fn is_differentiated(&self) -> bool {
        let mut derivatives = self.state.rates.iter().chain(&self.state.accelerations);
        derivatives.all(|x| x.is_finite())
    }

    /// Returns an error if rates or accelerations violate the loops or the prescribed coordinates.
    fn agree(&mut self, parameters: &Parameters<f64>) -> Result<(), AssemblyError> {
        self.kinematics.contradiction(
            &self.model,
            parameters,
            &self.state,
            &self.targets,
            &self.joint_names,
        )
    }

    /// Searches for a closed configuration from the present state, then closes the loops to
    /// round-off.
    fn reassemble(&mut self, parameters: &Parameters<f64>) -> Result<(), AssemblyError> {
        self.search(parameters)?;
        self.complete(parameters)
    }

    /// Closes the loops to round-off by Newton's method with a new elimination plan.
    fn complete(&mut self, parameters: &Parameters<f64>) -> Result<(), AssemblyError> {
        if let Err(error) = self.plan(parameters) {
            // A search ends with open loops only if no closed configuration is near.
            return Err(match self.is_closed(parameters) {
                true => error,
                false => AssemblyError::Gap(self.gap(parameters)),
            });
        }
        if !self.newton(parameters) {
            return Err(AssemblyError::Gap(self.gap(parameters)));
        }
        // Singular configurations can be detected only with loops closed to round-off.
        self.plan(parameters)
    }

    /// Returns `true` if the loops are closed and the prescribed values are met, both within the
    /// accuracy of a search near a singular configuration.
    fn is_closed(&mut self, parameters: &Parameters<f64>) -> bool {
        self.row_scales = self.model.constraints.row_scales(parameters.length);
        self.place(parameters) < SINGULAR
    }

    fn differentiate(&mut self, parameters: &Parameters<f64>) {
        self.kinematics.differentiate(&self.model, parameters, &mut self.state, &self.targets);
    }

    /// Computes the poses of all bodies; returns the largest scaled error.
    fn place(&mut self, parameters: &Parameters<f64>) -> f64 {
        let Self { kinematics, model, state, targets, .. } = self;
        kinematics.place(&model.topology, parameters, &model.constraints, state, targets);
        self.scaled_error()
    }

    /// Largest error of the position equations, with lengths divided by the characteristic length;
    /// infinite if any error is NaN.
    fn scaled_error(&self) -> f64 {
        let errors =
            self.kinematics.errors().iter().zip(&self.row_scales).map(|(e, s)| (e * s).abs());
        errors.fold(0.0, |max, e| if e.is_nan() { f64::INFINITY } else { e.max(max) })
    }
}
