//! Normal loads of friction interfaces as functions of the friction forces, for recordings.
//!
//! Joint wrenches are affine in friction forces, normal loads are functions of joint wrenches, and
//! friction forces are affine in normal loads.

use crate::recorded::Recorded;
use stiction_core::dynamics::InterfaceState;
use stiction_core::friction::Load;
use stiction_core::kinematics::Bodies;
use stiction_core::parameters::{InterfaceParameters, Parameters};
use stiction_core::scalar::Scalar;
use stiction_core::spatial::{Mat3, Pose, Vec3, Wrench};

/// Data from which the normal loads under given friction forces are computed.
pub(crate) struct Loads<'a> {
    pub(crate) parameters: &'a Parameters<Recorded>,
    pub(crate) bodies: &'a Bodies<Recorded>,
    pub(crate) states: &'a [InterfaceState<Recorded>],
    /// Indices of the coupled interfaces: those whose normal loads are unknowns of the iteration.
    pub(crate) coupled: &'a [usize],
    /// Frictionless wrench of each interface's joint in the joint's frame J, because many normal
    /// loads depend on only two components in this frame. For a ball, whose normal load does not
    /// depend on the axes, the wrench is expressed in world axes.
    pub(crate) without: Vec<Wrench<Recorded>>,
    /// For each interface, the change of its joint's wrench per unit friction force of each coupled
    /// interface, in the frame of `without`.
    pub(crate) added: Vec<Vec<Wrench<Recorded>>>,
}

impl Loads<'_> {
    pub(crate) fn interface(
        &self,
        interface: usize,
    ) -> (&InterfaceParameters<Recorded>, &InterfaceState<Recorded>) {
        (&self.parameters.interfaces[interface], &self.states[interface])
    }

    /// Derivative of an interface's friction force with respect to its normal load.
    pub(crate) fn coefficient(&self, interface: usize) -> Recorded {
        self.states[interface].resistance().0
    }

    /// Friction force of an interface under a normal load.
    pub(crate) fn force(&self, interface: usize, load: Recorded) -> Recorded {
        let (coefficient, constant) = self.states[interface].resistance();
        coefficient * load + constant
    }

    /// Friction forces of the coupled interfaces under the given normal loads.
    pub(crate) fn forces(&self, loads: &[Recorded]) -> Vec<Recorded> {
        self.coupled
            .iter()
            .zip(loads)
            .map(|(interface, load)| self.force(*interface, *load))
            .collect()
    }

    /// Normal load of an interface under a wrench of its joint.
    pub(crate) fn load(&self, interface: usize, wrench: Wrench<Recorded>) -> Load<Recorded> {
        let (parameters, state) = self.interface(interface);
        let joint = parameters.joint;
        let here = Pose { rotation: Mat3::identity(), position: Vec3::zero() };
        let across = self.bodies.frame_j[joint].inverse() * self.bodies.frame_k[joint];
        state.load_in(parameters, self.parameters.pitch[joint], &here, &across, wrench)
    }

    /// Normal load of one interface for the given friction forces of the coupled interfaces.
    pub(crate) fn under(&self, interface: usize, forces: &[Recorded]) -> Load<Recorded> {
        let mut wrench = self.without[interface];
        for (added, force) in self.added[interface].iter().zip(forces) {
            wrench += *added * *force;
        }
        self.load(interface, wrench)
    }

    /// Normal loads of all coupled interfaces for the given friction forces of these interfaces.
    pub(crate) fn all_under(&self, forces: &[Recorded]) -> Vec<Load<Recorded>> {
        self.coupled.iter().map(|row| self.under(*row, forces)).collect()
    }

    /// Normal loads of the coupled interfaces without friction, the initial guess of the iteration.
    pub(crate) fn initial_loads(&self) -> Vec<Recorded> {
        let none = vec![Recorded::zero(); self.coupled.len()];
        self.all_under(&none).iter().map(|load| load.value).collect()
    }

    /// Derivative of each interface's normal load (row) with respect to the friction force of each
    /// coupled interface (column), row by row.
    pub(crate) fn influences(&self, forces: &[Recorded]) -> Vec<Recorded> {
        let rows = self.added.iter().enumerate();
        let of_row = |(row, added): (usize, &Vec<Wrench<Recorded>>)| {
            let load = self.under(row, forces);
            added.iter().map(|added| load.gradient.power(*added)).collect::<Vec<_>>()
        };
        rows.flat_map(of_row).collect()
    }

    /// Residuals of the given normal loads: differences between these loads and the normal loads
    /// `found`, which result from the friction under the given loads. Residuals vanish at the
    /// solution.
    pub(crate) fn residuals(loads: &[Recorded], found: &[Load<Recorded>]) -> Vec<Recorded> {
        loads.iter().zip(found).map(|(load, found)| *load - found.value).collect()
    }

    /// Jacobian of the residuals of the coupled interfaces (rows) with respect to their normal
    /// loads (columns).
    pub(crate) fn matrix(&self, found: &[Load<Recorded>]) -> Vec<Vec<Recorded>> {
        let row = |(&row, load): (&usize, &Load<Recorded>)| {
            let entry = |(&column, added): (&usize, &Wrench<Recorded>)| {
                self.slope(row, column, load.gradient.power(*added))
            };
            self.coupled.iter().zip(&self.added[row]).map(entry).collect()
        };
        self.coupled.iter().zip(found).map(row).collect()
    }

    /// Derivative of the residual of interface `row` with respect to the normal load of interface
    /// `column`. `influence` is the derivative of the normal load of `row` with respect to the
    /// friction force of `column`.
    pub(crate) fn slope(&self, row: usize, column: usize, influence: Recorded) -> Recorded {
        let own = Recorded::from_f64(if row == column { 1.0 } else { 0.0 });
        own - influence * self.coefficient(column)
    }

    /// Normal loads of all interfaces: `loads` for the coupled interfaces; for all others, the
    /// normal loads under the friction forces `forces` of the coupled interfaces.
    pub(crate) fn of_all(&self, loads: &[Recorded], forces: &[Recorded]) -> Vec<Recorded> {
        let of = |row: usize| {
            let given = self.coupled.iter().position(|interface| *interface == row);
            given.map_or_else(|| self.under(row, forces).value, |at| loads[at])
        };
        (0..self.states.len()).map(of).collect()
    }

    /// Friction forces of all interfaces under the given normal loads.
    pub(crate) fn forces_of_all(&self, loads: &[Recorded]) -> Vec<Recorded> {
        loads.iter().enumerate().map(|(interface, load)| self.force(interface, *load)).collect()
    }
}
