//! Which friction causes how much of each driving force.
//!
//! With the friction forces as they were found, the balance is linear in them: each drive is the
//! frictionless one and a sum over contacts. A contact's part is the drive's response to the
//! friction at that contact alone, with nothing else to be carried. Where efforts are unique it is
//! also given by virtual work: friction times the contact's sliding velocity in the motion of one
//! unit of rate of that actuator while all others stand still.
//!
//! What friction a contact has depends on the others', through the reactions; how much of a drive it
//! causes, once it is there, does not.
//!
//! Equation (E2) of the book's theory.

use super::balance::Balance;
use super::interfaces::InterfaceState;
use super::inverse::Inverse;
use super::model::Model;
use crate::friction::Resistance;
use crate::kinematics::Bodies;
use crate::parameters::{InterfaceParameters, Parameters};
use crate::scalar::Scalar;
use crate::spatial::Wrench;

/// The part of each drive that the friction at each contact causes, N or N m. For each drive they
/// add up to the difference that friction makes. Contacts at rest have none.
#[derive(Clone, Debug, PartialEq)]
pub struct Shares<T> {
    actuators: usize,
    interfaces: usize,
    /// All actuators for the first contact, then for the next.
    values: Vec<T>,
}

impl<T: Scalar> Shares<T> {
    /// No friction at all.
    pub fn new(actuators: usize, interfaces: usize) -> Self {
        Self { actuators, interfaces, values: vec![T::zero(); actuators * interfaces] }
    }

    /// The part of drive `actuator` that contact `interface` causes. Efforts are in the order of
    /// [`crate::mechanism::Mechanism::actuators`], contacts in that of [`Parameters::interfaces`].
    pub fn of(&self, actuator: usize, interface: usize) -> T {
        self.values[interface * self.actuators + actuator]
    }

    /// The parts of one drive, contact by contact.
    pub fn of_actuator(&self, actuator: usize) -> impl ExactSizeIterator<Item = T> + '_ {
        (0..self.interfaces).map(move |interface| self.of(actuator, interface))
    }

    /// Sets what one contact causes.
    pub(super) fn set_interface(&mut self, interface: usize, efforts: &[T]) {
        self.row(interface).copy_from_slice(efforts);
    }

    fn row(&mut self, interface: usize) -> &mut [T] {
        &mut self.values[interface * self.actuators..][..self.actuators]
    }
}

/// What one newton of friction at a contact does to a mechanism's forces, everything else as it is.
#[derive(Clone, Debug)]
pub struct Response<T> {
    /// The change of each joint's complete wrench, predecessor on successor, about the kernel origin.
    pub wrenches: Vec<Wrench<T>>,
    /// The change of each drive.
    pub efforts: Vec<T>,
}

/// Room to find [`Shares`] in, made once. One factorisation serves all contacts.
#[derive(Clone, Debug)]
pub struct Sharing<T> {
    balance: Balance<T>,
}

impl<T: Scalar> Sharing<T> {
    /// Room for a mechanism.
    pub fn new(model: &Model) -> Self {
        Self { balance: Balance::new(&model.balance) }
    }

    /// The [`Response`] to each contact, at the motion in `bodies` and with the speeds that `inverse`
    /// has found. The forces of the mechanism are the frictionless ones and the sum over all contacts
    /// of friction force times response.
    pub fn responses(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        inverse: &Inverse<T>,
    ) -> Vec<Response<T>> {
        self.balance.rest_like(inverse.balance(), &model.balance, parameters, bodies);
        let of = |(interface, state): (&InterfaceParameters<T>, &InterfaceState<T>)| {
            let resistance = Resistance { coefficient: T::zero(), constant: T::one() };
            let unit = InterfaceState { resistance, ..*state };
            let mut efforts = vec![T::zero(); inverse.efforts().len()];
            self.balance.apply_friction_alone(
                &model.balance,
                parameters,
                bodies,
                interface,
                &unit,
                &mut efforts,
            );
            Response { wrenches: self.balance.joint_wrenches.clone(), efforts }
        };
        parameters.interfaces.iter().zip(inverse.interfaces()).map(of).collect()
    }

    /// Finds the shares of the frictions that `inverse` found last, at the motion in `bodies`.
    /// What is redundant is chosen by the same weighting, so shares add up there, too.
    pub fn run(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        inverse: &Inverse<T>,
        shares: &mut Shares<T>,
    ) {
        if !inverse.has_friction() {
            shares.values.fill(T::zero());
            return;
        }
        self.balance.rest_like(inverse.balance(), &model.balance, parameters, bodies);
        let interfaces = parameters.interfaces.iter().zip(inverse.interfaces()).enumerate();
        for (index, (interface, state)) in interfaces {
            let efforts = shares.row(index);
            self.balance.apply_friction_alone(
                &model.balance,
                parameters,
                bodies,
                interface,
                state,
                efforts,
            );
        }
    }
}
