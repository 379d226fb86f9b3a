//! Wrenches that motion, external loads, springs and rotors require, and unit wrenches at cut
//! joints.
//!
//! Equation (B4) of the book's theory.

use super::Balance;
use crate::dynamics::plan::BalancePlan;
use crate::dynamics::rotor::RotorMotion;
use crate::dynamics::spring::spring_wrenches;
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::spatial::{Twist, Vec3, Wrench};
use crate::statics::{AppliedLoad, demand_of_motion};
use crate::topology::{Link, Topology};

impl<T: Scalar> Balance<T> {
    /// Computes the loads of the balance without friction: the wrench that motion, external loads,
    /// springs and rotors require at each node, and the unit wrenches at cut joints.
    pub(in crate::dynamics) fn load(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        loads: &[AppliedLoad<T>],
    ) {
        let topology = &plan.topology;
        self.is_frictionless = false;
        for (demand, node) in self.demand.iter_mut().zip(&topology.nodes) {
            *demand = demand_of_motion(parameters, bodies, node.body);
        }
        for load in loads {
            if let Some(node) = topology.node_of_body[load.body.0] {
                self.demand[node] -= load.wrench(bodies);
            }
        }
        self.load_springs(topology, parameters, bodies);
        self.load_rotors(topology, parameters, bodies);
        accumulate(topology, &mut self.demand);
        for cut in &topology.cuts {
            let joint_type = topology.joint_types[cut.joint];
            let (j, k) = (&bodies.frame_j[cut.joint], &bodies.frame_k[cut.joint]);
            let pitch = parameters.pitch[cut.joint];
            for (column, constraint) in cut.constraints.clone().zip(joint_type.constraints()) {
                self.columns[column] = constraint.wrench(j, k, pitch);
            }
            for index in cut.actuators.clone() {
                let actuator = topology.actuators[topology.cut_actuators[index]];
                let dof = &joint_type.dofs()[actuator.dof];
                self.columns[topology.constraints + index] = dof.effort(j, k);
            }
        }
    }

    /// Solves the balance for a wrench that a body requires as the only load, using the frictionless
    /// matrix factorised by [`Self::factor_frictionless`], in `passes` passes.
    pub(in crate::dynamics) fn apply_demand_alone(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        (body, wrench): (usize, Wrench<T>),
        passes: usize,
    ) {
        let topology = &plan.topology;
        self.constants.fill(T::zero());
        self.cut_constants.fill(Wrench::zero());
        if let Some(node) = topology.node_of_body[body] {
            self.demand[node] = wrench;
        }
        accumulate(topology, &mut self.demand);
        self.solve_factored(plan, parameters, bodies, passes);
        self.demand.fill(Wrench::zero());
    }

    /// Subtracts the wrenches of springs and bushings from the wrenches that the nodes require.
    fn load_springs(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) {
        spring_wrenches(parameters, bodies, |ends, wrench| {
            let [from, to] = ends.map(|body| topology.node_of_body[body]);
            if let Some(node) = to {
                self.demand[node] -= wrench;
            }
            if let Some(node) = from {
                self.demand[node] += wrench;
            }
        });
    }

    /// Adds the gyroscopic and inertial moments of spinning rotors to the wrenches that the nodes
    /// require.
    #[inline(never)]
    fn load_rotors(&mut self, topology: &Topology, parameters: &Parameters<T>, bodies: &Bodies<T>) {
        for rotor in &parameters.rotors {
            if let Some(node) = topology.node_of_body[rotor.body] {
                let moment = RotorMotion::of(rotor, topology, parameters, bodies).moment;
                self.demand[node] += Wrench { force: Vec3::zero(), moment };
            }
        }
    }

    /// Computes the inertia wrenches of the nodes, including their descendants, per unit
    /// acceleration of the local degree of freedom with index `spin`. `accelerations` are the
    /// accelerations of the DOFs of the spanning tree that result from this unit acceleration.
    pub(in crate::dynamics) fn load_spin(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        spin: usize,
        accelerations: &[T],
    ) {
        let BalancePlan { topology, structure, .. } = plan;
        // Nodes are in tree order: parents precede children.
        let nodes = &structure.spin_nodes[spin];
        for (place, &node) in nodes.iter().enumerate() {
            let twist = spin_twist(topology, bodies, node, accelerations);
            let body = topology.nodes[node].body;
            let pose = bodies.pose[body];
            let com = pose.apply(parameters.com[body]);
            let force = twist.velocity_at(com) * parameters.mass[body];
            let turning = pose.rotation.transpose_mul(twist.angular);
            let moment = pose.rotation * (parameters.inertia[body] * turning);
            self.spin_demand[spin][place] = Wrench { force, moment: moment + com.cross(force) };
        }
        for place in (0..nodes.len()).rev() {
            let parent = topology.nodes[nodes[place]].parent;
            if let Some(above) = parent.and_then(|p| nodes.binary_search(&p).ok()) {
                let demand = self.spin_demand[spin][place];
                self.spin_demand[spin][above] += demand;
            }
        }
    }
}

/// Adds the wrench of each child node to the wrench of its parent, from the leaves to the root.
fn accumulate<T: Scalar>(topology: &Topology, wrenches: &mut [Wrench<T>]) {
    for (index, node) in topology.nodes.iter().enumerate().rev() {
        if let (Link::Joint { .. }, Some(parent)) = (node.link, node.parent) {
            let wrench = wrenches[index];
            wrenches[parent] += wrench;
        }
    }
}

/// Returns the acceleration of the body of a node per unit acceleration of a local degree of
/// freedom. `accelerations` are the resulting accelerations of the DOFs of the spanning tree.
fn spin_twist<T: Scalar>(
    topology: &Topology,
    bodies: &Bodies<T>,
    node: usize,
    accelerations: &[T],
) -> Twist<T> {
    let mut twist = Twist::zero();
    let mut next = Some(node);
    while let Some(node) = next {
        for tree_dof in topology.nodes[node].tree_dofs.clone() {
            twist += bodies.screws[tree_dof] * accelerations[tree_dof];
        }
        next = topology.nodes[node].parent;
    }
    twist
}
