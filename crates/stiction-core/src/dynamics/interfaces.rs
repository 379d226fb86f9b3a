//! Friction interfaces during a computation: sliding velocities, normal forces, and friction
//! linearised in the reactions.
//!
//! Equations (F2), (F4) and (F5) of the book's theory.

use crate::friction::{Law, Load, OwnFriction, Resistance};
use crate::friction_problem::normal_load::{normal_load, normal_load_between};
use crate::kinematics::Bodies;
use crate::parameters::{InterfaceParameters, Parameters};
use crate::scalar::Scalar;
use crate::spatial::{Pose, Twist, Wrench};
use crate::topology::Topology;

/// State of a friction interface at one instant.
///
/// The generalised friction force on DOF `f` of its joint is `against[f] * (resistance.constant +
/// resistance.coefficient * load)`, where `load` is the normal force.
#[derive(Clone, Copy, Debug)]
pub struct InterfaceState<T> {
    /// Sliding velocity at the surface, m/s. For a ball or plate, the magnitude of the sliding
    /// velocity.
    pub velocity: T,
    /// Slip indicator: one during slip, zero at rest.
    pub sliding: T,
    /// Generalised force on each DOF of the interface per newton of friction at the surface. The
    /// force opposes the motion and includes the lever arm.
    pub(crate) against: [T; 3],
    /// Sense of slip of an interface with one DOF: 1 for forward, -1 for backward slip. At rest,
    /// the signed ratio of the static friction to its limit.
    pub(crate) sense: T,
    pub(crate) resistance: Resistance<T>,
    /// Normal force at the last update, N, and the gradient of the normal force with respect to the
    /// joint wrench.
    pub(crate) load: Load<T>,
}

impl<T: Scalar> InterfaceState<T> {
    pub(crate) fn new() -> Self {
        Self {
            velocity: T::zero(),
            sliding: T::zero(),
            against: [T::zero(); 3],
            sense: T::zero(),
            resistance: Resistance { coefficient: T::zero(), constant: T::zero() },
            load: Load { value: T::zero(), gradient: Twist::zero() },
        }
    }

    /// Returns the normal force on the surface, N.
    pub fn load(&self) -> T {
        self.load.value
    }

    /// Returns the magnitude of the friction force, N; at rest the static friction limit.
    pub fn friction(&self) -> T {
        self.resistance.force(self.load.value)
    }

    /// Updates the sliding velocity, the direction of sliding and the friction law from the motion
    /// of the bodies. The interface is at rest if its sliding speed is at most `rest_speed`, m/s.
    /// `held` contains the components of the static friction of an interface at rest, as fractions
    /// of the static friction limit.
    pub(crate) fn update_slip(
        &mut self,
        topology: &Topology,
        interface: &InterfaceParameters<T>,
        pitch: T,
        bodies: &Bodies<T>,
        rest_speed: T,
        held: [T; 3],
    ) {
        let dofs = interface.shape.dofs().len();
        let arms = interface.arms(pitch);
        let surface = bodies.surface_velocity(topology, interface, pitch);
        let mut squared = T::zero();
        for &velocity in &surface[..dofs] {
            squared += velocity * velocity;
        }
        let speed = squared.norm_of_square();
        self.velocity = if dofs == 1 { surface[0] } else { speed };
        self.sliding = (speed - rest_speed).if_positive(T::one(), T::zero());
        let over = speed.if_positive(speed, T::one()).recip();
        let mut sense = T::zero();
        for (i, against) in self.against.iter_mut().enumerate() {
            let direction = surface[i] * over * self.sliding + held[i] * (T::one() - self.sliding);
            *against = -(direction * arms[i]);
            if i == 0 {
                sense = direction;
            }
        }
        self.sense = sense;
        let law = &interface.law;
        if law.is_constant() && interface.backward.is_none() {
            self.resistance = Resistance::coulomb_viscous(law.mu, law.viscous, speed);
        } else {
            self.evaluate_law(interface, speed);
        }
    }

    /// Evaluates a friction law that depends on the speed or direction of sliding, or that differs
    /// at rest. `speed` is the sliding speed, m/s. Not inlined, because generic code for dual
    /// numbers would become large.
    fn evaluate_law(&mut self, interface: &InterfaceParameters<T>, speed: T) {
        let (sliding, sense) = (self.sliding, self.sense);
        let of = |law: &Law<T>| {
            let Resistance { coefficient, constant } = law.sliding(speed);
            let coefficient = sliding.if_positive(coefficient, law.at_rest());
            Resistance { coefficient, constant }
        };
        let forward = of(&interface.law);
        self.resistance = forward;
        if let Some(law) = &interface.backward {
            let backward = of(law);
            // At rest without static friction, slip may begin in either sense, so the limit is the
            // greater coefficient.
            let greater = backward.coefficient - forward.coefficient;
            let pick = |backward: T, forward: T| {
                let open = greater.if_positive(backward, forward);
                sense.if_positive(forward, (-sense).if_positive(backward, open))
            };
            self.resistance.coefficient = pick(backward.coefficient, forward.coefficient);
            self.resistance.constant = pick(backward.constant, forward.constant);
        }
    }

    /// Returns the state for the opposite motion. The normal force remains that of the present
    /// motion.
    pub(crate) fn reversed(&self, interface: &InterfaceParameters<T>) -> Self {
        let mut reversed =
            Self { against: self.against.map(|against| -against), sense: -self.sense, ..*self };
        if !(interface.law.is_constant() && interface.backward.is_none()) {
            reversed.evaluate_law(interface, self.velocity.abs());
        }
        reversed
    }

    /// Updates the normal force from the complete wrench of the joint. If the normal force depends
    /// on the friction of the interface itself, the present friction is used.
    pub(crate) fn update_normal_forces(
        &mut self,
        interface: &InterfaceParameters<T>,
        pitch: T,
        bodies: &Bodies<T>,
        wrench: Wrench<T>,
    ) {
        self.update_normal_force_with(interface, pitch, bodies, wrench, self.own_friction());
    }

    /// Returns the friction of the interface itself, on which the normal force of a thread depends.
    pub(crate) fn own_friction(&self) -> OwnFriction<T> {
        let Resistance { coefficient, constant } = self.resistance;
        OwnFriction { coefficient, constant, direction: self.sense }
    }

    /// Updates the normal force from the complete wrench of the joint and the given friction force
    /// of the interface.
    pub(crate) fn update_normal_force_with(
        &mut self,
        interface: &InterfaceParameters<T>,
        pitch: T,
        bodies: &Bodies<T>,
        wrench: Wrench<T>,
        own: OwnFriction<T>,
    ) {
        self.load = normal_load(&interface.load, interface, pitch, bodies, wrench, own);
    }

    /// Returns the coefficient and the constant part, N, of the friction force at the present
    /// speed: `friction = coefficient * load + constant`.
    pub fn resistance(&self) -> (T, T) {
        (self.resistance.coefficient, self.resistance.constant)
    }

    /// Computes the normal force for the complete wrench of the joint, in any frame. `j` and `k`
    /// are the joint frames J and K relative to this frame; `wrench` is about the origin of this
    /// frame, in its axes.
    pub fn load_in(
        &self,
        interface: &InterfaceParameters<T>,
        pitch: T,
        j: &Pose<T>,
        k: &Pose<T>,
        wrench: Wrench<T>,
    ) -> Load<T> {
        let own = self.own_friction();
        let surface = (interface.shape, interface.radius);
        normal_load_between(&interface.load, surface, pitch, (j, k), wrench, own)
    }

    /// Returns the constant and the slope of the linearised friction force, `friction = constant +
    /// slope.power(wrench)`, linearised at the last update of the normal force.
    pub(crate) fn linear(&self, coupling: Coupling, wrench: Wrench<T>) -> (T, Twist<T>) {
        let coefficient = self.resistance.coefficient;
        match coupling {
            Coupling::None => (T::zero(), Twist::zero()),
            Coupling::Frozen => (self.friction(), Twist::zero()),
            Coupling::Linear => {
                // At the solution, `wrench` equals the wrench of the last update.
                let gradient = self.load.gradient.held();
                let base = self.load.value - gradient.power(wrench);
                (self.resistance.force(base), gradient * coefficient)
            }
        }
    }
}

/// Form of the friction forces in the linear equations of the balance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coupling {
    /// No friction.
    None,
    /// Constant friction forces at their present values.
    Frozen,
    /// Friction linearised in the reactions.
    Linear,
}

/// States of all friction interfaces of a mechanism.
#[derive(Clone, Debug)]
pub(crate) struct Interfaces<T> {
    pub(crate) states: Vec<InterfaceState<T>>,
    /// Static friction of each interface at rest, as fractions of the static friction limit along
    /// the DOFs of the interface; zero by default.
    pub(crate) held: Vec<[T; 3]>,
}

impl<T: Scalar> Interfaces<T> {
    pub(crate) fn new(count: usize) -> Self {
        Self { states: vec![InterfaceState::new(); count], held: vec![[T::zero(); 3]; count] }
    }

    pub(crate) fn update_slip(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        rest_speed: T,
    ) {
        for ((state, interface), held) in
            self.states.iter_mut().zip(&parameters.interfaces).zip(&self.held)
        {
            let pitch = parameters.pitch[interface.joint];
            state.update_slip(topology, interface, pitch, bodies, rest_speed, *held);
        }
    }

    /// Updates all normal forces from frictionless joint wrenches.
    pub(crate) fn update_frictionless_normal_forces(
        &mut self,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        wrenches: &[Wrench<T>],
    ) {
        for (state, interface) in self.states.iter_mut().zip(&parameters.interfaces) {
            let pitch = parameters.pitch[interface.joint];
            let wrench = wrenches[interface.joint];
            state.update_normal_force_with(interface, pitch, bodies, wrench, OwnFriction::none());
        }
    }

    /// Updates all normal forces from the joint wrenches. Returns the largest change of a normal
    /// force and the largest normal force, N.
    pub(crate) fn update_normal_forces(
        &mut self,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        wrenches: &[Wrench<T>],
    ) -> (T, T) {
        let (mut change, mut largest) = (T::zero(), T::zero());
        for (state, interface) in self.states.iter_mut().zip(&parameters.interfaces) {
            let before = state.load.value;
            let pitch = parameters.pitch[interface.joint];
            state.update_normal_forces(interface, pitch, bodies, wrenches[interface.joint]);
            let now = state.load.value;
            let moved = (now - before).abs();
            // Comparisons ignore NaN, sums propagate it.
            change = (moved - change).if_positive(moved, change) + now * T::zero();
            largest = (now - largest).if_positive(now, largest) + now * T::zero();
        }
        (change, largest)
    }
}

impl Interfaces<f64> {
    /// Computes, for each joint, the sum of the wrenches that the present friction forces exert.
    pub(crate) fn friction_at_joints(
        &self,
        topology: &Topology,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        efforts: &mut [Wrench<f64>],
    ) {
        efforts.fill(Wrench::zero());
        for (interface, state) in parameters.interfaces.iter().zip(&self.states) {
            let against = bodies.wrench_of(topology, interface, state.against);
            efforts[interface.joint] += against * state.friction();
        }
    }
}
