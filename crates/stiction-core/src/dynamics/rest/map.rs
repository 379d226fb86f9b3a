//! Joint wrenches and efforts as affine functions of the friction forces.

use crate::dynamics::inverse::Inverse;
use crate::dynamics::responses::Responses;
use crate::dynamics::settings::{FrictionMode, Settings};
use crate::friction::{NormalLoadMap, OwnFriction};
use crate::friction_problem::normal_load::normal_load;
use crate::friction_problem::uniqueness::radius_bound;
use crate::kinematics::Bodies;
use crate::parameters::{InterfaceParameters, Parameters};
use crate::spatial::Wrench;
use core::cell::OnceCell;
use nalgebra::DMatrix;

/// Friction forces and their effects at one configuration, relative to a solution without static
/// friction. A friction component has the sign of the sliding velocity that it opposes.
///
/// An interface at rest has one component for each of its DOFs. A sliding interface has a single
/// component: the change of its friction relative to that solution.
#[derive(Clone, Debug)]
pub(super) struct FrictionMap<'a> {
    parameters: &'a Parameters<f64>,
    bodies: &'a Bodies<f64>,
    inverse: &'a Inverse<f64>,
    responses: &'a Responses,
    /// True if friction changes normal forces.
    coupled: bool,
}

/// Bounds of the influence of friction on normal forces, see [`FrictionMap::couplings`].
pub(super) struct Couplings {
    bounds: DMatrix<f64>,
    /// Bounds of the influence of friction on friction limits: [`Self::bounds`], with each row
    /// multiplied by the larger friction coefficient of its interface. `None` if no friction
    /// changes a normal force.
    pub(super) of_limits: Option<DMatrix<f64>>,
    /// Upper bound of the spectral radius of [`Self::of_limits`], once it is known.
    radius: OnceCell<f64>,
}

impl Couplings {
    fn new(map: &FrictionMap<'_>, bounds: DMatrix<f64>) -> Self {
        let is_zero = bounds.iter().all(|entry| *entry == 0.0);
        let of_limits = (!is_zero).then(|| {
            let largest: Vec<f64> = (0..map.interfaces())
                .map(|interface| {
                    let [forward, backward] = map.coefficients(interface);
                    forward.max(backward)
                })
                .collect();
            DMatrix::from_fn(bounds.nrows(), bounds.ncols(), |i, j| largest[i] * bounds[(i, j)])
        });
        Self { bounds, of_limits, radius: OnceCell::new() }
    }

    /// Returns an upper bound of the spectral radius of [`Self::of_limits`].
    pub(super) fn radius(&self) -> f64 {
        *self.radius.get_or_init(|| match &self.of_limits {
            // The transpose has the same spectral radius.
            Some(matrix) => {
                radius_bound(matrix.as_slice(), matrix.nrows(), &mut Default::default())
            }
            None => 0.0,
        })
    }
}

impl<'a> FrictionMap<'a> {
    /// Creates a map that is linearised about the solution in `inverse`. `responses` must belong to
    /// the configuration of this solution.
    pub(super) fn new(
        inverse: &'a Inverse<f64>,
        responses: &'a Responses,
        parameters: &'a Parameters<f64>,
        bodies: &'a Bodies<f64>,
        settings: &Settings,
    ) -> Self {
        let coupled = settings.friction == FrictionMode::Converged;
        Self { parameters, bodies, inverse, responses, coupled }
    }

    /// Returns the number of friction components of all interfaces.
    pub(super) fn len(&self) -> usize {
        self.responses.len()
    }

    /// Returns the number of friction interfaces.
    pub(super) fn interfaces(&self) -> usize {
        self.parameters.interfaces.len()
    }

    /// Returns an iterator over the interface indices of all friction components.
    pub(super) fn owners(&self) -> impl Iterator<Item = usize> {
        (0..self.len()).map(|component| self.responses.interface(component))
    }

    /// Returns, for each interface, the Euclidean norm of its components in a vector over all
    /// friction components.
    pub(super) fn sizes(&self, vector: &[f64]) -> Vec<f64> {
        let mut sizes = vec![0.0; self.interfaces()];
        for (owner, x) in self.owners().zip(vector) {
            sizes[owner] = f64::hypot(sizes[owner], *x);
        }
        sizes
    }

    /// Returns the derivative of an effort with respect to each friction component.
    pub(super) fn slopes(&self, actuator: usize) -> Vec<f64> {
        (0..self.len()).map(|component| self.responses.effort(component, actuator)).collect()
    }

    /// Returns the derivative of the acceleration of a local degree of freedom with respect to each
    /// friction component.
    pub(super) fn spin_slopes(&self, spin: usize) -> Vec<f64> {
        (0..self.len()).map(|component| self.responses.spin(component, spin)).collect()
    }

    /// Returns the friction coefficients of an interface for forward sliding (positive friction)
    /// and backward sliding (negative friction).
    pub(super) fn coefficients(&self, interface: usize) -> [f64; 2] {
        let state = &self.inverse.interfaces()[interface];
        if state.sliding > 0.0 {
            return [state.resistance.coefficient; 2];
        }
        let content = &self.parameters.interfaces[interface];
        content.laws().map(|law| law.at_rest())
    }

    /// Returns true if an interface is at rest.
    pub(super) fn rests(&self, interface: usize) -> bool {
        self.inverse.interfaces()[interface].sliding == 0.0
    }

    /// Returns the normal force of an interface without static friction, N.
    pub(super) fn load_without(&self, interface: usize) -> f64 {
        self.inverse.interfaces()[interface].load()
    }

    /// Computes the normal forces of all interfaces for the given friction components, N.
    pub(super) fn loads(&self, frictions: &[f64]) -> Vec<f64> {
        (0..self.interfaces())
            .map(|interface| {
                if !self.coupled {
                    return self.load_without(interface);
                }
                let content = &self.parameters.interfaces[interface];
                let wrench = self.inverse.joint_wrenches()[content.joint];
                let change = self.change(content.joint, frictions);
                let own = self.own(interface).map_or(0.0, |k| frictions[k]);
                self.load_of(interface, &content.load, wrench + change, own)
            })
            .collect()
    }

    /// Returns bounds of the influence of friction on normal forces. Entry (i, j) bounds the change
    /// of the normal force at interface i due to a friction of one newton at interface j in any
    /// direction. The bound does not depend on the initial friction, because normal forces are
    /// norms of the reaction, up to constants.
    pub(super) fn couplings(&self) -> Couplings {
        let count = self.interfaces();
        let mut matrix = DMatrix::zeros(count, count);
        if self.coupled {
            (0..count).for_each(|owner| self.bound_column(owner, (&[], &[]), &mut matrix));
        }
        Couplings::new(self, matrix)
    }

    /// Returns the bounds [`Self::couplings`], here `plain`, without the component of each friction
    /// in the span of the orthonormal vectors `without`.
    pub(super) fn couplings_without(&self, plain: &Couplings, without: &[&[f64]]) -> Couplings {
        let count = self.interfaces();
        if !self.coupled || without.len() == self.len() {
            return Couplings::new(self, DMatrix::zeros(count, count));
        }
        let mut matrix = plain.bounds.clone();
        // For each interface and each vector, the change of the wrench that this friction causes.
        let of_interface = |content: &InterfaceParameters<f64>| -> Vec<Wrench<f64>> {
            without.iter().map(|vector| self.change(content.joint, vector)).collect()
        };
        let removed: Vec<_> = self.parameters.interfaces.iter().map(of_interface).collect();
        for owner in 0..count {
            let mut own = self.responses.components(owner);
            if own.any(|k| without.iter().any(|vector| vector[k] != 0.0)) {
                self.bound_column(owner, (without, &removed), &mut matrix);
            }
        }
        Couplings::new(self, matrix)
    }

    /// Computes the column of an interface in the matrix of [`Self::couplings_without`]. `removed`
    /// contains, for each interface, the changes of its wrench that frictions equal to the vectors
    /// `without` cause.
    fn bound_column(
        &self,
        owner: usize,
        (without, removed): (&[&[f64]], &[Vec<Wrench<f64>>]),
        matrix: &mut DMatrix<f64>,
    ) {
        for i in 0..self.interfaces() {
            let content = &self.parameters.interfaces[i];
            let (map, joint, own) = (content.load.seminorm(), content.joint, self.own(i));
            let mut bound = 0.0;
            for k in self.responses.components(owner) {
                let mut change = self.responses.wrench(k, joint);
                let mut friction = if own == Some(k) { 1.0 } else { 0.0 };
                for (place, vector) in without.iter().enumerate() {
                    change += removed[i][place] * -vector[k];
                    friction -= own.map_or(0.0, |own| vector[own] * vector[k]);
                }
                // Follows from the triangle and Cauchy-Schwarz inequalities.
                bound = f64::hypot(bound, self.load_of(i, &map, change, friction));
            }
            matrix[(i, owner)] = bound;
        }
    }

    fn change(&self, joint: usize, frictions: &[f64]) -> Wrench<f64> {
        let mut sum = Wrench::zero();
        let acting = frictions.iter().enumerate().filter(|(_, friction)| **friction != 0.0);
        for (component, &friction) in acting {
            sum += self.responses.wrench(component, joint) * friction;
        }
        sum
    }

    /// Returns the first friction component of an interface.
    fn own(&self, interface: usize) -> Option<usize> {
        self.responses.components(interface).next()
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
        let state = &self.inverse.interfaces()[interface];
        let direction = if state.sliding > 0.0 { state.sense } else { 1.0 };
        let own = OwnFriction { coefficient: 0.0, constant, direction };
        let content = &self.parameters.interfaces[interface];
        let pitch = self.parameters.pitch[content.joint];
        normal_load(map, content, pitch, self.bodies, wrench, own).value
    }
}
