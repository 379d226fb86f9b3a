//! Bringing a mechanism into a prescribed position, and keeping it there along a motion.
//!
//! Equation (K5) of the book's theory.

mod guess;
mod planning;
mod search;

pub(super) use guess::guess;

use super::bodies::{Bodies, State};
use super::coordinate::{Coordinate, Target};
use super::error::AssemblyError;
use super::system::{Kinematics, Prescription};
use crate::linalg::Elimination;
use crate::mechanism::{BodyId, Mechanism};
use crate::parameters::Parameters;
use crate::spatial::Pose;
use crate::topology::Topology;

/// Loops count as closed, and prescribed values as met, below this: m over the characteristic
/// length, and rad. Round-off of a chain of poses is some 1e-16.
const CLOSED: f64 = 1e-14;
/// Near a singular position round-off is magnified; beyond this the loops are not closed.
const CLOSED_AT_WORST: f64 = 1e-12;
/// Newton's method is converging from here: one more step squares the error.
const NEAR: f64 = 1e-7;
/// Newton steps before the careful method is asked.
const NEWTON_STEPS: usize = 12;
/// A step of the motion is halved at most so many times to follow it.
const HALVINGS: u32 = 12;

/// A mechanism in a position that satisfies its loops and a prescription.
#[derive(Clone, Debug)]
pub struct Assembly {
    prescription: Prescription,
    program: Elimination,
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
    body_names: Vec<String>,
    joint_names: Vec<String>,
    /// How often it was planned how to solve for rates.
    plans: u64,
}

impl Assembly {
    /// Assembles the mechanism at `targets`, one for each of `coordinates`, starting from the
    /// mechanism's start coordinates and from the guessed poses in `homes` (in the ground's frame).
    ///
    /// # Errors
    /// See [`AssemblyError`].
    ///
    /// # Panics
    /// Unless there is one target for each coordinate, and all bodies, joints and freedoms that are named exist.
    pub fn new(
        mechanism: &Mechanism,
        topology: &Topology,
        parameters: &Parameters<f64>,
        homes: &[(BodyId, Pose<f64>)],
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
    ) -> Result<Self, AssemblyError> {
        let body_names: Vec<_> = mechanism.bodies().iter().map(|b| b.name.clone()).collect();
        let joint_names: Vec<_> = mechanism.joints().iter().map(|j| j.name.clone()).collect();
        check_existence(mechanism, homes, coordinates);
        check_targets(&body_names, coordinates, targets)?;
        let state = guess(mechanism, topology, parameters, homes);
        let prescription = Prescription::new(topology, coordinates, &[]);
        let kinematics = Kinematics::new(topology, &prescription, &Elimination::default());
        let mut assembly = Self {
            prescription,
            program: Elimination::default(),
            kinematics,
            before: state.clone(),
            sound: state.clone(),
            predicted: state.clone(),
            state,
            trial: Bodies::new(topology),
            step: vec![0.0; topology.freedoms()],
            targets: targets.to_vec(),
            passed: targets.to_vec(),
            row_scales: Vec::new(),
            body_names,
            joint_names,
            plans: 0,
        };
        assembly.assemble(topology, parameters)?;
        assembly.differentiate(topology, parameters);
        assembly.agree(topology, parameters)?;
        Ok(assembly)
    }

    /// What is prescribed, idle spins included.
    pub fn prescription(&self) -> &Prescription {
        &self.prescription
    }

    /// The program that solves for rates; for kernels in other scalars.
    pub fn program(&self) -> &Elimination {
        &self.program
    }

    /// The motion of everything at the present instant.
    pub fn kinematics(&self) -> &Kinematics<f64> {
        &self.kinematics
    }

    /// Coordinates, rates and accelerations of the tree at the present instant.
    pub fn state(&self) -> &State<f64> {
        &self.state
    }

    /// Takes the accelerations of idle spins out again, which dynamics adds.
    pub(crate) fn forget_spins(&mut self, topology: &Topology) {
        if !self.prescription.spins().is_empty() {
            self.kinematics.bodies.accelerate(topology, &self.state.accelerations);
        }
    }

    /// What is prescribed, how rates are solved for, and the motion to be completed.
    pub(crate) fn parts(&mut self) -> (&Prescription, &Elimination, &mut Kinematics<f64>) {
        (&self.prescription, &self.program, &mut self.kinematics)
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
    pub(crate) fn reverse(&mut self, topology: &Topology, parameters: &Parameters<f64>) {
        self.targets.iter_mut().for_each(|target| target.rate = -target.rate);
        self.differentiate(topology, parameters);
    }

    /// Moves to new targets near the present ones: Newton's method from the present position. It
    /// does not watch the assembly mode; [`Self::follow`] does.
    ///
    /// # Errors
    /// See [`AssemblyError`]; it is then where it was before.
    ///
    /// # Panics
    /// Unless there is one target for each prescribed coordinate.
    pub fn move_to(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
        targets: &[Target<f64>],
    ) -> Result<(), AssemblyError> {
        check_targets(&self.body_names, self.prescription.coordinates(), targets)?;
        self.before.clone_from(&self.state);
        self.passed.copy_from_slice(&self.targets);
        self.targets.copy_from_slice(targets);
        let outcome = self.settle(topology, parameters);
        if outcome.is_err() {
            // Where the search ended loops are open, and nobody is to compute forces there.
            self.state.clone_from(&self.before);
            self.targets.copy_from_slice(&self.passed);
            // The search may have planned for another position.
            let is_sound = self.differentiates(topology, parameters)
                && self.agree(topology, parameters).is_ok();
            if !is_sound && self.plan(topology, parameters).is_ok() {
                self.differentiate(topology, parameters);
            }
        }
        outcome
    }

    /// Stops where it is: all rates and accelerations zero.
    pub(crate) fn stop(&mut self, topology: &Topology, parameters: &Parameters<f64>) {
        for target in &mut self.targets {
            (target.rate, target.acceleration) = (0.0, 0.0);
        }
        self.differentiate(topology, parameters);
    }

    /// Moves along a motion from time `from` (the present position) to `to`, staying in the same
    /// assembly mode. `motion` writes the targets of an instant.
    ///
    /// # Errors
    /// See [`AssemblyError`]; a jump that no halving of the step removes is one. Loops may be open then: use it no
    /// more before it has been moved to a position that it can reach.
    pub fn follow(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
        from: f64,
        to: f64,
        mut motion: impl FnMut(f64, &mut [Target<f64>]),
    ) -> Result<(), AssemblyError> {
        let (mut now, mut step) = (from, to - from);
        let smallest = step * 0.5_f64.powi(HALVINGS as i32);
        // That a position is singular says more than that the way there is not smooth; that there is none
        // says more than that the last one before it is singular, as it always is.
        let mut singular = None;
        self.passed.copy_from_slice(&self.targets);
        while now != to {
            // The last piece ends exactly at `to`.
            let last = (to - now).abs() <= step.abs() * (1.0 + 1e-9);
            let next = if last { to } else { now + step };
            let mut targets = core::mem::take(&mut self.targets);
            motion(next, &mut targets);
            self.targets = targets;
            let outcome = check_angle_ranges(
                &self.body_names,
                self.prescription.coordinates(),
                &self.targets,
            )
            .and_then(|()| self.step_smoothly(topology, parameters, next - now, true));
            match outcome {
                Ok(()) => {
                    now = next;
                    self.passed.copy_from_slice(&self.targets);
                    step *= 2.0;
                }
                Err(error) if (0.5 * step).abs() < smallest.abs() => {
                    let out_of_reach = self.out_of_reach(topology, parameters, to, motion);
                    return Err(out_of_reach.or(singular).unwrap_or(error));
                }
                Err(error) => {
                    if matches!(error, AssemblyError::Undetermined { .. }) {
                        singular.get_or_insert(error);
                    }
                    self.state.clone_from(&self.before);
                    step = 0.5 * (next - now);
                }
            }
        }
        Ok(())
    }

    /// The gap at `to` if the mechanism cannot be assembled there at all, near where it is: what is
    /// out of reach is no jump on the way.
    fn out_of_reach(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
        to: f64,
        mut motion: impl FnMut(f64, &mut [Target<f64>]),
    ) -> Option<AssemblyError> {
        self.state.clone_from(&self.before);
        let mut targets = core::mem::take(&mut self.targets);
        motion(to, &mut targets);
        self.targets = targets;
        self.search(topology, parameters).err()
    }

    /// Moves along a motion in one step, if it is smooth enough for that; if not, stays where it is and
    /// returns false. It may be many samples long: [`Self::follow`] is for what must arrive. Unlike there,
    /// nothing is searched for, so that failing costs little.
    ///
    /// # Panics
    /// Unless there is one target for each prescribed coordinate.
    #[must_use = "it may have stayed where it was"]
    pub fn leap(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
        step: f64,
        targets: &[Target<f64>],
    ) -> bool {
        let coordinates = self.prescription.coordinates();
        check_number(coordinates, targets);
        if check_angle_ranges(&self.body_names, coordinates, targets).is_err() {
            return false;
        }
        let before = core::mem::replace(&mut self.targets, targets.to_vec());
        self.passed.copy_from_slice(&before);
        let arrived = self.step_smoothly(topology, parameters, step, false).is_ok();
        if !arrived {
            self.state.clone_from(&self.before);
            self.targets = before;
            self.differentiate(topology, parameters);
        }
        arrived
    }

    /// One step along a motion; fails if the bodies do not move as their velocities say. Where it does not
    /// converge by itself it is searched for if `careful`.
    fn step_smoothly(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
        step: f64,
        careful: bool,
    ) -> Result<(), AssemblyError> {
        self.before.clone_from(&self.state);
        for (move_by, (v, a)) in
            self.step.iter_mut().zip(self.state.rates.iter().zip(&self.state.accelerations))
        {
            *move_by = step * (v + 0.5 * step * a);
        }
        self.state.advance(topology, &self.step);
        if careful {
            self.settle(topology, parameters)?;
        } else if !self.newton(topology, parameters) || !self.differentiates(topology, parameters) {
            return Err(AssemblyError::Undetermined { open: Vec::new() });
        }

        // Fourth-order prediction from velocities and accelerations at both ends.
        let ends = self.before.rates.iter().zip(&self.state.rates);
        let bends = self.before.accelerations.iter().zip(&self.state.accelerations);
        for ((move_by, (v0, v1)), (a0, a1)) in self.step.iter_mut().zip(ends).zip(bends) {
            *move_by = 0.5 * step * (v0 + v1) + step * step / 12.0 * (a0 - a1);
        }
        self.predicted.clone_from(&self.before);
        self.predicted.advance(topology, &self.step);
        let length = parameters.length;
        self.trial.place(topology, parameters, &self.before.coordinates);
        let (_, _, moved) = farthest(&self.trial, &self.kinematics.bodies, length);
        self.trial.place(topology, parameters, &self.predicted.coordinates);
        let (body, apart, missed) = farthest(&self.trial, &self.kinematics.bodies, length);
        // A smooth motion is predicted to a small part of what was moved; a jump is not.
        let follows = missed <= 0.2 * moved + 1e-6 && missed <= 0.1;
        if !follows && !self.turns_with_a_kink(topology, parameters, step, missed) {
            return Err(AssemblyError::Jump {
                body: self.body_names[body].clone(),
                distance_mm: apart.position.norm() * 1e3,
                angle_deg: apart.rotation.rotation_vector().norm().to_degrees(),
                step,
            });
        }
        Ok(())
    }

    /// Whether a step that is `missed` by so much is what a kink of the prescribed motion explains: rates
    /// that jump because theirs do, and bodies no farther off than these rates carry them.
    fn turns_with_a_kink(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
        step: f64,
        missed: f64,
    ) -> bool {
        let kinked = self.passed.iter().zip(&self.targets).any(|(from, to)| {
            let bend = 0.5 * step * (from.acceleration + to.acceleration);
            (to.rate - from.rate - bend).abs() > 0.1 * from.rate.abs().max(to.rate.abs())
        });
        if !kinked || missed > 0.01 {
            return false;
        }
        // Somewhere on the way the rates change from those before to those behind.
        let ends = [&self.before.rates, &self.state.rates].map(|rates| {
            let mut end = self.before.clone();
            end.advance(topology, &rates.iter().map(|rate| step * rate).collect::<Vec<f64>>());
            end
        });
        self.trial.place(topology, parameters, &ends[0].coordinates);
        let mut behind = self.trial.clone();
        behind.place(topology, parameters, &ends[1].coordinates);
        let (_, _, spread) = farthest(&self.trial, &behind, parameters.length);
        missed <= 0.6 * spread + 1e-6
    }

    /// Newton's method from the present state to the present targets, then rates and
    /// accelerations. Falls back on the careful search and on a new plan.
    fn settle(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
    ) -> Result<(), AssemblyError> {
        if !self.newton(topology, parameters) {
            self.reassemble(topology, parameters).map_err(on_the_way)?;
        }
        if self.differentiates(topology, parameters) {
            return self.agree(topology, parameters);
        }
        // The position is closed, but singular: no rates, or any.
        self.state.rates.fill(0.0);
        self.state.accelerations.fill(0.0);
        let planned = self.plan(topology, parameters).map_err(on_the_way);
        planned.and(Err(AssemblyError::Undetermined { open: Vec::new() }))
    }

    /// Finds rates and accelerations; false where there are none.
    fn differentiates(&mut self, topology: &Topology, parameters: &Parameters<f64>) -> bool {
        self.differentiate(topology, parameters);
        let mut derivatives = self.state.rates.iter().chain(&self.state.accelerations);
        derivatives.all(|x| x.is_finite())
    }

    /// Whether rates and accelerations are those of loops that stay closed, as prescribed.
    fn agree(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
    ) -> Result<(), AssemblyError> {
        self.kinematics.contradiction(
            topology,
            parameters,
            &self.prescription,
            &self.state,
            &self.targets,
            &self.joint_names,
        )
    }

    /// The careful search, then Newton's method with a new plan.
    fn reassemble(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
    ) -> Result<(), AssemblyError> {
        self.search(topology, parameters)?;
        self.plan(topology, parameters)?;
        if !self.newton(topology, parameters) {
            return Err(AssemblyError::Gap(self.gap(topology, parameters)));
        }
        // What is singular shows only where the loops are closed to round-off.
        self.plan(topology, parameters)
    }

    fn differentiate(&mut self, topology: &Topology, parameters: &Parameters<f64>) {
        self.kinematics.differentiate(
            topology,
            parameters,
            &self.prescription,
            &self.program,
            &mut self.state,
            &self.targets,
        );
    }

    /// Whether Newton's method closes everything, by the present plan.
    fn newton(&mut self, topology: &Topology, parameters: &Parameters<f64>) -> bool {
        let closed = CLOSED.max(self.round_off());
        let mut error = f64::INFINITY;
        for _ in 0..NEWTON_STEPS {
            self.sound.clone_from(&self.state);
            self.kinematics.approach(
                topology,
                parameters,
                &self.prescription,
                &self.program,
                &mut self.state,
                &self.targets,
            );
            if !self.state.coordinates.iter().all(|q| q.is_finite()) {
                // Singular: whoever comes next begins where numbers are still numbers.
                self.state.clone_from(&self.sound);
                return false;
            }
            // The error before the step that was just taken.
            if self.scaled_error() < NEAR {
                let (prescription, state) = (&self.prescription, &self.state);
                self.kinematics.place(topology, parameters, prescription, state, &self.targets);
                error = self.scaled_error();
                if error < closed {
                    return true;
                }
            }
        }
        error < CLOSED_AT_WORST.max(closed)
    }

    /// Joint coordinates of many turns, and numbers far from zero, carry their own round-off.
    fn round_off(&self) -> f64 {
        let largest = self.state.coordinates.iter().fold(0.0_f64, |max, q| max.max(q.abs()));
        8.0 * f64::EPSILON * largest
    }

    /// The largest error, lengths in units of the characteristic length; infinite if undefined.
    fn scaled_error(&self) -> f64 {
        let errors =
            self.kinematics.errors().iter().zip(&self.row_scales).map(|(e, s)| (e * s).abs());
        errors.fold(0.0, |max, e| if e.is_nan() { f64::INFINITY } else { e.max(max) })
    }
}

/// What a prescription leaves open at a position that it reached is due to that position.
fn on_the_way(error: AssemblyError) -> AssemblyError {
    match error {
        AssemblyError::Open { open } => AssemblyError::Undetermined { open },
        other => other,
    }
}

/// The body that differs most between two placements: its number, its relative pose, and the size
/// of the difference, rotations counting as such and displacements in units of `length`.
fn farthest(a: &Bodies<f64>, b: &Bodies<f64>, length: f64) -> (usize, Pose<f64>, f64) {
    let mut worst = (0, Pose::identity(), 0.0);
    for (body, (a, b)) in a.pose.iter().zip(&b.pose).enumerate() {
        let apart = a.inverse() * *b;
        let size = apart.position.norm() / length + apart.rotation.rotation_vector().norm();
        if size > worst.2 {
            worst = (body, apart, size);
        }
    }
    worst
}

/// What is named must exist: indices are the caller's, and no input.
fn check_existence(
    mechanism: &Mechanism,
    homes: &[(BodyId, Pose<f64>)],
    coordinates: &[Coordinate],
) {
    let check_body = |body: BodyId| {
        let count = mechanism.bodies().len();
        assert!(body.0 < count, "{body:?} of a mechanism of {count} bodies, the ground among them");
    };
    homes.iter().for_each(|(body, _)| check_body(*body));
    for coordinate in coordinates {
        match *coordinate {
            Coordinate::Position { body, axis: index }
            | Coordinate::Angle { body, index, .. }
            | Coordinate::RotationVector { body, axis: index } => {
                check_body(body);
                assert!(index < 3, "{coordinate:?}: there are three of these");
            }
            Coordinate::Joint { joint, freedom } => {
                let joints = mechanism.joints();
                let count = joints.len();
                assert!(joint.0 < count, "{joint:?} of a mechanism of {count} joints");
                let joint_type = joints[joint.0].joint_type;
                assert!(
                    joint_type.has_scalar_coordinates() && freedom < joint_type.freedoms().len(),
                    "joint `{}` has no scalar coordinate {freedom}",
                    joints[joint.0].name
                );
            }
        }
    }
}

fn check_number(coordinates: &[Coordinate], targets: &[Target<f64>]) {
    let (found, expected) = (targets.len(), coordinates.len());
    assert!(found == expected, "{found} targets for {expected} prescribed coordinates");
}

fn check_targets(
    body_names: &[String],
    coordinates: &[Coordinate],
    targets: &[Target<f64>],
) -> Result<(), AssemblyError> {
    check_number(coordinates, targets);
    let is_finite =
        |t: &Target<f64>| [t.value, t.rate, t.acceleration].iter().all(|x| x.is_finite());
    match targets.iter().position(|target| !is_finite(target)) {
        Some(index) => Err(AssemblyError::NotFinite { index }),
        None => check_angle_ranges(body_names, coordinates, targets),
    }
}

fn check_angle_ranges(
    body_names: &[String],
    coordinates: &[Coordinate],
    targets: &[Target<f64>],
) -> Result<(), AssemblyError> {
    for (coordinate, target) in coordinates.iter().zip(targets) {
        let Coordinate::Angle { body, order, index: 1 } = coordinate else { continue };
        let quarter = core::f64::consts::FRAC_PI_2;
        let (middle, range) = if order.is_tait_bryan() {
            (0.0, "between -90 and 90 deg")
        } else {
            (quarter, "between 0 and 180 deg")
        };
        if (target.value - middle).abs() >= quarter * (1.0 - 1e-9) {
            return Err(AssemblyError::AngleRange {
                body: body_names[body.0].clone(),
                degrees: target.value.to_degrees(),
                range,
            });
        }
    }
    Ok(())
}
