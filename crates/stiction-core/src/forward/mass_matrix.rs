//! Mass matrix of the spanning tree, and the bias forces due to inertia, gravity, loads and
//! springs.

use super::rotors::{Rotor, RotorPart, RotorTerm};
use crate::dynamics::{RotorMotion, spring_powers, spring_wrenches};
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Twist, Vec3, Wrench};
use crate::statics::{AppliedLoad, demand_of_motion};
use crate::topology::{Link, Topology};

/// Inertia of a body or of several rigidly connected bodies, about the reference point in world
/// axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inertia {
    mass: f64,
    /// Mass times position of the centre of mass, kg m.
    moment: Vec3<f64>,
    /// Inertia tensor about the reference point, kg m^2.
    second: Mat3<f64>,
}

impl Inertia {
    fn of(parameters: &Parameters<f64>, bodies: &Bodies<f64>, body: usize) -> Self {
        let pose = bodies.pose[body];
        let (mass, com) = (parameters.mass[body], pose.apply(parameters.com[body]));
        let about_com = pose.rotation * parameters.inertia[body] * pose.rotation.transpose();
        let square = com.norm_squared();
        let column = |k: usize| {
            let e: Vec3<f64> = Vec3::unit(k);
            (e * square - com * com.component(k)) * mass
        };
        let steiner = Mat3::from_columns(column(0), column(1), column(2));
        Self { mass, moment: com * mass, second: about_com + steiner }
    }

    fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.moment += other.moment;
        self.second = self.second + other.second;
    }

    /// Returns the product of the inertia with a twist: the momentum for a velocity, or the inertia
    /// wrench for an acceleration.
    #[inline(always)]
    pub(super) fn times<T: Scalar>(&self, twist: Twist<T>) -> Wrench<T> {
        let (mass, moment) = (T::from_f64(self.mass), self.moment.lift());
        let second = self.second.lift();
        Wrench {
            force: twist.linear * mass + twist.angular.cross(moment),
            moment: second * twist.angular + moment.cross(twist.linear),
        }
    }
}

/// Inertias and bias forces at one configuration and velocity, from which the mass matrix is
/// computed.
#[derive(Clone, Debug, Default)]
pub(super) struct MassMatrix {
    /// Inertia of each body.
    pub(super) inertia: Vec<Inertia>,
    /// Wrench that the joints must exert on each body if all accelerations of the spanning tree are
    /// zero.
    pub(super) bias_wrenches: Vec<Wrench<f64>>,
    /// Generalised forces of the bias wrenches on the DOFs of the spanning tree.
    pub(super) bias: Vec<f64>,
    /// Rotors of drive trains at the present configuration and velocity.
    pub(super) rotors: Vec<RotorTerm>,
    /// Joints that move each rotor, concatenated for all rotors.
    pub(super) rotor_parts: Vec<RotorPart>,
    pub(super) rotor_rows: Vec<f64>,
    /// One row for each rotor: effort on the output coordinate that accelerates the rotor, per
    /// acceleration of each DOF of the spanning tree.
    pub(super) taken_rows: Vec<f64>,
    /// Composite rigid-body inertia of each subtree.
    pub(super) composite: Vec<Inertia>,
    /// Buffer: bias wrench of each subtree, about the reference point.
    subtree_wrenches: Vec<Wrench<f64>>,
}

impl MassMatrix {
    /// Computes inertias and bias forces. Beforehand [`Bodies::place`] and [`Bodies::move_with`]
    /// must have set the poses and twists of the bodies.
    pub(super) fn new(
        topology: &Topology,
        (parameters, rotors): (&Parameters<f64>, &[Rotor]),
        bodies: &mut Bodies<f64>,
        loads: &[AppliedLoad<f64>],
    ) -> Self {
        let mut masses = Self::default();
        masses.update(topology, (parameters, rotors), bodies, loads);
        masses
    }

    /// Recomputes inertias and bias forces like [`Self::new`], reusing the buffers.
    pub(super) fn update(
        &mut self,
        topology: &Topology,
        (parameters, rotors): (&Parameters<f64>, &[Rotor]),
        bodies: &mut Bodies<f64>,
        loads: &[AppliedLoad<f64>],
    ) {
        let count = bodies.pose.len();
        let n = topology.dofs();
        let Self { inertia, bias_wrenches, bias, composite, subtree_wrenches, .. } = self;
        inertia.clear();
        inertia.extend((0..count).map(|b| Inertia::of(parameters, bodies, b)));
        bodies.acceleration.clone_from(&bodies.bias);
        bias_wrenches.clear();
        bias_wrenches.extend((0..count).map(|body| match body {
            0 => Wrench::zero(),
            _ => demand_of_motion(parameters, bodies, body),
        }));
        for load in loads {
            bias_wrenches[load.body.0] -= load.wrench(bodies);
        }
        spring_wrenches(parameters, bodies, |[from, to], wrench| {
            bias_wrenches[to] -= wrench;
            bias_wrenches[from] += wrench;
        });
        for rotor in &parameters.rotors {
            let moment = RotorMotion::of(rotor, topology, parameters, bodies).moment;
            bias_wrenches[rotor.body] += Wrench { force: Vec3::zero(), moment };
        }
        composite.clone_from(inertia);
        subtree_wrenches.clone_from(bias_wrenches);
        bias.clear();
        bias.resize(n, 0.0);
        for node in topology.nodes.iter().rev() {
            let whole = composite[node.body];
            for tree_dof in node.tree_dofs.clone() {
                bias[tree_dof] = bodies.screws[tree_dof].power(subtree_wrenches[node.body]);
            }
            if let (Link::Joint { .. }, Some(parent)) = (node.link, node.parent) {
                let parent = topology.nodes[parent].body;
                composite[parent].add(&whole);
                let wrench = subtree_wrenches[node.body];
                subtree_wrenches[parent] += wrench;
            }
        }
        self.update_rotors((topology, parameters), rotors, bodies);
    }

    /// Writes the mass matrix of the spanning tree, row-major, reusing the buffer. The size of the
    /// matrix is quadratic in the number of degrees of freedom, so only the dense solver uses it.
    pub(super) fn matrix_into(
        &self,
        topology: &Topology,
        bodies: &Bodies<f64>,
        matrix: &mut Vec<f64>,
    ) {
        let n = topology.dofs();
        matrix.clear();
        matrix.resize(n * n, 0.0);
        for node in topology.nodes.iter().rev() {
            let whole = self.composite[node.body];
            for tree_dof in node.tree_dofs.clone() {
                let momentum = whole.times(bodies.screws[tree_dof]);
                let mut next = Some(node);
                while let Some(above) = next {
                    for other in above.tree_dofs.clone() {
                        let entry = bodies.screws[other].power(momentum);
                        matrix[tree_dof * n + other] = entry;
                        matrix[other * n + tree_dof] = entry;
                    }
                    next = above.parent.map(|parent| &topology.nodes[parent]);
                }
            }
        }
        let rows =
            self.rotor_rows.chunks_exact(n.max(1)).zip(self.taken_rows.chunks_exact(n.max(1)));
        for (term, (row, taken)) in self.rotors.iter().zip(rows) {
            for (i, a) in row.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                for (entry, b) in matrix[i * n..][..n].iter_mut().zip(taken) {
                    *entry += a * b;
                }
            }
            // Moment that the rotor exerts on the carrying body.
            if let Some((body, momentum)) = term.carrier {
                let mut next = topology.node_of_body[body];
                while let Some(node) = next {
                    for i in topology.nodes[node].tree_dofs.clone() {
                        let spin = momentum.dot(bodies.screws[i].angular);
                        for (entry, a) in matrix[i * n..][..n].iter_mut().zip(row) {
                            *entry += spin * a;
                        }
                    }
                    next = topology.nodes[node].parent;
                }
            }
        }
    }

    /// Computes the terms and matrix rows of the rotors, and adds the efforts that accelerate the
    /// rotors to the bias forces.
    fn update_rotors(
        &mut self,
        (topology, parameters): (&Topology, &Parameters<f64>),
        rotors: &[Rotor],
        bodies: &Bodies<f64>,
    ) {
        let n = topology.dofs();
        let Self { bias, rotors: terms, rotor_parts, rotor_rows, taken_rows, .. } = self;
        terms.clear();
        rotor_parts.clear();
        rotor_rows.clear();
        rotor_rows.resize(rotors.len() * n, 0.0);
        taken_rows.clear();
        taken_rows.resize(rotors.len() * n, 0.0);
        let rows = rotor_rows.chunks_exact_mut(n.max(1)).zip(taken_rows.chunks_exact_mut(n.max(1)));
        for (rotor, (row, taken)) in rotors.iter().zip(rows) {
            let term =
                rotor.at((topology, parameters), bodies, (&mut *row, &mut *taken), rotor_parts);
            for (bias, a) in bias.iter_mut().zip(&*row).filter(|(_, a)| **a != 0.0) {
                *bias += a * term.bias;
            }
            terms.push(term);
        }
    }

    /// Returns the kinetic energy of bodies and rotors, J.
    pub(super) fn kinetic(&self, bodies: &Bodies<f64>) -> f64 {
        let each = self.inertia.iter().zip(&bodies.twist);
        let of_bodies = each.map(|(inertia, twist)| 0.5 * twist.power(inertia.times(*twist)));
        let of_rotors =
            self.rotors.iter().map(|rotor| rotor.kinetic(&self.rotor_parts, &bodies.twist));
        of_bodies.chain(of_rotors).sum()
    }
}

/// Returns the potential energy of gravity (zero at the reference point) and of springs, J.
pub(super) fn potential(parameters: &Parameters<f64>, bodies: &Bodies<f64>) -> f64 {
    let of_body = |body: usize| {
        let com = bodies.pose[body].apply(parameters.com[body]);
        -parameters.mass[body] * parameters.gravity.dot(com)
    };
    let of_springs = spring_powers(parameters, bodies).map(|spring| spring.energy);
    (1..bodies.pose.len()).map(of_body).chain(of_springs).sum()
}

/// Returns the power dissipated by the dampers of springs, W. The twists in `bodies` must be up to
/// date.
pub(super) fn damped<T: Scalar>(parameters: &Parameters<T>, bodies: &Bodies<T>) -> T {
    sum(spring_powers(parameters, bodies).map(|spring| spring.dissipated))
}

/// Returns the power of all external loads, W. The twists in `bodies` must be up to date.
pub(super) fn power_of_loads<T: Scalar>(loads: &[AppliedLoad<T>], bodies: &Bodies<T>) -> T {
    sum(loads.iter().map(|load| bodies.twist[load.body.0].power(load.wrench(bodies))))
}

/// Returns the rate of change of the potential energy of gravity and springs, W. The twists in
/// `bodies` must be up to date.
pub(super) fn exchange<T: Scalar>(parameters: &Parameters<T>, bodies: &Bodies<T>) -> T {
    let of_body = |body: usize| {
        let com = bodies.pose[body].apply(parameters.com[body]);
        let velocity = bodies.twist[body].velocity_at(com);
        -parameters.mass[body] * parameters.gravity.dot(velocity)
    };
    let of_springs = spring_powers(parameters, bodies).map(|spring| spring.energy_rate);
    sum((1..bodies.pose.len()).map(of_body).chain(of_springs))
}

fn sum<T: Scalar>(terms: impl Iterator<Item = T>) -> T {
    terms.fold(T::zero(), |sum, term| sum + term)
}
