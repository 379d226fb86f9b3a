//! Normal loads of friction interfaces as functions of normal loads and accelerations, for
//! recordings.
//!
//! Friction forces are affine in the normal loads, joint wrenches are affine in friction forces and
//! in the accelerations of the prescribed coordinates, and normal loads are functions of joint
//! wrenches. At fixed accelerations, friction in one leg changes wrenches in all legs, because the
//! actuators compensate for it. In the form of the wrenches in which multiples of the equations of
//! the efforts have been added (`locality`, equation (P5) of the book's theory), most of these
//! changes are zero, and the influence on other legs is due to accelerations.

use crate::motions::UnitAccelerations;
use crate::recorded::Recorded;
use stiction_core::dynamics::InterfaceState;
use stiction_core::friction::Load;
use stiction_core::kinematics::Bodies;
use stiction_core::parameters::Parameters;
use stiction_core::spatial::{Mat3, Pose, Vec3, Wrench};

/// Data from which the normal loads under given friction forces and accelerations are computed.
pub(crate) struct Loads<'a> {
    pub(crate) parameters: &'a Parameters<Recorded>,
    pub(crate) bodies: &'a Bodies<Recorded>,
    pub(crate) states: &'a [InterfaceState<Recorded>],
    /// Indices of the coupled interfaces: those whose normal loads are unknowns of the iteration.
    pub(crate) coupled: &'a [usize],
    /// Changes due to unit accelerations.
    pub(crate) units: &'a UnitAccelerations<Recorded>,
    /// `true` if the rows contain changes per unit acceleration of each degree of freedom of the
    /// tree, `false` for those of each prescribed coordinate.
    pub(crate) by_tree: bool,
    /// Rows of all interfaces.
    pub(crate) rows: Vec<Row>,
}

/// Wrench of an interface's joint, in the joint's frame J, because many normal loads depend on only
/// two components in this frame. For a ball, whose normal load does not depend on the axes, the
/// wrench is expressed in world axes.
pub(crate) struct Row {
    /// Wrench without friction and accelerations.
    ideal: Wrench<Recorded>,
    /// The same wrench with those parts of the friction forces of all interfaces that do not depend
    /// on the normal loads.
    unloaded: Wrench<Recorded>,
    /// Change of the wrench per unit normal load of each coupled interface.
    by_load: Vec<Wrench<Recorded>>,
    /// Change of the wrench per unit acceleration of each degree of freedom of the tree, or of each
    /// prescribed coordinate.
    by_acceleration: Vec<Wrench<Recorded>>,
}

/// Sum of `start` and of the given wrenches, each multiplied by its amount.
fn sum(start: Wrench<Recorded>, of: &[Wrench<Recorded>], amounts: &[Recorded]) -> Wrench<Recorded> {
    of.iter().zip(amounts).fold(start, |sum, (wrench, amount)| sum + *wrench * *amount)
}

impl Loads<'_> {
    /// Adds the row of the next interface, with the changes of the wrench per newton of friction of
    /// each interface and per unit acceleration of each degree of freedom of the tree.
    pub(crate) fn push(
        &mut self,
        ideal: Wrench<Recorded>,
        by_friction: &[Wrench<Recorded>],
        of_tree: &[Wrench<Recorded>],
    ) {
        let by_acceleration = match self.by_tree {
            true => of_tree.to_vec(),
            false => {
                self.units.tree.iter().map(|unit| sum(Wrench::zero(), of_tree, unit)).collect()
            }
        };
        let parts = self.states.iter().map(InterfaceState::resistance);
        let (coefficients, constants): (Vec<Recorded>, Vec<Recorded>) = parts.unzip();
        let per_load = |interface: &usize| by_friction[*interface] * coefficients[*interface];
        let by_load = self.coupled.iter().map(per_load).collect();
        let unloaded = sum(ideal, by_friction, &constants);
        self.rows.push(Row { ideal, unloaded, by_load, by_acceleration });
    }

    /// Accelerations on which the rows depend, for given accelerations of the prescribed
    /// coordinates.
    pub(crate) fn accelerations(&self, targets: &[Recorded]) -> Vec<Recorded> {
        if self.by_tree { self.units.of_tree(targets) } else { targets.to_vec() }
    }

    /// Friction force of an interface under a normal load.
    pub(crate) fn force(&self, interface: usize, load: Recorded) -> Recorded {
        let (coefficient, constant) = self.states[interface].resistance();
        coefficient * load + constant
    }

    /// Normal load of an interface under a wrench of its joint.
    fn load(&self, interface: usize, wrench: Wrench<Recorded>) -> Load<Recorded> {
        let (parameters, state) = (&self.parameters.interfaces[interface], &self.states[interface]);
        let joint = parameters.joint;
        let here = Pose { rotation: Mat3::identity(), position: Vec3::zero() };
        let across = self.bodies.frame_j[joint].inverse() * self.bodies.frame_k[joint];
        state.load_in(parameters, self.parameters.pitch[joint], &here, &across, wrench)
    }

    /// Normal load of one interface under the friction that the normal loads `loads` of the coupled
    /// interfaces cause, with the [`Self::accelerations`].
    fn under(
        &self,
        interface: usize,
        loads: &[Recorded],
        accelerations: &[Recorded],
    ) -> Load<Recorded> {
        let Row { unloaded, by_load, by_acceleration, .. } = &self.rows[interface];
        let wrench = sum(*unloaded, by_load, loads);
        self.load(interface, sum(wrench, by_acceleration, accelerations))
    }

    /// Normal loads of the coupled interfaces without friction.
    pub(crate) fn frictionless(&self, accelerations: &[Recorded]) -> Vec<Recorded> {
        let of = |row: &usize| {
            let Row { ideal, by_acceleration, .. } = &self.rows[*row];
            self.load(*row, sum(*ideal, by_acceleration, accelerations)).value
        };
        self.coupled.iter().map(of).collect()
    }

    /// Normal loads of the coupled interfaces under the friction that the normal loads `loads`
    /// cause.
    pub(crate) fn all_under(
        &self,
        loads: &[Recorded],
        accelerations: &[Recorded],
    ) -> Vec<Load<Recorded>> {
        self.coupled.iter().map(|row| self.under(*row, loads, accelerations)).collect()
    }

    /// Derivatives of the normal loads `found` of the coupled interfaces (rows) with respect to the
    /// normal loads that cause friction, at fixed accelerations, then with respect to the
    /// accelerations of the prescribed coordinates (columns).
    pub(crate) fn slopes(&self, found: &[Load<Recorded>]) -> Vec<Vec<Recorded>> {
        let row = |(row, load): (&usize, &Load<Recorded>)| {
            let Row { by_load, by_acceleration, .. } = &self.rows[*row];
            let slopes = |changes: &[Wrench<Recorded>]| -> Vec<Recorded> {
                changes.iter().map(|change| load.gradient.power(*change)).collect()
            };
            let mut by_acceleration = slopes(by_acceleration);
            if self.by_tree {
                by_acceleration = self.units.of_targets(&by_acceleration);
            }
            [slopes(by_load), by_acceleration].concat()
        };
        self.coupled.iter().zip(found).map(row).collect()
    }

    /// Normal loads of all interfaces: `loads` for the coupled interfaces; for all others, the
    /// normal loads under the friction of the coupled interfaces.
    pub(crate) fn of_all(&self, loads: &[Recorded], accelerations: &[Recorded]) -> Vec<Recorded> {
        let of = |row: usize| {
            let given = self.coupled.iter().position(|interface| *interface == row);
            given.map_or_else(|| self.under(row, loads, accelerations).value, |at| loads[at])
        };
        (0..self.states.len()).map(of).collect()
    }

    /// Friction forces of all interfaces under the given normal loads.
    pub(crate) fn forces_of_all(&self, loads: &[Recorded]) -> Vec<Recorded> {
        loads.iter().enumerate().map(|(interface, load)| self.force(interface, *load)).collect()
    }
}
