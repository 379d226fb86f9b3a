//! What friction does: joints' wrenches and efforts are affine in the friction forces.

use crate::dynamics::interfaces::load_by;
use crate::dynamics::inverse::Inverse;
use crate::dynamics::model::Model;
use crate::dynamics::settings::{FrictionMode, Settings};
use crate::friction::{NormalLoadMap, OwnFriction, Resistance};
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::spatial::Wrench;
use nalgebra::DMatrix;

/// One component of the friction at one contact.
#[derive(Clone, Debug)]
struct Component {
    interface: usize,
    /// What a friction of one newton adds to the wrench of each joint.
    wrenches: Vec<Wrench<f64>>,
    /// What it adds to each drive, and to the acceleration of each idle spin.
    efforts: Vec<f64>,
    spins: Vec<f64>,
}

/// Friction forces and their effects at one position, about a solution in which nothing that rests
/// has friction. A component has the sign of the sliding velocity that it would act against.
///
/// A contact at rest has a component for each of its freedoms; one that slides has one, the change
/// of its friction.
#[derive(Clone, Debug)]
pub(super) struct FrictionMap<'a> {
    parameters: &'a Parameters<f64>,
    bodies: &'a Bodies<f64>,
    inverse: &'a Inverse<f64>,
    components: Vec<Component>,
    /// Whether friction changes loads.
    coupled: bool,
}

impl<'a> FrictionMap<'a> {
    /// About the solution in `inverse`.
    pub(super) fn new(
        inverse: &'a Inverse<f64>,
        model: &Model,
        parameters: &'a Parameters<f64>,
        bodies: &'a Bodies<f64>,
        settings: &Settings,
    ) -> Self {
        let mut probe = inverse.clone();
        let mut respond = |interface: usize, held: [f64; 3], force: f64| {
            probe.set_held(interface, held);
            probe.apply_friction_at(model.topology(), parameters, bodies, settings, 1.0);
            probe.set_resistances(Resistance { coefficient: 0.0, constant: 0.0 });
            probe.set_resistance(interface, Resistance { coefficient: 0.0, constant: force });
            let wrenches = probe.frozen_wrenches(model, parameters, bodies).to_vec();
            probe.finish_friction(model.topology(), parameters, bodies);
            probe.set_held(interface, [0.0; 3]);
            (wrenches, probe.efforts().to_vec(), probe.spin_accelerations(model).to_vec())
        };
        let mut components = Vec::new();
        for (interface, content) in parameters.interfaces.iter().enumerate() {
            let rests = inverse.interfaces()[interface].sliding == 0.0;
            let without = respond(interface, [0.0; 3], 0.0);
            let dofs = if rests { content.shape.dofs().len() } else { 1 };
            for dof in 0..dofs {
                let mut held = [0.0; 3];
                held[dof] = 1.0;
                let with = respond(interface, held, 1.0);
                let less = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
                components.push(Component {
                    interface,
                    wrenches: with.0.iter().zip(&without.0).map(|(a, b)| *a - *b).collect(),
                    efforts: less(&with.1, &without.1),
                    spins: less(&with.2, &without.2),
                });
            }
        }
        let coupled = settings.friction == FrictionMode::Converged;
        Self { parameters, bodies, inverse, components, coupled }
    }

    /// Number of components of all frictions.
    pub(super) fn len(&self) -> usize {
        self.components.len()
    }

    /// Number of contacts.
    pub(super) fn interfaces(&self) -> usize {
        self.parameters.interfaces.len()
    }

    /// The contact of each component.
    pub(super) fn owners(&self) -> impl Iterator<Item = usize> {
        self.components.iter().map(|component| component.interface)
    }

    /// The lengths of the contacts' parts of a vector with an entry for each component.
    pub(super) fn sizes(&self, vector: &[f64]) -> Vec<f64> {
        let mut sizes = vec![0.0; self.interfaces()];
        for (owner, x) in self.owners().zip(vector) {
            sizes[owner] = f64::hypot(sizes[owner], *x);
        }
        sizes
    }

    /// The change of a drive with each component.
    pub(super) fn slopes(&self, actuator: usize) -> Vec<f64> {
        self.components.iter().map(|component| component.efforts[actuator]).collect()
    }

    /// The change of the acceleration of an idle spin with each component.
    pub(super) fn spin_slopes(&self, spin: usize) -> Vec<f64> {
        self.components.iter().map(|component| component.spins[spin]).collect()
    }

    /// The coefficients of a contact, of its friction forward and backward (positive and negative).
    pub(super) fn coefficients(&self, interface: usize) -> [f64; 2] {
        let state = &self.inverse.interfaces()[interface];
        if state.sliding > 0.0 {
            return [state.resistance.coefficient; 2];
        }
        let content = &self.parameters.interfaces[interface];
        content.laws().map(|law| law.at_rest())
    }

    /// Whether a contact rests.
    pub(super) fn rests(&self, interface: usize) -> bool {
        self.inverse.interfaces()[interface].sliding == 0.0
    }

    /// The load of a contact where nothing at rest has friction, N.
    pub(super) fn load_without(&self, interface: usize) -> f64 {
        self.inverse.interfaces()[interface].load()
    }

    /// The loads of all contacts under frictions, N.
    pub(super) fn loads(&self, frictions: &[f64]) -> Vec<f64> {
        (0..self.interfaces())
            .map(|interface| {
                if !self.coupled {
                    return self.load_without(interface);
                }
                let content = &self.parameters.interfaces[interface];
                let wrench = self.inverse.joint_wrenches()[content.joint];
                let change = self.change(content.joint, frictions);
                self.load_of(interface, &content.load, wrench + change, frictions)
            })
            .collect()
    }

    /// The most by which the load of each contact changes with frictions that change by these,
    /// whatever they were before: loads are norms of the reaction, up to constants.
    pub(super) fn most_changes(&self, frictions: &[f64]) -> Vec<f64> {
        (0..self.interfaces())
            .map(|interface| {
                let content = &self.parameters.interfaces[interface];
                let (map, change) =
                    (content.load.seminorm(), self.change(content.joint, frictions));
                if self.coupled { self.load_of(interface, &map, change, frictions) } else { 0.0 }
            })
            .collect()
    }

    /// Entry (i, j): the most by which the load of contact i changes with a friction of one newton
    /// at contact j, in any direction, after `filter` has made of it what may be.
    pub(super) fn couplings(&self, filter: impl Fn(usize) -> Vec<f64>) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.interfaces(), self.interfaces());
        for (k, owner) in self.owners().enumerate() {
            // By the triangle inequality and that of Cauchy and Schwarz.
            for (i, change) in self.most_changes(&filter(k)).into_iter().enumerate() {
                matrix[(i, owner)] = f64::hypot(matrix[(i, owner)], change);
            }
        }
        matrix
    }

    fn change(&self, joint: usize, frictions: &[f64]) -> Wrench<f64> {
        let mut sum = Wrench::zero();
        let acting =
            self.components.iter().zip(frictions).filter(|(_, friction)| **friction != 0.0);
        for (component, &friction) in acting {
            sum += component.wrenches[joint] * friction;
        }
        sum
    }

    fn load_of(
        &self,
        interface: usize,
        map: &NormalLoadMap<f64>,
        wrench: Wrench<f64>,
        frictions: &[f64],
    ) -> f64 {
        // A thread's own friction bears a part of its load; it has one component.
        let own = self.owners().position(|owner| owner == interface);
        let constant = own.map_or(0.0, |k| frictions[k]);
        let state = &self.inverse.interfaces()[interface];
        let direction = if state.sliding > 0.0 { state.sense } else { 1.0 };
        let own = OwnFriction { coefficient: 0.0, constant, direction };
        let content = &self.parameters.interfaces[interface];
        let pitch = self.parameters.pitch[content.joint];
        load_by(map, content, pitch, self.bodies, wrench, own).value
    }
}

/// A unit vector.
pub(super) fn unit(length: usize, place: usize) -> Vec<f64> {
    (0..length).map(|k| if k == place { 1.0 } else { 0.0 }).collect()
}
