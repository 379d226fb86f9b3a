//! Joint wrenches and efforts as affine functions of the friction forces.

use super::couplings::Couplings;
use crate::dynamics::balance::WIDTH;
use crate::dynamics::interfaces::InterfaceState;
use crate::dynamics::inverse::Inverse;
use crate::dynamics::responses::{Influences, Responses};
use crate::dynamics::settings::{FrictionMode, Settings};
use crate::friction::{NormalLoadMap, OwnFriction};
use crate::friction_problem::normal_load::normal_load;
use crate::kinematics::Bodies;
use crate::linalg::SparseMatrix;
use crate::parameters::{InterfaceParameters, Parameters};
use crate::spatial::Wrench;
use core::ops::Range;

/// Friction forces and their effects at one configuration, relative to a solution without static
/// friction. A friction component has the sign of the sliding velocity that it opposes.
///
/// An interface at rest has one component for each of its DOFs. A sliding interface has a single
/// component: the change of its friction relative to that solution.
///
/// A map can be restricted to some of the interfaces. All indices of interfaces and components
/// then refer to this selection.
#[derive(Clone, Debug)]
pub(super) struct FrictionMap<'a> {
    parameters: &'a Parameters<f64>,
    bodies: &'a Bodies<f64>,
    inverse: &'a Inverse<f64>,
    responses: &'a Responses,
    influences: &'a Influences,
    /// True if friction changes normal forces.
    coupled: bool,
    /// Selected interfaces of the mechanism, in ascending order.
    interfaces: Vec<usize>,
    /// For each component of the selected interfaces, its index in [`Self::responses`].
    components: Vec<usize>,
    /// For each component, the index of its interface in the selection.
    owners: Vec<usize>,
    /// Index of the first component of each interface, followed by the number of components.
    starts: Vec<usize>,
}

impl<'a> FrictionMap<'a> {
    /// Creates a map of all interfaces that is linearised about the solution in `inverse`.
    /// `responses` must belong to the configuration of this solution, and `influences` to
    /// `responses`.
    pub(super) fn new(
        inverse: &'a Inverse<f64>,
        (responses, influences): (&'a Responses, &'a Influences),
        parameters: &'a Parameters<f64>,
        bodies: &'a Bodies<f64>,
        settings: &Settings,
    ) -> Self {
        let coupled = settings.friction == FrictionMode::Converged;
        let (interfaces, components, owners, starts) = Default::default();
        let empty = Self {
            parameters,
            bodies,
            inverse,
            responses,
            influences,
            coupled,
            interfaces,
            components,
            owners,
            starts,
        };
        empty.restricted((0..parameters.interfaces.len()).collect())
    }

    /// Returns the map of the given interfaces of the mechanism, in ascending order. No other
    /// friction may influence the normal forces of these interfaces.
    pub(super) fn restricted(&self, interfaces: Vec<usize>) -> Self {
        let (mut components, mut owners, mut starts) = (Vec::new(), Vec::new(), vec![0]);
        for (place, &interface) in interfaces.iter().enumerate() {
            components.extend(self.responses.components(interface));
            owners.resize(components.len(), place);
            starts.push(components.len());
        }
        Self { interfaces, components, owners, starts, ..*self }
    }

    /// Returns the number of friction components of all interfaces.
    pub(super) fn len(&self) -> usize {
        self.components.len()
    }

    /// Returns the number of friction interfaces.
    pub(super) fn interfaces(&self) -> usize {
        self.interfaces.len()
    }

    /// Returns the index of a component in the map of all interfaces.
    pub(super) fn global(&self, component: usize) -> usize {
        self.components[component]
    }

    /// Returns an iterator over the interface indices of all friction components.
    pub(super) fn owners(&self) -> impl Iterator<Item = usize> {
        self.owners.iter().copied()
    }

    /// Returns, for each interface, the Euclidean norm of its components in a vector over all
    /// friction components.
    pub(super) fn sizes(&self, vector: &[f64]) -> Vec<f64> {
        let of_interface = |interface| match &vector[self.components(interface)] {
            [single] => single.abs(),
            own => own.iter().fold(0.0, |size, x| f64::hypot(size, *x)),
        };
        (0..self.interfaces()).map(of_interface).collect()
    }

    /// Returns the derivative of an effort with respect to each friction component.
    pub(super) fn slopes(&self, actuator: usize) -> Vec<f64> {
        let effort = |component: &usize| self.responses.effort(*component, actuator);
        self.components.iter().map(effort).collect()
    }

    /// Returns the derivative of the acceleration of a local degree of freedom with respect to each
    /// friction component.
    pub(super) fn spin_slopes(&self, spin: usize) -> Vec<f64> {
        self.components.iter().map(|component| self.responses.spin(*component, spin)).collect()
    }

    /// Returns the components of an interface.
    pub(super) fn components(&self, interface: usize) -> Range<usize> {
        self.starts[interface]..self.starts[interface + 1]
    }

    fn state(&self, interface: usize) -> &InterfaceState<f64> {
        &self.inverse.interfaces()[self.interfaces[interface]]
    }

    fn content(&self, interface: usize) -> &InterfaceParameters<f64> {
        &self.parameters.interfaces[self.interfaces[interface]]
    }

    /// Returns the friction coefficients of an interface for forward sliding (positive friction)
    /// and backward sliding (negative friction).
    pub(super) fn coefficients(&self, interface: usize) -> [f64; 2] {
        let state = self.state(interface);
        if state.sliding > 0.0 {
            return [state.resistance.coefficient; 2];
        }
        self.content(interface).laws().map(|law| law.at_rest())
    }

    /// Returns true if an interface is at rest.
    pub(super) fn rests(&self, interface: usize) -> bool {
        self.state(interface).sliding == 0.0
    }

    /// Returns the normal force of an interface without static friction, N.
    pub(super) fn load_without(&self, interface: usize) -> f64 {
        self.state(interface).load()
    }

    /// Computes the normal forces of all interfaces for the given friction components, N.
    pub(super) fn loads(&self, frictions: &[f64]) -> Vec<f64> {
        if !self.coupled {
            return (0..self.interfaces()).map(|interface| self.load_without(interface)).collect();
        }
        let changes = self.changes(frictions);
        (0..self.interfaces())
            .map(|interface| {
                let content = self.content(interface);
                let wrench = self.inverse.joint_wrenches()[content.joint];
                let own = self.own(interface).map_or(0.0, |k| frictions[k]);
                self.load_of(interface, &content.load, wrench + changes[interface], own)
            })
            .collect()
    }

    /// Returns bounds of the influence of friction on normal forces. Entry (i, j) bounds the change
    /// of the normal force at interface i due to a friction of one newton at interface j in any
    /// direction. The bound does not depend on the initial friction, because normal forces are
    /// norms of the reaction, up to constants.
    pub(super) fn couplings(&self) -> Couplings {
        let count = self.interfaces();
        let mut entries = Vec::new();
        let mut bounds = vec![0.0; count];
        for interface in (0..count).filter(|_| self.coupled) {
            let map = self.content(interface).load.seminorm();
            let first = entries.len();
            self.visit(interface, |component, wrench| {
                let owner = self.owners[component];
                let friction = if self.own(interface) == Some(component) { 1.0 } else { 0.0 };
                if bounds[owner] == 0.0 {
                    entries.push((interface, owner, 0.0));
                }
                // Follows from the triangle and Cauchy-Schwarz inequalities.
                let change = self.load_of(interface, &map, wrench, friction);
                bounds[owner] = f64::hypot(bounds[owner], change);
            });
            for (_, owner, entry) in &mut entries[first..] {
                *entry = core::mem::take(&mut bounds[*owner]);
            }
        }
        Couplings::new(self, SparseMatrix::new((count, count), entries.into_iter()))
    }

    /// Calls `put` with each component that may change the wrench or the normal force at an
    /// interface, and with the change of the wrench per newton. The components are in ascending
    /// order.
    fn visit(&self, interface: usize, mut put: impl FnMut(usize, Wrench<f64>)) {
        let joint = self.content(interface).joint;
        for &block in self.influences.at(self.interfaces[interface]) {
            let wrenches = self.responses.block(block, joint);
            let first = self.components.partition_point(|component| *component < WIDTH * block);
            let own = self.components[first..].iter().enumerate();
            for (k, component) in own.take_while(|(_, c)| **c < WIDTH * (block + 1)) {
                put(first + k, wrenches.lane(component % WIDTH));
            }
        }
    }

    /// Returns bounds like [`Self::couplings`] for friction without its component in the span of the
    /// orthonormal vectors `without`. `plain` contains the bounds for complete friction.
    pub(super) fn couplings_without(&self, plain: &Couplings, without: &[&[f64]]) -> Couplings {
        let count = self.interfaces();
        if !self.coupled || without.len() == self.len() {
            return Couplings::new(self, SparseMatrix::new((count, count), core::iter::empty()));
        }
        // For each vector and each interface, the change of the wrench that this friction causes.
        let removed: Vec<_> = without.iter().map(|vector| self.changes(vector)).collect();
        let mut entries = Vec::new();
        for owner in 0..count {
            let mut own = self.components(owner);
            if own.any(|k| without.iter().any(|vector| vector[k] != 0.0)) {
                let column = self.column_without(owner, without, &removed);
                entries.extend(column.map(|(row, bound)| (row, owner, bound)));
            } else {
                entries.extend(plain.column(owner).map(|(row, bound)| (row, owner, bound)));
            }
        }
        Couplings::new(self, SparseMatrix::new((count, count), entries.into_iter()))
    }

    /// Computes the column of an interface in the matrix of [`Self::couplings_without`], as pairs
    /// of row and bound. `removed` contains the changes of the wrenches of all interfaces that
    /// frictions equal to the vectors `without` cause.
    fn column_without<'b>(
        &'b self,
        owner: usize,
        without: &'b [&[f64]],
        removed: &'b [Vec<Wrench<f64>>],
    ) -> impl Iterator<Item = (usize, f64)> + 'b {
        (0..self.interfaces()).map(move |i| {
            let content = self.content(i);
            let (map, own) = (content.load.seminorm(), self.own(i));
            let mut bound = 0.0;
            for k in self.components(owner) {
                let mut change = self.responses.wrench(self.components[k], content.joint);
                let mut friction = if own == Some(k) { 1.0 } else { 0.0 };
                for (vector, removed) in without.iter().zip(removed) {
                    change += removed[i] * -vector[k];
                    friction -= own.map_or(0.0, |own| vector[own] * vector[k]);
                }
                // Follows from the triangle and Cauchy-Schwarz inequalities.
                bound = f64::hypot(bound, self.load_of(i, &map, change, friction));
            }
            (i, bound)
        })
    }

    /// Computes the changes of the wrenches of all interfaces due to the given friction components.
    fn changes(&self, frictions: &[f64]) -> Vec<Wrench<f64>> {
        let of_interface = |interface| {
            let mut sum = Wrench::zero();
            self.visit(interface, |component, wrench| {
                if frictions[component] != 0.0 {
                    sum += wrench * frictions[component];
                }
            });
            sum
        };
        (0..self.interfaces()).map(of_interface).collect()
    }

    /// Returns the first friction component of an interface.
    fn own(&self, interface: usize) -> Option<usize> {
        self.components(interface).next()
    }

    /// Returns the interfaces of the mechanism whose friction can change a quantity with the
    /// derivatives `slopes` with respect to the friction components: directly, or through normal
    /// forces of interfaces whose friction does. `influencing` is [`Couplings::influencing`]. The
    /// map must contain all interfaces.
    pub(super) fn reach(&self, slopes: &[f64], influencing: &SparseMatrix) -> Vec<usize> {
        let acting = self.owners().zip(slopes).filter(|(_, slope)| **slope != 0.0);
        let mut reached: Vec<usize> = acting.map(|(owner, _)| owner).collect();
        reached.dedup();
        let mut known: std::collections::BTreeSet<usize> = reached.iter().copied().collect();
        while let Some(interface) = reached.pop() {
            for (other, _) in influencing.column(interface) {
                if known.insert(other) {
                    reached.push(other);
                }
            }
        }
        known.into_iter().collect()
    }

    /// Computes the normal force of an interface, N, for the given joint wrench. `constant` is the
    /// first friction component of the interface, N. Only a thread depends on it, because the
    /// friction of a thread carries a part of the wrench.
    fn load_of(
        &self,
        interface: usize,
        map: &NormalLoadMap<f64>,
        wrench: Wrench<f64>,
        constant: f64,
    ) -> f64 {
        let state = self.state(interface);
        let direction = if state.sliding > 0.0 { state.sense } else { 1.0 };
        let own = OwnFriction { coefficient: 0.0, constant, direction };
        let content = self.content(interface);
        let pitch = self.parameters.pitch[content.joint];
        normal_load(map, content, pitch, self.bodies, wrench, own).value
    }
}
