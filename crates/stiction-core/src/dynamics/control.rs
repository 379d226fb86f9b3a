//! Inverse dynamics in a control loop: computes all forces from independent coordinates without
//! memory allocation.

use super::checks;
use super::data::Data;
use super::forces::{BALANCED, InterfaceForce};
use super::model::Model;
use super::power::Power;
use super::settings::FrictionMode;
use super::spring::SpringFault;
use crate::kinematics::{State, Target};
use crate::parameters::Parameters;
use crate::spatial::Vec3;
use crate::statics::AppliedLoad;

/// Largest number of Newton steps to close the loops.
const CLOSURE_STEPS: usize = 12;
/// Closure error below which one more Newton step closes the loops to round-off: lengths divided by
/// the characteristic length, angles in rad.
const NEAR: f64 = 1e-7;
/// Loops count as open if the closure error exceeds this value: lengths divided by the
/// characteristic length, angles in rad.
const CLOSED: f64 = 1e-12;

/// Outcome of [`Model::inverse_dynamics`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[must_use = "the forces are valid only if the computation converged"]
pub enum Status {
    /// All equations hold: loop closures, balance of every body, friction laws.
    Converged,
    /// A coordinate, rate, acceleration or load is NaN or infinite.
    InputNotFinite,
    /// Newton's method does not close the loops from the last closed configuration: the requested
    /// configuration is out of reach or too far away.
    LoopsOpen {
        /// Largest error of a loop closure or a prescribed coordinate: lengths divided by the
        /// characteristic length, angles in rad. NaN if Newton's method diverged.
        error: f64,
    },
    /// The prescribed rates or accelerations would open a loop.
    MotionInconsistent,
    /// The configuration is singular: the prescribed coordinates do not determine rates or
    /// accelerations.
    Singular,
    /// The ends of a spring coincide, so its force has no direction.
    SpringWithoutDirection {
        /// Index of the spring in [`Parameters::springs`].
        spring: usize,
    },
    /// A bushing, or a spring on a cut joint, is rotated too far for its moment to be defined.
    SpringTurned {
        /// Index of the bushing in [`Parameters::bushings`] or, if `on_joint`, of the spring in
        /// [`Parameters::joint_springs`].
        spring: usize,
        /// True for a joint spring, false for a bushing.
        on_joint: bool,
    },
    /// The two supports of a friction interface no longer overlap.
    NoOverlap {
        /// Index of the friction interface in [`Parameters::interfaces`].
        interface: usize,
    },
    /// The coupling of friction and reactions did not converge within
    /// [`Settings::friction_steps`](super::Settings::friction_steps).
    FrictionNotConverged {
        /// Largest change of a normal force in the last step, N.
        change: f64,
    },
    /// The determinant of the balance with friction differs in sign from that without friction.
    /// Either friction locks the mechanism at smaller friction coefficients, or the solution is on
    /// another solution branch.
    FrictionLocks,
    /// The relative power residual exceeds 1e-9, because the elimination order is not suited to the
    /// configuration. Compile a model at this configuration with
    /// [`InverseDynamics`](super::InverseDynamics).
    Unbalanced {
        /// Relative power residual; infinite if forces are not finite or grow without bound.
        residual: f64,
    },
}

impl Status {
    /// Returns true if the iteration has converged, so that the forces are valid.
    pub fn is_converged(self) -> bool {
        self == Self::Converged
    }

    /// Returns a description of the outcome, without a capital letter and a full stop.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Converged => "all equations hold",
            Self::InputNotFinite => "a coordinate, rate, acceleration or load is NaN or infinite",
            Self::LoopsOpen { .. } => "the loops do not close: the position is out of reach",
            Self::MotionInconsistent => "the rates or accelerations would open a loop",
            Self::Singular => {
                "the position is singular: the coordinates do not determine the motion"
            }
            Self::SpringWithoutDirection { .. } => "the ends of a spring coincide",
            Self::SpringTurned { .. } => "a bushing or a spring on a joint is rotated too far",
            Self::NoOverlap { .. } => "the two supports of a guide have passed each other",
            Self::FrictionNotConverged { .. } => {
                "the coupling of friction and reactions did not converge: friction is close to \
                 locking the mechanism"
            }
            Self::FrictionLocks => "friction locks the mechanism",
            Self::Unbalanced { .. } => {
                "the forces do not balance to 1e-9: the position is close to a singular one, or far \
                 from the home position"
            }
        }
    }
}

impl Model {
    /// Computes the inverse dynamics with friction: the efforts for values `q`, rates `v` and
    /// accelerations `a` of the prescribed coordinates under external `loads`.
    ///
    /// `q`, `v` and `a` are in the order of
    /// [`MotionConstraints::coordinates`](crate::kinematics::MotionConstraints::coordinates), in m
    /// and rad. Newton's method closes the loops from the last closed configuration in `data`, so
    /// successive configurations must be close to each other; the assembly mode is that of `data`.
    /// The parameters are [`Self::parameters`]. The computation allocates no memory.
    ///
    /// Unless the status is [`Status::Converged`], the forces in `data` are not valid for this
    /// motion, and the next call starts from the last closed configuration. The coupling of
    /// friction and reactions yields the solution connected to the frictionless solution;
    /// [`InverseDynamics::coupling`](super::InverseDynamics::coupling) certifies its uniqueness.
    ///
    /// # Panics
    /// If the length of `q`, `v` or `a` differs from the number of coordinates, or if a load acts
    /// on a body that does not exist.
    pub fn inverse_dynamics(
        &self,
        data: &mut Data<f64>,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        loads: &[AppliedLoad<f64>],
    ) -> Status {
        self.inverse_dynamics_with(&self.parameters, data, q, v, a, loads)
    }

    /// Computes the inverse dynamics like [`Self::inverse_dynamics`], with the given parameters,
    /// such as friction coefficients tuned at run time.
    ///
    /// # Panics
    /// See [`Self::inverse_dynamics`]; also if `parameters` belongs to another mechanism.
    pub fn inverse_dynamics_with(
        &self,
        parameters: &Parameters<f64>,
        data: &mut Data<f64>,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        loads: &[AppliedLoad<f64>],
    ) -> Status {
        data.set_targets(q, v, a);
        let outcome = self.solve_for_motion_or_return(parameters, data, loads);
        match outcome.and_then(|()| self.solve_for_forces(parameters, data, loads)) {
            Ok(()) => Status::Converged,
            Err(status) => status,
        }
    }

    /// Closes the loops and computes the motion of all bodies, [`Data::kinematics`], without
    /// forces; see [`Self::inverse_dynamics`].
    ///
    /// # Panics
    /// If the length of `q`, `v` or `a` differs from the number of coordinates.
    pub fn move_to(&self, data: &mut Data<f64>, q: &[f64], v: &[f64], a: &[f64]) -> Status {
        data.set_targets(q, v, a);
        match self.solve_for_motion_or_return(&self.parameters, data, &[]) {
            Ok(()) => Status::Converged,
            Err(status) => status,
        }
    }

    /// Solves for the motion. If the loops stay open or the configuration is singular, restores the
    /// last closed configuration.
    fn solve_for_motion_or_return(
        &self,
        parameters: &Parameters<f64>,
        data: &mut Data<f64>,
        loads: &[AppliedLoad<f64>],
    ) -> Result<(), Status> {
        let outcome = self.solve_for_motion(parameters, data, loads);
        if matches!(outcome, Err(Status::LoopsOpen { .. } | Status::Singular)) {
            data.state.clone_from(&data.closed);
        }
        outcome
    }

    /// Closes the loops and solves for rates and accelerations.
    fn solve_for_motion(
        &self,
        parameters: &Parameters<f64>,
        data: &mut Data<f64>,
        loads: &[AppliedLoad<f64>],
    ) -> Result<(), Status> {
        let Data { state, kinematics, closed, targets, .. } = data;
        let is_finite = |t: &Target<f64>| {
            t.value.is_finite() && t.rate.is_finite() && t.acceleration.is_finite()
        };
        let bodies = self.mechanism.bodies().len();
        if !targets.iter().all(is_finite) || checks::not_finite_load(loads, bodies).is_some() {
            return Err(Status::InputNotFinite);
        }
        let (constraints, length) = (self.constraints(), parameters.length);
        let mut error = f64::INFINITY;
        for _ in 0..CLOSURE_STEPS {
            kinematics.approach(&self.kinematic, parameters, state, targets);
            error = kinematics.scaled_error(constraints, length);
            if !state.coordinates.iter().all(|q| q.is_finite()) {
                return Err(Status::LoopsOpen { error });
            }
            if error >= NEAR {
                continue;
            }
            kinematics.differentiate(&self.kinematic, parameters, state, targets);
            error = kinematics.scaled_error(constraints, length);
            if error <= CLOSED.max(state.round_off()) {
                break;
            }
        }
        if error.is_nan() || error > CLOSED.max(state.round_off()) {
            return Err(Status::LoopsOpen { error });
        }
        if !state.rates.iter().chain(&state.accelerations).all(|x| x.is_finite()) {
            return Err(Status::Singular);
        }
        closed.clone_from(state);
        if kinematics.contradicts(&self.kinematic, parameters, state, targets) {
            return Err(Status::MotionInconsistent);
        }
        Ok(())
    }

    /// Solves for reactions, friction and efforts at the motion in `data`, and checks that the
    /// results are valid.
    fn solve_for_forces(
        &self,
        parameters: &Parameters<f64>,
        data: &mut Data<f64>,
        loads: &[AppliedLoad<f64>],
    ) -> Result<(), Status> {
        let Data { kinematics, inverse, settings, forces, .. } = data;
        match SpringFault::first(&self.kinematic.topology, parameters, &kinematics.bodies) {
            None => {}
            Some(SpringFault::NoDirection(spring)) => {
                return Err(Status::SpringWithoutDirection { spring });
            }
            Some(SpringFault::Twisted(spring, _)) => {
                return Err(Status::SpringTurned { spring, on_joint: false });
            }
            Some(SpringFault::Uncounted(spring, _)) => {
                return Err(Status::SpringTurned { spring, on_joint: true });
            }
        }
        if settings.friction != FrictionMode::Off
            && let Some((interface, _)) = checks::parted_supports(parameters, &kinematics.bodies)
        {
            return Err(Status::NoOverlap { interface });
        }
        inverse.solve(self, parameters, kinematics, loads, settings);
        if !inverse.friction_settled(settings) {
            return Err(match inverse.orientation() < 0.0 {
                true => Status::FrictionLocks,
                false => Status::FrictionNotConverged { change: inverse.friction_change() },
            });
        }
        let bodies = &kinematics.bodies;
        forces.read(self, parameters, bodies, inverse);
        let dissipated = forces.interfaces.iter().map(|interface| interface.power);
        let efforts = &forces.efforts;
        forces.power = Power::new(self.topology(), parameters, bodies, efforts, dissipated, loads);
        let residual = match inverse.is_balanced(self, parameters) {
            true => forces.imbalance(parameters.length),
            false => f64::INFINITY,
        };
        if residual <= BALANCED { Ok(()) } else { Err(Status::Unbalanced { residual }) }
    }
}

impl Data<f64> {
    /// Sets the configuration from which the next computation starts, without memory allocation.
    ///
    /// # Panics
    /// If `state` belongs to another spanning tree.
    pub fn start_from(&mut self, state: &State<f64>) {
        assert_eq!(
            state.coordinates.len(),
            self.state.coordinates.len(),
            "the state belongs to another spanning tree"
        );
        self.state.clone_from(state);
        self.closed.clone_from(state);
    }

    fn set_targets(&mut self, q: &[f64], v: &[f64], a: &[f64]) {
        let count = self.targets.len();
        let lengths = [q.len(), v.len(), a.len()];
        assert_eq!(
            lengths, [count; 3],
            "expected positions, rates and accelerations of {count} coordinates"
        );
        for (target, ((value, rate), acceleration)) in
            self.targets.iter_mut().zip(q.iter().zip(v).zip(a))
        {
            *target = Target { value: *value, rate: *rate, acceleration: *acceleration };
        }
    }

    /// Returns the actuator forces, N, and torques, N m, computed by [`Model::inverse_dynamics`],
    /// in the order of [`Mechanism::actuators`](crate::mechanism::Mechanism::actuators). They are
    /// valid if the last call returned [`Status::Converged`].
    pub fn efforts(&self) -> &[f64] {
        &self.forces.efforts
    }

    /// Returns the actuator forces, N, and torques, N m, without friction, in the order of
    /// [`Self::efforts`].
    pub fn efforts_frictionless(&self) -> &[f64] {
        &self.forces.efforts_frictionless
    }

    /// Returns the complete reaction of the joint with index `joint`, in world axes: the force, N,
    /// that the predecessor exerts on the successor, and the moment about the origin of frame J of
    /// the joint, N m. The reaction includes constraint, actuator and friction forces.
    pub fn reaction(&self, joint: usize) -> (Vec3<f64>, Vec3<f64>) {
        self.forces.reactions[joint]
    }

    /// Returns sliding velocity, normal force and friction force of each friction interface, in the
    /// order of [`Parameters::interfaces`].
    pub fn friction(&self) -> &[InterfaceForce] {
        &self.forces.interfaces
    }

    /// Returns the power balance of the last [`Model::inverse_dynamics`].
    pub fn power(&self) -> &Power {
        &self.forces.power
    }
}
