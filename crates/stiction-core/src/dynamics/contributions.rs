//! Friction contributions: the part of each effort that the friction of each interface causes.
//!
//! With the friction forces held constant, the balance is linear in them: each effort is the
//! frictionless effort plus a sum over interfaces. The contribution of an interface is the response
//! of the effort to the friction of that interface, without any other load. For unique efforts,
//! virtual work yields the same result: friction times sliding velocity in the motion with unit
//! rate of that actuator while all other actuators are at rest.
//!
//! The friction force of an interface depends on the other interfaces through the reactions; the
//! contribution of a given friction force does not.
//!
//! Equation (E2) of the book's theory.

use super::balance::Balance;
use super::interfaces::InterfaceState;
use super::inverse::Inverse;
use super::model::Model;
use crate::kinematics::Bodies;
use crate::parameters::{InterfaceParameters, Parameters};
use crate::scalar::Scalar;
use crate::spatial::Wrench;

/// Contribution of the friction at each interface to each effort, N or N m. The contributions to an
/// effort add up to the difference between the efforts with and without friction. Interfaces at
/// rest contribute nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Contributions<T> {
    actuators: usize,
    interfaces: usize,
    /// Contributions to the efforts of all actuators, interface by interface.
    values: Vec<T>,
}

impl<T: Scalar> Contributions<T> {
    /// Creates the contributions of a frictionless mechanism, all zero.
    pub fn new(actuators: usize, interfaces: usize) -> Self {
        Self { actuators, interfaces, values: vec![T::zero(); actuators * interfaces] }
    }

    /// Contribution of friction interface `interface` to the effort of actuator `actuator`, in the
    /// orders of [`Mechanism::actuators`](crate::mechanism::Mechanism::actuators) and
    /// [`Parameters::interfaces`].
    pub fn of(&self, actuator: usize, interface: usize) -> T {
        self.values[interface * self.actuators + actuator]
    }

    /// Contributions to the effort of one actuator, interface by interface.
    pub fn of_actuator(&self, actuator: usize) -> impl ExactSizeIterator<Item = T> + '_ {
        (0..self.interfaces).map(move |interface| self.of(actuator, interface))
    }

    /// Sets all contributions to zero.
    pub(super) fn clear(&mut self) {
        self.values.fill(T::zero());
    }

    /// Sets the contributions of one interface to the effort of each actuator.
    pub(super) fn set_interface(&mut self, interface: usize, efforts: &[T]) {
        self.row(interface).copy_from_slice(efforts);
    }

    pub(super) fn row(&mut self, interface: usize) -> &mut [T] {
        &mut self.values[interface * self.actuators..][..self.actuators]
    }
}

/// Changes of all forces per newton of friction at one interface.
#[derive(Clone, Debug)]
pub struct Response<T> {
    /// Change of the complete wrench at each joint, predecessor on successor, about the reference
    /// point.
    pub wrenches: Vec<Wrench<T>>,
    /// Change of the effort of each actuator.
    pub efforts: Vec<T>,
}

/// Buffers for computing [`Contributions`], allocated once. One factorisation serves all
/// interfaces.
#[derive(Clone, Debug)]
pub struct Sharing<T> {
    balance: Balance<T>,
}

impl<T: Scalar> Sharing<T> {
    /// Allocates buffers for a compiled model.
    pub fn new(model: &Model) -> Self {
        Self { balance: Balance::new(&model.balance) }
    }

    /// Computes the [`Response`] to each friction interface at the motion in `bodies`, with the
    /// sliding directions in `inverse`. All forces are the frictionless forces plus the sum over
    /// interfaces of friction force times response.
    pub fn responses(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        inverse: &Inverse<T>,
    ) -> Vec<Response<T>> {
        self.balance.factor_frictionless(inverse.balance(), &model.balance, parameters, bodies);
        let of = |(interface, state): (&InterfaceParameters<T>, &InterfaceState<T>)| {
            let mut efforts = vec![T::zero(); inverse.efforts().len()];
            self.balance.apply_friction_alone(
                &model.balance,
                parameters,
                bodies,
                interface,
                (state.against, T::one()),
                &mut efforts,
            );
            Response { wrenches: self.balance.joint_wrenches.clone(), efforts }
        };
        parameters.interfaces.iter().zip(inverse.interfaces()).map(of).collect()
    }

    /// Computes the contributions of the friction forces in `inverse` at the motion in `bodies`.
    /// Redundant forces follow the same weighting, so the contributions to them add up as well.
    pub fn run(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        inverse: &Inverse<T>,
        shares: &mut Contributions<T>,
    ) {
        if !inverse.has_friction() {
            shares.clear();
            return;
        }
        self.balance.factor_frictionless(inverse.balance(), &model.balance, parameters, bodies);
        let interfaces = parameters.interfaces.iter().zip(inverse.interfaces()).enumerate();
        for (index, (interface, state)) in interfaces {
            let efforts = shares.row(index);
            self.balance.apply_friction_alone(
                &model.balance,
                parameters,
                bodies,
                interface,
                (state.against, state.friction()),
                efforts,
            );
        }
    }
}
