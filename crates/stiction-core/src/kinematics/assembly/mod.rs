//! Bringing a mechanism into a prescribed position, and keeping it there along a motion.
//!
//! Equation (K5) of the book's theory.

mod asked;
mod checkpoint;
mod following;
mod guess;
mod planning;
mod search;

pub(super) use guess::guess;

use super::bodies::{Bodies, State};
use super::coordinate::{Coordinate, Target};
use super::error::AssemblyError;
use super::model::KinematicModel;
use super::motion_constraints::MotionConstraints;
use super::system::Kinematics;
use crate::mechanism::{BodyId, Mechanism};
use crate::parameters::Parameters;
use crate::spatial::Pose;
use crate::topology::Topology;
use asked::{check_existence, check_targets};
use following::on_the_way;
use std::sync::Arc;

/// Loops count as closed, and prescribed values as met, below this: m over the characteristic
/// length, and rad. Round-off of a chain of poses is some 1e-16.
const CLOSED: f64 = 1e-14;
/// Near a singular position round-off is magnified; beyond this the loops are not closed.
const CLOSED_AT_WORST: f64 = 1e-12;
/// Newton's method is converging from here: one more step squares the error.
const NEAR: f64 = 1e-7;
/// Newton steps before the careful method is asked.
const NEWTON_STEPS: usize = 12;

/// A mechanism in a position that satisfies its loops and a prescription.
#[derive(Clone, Debug)]
pub(crate) struct Assembly {
    model: KinematicModel,
    kinematics: Kinematics<f64>,
    state: State<f64>,
    /// The last position that was found, to judge the next by.
    before: State<f64>,
    /// Newton's last state in which all was finite.
    sound: State<f64>,
    predicted: State<f64>,
    trial: Bodies<f64>,
    step: Vec<f64>,
    targets: Vec<Target<f64>>,
    /// The targets of the last position that was found.
    passed: Vec<Target<f64>>,
    row_scales: Vec<f64>,
    /// The tree's coordinates at which the rate equations were compiled.
    planned_at: Vec<f64>,
    body_names: Vec<String>,
    joint_names: Vec<String>,
    /// How often it was planned how to solve for rates.
    plans: u64,
}

impl Assembly {
    /// Assembles the mechanism at `targets`, one for each of `coordinates`, starting from the
    /// mechanism's start coordinates and from the guessed poses in `initial_poses` (in the ground's frame).
    ///
    /// # Errors
    /// See [`AssemblyError`].
    ///
    /// # Panics
    /// Unless there is one target for each coordinate, and all bodies, joints and freedoms that are named exist.
    pub(crate) fn new(
        mechanism: &Mechanism,
        topology: &Arc<Topology>,
        parameters: &Parameters<f64>,
        initial_poses: &[(BodyId, Pose<f64>)],
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
    ) -> Result<Self, AssemblyError> {
        let body_names: Vec<_> = mechanism.bodies().iter().map(|b| b.name.clone()).collect();
        let joint_names: Vec<_> = mechanism.joints().iter().map(|j| j.name.clone()).collect();
        check_existence(mechanism, initial_poses, coordinates);
        check_targets(&body_names, coordinates, targets)?;
        let state = guess(mechanism, topology, parameters, initial_poses);
        let model = KinematicModel {
            topology: Arc::clone(topology),
            constraints: Arc::new(MotionConstraints::new(topology, coordinates, &[])),
            rates: Arc::default(),
        };
        let kinematics = Kinematics::new(topology, &model.constraints, &model.rates);
        let mut assembly = Self {
            kinematics,
            before: state.clone(),
            sound: state.clone(),
            predicted: state.clone(),
            state,
            trial: Bodies::new(topology),
            step: vec![0.0; topology.dofs()],
            model,
            targets: targets.to_vec(),
            passed: targets.to_vec(),
            row_scales: Vec::new(),
            planned_at: Vec::new(),
            body_names,
            joint_names,
            plans: 0,
        };
        assembly.planned_at.clone_from(&assembly.state.coordinates);
        assembly.assemble(parameters)?;
        assembly.differentiate(parameters);
        assembly.agree(parameters)?;
        Ok(assembly)
    }

    /// What is prescribed, idle spins included.
    pub(crate) fn motion_constraints(&self) -> &MotionConstraints {
        &self.model.constraints
    }

    /// The compiled kinematics at the present position.
    pub(crate) fn model(&self) -> &KinematicModel {
        &self.model
    }

    /// The motion of everything at the present instant.
    pub(crate) fn kinematics(&self) -> &Kinematics<f64> {
        &self.kinematics
    }

    /// Coordinates, rates and accelerations of the tree at the present instant.
    pub(crate) fn state(&self) -> &State<f64> {
        &self.state
    }

    /// Takes the accelerations of idle spins out again, which dynamics adds.
    pub(crate) fn forget_spins(&mut self) {
        if !self.model.constraints.spins().is_empty() {
            self.kinematics.bodies.accelerate(&self.model.topology, &self.state.accelerations);
        }
    }

    /// The compiled kinematics, and the motion of all bodies to be completed by dynamics.
    pub(crate) fn parts(&mut self) -> (&KinematicModel, &mut Kinematics<f64>) {
        (&self.model, &mut self.kinematics)
    }

    /// How often it was planned how to solve for rates.
    pub(crate) fn plans(&self) -> u64 {
        self.plans
    }

    /// Goes to where another one of the same plan is; [`Self::reverse`] does the rest.
    pub(crate) fn go_to(&mut self, other: &Self) {
        self.state.clone_from(&other.state);
        self.targets.copy_from_slice(&other.targets);
    }

    /// Passes the present position the other way: rates reversed, accelerations the same.
    pub(crate) fn reverse(&mut self, parameters: &Parameters<f64>) {
        self.targets.iter_mut().for_each(|target| target.rate = -target.rate);
        self.differentiate(parameters);
    }

    /// Moves to new targets near the present ones: Newton's method from the present position. It
    /// does not watch the assembly mode; [`Self::follow`] does.
    ///
    /// # Errors
    /// See [`AssemblyError`]; it is then where it was before.
    ///
    /// # Panics
    /// Unless there is one target for each prescribed coordinate.
    pub(crate) fn move_to(
        &mut self,
        parameters: &Parameters<f64>,
        targets: &[Target<f64>],
    ) -> Result<(), AssemblyError> {
        check_targets(&self.body_names, self.model.constraints.coordinates(), targets)?;
        self.before.clone_from(&self.state);
        self.passed.copy_from_slice(&self.targets);
        self.targets.copy_from_slice(targets);
        let outcome = self.settle(parameters);
        if outcome.is_err() {
            // Where the search ended loops are open, and nobody is to compute forces there.
            self.state.clone_from(&self.before);
            self.targets.copy_from_slice(&self.passed);
            // The search may have planned for another position.
            let is_sound = self.differentiates(parameters) && self.agree(parameters).is_ok();
            if !is_sound && self.plan(parameters).is_ok() {
                self.differentiate(parameters);
            }
        }
        outcome
    }

    /// Stops where it is: all rates and accelerations zero.
    pub(crate) fn stop(&mut self, parameters: &Parameters<f64>) {
        for target in &mut self.targets {
            (target.rate, target.acceleration) = (0.0, 0.0);
        }
        self.differentiate(parameters);
    }

    /// Newton's method from the present state to the present targets, then rates and
    /// accelerations. Falls back on the careful search and on a new plan.
    fn settle(&mut self, parameters: &Parameters<f64>) -> Result<(), AssemblyError> {
        if !self.newton(parameters) {
            self.reassemble(parameters).map_err(on_the_way)?;
        }
        if self.differentiates(parameters) {
            return self.agree(parameters);
        }
        // The position is closed, but singular: no rates, or any.
        self.state.rates.fill(0.0);
        self.state.accelerations.fill(0.0);
        let planned = self.plan(parameters).map_err(on_the_way);
        planned.and(Err(AssemblyError::Undetermined { open: Vec::new() }))
    }

    /// Finds rates and accelerations; false where there are none.
    fn differentiates(&mut self, parameters: &Parameters<f64>) -> bool {
        self.differentiate(parameters);
        let mut derivatives = self.state.rates.iter().chain(&self.state.accelerations);
        derivatives.all(|x| x.is_finite())
    }

    /// Whether rates and accelerations are those of loops that stay closed, as prescribed.
    fn agree(&mut self, parameters: &Parameters<f64>) -> Result<(), AssemblyError> {
        self.kinematics.contradiction(
            &self.model,
            parameters,
            &self.state,
            &self.targets,
            &self.joint_names,
        )
    }

    /// The careful search, then Newton's method with a new plan.
    fn reassemble(&mut self, parameters: &Parameters<f64>) -> Result<(), AssemblyError> {
        self.search(parameters)?;
        self.plan(parameters)?;
        if !self.newton(parameters) {
            return Err(AssemblyError::Gap(self.gap(parameters)));
        }
        // What is singular shows only where the loops are closed to round-off.
        self.plan(parameters)
    }

    fn differentiate(&mut self, parameters: &Parameters<f64>) {
        self.kinematics.differentiate(&self.model, parameters, &mut self.state, &self.targets);
    }

    /// Whether Newton's method closes everything, by the present plan.
    fn newton(&mut self, parameters: &Parameters<f64>) -> bool {
        let closed = CLOSED.max(self.state.round_off());
        let mut error = f64::INFINITY;
        for _ in 0..NEWTON_STEPS {
            self.sound.clone_from(&self.state);
            self.kinematics.approach(&self.model, parameters, &mut self.state, &self.targets);
            if !self.state.coordinates.iter().all(|q| q.is_finite()) {
                // Singular: whoever comes next begins where numbers are still numbers.
                self.state.clone_from(&self.sound);
                return false;
            }
            // The error before the step that was just taken.
            if self.scaled_error() < NEAR {
                let (motion_constraints, state) = (&self.model.constraints, &self.state);
                self.kinematics.place(
                    &self.model.topology,
                    parameters,
                    motion_constraints,
                    state,
                    &self.targets,
                );
                error = self.scaled_error();
                if error < closed {
                    return true;
                }
            }
        }
        error < CLOSED_AT_WORST.max(closed)
    }

    /// The largest error, lengths in units of the characteristic length; infinite if undefined.
    fn scaled_error(&self) -> f64 {
        let errors =
            self.kinematics.errors().iter().zip(&self.row_scales).map(|(e, s)| (e * s).abs());
        errors.fold(0.0, |max, e| if e.is_nan() { f64::INFINITY } else { e.max(max) })
    }
}
