//! Linearised joint friction in the balance equations: changes to their rows, columns and
//! constants.
//!
//! Equation (F5) of the book's theory.

use super::Balance;
use crate::dynamics::interfaces::{Coupling, Interfaces};
use crate::dynamics::plan::BalancePlan;
use crate::kinematics::Bodies;
use crate::parameters::{InterfaceParameters, Parameters};
use crate::scalar::Scalar;
use crate::spatial::{Twist, Wrench};
use crate::topology::{Link, Role, Topology};

impl<T: Scalar> Balance<T> {
    /// Adds the linearised friction to the rows and columns of the balance equations. Friction is
    /// linearised about the wrenches in `joint_wrenches`, which must be those for which the normal
    /// forces were last updated.
    pub(in crate::dynamics) fn apply_friction(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        interfaces: &Interfaces<T>,
        coupling: Coupling,
    ) {
        let topology = &plan.topology;
        self.rows.copy_from_slice(&bodies.screws);
        self.tilted.copy_from_slice(&self.columns);
        self.constants.fill(T::zero());
        self.cut_constants.fill(Wrench::zero());
        // Describes the matrix that the caller factorises next.
        self.is_frictionless = coupling == Coupling::None;
        if coupling == Coupling::None {
            return;
        }
        for (interface, state) in parameters.interfaces.iter().zip(&interfaces.states) {
            let Role::Tree { node } = topology.role[interface.joint] else { continue };
            let (constant, slope) = state.linear(coupling, self.joint_wrenches[interface.joint]);
            let first = topology.nodes[node].tree_dofs.start;
            let reversed = matches!(topology.nodes[node].link, Link::Joint { reversed: true, .. });
            for (&against, dof) in state.against.iter().zip(interface.shape.dofs()) {
                // `slope` refers to the wrench that the predecessor exerts, `rows` to the wrench
                // that the parent in the tree exerts.
                let tilt = slope * against;
                if reversed {
                    self.rows[first + dof] += tilt;
                } else {
                    self.rows[first + dof] -= tilt;
                }
                self.constants[first + dof] += against * constant;
            }
        }
        for cut in 0..topology.cuts.len() {
            self.apply_friction_at_cut(topology, parameters, bodies, interfaces, coupling, cut);
        }
    }

    /// Computes the columns and the constant part of the wrench at a cut joint, including
    /// linearised friction. Each of them solves `wrench = u + sum of q slope.power(wrench)`, summed
    /// over the interfaces of the joint. Here `u` is a frictionless column or the constant part of
    /// the friction, and `q` is the wrench of an interface per newton of friction.
    fn apply_friction_at_cut(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        interfaces: &Interfaces<T>,
        coupling: Coupling,
        cut: usize,
    ) {
        let joint = topology.cuts[cut].joint;
        // Each joint type has at most two friction interfaces.
        let mut q = [Wrench::zero(); 2];
        let mut n = [Twist::zero(); 2];
        let mut constant = Wrench::zero();
        let range = parameters.interfaces_at[joint].clone();
        if range.is_empty() {
            return;
        }
        for (place, index) in range.take(2).enumerate() {
            let (interface, state) = (&parameters.interfaces[index], &interfaces.states[index]);
            let (force, slope) = state.linear(coupling, self.joint_wrenches[joint]);
            q[place] = bodies.wrench_of(topology, interface, state.against);
            n[place] = slope;
            constant += q[place] * force;
        }
        // (I - G) y = n(u), wrench = u + q y, with G_ab = n_a(q_b).
        let (g00, g01) = (n[0].power(q[0]), n[0].power(q[1]));
        let (g10, g11) = (n[1].power(q[0]), n[1].power(q[1]));
        let (a, d) = (T::one() - g00, T::one() - g11);
        let over = (a * d - g01 * g10).recip();
        let absorb = |u: Wrench<T>| {
            let (b0, b1) = (n[0].power(u), n[1].power(u));
            let y0 = (d * b0 + g01 * b1) * over;
            let y1 = (a * b1 + g10 * b0) * over;
            u + q[0] * y0 + q[1] * y1
        };
        for column in topology.cuts[cut].columns(topology.constraints) {
            self.tilted[column] = absorb(self.columns[column]);
        }
        self.cut_constants[cut] = absorb(constant);
    }

    /// Solves the balance for the friction of a single interface as the only load, using the
    /// frictionless matrix factorised by [`Self::factor_frictionless`]. `friction` contains the
    /// generalised force on each DOF of the interface per newton of friction, and the friction
    /// force, N. Solves in `passes` passes. Writes the actuator efforts that overcome this friction.
    pub(in crate::dynamics) fn apply_friction_alone(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        interface: &InterfaceParameters<T>,
        friction: ([T; 3], T),
        (passes, efforts): (usize, &mut [T]),
    ) {
        let topology = &plan.topology;
        self.set_friction_alone(topology, bodies, interface, friction);
        self.solve_factored(plan, parameters, bodies, passes);
        self.read_efforts(plan, parameters, bodies, &self.constants, efforts);
    }

    /// Sets the constants of the balance equations to the friction of a single interface. `against`
    /// contains the generalised force on each DOF of the interface per newton of friction, and
    /// `friction` is the friction force, N.
    pub(super) fn set_friction_alone(
        &mut self,
        topology: &Topology,
        bodies: &Bodies<T>,
        interface: &InterfaceParameters<T>,
        (against, friction): ([T; 3], T),
    ) {
        self.constants.fill(T::zero());
        self.cut_constants.fill(Wrench::zero());
        match topology.role[interface.joint] {
            Role::Tree { node } => {
                let first = topology.nodes[node].tree_dofs.start;
                for (&against, dof) in against.iter().zip(interface.shape.dofs()) {
                    self.constants[first + dof] = against * friction;
                }
            }
            Role::Cut { cut } => {
                self.cut_constants[cut] = bodies.wrench_of(topology, interface, against) * friction;
            }
        }
    }
}
