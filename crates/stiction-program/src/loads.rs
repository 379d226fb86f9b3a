//! Loads of contacts, as they follow from the friction forces of others.
//!
//! Wrenches are affine in friction forces, loads are functions of wrenches, and friction forces are affine in
//! loads. All programs couple friction through these.

use crate::recorded::Recorded;
use stiction_core::dynamics::InterfaceState;
use stiction_core::friction::Load;
use stiction_core::kinematics::Bodies;
use stiction_core::parameters::{InterfaceParameters, Parameters};
use stiction_core::scalar::Scalar;
use stiction_core::spatial::{Mat3, Pose, Vec3, Wrench};

/// All that loads depend on once the frictionless forces are known.
pub(crate) struct Loads<'a> {
    pub(crate) parameters: &'a Parameters<Recorded>,
    pub(crate) bodies: &'a Bodies<Recorded>,
    pub(crate) states: &'a [InterfaceState<Recorded>],
    /// The contacts whose loads are unknown.
    pub(crate) coupled: &'a [usize],
    /// For each contact the wrench of its joint without friction, in the joint's frame J: many a load needs but
    /// two components of that. The load of a ball is the same in all axes.
    pub(crate) without: Vec<Wrench<Recorded>>,
    /// For each contact and each coupled one what one newton of the second's friction adds.
    pub(crate) added: Vec<Vec<Wrench<Recorded>>>,
}

impl Loads<'_> {
    pub(crate) fn interface(
        &self,
        interface: usize,
    ) -> (&InterfaceParameters<Recorded>, &InterfaceState<Recorded>) {
        (&self.parameters.interfaces[interface], &self.states[interface])
    }

    /// How the friction of a contact grows with its load.
    pub(crate) fn coefficient(&self, interface: usize) -> Recorded {
        self.states[interface].resistance().0
    }

    /// The friction force under a load.
    pub(crate) fn force(&self, interface: usize, load: Recorded) -> Recorded {
        let (coefficient, constant) = self.states[interface].resistance();
        coefficient * load + constant
    }

    /// The friction forces of the coupled contacts under these loads.
    pub(crate) fn forces(&self, loads: &[Recorded]) -> Vec<Recorded> {
        self.coupled
            .iter()
            .zip(loads)
            .map(|(interface, load)| self.force(*interface, *load))
            .collect()
    }

    /// The load that a wrench of its joint puts on a contact.
    pub(crate) fn load(&self, interface: usize, wrench: Wrench<Recorded>) -> Load<Recorded> {
        let (parameters, state) = self.interface(interface);
        let joint = parameters.joint;
        let here = Pose { rotation: Mat3::identity(), position: Vec3::zero() };
        let across = self.bodies.frame_j[joint].inverse() * self.bodies.frame_k[joint];
        state.load_in(parameters, self.parameters.pitch[joint], &here, &across, wrench)
    }

    /// The load on any contact under these frictions of the coupled ones.
    pub(crate) fn under(&self, interface: usize, forces: &[Recorded]) -> Load<Recorded> {
        let mut wrench = self.without[interface];
        for (added, force) in self.added[interface].iter().zip(forces) {
            wrench += *added * *force;
        }
        self.load(interface, wrench)
    }

    /// The loads on the coupled contacts under these frictions of theirs.
    pub(crate) fn all_under(&self, forces: &[Recorded]) -> Vec<Load<Recorded>> {
        self.coupled.iter().map(|row| self.under(*row, forces)).collect()
    }

    /// The same without friction.
    pub(crate) fn at_first(&self) -> Vec<Recorded> {
        let none = vec![Recorded::zero(); self.coupled.len()];
        self.all_under(&none).iter().map(|load| load.value).collect()
    }

    /// For each contact and each coupled one how the friction of the second changes the first's load, row by
    /// row.
    pub(crate) fn influences(&self, forces: &[Recorded]) -> Vec<Recorded> {
        let rows = self.added.iter().enumerate();
        let of_row = |(row, added): (usize, &Vec<Wrench<Recorded>>)| {
            let load = self.under(row, forces);
            added.iter().map(|added| load.gradient.power(*added)).collect::<Vec<_>>()
        };
        rows.flat_map(of_row).collect()
    }

    /// What these loads are more than those that follow from them: zero where friction is coupled.
    pub(crate) fn misfits(presses: &[Recorded], found: &[Load<Recorded>]) -> Vec<Recorded> {
        presses.iter().zip(found).map(|(press, load)| *press - load.value).collect()
    }

    /// How misfits change with loads, row by row.
    pub(crate) fn matrix(&self, found: &[Load<Recorded>]) -> Vec<Vec<Recorded>> {
        let row = |(&row, load): (&usize, &Load<Recorded>)| {
            let entry = |(&column, added): (&usize, &Wrench<Recorded>)| {
                self.slope(row, column, load.gradient.power(*added))
            };
            self.coupled.iter().zip(&self.added[row]).map(entry).collect()
        };
        self.coupled.iter().zip(found).map(row).collect()
    }

    /// How the misfit of a contact changes with another's load, by what the friction of that one does.
    pub(crate) fn slope(&self, row: usize, column: usize, influence: Recorded) -> Recorded {
        let own = Recorded::from_f64(if row == column { 1.0 } else { 0.0 });
        own - influence * self.coefficient(column)
    }

    /// The loads on all contacts: those given for the coupled ones, and what follows from them for the others,
    /// which change nothing.
    pub(crate) fn of_all(&self, presses: &[Recorded], forces: &[Recorded]) -> Vec<Recorded> {
        let of = |row: usize| {
            let given = self.coupled.iter().position(|interface| *interface == row);
            given.map_or_else(|| self.under(row, forces).value, |at| presses[at])
        };
        (0..self.states.len()).map(of).collect()
    }

    /// The frictions of all contacts under loads of all.
    pub(crate) fn forces_of_all(&self, loads: &[Recorded]) -> Vec<Recorded> {
        loads.iter().enumerate().map(|(interface, load)| self.force(interface, *load)).collect()
    }
}
