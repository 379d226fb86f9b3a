//! Inverse dynamics for any scalar type: reactions, load-dependent friction and efforts.

mod probing;
mod settled;

pub(super) use settled::BALANCED;

use super::balance::Balance;
use super::interfaces::{Coupling, InterfaceState, Interfaces};
use super::model::Model;
use super::settings::{FrictionMode, Settings};
use crate::kinematics::{Bodies, Kinematics, Results};
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::spatial::{Vec3, Wrench};
use crate::statics::AppliedLoad;
use crate::topology::{Role, Topology};

/// Forces of a mechanism at one instant, and the buffers for computing them.
#[derive(Clone, Debug)]
pub struct Inverse<T> {
    balance: Balance<T>,
    interfaces: Interfaces<T>,
    efforts: Vec<T>,
    efforts_frictionless: Vec<T>,
    /// Accelerations of the spanning tree per unit acceleration of each local degree of freedom.
    spin_responses: Vec<Vec<T>>,
    friction_efforts: Vec<T>,
    friction_change: T,
    sign_without: T,
    sign_with: T,
    mode: FrictionMode,
}

impl<T: Scalar> Inverse<T> {
    /// Allocates results and buffers for a compiled model. All results are zero.
    pub(super) fn new(model: &Model) -> Self {
        let topology = model.topology();
        let actuators = topology.actuators.len();
        let spins = model.constraints().spins().len();
        Self {
            balance: Balance::new(&model.balance),
            interfaces: Interfaces::new(model.parameters.interfaces.len()),
            efforts: vec![T::zero(); actuators],
            efforts_frictionless: vec![T::zero(); actuators],
            spin_responses: vec![vec![T::zero(); topology.dofs()]; spins],
            friction_efforts: vec![T::zero(); topology.dofs()],
            friction_change: T::zero(),
            sign_without: T::one(),
            sign_with: T::one(),
            mode: FrictionMode::Off,
        }
    }

    /// Returns the effort of each actuator, N or N m, in the order of
    /// [`Mechanism::actuators`](crate::mechanism::Mechanism::actuators).
    pub fn efforts(&self) -> &[T] {
        &self.efforts
    }

    /// Returns the effort of each actuator without friction, N or N m, in the order of
    /// [`Self::efforts`].
    pub fn efforts_frictionless(&self) -> &[T] {
        &self.efforts_frictionless
    }

    /// Returns the complete wrench of each joint, exerted by the predecessor on the successor,
    /// about the reference point in world axes. The wrench includes constraint, actuator and
    /// friction forces.
    pub fn joint_wrenches(&self) -> &[Wrench<T>] {
        &self.balance.joint_wrenches
    }

    /// Returns the force of a joint, N, and the moment of the joint about the origin of frame J, N
    /// m, exerted by the predecessor on the successor, in world axes.
    pub fn reaction(&self, bodies: &Bodies<T>, joint: usize) -> (Vec3<T>, Vec3<T>) {
        let wrench = self.balance.joint_wrenches[joint];
        (wrench.force, wrench.moment_about(bodies.frame_j[joint].position))
    }

    /// Returns the states of the friction interfaces, in the order of [`Parameters::interfaces`].
    pub fn interfaces(&self) -> &[InterfaceState<T>] {
        &self.interfaces.states
    }

    /// Sets the static friction of an interface at rest, as a fraction of the static friction
    /// limit. `held` contains the components along the DOFs of the interface; its norm must not
    /// exceed one. The default is zero.
    pub fn set_static_friction(&mut self, interface: usize, held: [T; 3]) {
        self.interfaces.held[interface] = held;
    }

    /// Returns true if the forces include friction.
    pub fn has_friction(&self) -> bool {
        self.mode != FrictionMode::Off && !self.interfaces.states.is_empty()
    }

    /// Returns the largest change of a normal force, N, in the last Newton step of the iteration
    /// between friction and reactions.
    pub fn friction_change(&self) -> T {
        self.friction_change
    }

    /// Solves for all forces for the motion in `kinematics`.
    ///
    /// Also computes the accelerations of local degrees of freedom and adds them to the
    /// accelerations of the bodies.
    pub fn solve(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        kinematics: &mut Kinematics<T>,
        loads: &[AppliedLoad<T>],
        settings: &Settings,
    ) {
        self.begin(model, parameters, kinematics, loads, settings);
        self.complete(model, parameters, kinematics, settings);
    }

    /// Solves for all forces with friction after [`Self::begin`], starting from the present normal
    /// forces.
    pub(super) fn complete(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        kinematics: &mut Kinematics<T>,
        settings: &Settings,
    ) {
        match settings.friction {
            FrictionMode::Off => {}
            FrictionMode::OnePass => {
                self.couple(model, parameters, &kinematics.bodies, Coupling::Frozen);
                self.finish_friction(model, parameters, &kinematics.bodies);
            }
            FrictionMode::Converged => {
                for _ in 0..settings.friction_steps {
                    let (change, largest) = self.step(model, parameters, &kinematics.bodies);
                    if settings.is_settled(change.largest(), largest.largest()) {
                        break;
                    }
                }
                self.finish_friction(model, parameters, &kinematics.bodies);
            }
        }
        self.spin_up(model, kinematics);
    }

    /// Solves without friction, then computes the sliding velocities and normal forces of all
    /// interfaces.
    pub(super) fn begin(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        kinematics: &mut Kinematics<T>,
        loads: &[AppliedLoad<T>],
        settings: &Settings,
    ) {
        self.mode = settings.friction;
        self.balance.load(&model.balance, parameters, &kinematics.bodies, loads);
        for spin in 0..self.spin_responses.len() {
            let response = &mut self.spin_responses[spin];
            kinematics.response_to_spin(&model.kinematic, spin, response);
            let bodies = &kinematics.bodies;
            self.balance.load_spin(&model.balance, parameters, bodies, spin, response);
        }
        let bodies = &kinematics.bodies;
        self.sign_without = self.couple(model, parameters, bodies, Coupling::None);
        self.sign_with = self.sign_without;
        self.friction_efforts.fill(T::zero());
        let topology = model.topology();
        self.read_efforts(model, parameters, bodies);
        self.efforts_frictionless.copy_from_slice(&self.efforts);
        let rest_speed = T::from_f64(settings.rest_speed);
        self.interfaces.update_slip(topology, parameters, bodies, rest_speed);
        self.interfaces.update_frictionless_normal_forces(
            parameters,
            bodies,
            &self.balance.joint_wrenches,
        );
        self.friction_change = T::zero();
    }

    /// Calls `put` with the numbers of the solution without friction.
    pub(super) fn write_frictionless(&self, mut put: impl FnMut(&[T])) {
        self.balance.write_wrenches(&mut put);
        put(&self.efforts_frictionless);
    }

    /// Takes one Newton step of the iteration between friction and reactions. Returns the largest
    /// change of a normal force and the largest normal force, N.
    pub(super) fn step(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) -> (T, T) {
        self.sign_with = self.couple(model, parameters, bodies, Coupling::Linear);
        let (change, largest) =
            self.interfaces.update_normal_forces(parameters, bodies, &self.balance.joint_wrenches);
        self.friction_change = change;
        (change, largest)
    }

    /// Returns the unknowns that determine all joint wrenches for this motion: the wrenches of the
    /// cut joints, exerted by the predecessor on the successor, and the accelerations of local
    /// degrees of freedom.
    pub fn carried(&self, model: &Model) -> (Vec<Wrench<T>>, Vec<T>) {
        self.balance.carried(&model.balance.structure)
    }

    /// Takes one Newton step with friction linearised about the given unknowns, see
    /// [`Self::carried`]. Updates [`Self::efforts`], [`Self::joint_wrenches`] and the normal
    /// forces. Requires a previous [`Self::solve`] for this motion, in any friction mode.
    pub fn step_from(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        (cuts, spins): (&[Wrench<T>], &[T]),
    ) {
        self.balance.carry(&model.balance, cuts, spins);
        self.interfaces.update_normal_forces(parameters, bodies, &self.balance.joint_wrenches);
        self.step(model, parameters, bodies);
        self.finish_friction(model, parameters, bodies);
    }

    /// Takes one Newton step with friction linearised about the given joint wrenches, which the
    /// predecessors exert on the successors, about the reference point. Wrenches of joints without
    /// friction have no influence.
    pub fn step_at(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        wrenches: &[Wrench<T>],
    ) {
        self.restart_from(parameters, bodies, wrenches);
        self.step(model, parameters, bodies);
        self.finish_friction(model, parameters, bodies);
    }

    /// Returns the reciprocal pivots of the last factorisation of the balance, in elimination
    /// order.
    pub fn reciprocal_pivots(&self, model: &Model) -> Vec<T> {
        self.balance.reciprocal_pivots(&model.balance.program)
    }

    /// Solves the balance with friction in the form that `coupling` specifies. Returns the sign of
    /// the determinant.
    fn couple(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        coupling: Coupling,
    ) -> T {
        let plan = &*model.balance;
        self.balance.apply_friction(plan, parameters, bodies, &self.interfaces, coupling);
        self.balance.solve(plan, parameters, bodies)
    }

    /// Computes the actuator efforts, including the friction forces for the present normal forces.
    pub(super) fn finish_friction(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) {
        self.add_friction_efforts(model.topology(), parameters);
        self.read_efforts(model, parameters, bodies);
    }

    /// Computes the generalised friction forces on the DOFs of the spanning tree.
    fn add_friction_efforts(&mut self, topology: &Topology, parameters: &Parameters<T>) {
        self.friction_efforts.fill(T::zero());
        for (interface, state) in parameters.interfaces.iter().zip(&self.interfaces.states) {
            let Role::Tree { node } = topology.role[interface.joint] else { continue };
            let first = topology.nodes[node].tree_dofs.start;
            for (&against, dof) in state.against.iter().zip(interface.shape.dofs()) {
                self.friction_efforts[first + dof] += against * state.friction();
            }
        }
    }

    fn read_efforts(&mut self, model: &Model, parameters: &Parameters<T>, bodies: &Bodies<T>) {
        let (plan, frictions) = (&*model.balance, &self.friction_efforts);
        self.balance.read_efforts(plan, parameters, bodies, frictions, &mut self.efforts);
    }

    /// Returns the effort of each gearing, N m; N if the gearing sums lengths. The order is that of
    /// the gearings of the mechanism.
    pub fn gearing_efforts<'a>(
        &'a self,
        model: &'a Model,
        parameters: &'a Parameters<T>,
    ) -> impl Iterator<Item = T> + 'a {
        let first = model.balance.structure.first_gearing();
        let each = self.balance.unknowns[first..].iter().zip(&parameters.gearings);
        each.map(|(multiplier, gearing)| *multiplier * T::from_f64(gearing.size.recip()))
    }

    /// Returns the last solution of the balance.
    pub(super) fn balance(&self) -> &Balance<T> {
        &self.balance
    }

    /// Adds the accelerations of local degrees of freedom to the accelerations of the bodies.
    pub(super) fn spin_up(&self, model: &Model, kinematics: &mut Kinematics<T>) {
        let first = model.balance.structure.wrench_columns;
        for (spin, response) in self.spin_responses.iter().enumerate() {
            let amount = self.balance.unknowns[first + spin];
            // A value that is not finite would propagate into the motion of the bodies.
            let finite = T::one() + amount * T::zero();
            let amount = finite.if_positive(amount, T::zero());
            kinematics.bodies.accelerate_more(model.topology(), response, amount);
        }
    }
}

impl Inverse<f64> {
    /// Returns the smallest magnitude of the pivots of the last factorisation of the balance; their
    /// units are powers of the metre.
    pub(super) fn smallest_pivot(&self, model: &Model) -> f64 {
        self.balance.smallest_pivot(&model.balance.program)
    }

    /// Reads the solution without friction that [`Self::write_frictionless`] puts from the results
    /// of a program, and computes the sliding velocities. The matrix of the balance is not
    /// computed.
    pub(super) fn begin_by_program(
        &mut self,
        model: &Model,
        (parameters, bodies): (&Parameters<f64>, &Bodies<f64>),
        settings: &Settings,
        numbers: &mut Results<'_>,
    ) {
        self.mode = settings.friction;
        self.balance.read_wrenches(bodies, numbers);
        numbers.fill(&mut self.efforts_frictionless);
        self.efforts.copy_from_slice(&self.efforts_frictionless);
        (self.sign_without, self.sign_with) = (1.0, 1.0);
        self.friction_change = 0.0;
        self.friction_efforts.fill(0.0);
        self.interfaces.update_slip(model.topology(), parameters, bodies, settings.rest_speed);
    }
}
