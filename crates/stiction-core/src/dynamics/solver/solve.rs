//! Computation of forces at a configuration: by the compiled model or, where it is not reliable, by
//! the dense fallback.

use super::{Compiled, InverseDynamics};
use crate::dynamics::checks;
use crate::dynamics::continuation;
use crate::dynamics::dense_fallback;
use crate::dynamics::error::InverseError;
use crate::dynamics::forces::{BALANCED, Bounds, Forces};
use crate::dynamics::inverse::BALANCED as BALANCE;
use crate::dynamics::power::Power;
use crate::dynamics::rest::bounds;
use crate::dynamics::rest::{self, Rest};
use crate::dynamics::settings::FrictionMode;
use crate::dynamics::spring::SpringFault;
use crate::friction::InterfaceShape;
use crate::friction_problem::continuation::Lock;
use crate::friction_problem::normal_load::Configuration;
use crate::mechanism::Mechanism;
use crate::parameters::{InterfaceParameters, Parameters};
use crate::statics::{AppliedLoad, InfeasibleLoad};

/// A configuration counts as singular only if a pivot of the balance is below this value, in units
/// of the characteristic length.
const SUSPICIOUS_PIVOT: f64 = 1e-8;

impl InverseDynamics {
    /// Computes all forces at the present configuration under external loads.
    ///
    /// # Errors
    /// See [`InverseError`]. After an error, [`Self::forces`] does not belong to this
    /// configuration.
    ///
    /// # Panics
    /// If a load acts on a body that does not exist.
    pub fn solve(&mut self, loads: &[AppliedLoad<f64>]) -> Result<&Forces, InverseError> {
        self.check_loads(loads)?;
        self.check_springs()?;
        self.check_overlaps()?;
        // A program computes no pivots, and its solutions are unique.
        let by_program = self.by_program(loads);
        let mut balanced = by_program || self.by_kernel(loads);
        if !balanced {
            // The elimination order may be unsuited to this configuration, so the model is compiled
            // here.
            self.replan();
            balanced = self.by_kernel(loads);
            if !balanced && !self.is_balanced_without_friction(loads) {
                return self.solve_dense(loads);
            }
        }
        match self.finish(loads, balanced) {
            // At a singular configuration, the kernel solves with pivots that are round-off.
            Ok(())
                if self.forces.imbalance(self.parameters.length) <= BALANCED
                    && (by_program || !self.is_singular()) =>
            {
                Ok(&self.forces)
            }
            Err(locked @ InverseError::Locked { .. }) if !self.is_singular() => Err(locked),
            _ => self.solve_dense(loads),
        }
    }

    /// Checks that all components of the loads are finite and that their bodies exist.
    fn check_loads(&self, loads: &[AppliedLoad<f64>]) -> Result<(), InverseError> {
        let bodies = self.mechanism.bodies();
        match checks::not_finite_load(loads, bodies.len()) {
            None => Ok(()),
            Some(k) => {
                let body = bodies[loads[k].body.0].name.clone();
                Err(InverseError::NotFinite { body })
            }
        }
    }

    /// Checks that the force of every spring is defined.
    fn check_springs(&self) -> Result<(), InverseError> {
        let fault = SpringFault::first(&self.topology, &self.parameters, self.bodies());
        match fault.map(|fault| fault.in_words(&self.mechanism)) {
            None => Ok(()),
            Some((spring, None)) => Err(InverseError::SpringWithoutDirection { spring }),
            Some((spring, Some(problem))) => Err(InverseError::Spring { spring, problem }),
        }
    }

    /// Checks that the two supports of every guide overlap.
    fn check_overlaps(&self) -> Result<(), InverseError> {
        if self.settings.friction == FrictionMode::Off {
            return Ok(());
        }
        match checks::parted_supports(&self.parameters, self.bodies()) {
            None => Ok(()),
            Some((interface, beyond)) => {
                let joint = self.parameters.interfaces[interface].joint;
                let joint = self.mechanism.joints()[joint].name.clone();
                Err(InverseError::NoOverlap { joint, beyond })
            }
        }
    }

    /// Returns true if the forces of the last solution by the kernel are not unique because the
    /// configuration is singular. Decomposes matrices only if a pivot is small.
    fn is_singular(&self) -> bool {
        let Ok(Compiled { model, inverse }) = &self.compiled else { return false };
        let length = self.parameters.length;
        let suspicious = SUSPICIOUS_PIVOT * length.min(1.0 / length).min(1.0);
        let is_regular = inverse.smallest_pivot(model) >= suspicious;
        !is_regular && self.statics().open_motions() > self.constraints().spins().len()
    }

    /// Returns true if the balance is satisfied without friction; only then can friction be the
    /// cause of a failure.
    fn is_balanced_without_friction(&mut self, loads: &[AppliedLoad<f64>]) -> bool {
        if self.settings.friction != FrictionMode::Converged {
            return false;
        }
        self.settings.friction = FrictionMode::Off;
        let balanced = self.by_kernel(loads);
        self.settings.friction = FrictionMode::Converged;
        self.by_kernel(loads);
        balanced
    }

    /// Solves for all forces with the compiled model. Returns false if no model is compiled, or if
    /// the results are not reliable.
    pub(in crate::dynamics) fn by_kernel(&mut self, loads: &[AppliedLoad<f64>]) -> bool {
        self.share_kinematics();
        let Ok(Compiled { model, inverse }) = &mut self.compiled else { return false };
        self.assembly.forget_spins();
        let (_, kinematics) = self.assembly.parts();
        let (parameters, settings) = (&*self.parameters, &self.settings);
        inverse.begin(model, parameters, kinematics, loads, settings);
        let coupling = &mut self.friction_coupling;
        coupling.start_from(inverse);
        self.strength = 0.0;
        if settings.friction == FrictionMode::Converged
            && inverse.interfaces().iter().any(|interface| interface.sliding > 0.0)
        {
            let bodies = &kinematics.bodies;
            self.strength = coupling.begin(inverse, model, parameters, bodies);
            let at = Configuration { parameters, bodies };
            if self.strength < 1.0 && coupling.solve_present(at) {
                let wrench_of = |joint| coupling.present_wrench(joint);
                let found = (wrench_of, coupling.present_loads());
                // This solution does not include static friction.
                let is_whole = coupling.has_only_sliding_friction();
                let tolerance = (settings, BALANCE);
                let adopted = inverse.adopt(model, parameters, bodies, tolerance, found);
                if adopted && is_whole {
                    return true;
                }
            }
        }
        // Newton's method starts from the present normal loads.
        inverse.complete(model, parameters, kinematics, settings);
        inverse.is_balanced(model, parameters)
    }

    /// Checks the friction solution, copies the results of the compiled model, and computes effort
    /// intervals and the power balance. `balanced` is true if the results of the compiled model
    /// satisfy the balance.
    fn finish(&mut self, loads: &[AppliedLoad<f64>], balanced: bool) -> Result<(), InverseError> {
        let Ok(Compiled { model, inverse }) = &mut self.compiled else {
            return Err(InverseError::Unsettled);
        };
        let (topology, parameters) = (&*self.topology, &*self.parameters);
        let settings = &self.settings;
        let (_, kinematics) = self.assembly.parts();
        let is_unique = self.strength < 1.0;
        let settled =
            inverse.friction_settled(settings) || (is_unique && inverse.friction_stagnated());
        if !settled || !is_unique || !balanced {
            // Several solutions or none may exist. Continuation from zero friction reaches the
            // solution connected to the frictionless one, or ends where friction locks the
            // mechanism.
            let followed = continuation::follow_friction(
                inverse, model, parameters, kinematics, loads, settings, 1.0,
            );
            if let Err(lock) = followed {
                // If a solution certainly exists, the failure is only a lack of accuracy. (The
                // normal force of a thread depends on the friction of the thread itself and is
                // unbounded if the thread locks.)
                let is_thread = |interface: &InterfaceParameters<f64>| {
                    interface.shape == InterfaceShape::Thread
                };
                let exists = is_unique && !parameters.interfaces.iter().any(is_thread);
                return Err(match exists {
                    true => InverseError::Unsettled,
                    false => locked(&self.mechanism, parameters, lock),
                });
            }
        }
        self.forces_by_kernel = true;
        let forces = &mut self.forces;
        forces.read(model, parameters, &kinematics.bodies, inverse);
        let position = bounds::Position { model, parameters, kinematics, loads, settings };
        bounds::bound_efforts(forces, inverse, position, &mut self.friction_coupling);
        let dissipated = forces.interfaces.iter().map(|c| c.power);
        let bodies = &kinematics.bodies;
        forces.power = Power::new(topology, parameters, bodies, &forces.efforts, dissipated, loads);
        Ok(())
    }

    /// Computes all forces by dense decompositions, which is slow. Used for configurations that the
    /// compiled model cannot solve, and as a reference in tests. Does not compute effort intervals:
    /// their width is zero, and [`Forces::bounds`] is [`Bounds::Unknown`] if static friction acts.
    ///
    /// # Errors
    /// See [`InverseError`].
    ///
    /// # Panics
    /// If a load acts on a body that does not exist.
    pub fn solve_dense(&mut self, loads: &[AppliedLoad<f64>]) -> Result<&Forces, InverseError> {
        self.check_loads(loads)?;
        self.check_springs()?;
        self.check_overlaps()?;
        let statics = self.statics();
        let spins = self.spin_responses();
        let bodies = &self.assembly.kinematics().bodies;
        let accelerations = &self.assembly.state().accelerations;
        let solution = dense_fallback::solve(
            &dense_fallback::Position {
                mechanism: &self.mechanism,
                topology: &self.topology,
                parameters: &self.parameters,
                statics: &statics,
                bodies,
            },
            accelerations,
            &spins,
            loads,
            &self.settings,
        )
        .map_err(|uncarried| self.in_words(&uncarried))?;
        if !solution.settled {
            return Err(InverseError::Unsettled);
        }
        if let Some(lock) = solution.lock {
            return Err(locked(&self.mechanism, &self.parameters, lock));
        }
        let has_friction = self.settings.friction != FrictionMode::Off;
        self.forces.take(bodies, &solution, has_friction);
        self.forces_by_kernel = false;
        self.shares.clone_from(&solution.shares);
        self.forces.power = Power::new(
            &self.topology,
            &self.parameters,
            &solution.bodies,
            &self.forces.efforts,
            self.forces.interfaces.iter().map(|c| c.power),
            loads,
        );
        let residual = self.forces.imbalance(self.parameters.length);
        if residual <= BALANCED {
            Ok(&self.forces)
        } else {
            Err(InverseError::Inaccurate { residual })
        }
    }

    /// Stops the mechanism at the present configuration, with zero rates and accelerations, and
    /// analyses static friction there. Afterwards [`Self::forces`] returns the forces at rest.
    ///
    /// # Errors
    /// See [`InverseError`]. Returns [`InverseError::Singular`] or [`InverseError::Unsettled`] if the
    /// configuration is singular, and [`InverseError::TwoWeightings`] if constraints and actuators
    /// are both redundant.
    ///
    /// # Panics
    /// If a load acts on a body that does not exist.
    pub fn rest(&mut self, loads: &[AppliedLoad<f64>]) -> Result<Rest, InverseError> {
        self.assembly.stop(&self.parameters);
        self.solve(loads)?;
        let Compiled { model, inverse } = self.compiled.as_mut().map_err(|error| error.clone())?;
        if self.forces.bounds == Bounds::Unknown {
            return Err(InverseError::Unsettled);
        }
        let (parameters, settings) = (&*self.parameters, &self.settings);
        let (_, kinematics) = self.assembly.parts();
        let position = bounds::Position { model, parameters, kinematics, loads, settings };
        let mut rest = rest::examine(inverse, position, &mut self.friction_coupling);
        rest.extend_intervals(&mut self.forces);
        rest.take_intervals(&self.forces);
        Ok(rest)
    }

    /// Converts an infeasible load to an error that names the body and describes the motion.
    fn in_words(&self, uncarried: &InfeasibleLoad) -> InverseError {
        let (body, motion) = uncarried.motion.in_words(&self.mechanism, self.parameters.origin);
        let unit = if uncarried.motion.turns { "N m" } else { "N" };
        InverseError::CannotCarry { body, motion, missing: uncarried.missing.abs(), unit }
    }
}

/// Creates the error for a mechanism that friction locks, with the name of the joint.
fn locked(mechanism: &Mechanism, parameters: &Parameters<f64>, lock: Lock) -> InverseError {
    let joint = parameters.interfaces[lock.interface].joint;
    InverseError::Locked {
        joint: mechanism.joints()[joint].name.clone(),
        percent: 100.0 * lock.part,
    }
}
