//! Sliding contacts during a computation: speeds, loads, and friction made linear in the reactions.
//!
//! Equations (F2), (F4) and (F5) of the book's theory.

use crate::friction::{Law, Load, OwnFriction, Resistance};
use crate::friction_problem::normal_load::{normal_load, normal_load_between};
use crate::kinematics::Bodies;
use crate::parameters::{InterfaceParameters, Parameters};
use crate::scalar::Scalar;
use crate::spatial::{Pose, Twist, Wrench};
use crate::topology::Topology;

/// A contact at one instant.
///
/// The effort of its friction on freedom `f` of its joint is
/// `against[f] * (resistance.constant + resistance.coefficient * load)`.
#[derive(Clone, Copy, Debug)]
pub struct InterfaceState<T> {
    /// Sliding velocity at the surface, m/s; of a ball its magnitude.
    pub velocity: T,
    /// One where the contact slides, zero where it rests.
    pub sliding: T,
    /// For each freedom of the contact, the effort of a friction force of one newton: against the
    /// motion, with the arm of the surface's radius.
    pub(crate) against: [T; 3],
    /// Of a contact with one freedom 1 where it slides forward, -1 backward; at rest the part of its
    /// greatest friction by which it holds, with its sign.
    pub(crate) sense: T,
    pub(crate) resistance: Resistance<T>,
    /// The load with its gradient, at the reaction it was last computed from.
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

    /// The load on the surface, N.
    pub fn load(&self) -> T {
        self.load.value
    }

    /// The magnitude of the friction force, N; of a contact at rest the greatest that it can have.
    pub fn friction(&self) -> T {
        self.resistance.force(self.load.value)
    }

    /// Speeds and directions from the motion of the bodies. A contact that slides no faster than
    /// `rest_speed` rests; its friction then acts along `held`, in units of the greatest it can be.
    pub(crate) fn slide(
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
            self.resist(interface, speed);
        }
    }

    /// What laws say that change with speed, with its sense, or at rest. Not inlined: kernels of
    /// dual numbers grow large.
    fn resist(&mut self, interface: &InterfaceParameters<T>, speed: T) {
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
            // At rest, with nothing held, either may come: the greater is the limit.
            let greater = backward.coefficient - forward.coefficient;
            let pick = |backward: T, forward: T| {
                let open = greater.if_positive(backward, forward);
                sense.if_positive(forward, (-sense).if_positive(backward, open))
            };
            self.resistance.coefficient = pick(backward.coefficient, forward.coefficient);
            self.resistance.constant = pick(backward.constant, forward.constant);
        }
    }

    /// The load under a joint's complete wrench, with the present friction where a load contains it.
    pub(crate) fn press(
        &mut self,
        interface: &InterfaceParameters<T>,
        pitch: T,
        bodies: &Bodies<T>,
        wrench: Wrench<T>,
    ) {
        self.press_with(interface, pitch, bodies, wrench, self.own_friction());
    }

    /// Its friction, as the normal load of a thread contains it.
    pub(crate) fn own_friction(&self) -> OwnFriction<T> {
        let Resistance { coefficient, constant } = self.resistance;
        OwnFriction { coefficient, constant, direction: self.sense }
    }

    /// The load under a joint's complete wrench, and with this friction of its own where it contains
    /// that.
    pub(crate) fn press_with(
        &mut self,
        interface: &InterfaceParameters<T>,
        pitch: T,
        bodies: &Bodies<T>,
        wrench: Wrench<T>,
        own: OwnFriction<T>,
    ) {
        self.load = normal_load(&interface.load, interface, pitch, bodies, wrench, own);
    }

    /// The coefficient and the constant part of the friction force at this speed:
    /// `friction = coefficient * load + constant`.
    pub fn resistance(&self) -> (T, T) {
        (self.resistance.coefficient, self.resistance.constant)
    }

    /// The load under a joint's complete wrench, seen from any frame: `j` and `k` are the joint's
    /// frames and `wrench` is about that frame's origin in its axes.
    pub fn load_in(
        &self,
        interface: &InterfaceParameters<T>,
        pitch: T,
        j: &Pose<T>,
        k: &Pose<T>,
        wrench: Wrench<T>,
    ) -> Load<T> {
        let own = self.own_friction();
        normal_load_between(&interface.load, interface, pitch, j, k, wrench, own)
    }

    /// The part of the friction force that does not change with the reaction, in the linear form of
    /// [`Self::press`]'s last call: `friction = constant + slope.power(wrench)`.
    pub(crate) fn linear(&self, coupling: Coupling, wrench: Wrench<T>) -> (T, Twist<T>) {
        let coefficient = self.resistance.coefficient;
        match coupling {
            Coupling::None => (T::zero(), Twist::zero()),
            Coupling::Frozen => (self.friction(), Twist::zero()),
            Coupling::Linear => {
                // At the solution the wrench is the one that the load was computed from.
                let gradient = self.load.gradient.held();
                let base = self.load.value - gradient.power(wrench);
                (self.resistance.force(base), gradient * coefficient)
            }
        }
    }
}

/// How friction enters the linear system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coupling {
    /// Not at all.
    None,
    /// As it is now.
    Frozen,
    /// With its change by the reactions.
    Linear,
}

/// All contacts, and which are at which joint.
#[derive(Clone, Debug)]
pub(crate) struct Interfaces<T> {
    pub(crate) states: Vec<InterfaceState<T>>,
    /// For each contact the direction in which it holds while it rests; zero by default.
    pub(crate) held: Vec<[T; 3]>,
}

impl<T: Scalar> Interfaces<T> {
    pub(crate) fn new(count: usize) -> Self {
        Self { states: vec![InterfaceState::new(); count], held: vec![[T::zero(); 3]; count] }
    }

    pub(crate) fn slide(
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
            state.slide(topology, interface, pitch, bodies, rest_speed, *held);
        }
    }

    /// The loads under wrenches that no friction has a part in.
    pub(crate) fn press_frictionless(
        &mut self,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        wrenches: &[Wrench<T>],
    ) {
        for (state, interface) in self.states.iter_mut().zip(&parameters.interfaces) {
            let pitch = parameters.pitch[interface.joint];
            let wrench = wrenches[interface.joint];
            state.press_with(interface, pitch, bodies, wrench, OwnFriction::none());
        }
    }

    /// Updates all loads to the joints' wrenches; returns the largest change and the largest load.
    pub(crate) fn press(
        &mut self,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        wrenches: &[Wrench<T>],
    ) -> (T, T) {
        let (mut change, mut largest) = (T::zero(), T::zero());
        for (state, interface) in self.states.iter_mut().zip(&parameters.interfaces) {
            let before = state.load.value;
            let pitch = parameters.pitch[interface.joint];
            state.press(interface, pitch, bodies, wrenches[interface.joint]);
            let now = state.load.value;
            let moved = (now - before).abs();
            // Comparisons pass over NaN, sums do not.
            change = (moved - change).if_positive(moved, change) + now * T::zero();
            largest = (now - largest).if_positive(now, largest) + now * T::zero();
        }
        (change, largest)
    }
}

impl Interfaces<f64> {
    /// The efforts of all present frictions, joint by joint.
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
