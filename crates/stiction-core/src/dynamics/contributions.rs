//! Friction contributions: the part of each effort that is due to the friction of each interface.
//!
//! For fixed friction forces the balance is linear in these forces: each effort is the frictionless
//! effort plus a sum over interfaces. The contribution of an interface is the effort due to the
//! friction of this interface alone, without any other load. If the efforts are unique, virtual
//! work yields the same result: the contribution to an effort equals friction force times sliding
//! velocity, in the motion in which this actuator has unit rate and all other actuators are at
//! rest.
//!
//! The friction force of an interface depends on the other interfaces through the reactions. The
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

/// Contribution of the friction of each interface to each effort, N or N m. The contributions to an
/// effort add up to the difference between the efforts with and without friction. Interfaces at
/// rest contribute nothing.
#[derive(Debug)]
pub struct Contributions<T> {
    actuators: usize,
    interfaces: usize,
    /// Contributions to the efforts of all actuators for the first interface, then for the second,
    /// and so on. Empty if all contributions are zero, because their number is quadratic.
    values: Vec<T>,
}

impl<T: Scalar + PartialEq> PartialEq for Contributions<T> {
    fn eq(&self, other: &Self) -> bool {
        let mut drives = 0..self.actuators;
        (self.actuators, self.interfaces) == (other.actuators, other.interfaces)
            && drives.all(|drive| self.of_actuator(drive).eq(other.of_actuator(drive)))
    }
}

impl<T: Clone> Clone for Contributions<T> {
    fn clone(&self) -> Self {
        let mut values = Vec::with_capacity(self.actuators * self.interfaces);
        values.extend_from_slice(&self.values);
        Self { values, ..*self }
    }

    /// Copies `other` into the existing buffer, so that results of many samples do not allocate.
    fn clone_from(&mut self, other: &Self) {
        let Self { actuators, interfaces, values } = other;
        (self.actuators, self.interfaces) = (*actuators, *interfaces);
        self.values.clone_from(values);
    }
}

impl<T: Scalar> Contributions<T> {
    /// Creates contributions that are all zero, as for a frictionless mechanism.
    pub fn new(actuators: usize, interfaces: usize) -> Self {
        // Kernels allocate no memory. Memory that is not written costs nothing.
        Self { actuators, interfaces, values: Vec::with_capacity(actuators * interfaces) }
    }

    /// Returns the contribution of friction interface `interface` to the effort of actuator
    /// `actuator`, N or N m. Indices are in the orders of [`Parameters::interfaces`] and
    /// [`Mechanism::actuators`](crate::mechanism::Mechanism::actuators).
    pub fn of(&self, actuator: usize, interface: usize) -> T {
        match self.values.as_slice() {
            [] => T::zero(),
            values => values[interface * self.actuators + actuator],
        }
    }

    /// Returns the contribution of each interface to the effort of one actuator, N or N m.
    pub fn of_actuator(&self, actuator: usize) -> impl ExactSizeIterator<Item = T> + '_ {
        (0..self.interfaces).map(move |interface| self.of(actuator, interface))
    }

    /// Sets all contributions to zero.
    pub(super) fn clear(&mut self) {
        self.values.clear();
    }

    /// Sets the contributions of one interface to the efforts of all actuators, N or N m.
    pub(super) fn set_interface(&mut self, interface: usize, efforts: &[T]) {
        self.row(interface).copy_from_slice(efforts);
    }

    pub(super) fn row(&mut self, interface: usize) -> &mut [T] {
        if self.values.is_empty() {
            self.values.resize(self.actuators * self.interfaces, T::zero());
        }
        &mut self.values[interface * self.actuators..][..self.actuators]
    }
}

/// Changes of joint wrenches and actuator efforts per newton of friction at one interface.
#[derive(Clone, Debug)]
pub struct Response<T> {
    /// Change of the complete wrench of each joint, exerted by the predecessor on the successor,
    /// about the reference point.
    pub wrenches: Vec<Wrench<T>>,
    /// Change of the effort of each actuator.
    pub efforts: Vec<T>,
}

/// Buffers for computing [`Contributions`], allocated once. A single factorisation is used for all
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

    /// Computes the [`Response`] to one newton of friction at each interface, for the motion in
    /// `bodies` and the sliding directions in `inverse`. All forces are the frictionless forces
    /// plus the sum over interfaces of friction force times response.
    pub fn responses(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        inverse: &Inverse<T>,
    ) -> Vec<Response<T>> {
        self.responses_in(model.balance.passes(), model, parameters, bodies, inverse)
    }

    /// Computes the responses like [`Self::responses`], with `passes` solves for each interface:
    /// one without iterative refinement.
    pub(super) fn responses_in(
        &mut self,
        passes: usize,
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
                (passes, &mut efforts),
            );
            Response { wrenches: self.balance.joint_wrenches.clone(), efforts }
        };
        parameters.interfaces.iter().zip(inverse.interfaces()).map(of).collect()
    }

    /// Computes the contributions of the friction forces in `inverse`, for the motion in `bodies`.
    /// Statically indeterminate forces are selected by the same weighting as in the inverse
    /// dynamics, so their contributions add up as well.
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
                (model.balance.passes(), efforts),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Contributions;

    /// Contributions that are all zero are equal, stored or not, and a stored row leaves the others
    /// zero.
    #[test]
    fn contributions_are_zero_unless_stored() {
        let zero = Contributions::<f64>::new(2, 3);
        let mut found = Contributions::new(2, 3);
        found.row(1).copy_from_slice(&[1.0, 2.0]);
        assert_ne!(found, zero);
        assert!(found.of_actuator(1).eq([0.0, 2.0, 0.0]));
        found.row(1).fill(0.0);
        assert_eq!(found, zero);
        found.set_interface(2, &[3.0, 4.0]);
        found.clear();
        assert_eq!((found.of(0, 2), found.clone()), (0.0, zero));
    }
}
