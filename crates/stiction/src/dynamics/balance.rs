//! The kernel that solves the balance for all reactions, given motion and linearised friction.
//!
//! Equations (B4), (B5) and (B6) of the book's theory.

use super::contacts::{ContactState, Contacts, Coupling, wrench_against};
use super::inverse::Setup;
use super::load::{AppliedLoad, demand_of_motion};
use super::plan::BalancePlan;
use super::spring::Pull;
use super::structure::{BalanceStructure, WeighedKind, Weighting};
use crate::joint::Motion;
use crate::kinematics::Bodies;
use crate::linalg::Elimination;
use crate::parameters::{ContactParameters, Parameters, Weights};
use crate::scalar::Scalar;
use crate::spatial::{Pose, Twist, Wrench};
use crate::topology::{Link, Role, Topology};

/// The balance and the scratch to solve it.
#[derive(Clone, Debug)]
pub(crate) struct Balance<T> {
    /// For each node what its body and all bodies beyond demand of the joints.
    demand: Vec<Wrench<T>>,
    /// For each spin and each of its nodes: what a unit acceleration of the spin adds to the demand.
    spin_demand: Vec<Vec<Wrench<T>>>,
    /// Unit wrenches of the columns, plain and tilted by friction.
    columns: Vec<Wrench<T>>,
    tilted: Vec<Wrench<T>>,
    /// For each freedom of the tree its equation: `row.power(wrench) = constant`.
    rows: Vec<Twist<T>>,
    constants: Vec<T>,
    /// For each cut the part of its wrench that friction makes without the columns.
    cut_constants: Vec<Wrench<T>>,
    /// The wrench at each node's link, parent on child, and at each cut, predecessor on successor.
    node_wrenches: Vec<Wrench<T>>,
    cut_wrenches: Vec<Wrench<T>>,
    entries: Vec<T>,
    factors: Vec<T>,
    right: Vec<T>,
    correction: Vec<T>,
    pub(super) unknowns: Vec<T>,
    /// The complete wrench at each joint, predecessor on successor.
    pub(super) joint_wrenches: Vec<Wrench<T>>,
}

impl<T: Scalar> Balance<T> {
    pub(super) fn new(
        topology: &Topology,
        structure: &BalanceStructure,
        program: &Elimination,
    ) -> Self {
        let zeros = |n| vec![T::zero(); n];
        let wrenches = |n| vec![Wrench::zero(); n];
        Self {
            demand: wrenches(topology.nodes.len()),
            spin_demand: structure.spin_nodes.iter().map(|nodes| wrenches(nodes.len())).collect(),
            columns: wrenches(structure.wrench_columns),
            tilted: wrenches(structure.wrench_columns),
            rows: vec![Twist::zero(); topology.freedoms()],
            constants: zeros(topology.freedoms()),
            cut_constants: wrenches(topology.cuts.len()),
            node_wrenches: wrenches(topology.nodes.len()),
            cut_wrenches: wrenches(topology.cuts.len()),
            entries: zeros(structure.entries.len()),
            factors: zeros(program.values()),
            right: zeros(structure.rows()),
            correction: zeros(structure.size()),
            unknowns: zeros(structure.size()),
            joint_wrenches: wrenches(topology.joint_types.len()),
        }
    }

    /// Whether there is the same room for everything.
    pub(super) fn fits(&self, other: &Self) -> bool {
        self.entries.len() == other.entries.len()
            && self.factors.len() == other.factors.len()
            && self.right.len() == other.right.len()
            && self.unknowns.len() == other.unknowns.len()
            && self.columns.len() == other.columns.len()
            && self.spin_demand.len() == other.spin_demand.len()
            && self.spin_demand.iter().zip(&other.spin_demand).all(|(a, b)| a.len() == b.len())
    }

    /// Takes over the motion, the loads and the pull of springs; nothing of friction.
    pub(super) fn load(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        loads: &[AppliedLoad<T>],
    ) {
        for (demand, node) in self.demand.iter_mut().zip(&topology.nodes) {
            *demand = demand_of_motion(parameters, bodies, node.body);
        }
        for load in loads {
            if let Some(node) = topology.node_of_body[load.body.0] {
                self.demand[node] -= load.wrench(bodies);
            }
        }
        self.load_springs(topology, parameters, bodies);
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
                let freedom = &joint_type.freedoms()[actuator.freedom];
                self.columns[topology.constraints + index] = freedom.effort(j, k);
            }
        }
    }

    /// What springs take off the demand of the joints. Not inlined: most mechanisms have none, and
    /// compilers take minutes over what kernels of nested scalars inline.
    #[inline(never)]
    fn load_springs(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) {
        for spring in &parameters.springs {
            let wrench = Pull::of(spring, bodies).wrench;
            let [from, to] = spring.ends.map(|body| topology.node_of_body[body]);
            if let Some(node) = to {
                self.demand[node] -= wrench;
            }
            if let Some(node) = from {
                self.demand[node] += wrench;
            }
        }
    }

    /// What unit accelerations of one idle spin demand: `accelerations` are those of the tree.
    pub(super) fn load_spin(
        &mut self,
        topology: &Topology,
        structure: &BalanceStructure,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        spin: usize,
        accelerations: &[T],
    ) {
        // Nodes are in the order of the tree: parents before children.
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

    /// Tilts rows and columns by friction. Needs the wrenches that the contacts were pressed with.
    pub(super) fn rub(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        contacts: &Contacts<T>,
        coupling: Coupling,
    ) {
        self.rows.copy_from_slice(&bodies.screws);
        self.tilted.copy_from_slice(&self.columns);
        self.constants.fill(T::zero());
        self.cut_constants.fill(Wrench::zero());
        if coupling == Coupling::None {
            return;
        }
        for (contact, state) in parameters.contacts.iter().zip(&contacts.states) {
            let Role::Tree { node } = topology.role[contact.joint] else { continue };
            let (constant, slope) = state.linear(coupling, self.joint_wrenches[contact.joint]);
            let first = topology.nodes[node].dofs.start;
            let reversed = matches!(topology.nodes[node].link, Link::Joint { reversed: true, .. });
            for (&against, freedom) in state.against.iter().zip(contact.shape.freedoms()) {
                // `slope` acts on the predecessor's wrench, rows on the parent's.
                let tilt = slope * against;
                if reversed {
                    self.rows[first + freedom] += tilt;
                } else {
                    self.rows[first + freedom] -= tilt;
                }
                self.constants[first + freedom] += against * constant;
            }
        }
        for cut in 0..topology.cuts.len() {
            self.rub_cut(topology, parameters, bodies, contacts, coupling, cut);
        }
    }

    /// A cut joint's wrench is `columns + sum of q (constant + slope.power(wrench))`, with `q` the
    /// efforts of each contact's friction: solved here for the wrench.
    fn rub_cut(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        contacts: &Contacts<T>,
        coupling: Coupling,
        cut: usize,
    ) {
        let joint = topology.cuts[cut].joint;
        // No joint type has more than two contacts.
        let mut q = [Wrench::zero(); 2];
        let mut n = [Twist::zero(); 2];
        let mut constant = Wrench::zero();
        let range = parameters.contacts_at[joint].clone();
        if range.is_empty() {
            return;
        }
        for (place, index) in range.take(2).enumerate() {
            let (contact, state) = (&parameters.contacts[index], &contacts.states[index]);
            let (force, slope) = state.linear(coupling, self.joint_wrenches[joint]);
            q[place] = wrench_against(topology, contact, state, bodies);
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

    /// Solves the balance with friction as it was made linear; `passes` beyond the first refine.
    /// Returns the product of the signs of the pivots.
    pub(super) fn solve(
        &mut self,
        topology: &Topology,
        structure: &BalanceStructure,
        program: &Elimination,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        passes: usize,
    ) -> T {
        self.assemble(topology, structure, parameters, bodies);
        let sign = program.factor(&self.entries, &mut self.factors);
        self.solve_factored(topology, structure, program, parameters, bodies, passes);
        sign
    }

    /// The reciprocal pivots of the last factorisation.
    pub(super) fn reciprocal_pivots(&self, program: &Elimination) -> Vec<T> {
        program.pivots().map(|slot| self.factors[slot]).collect()
    }

    /// What all wrenches follow from, under the same demand: those at the cuts, and accelerations of idle spins.
    pub(super) fn carried(&self, structure: &BalanceStructure) -> (Vec<Wrench<T>>, Vec<T>) {
        (
            self.cut_wrenches.clone(),
            self.unknowns[structure.wrench_columns..][..self.spin_demand.len()].to_vec(),
        )
    }

    /// Sets all wrenches to those that follow from the ones at the cuts and from accelerations of idle spins.
    pub(super) fn carry(
        &mut self,
        topology: &Topology,
        structure: &BalanceStructure,
        cuts: &[Wrench<T>],
        spins: &[T],
    ) {
        self.node_wrenches.copy_from_slice(&self.demand);
        self.cut_wrenches.fill(Wrench::zero());
        for (cut, wrench) in cuts.iter().enumerate() {
            self.add_at_cut(topology, cut, *wrench);
        }
        for ((nodes, demand), spin) in structure.spin_nodes.iter().zip(&self.spin_demand).zip(spins)
        {
            for (&node, &demand) in nodes.iter().zip(demand) {
                self.node_wrenches[node] += demand * *spin;
            }
        }
        self.collect(topology);
    }

    /// The same with the matrix as it was factored last.
    fn solve_factored(
        &mut self,
        topology: &Topology,
        structure: &BalanceStructure,
        program: &Elimination,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        passes: usize,
    ) {
        self.unknowns.fill(T::zero());
        self.node_wrenches.copy_from_slice(&self.demand);
        self.cut_wrenches.fill(Wrench::zero());
        for cut in 0..topology.cuts.len() {
            self.add_at_cut(topology, cut, self.cut_constants[cut]);
        }
        for _ in 0..passes {
            self.measure(topology, structure, parameters, bodies);
            program.solve(&self.factors, &mut self.right, &mut self.correction);
            self.correct(topology, structure);
        }
        self.collect(topology);
    }

    /// Becomes the frictionless balance of the same position as `other`, demanding nothing, and
    /// factors it.
    pub(super) fn rest_like(
        &mut self,
        other: &Self,
        setup: &Setup<'_>,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) {
        let BalancePlan { structure, program } = setup.balance;
        self.demand.fill(Wrench::zero());
        self.columns.copy_from_slice(&other.columns);
        for (demand, others) in self.spin_demand.iter_mut().zip(&other.spin_demand) {
            demand.copy_from_slice(others);
        }
        self.rows.copy_from_slice(&bodies.screws);
        self.tilted.copy_from_slice(&self.columns);
        self.assemble(setup.topology, structure, parameters, bodies);
        program.factor(&self.entries, &mut self.factors);
    }

    /// The balance of [`Self::rest_like`] with nothing but one contact's friction, as it is now;
    /// writes what the drives must do against it.
    pub(super) fn rub_alone(
        &mut self,
        setup: &Setup<'_>,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        contact: &ContactParameters<T>,
        state: &ContactState<T>,
        drives: &mut [T],
    ) {
        let topology = setup.topology;
        self.constants.fill(T::zero());
        self.cut_constants.fill(Wrench::zero());
        match topology.role[contact.joint] {
            Role::Tree { node } => {
                let first = topology.nodes[node].dofs.start;
                for (&against, freedom) in state.against.iter().zip(contact.shape.freedoms()) {
                    self.constants[first + freedom] = against * state.friction();
                }
            }
            Role::Cut { cut } => {
                let wrench = wrench_against(topology, contact, state, bodies);
                self.cut_constants[cut] = wrench * state.friction();
            }
        }
        let BalancePlan { structure, program } = setup.balance;
        let passes = setup.balance.passes();
        self.solve_factored(topology, structure, program, parameters, bodies, passes);
        self.read_drives(topology, bodies, &self.constants, drives);
    }

    /// What the actuators must do: the joint's effort on their freedoms, less friction's.
    pub(super) fn read_drives(
        &self,
        topology: &Topology,
        bodies: &Bodies<T>,
        friction_efforts: &[T],
        drives: &mut [T],
    ) {
        for (dof, content) in topology.dofs.iter().enumerate() {
            let (Some(actuator), Link::Joint { joint, reversed }) =
                (content.actuator, topology.nodes[content.node].link)
            else {
                continue;
            };
            let effort = bodies.screws[dof].power(self.joint_wrenches[joint]);
            let effort = if reversed { -effort } else { effort };
            drives[actuator] = effort - friction_efforts[dof];
        }
        for (index, &actuator) in topology.cut_actuators.iter().enumerate() {
            drives[actuator] = self.unknowns[topology.constraints + index];
        }
    }

    /// A wrench more at a cut joint, and what it takes off the joints of the tree.
    fn add_at_cut(&mut self, topology: &Topology, cut: usize, wrench: Wrench<T>) {
        self.cut_wrenches[cut] += wrench;
        for &(node, sign) in &topology.cuts[cut].path {
            if sign > 0.0 {
                self.node_wrenches[node] -= wrench;
            } else {
                self.node_wrenches[node] += wrench;
            }
        }
    }

    /// The matrix, in the order of [`BalanceStructure::pattern`].
    pub(super) fn assemble(
        &mut self,
        topology: &Topology,
        structure: &BalanceStructure,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) {
        let bordered = structure.weighting != Weighting::Determined;
        let mut at = 0;
        let mut push = |value: T| {
            self.entries[at] = value;
            at += 1;
        };
        let is_passive = |dof: &usize| topology.dofs[*dof].actuator.is_none();
        for (cut, columns) in topology.cuts.iter().zip(&structure.columns_of) {
            for &(node, sign) in &cut.path {
                let sign = T::from_f64(sign);
                for dof in topology.nodes[node].dofs.clone().filter(is_passive) {
                    for &column in columns {
                        push(self.rows[dof].power(self.tilted[column]) * sign);
                        if bordered {
                            push(bodies.screws[dof].power(self.columns[column]) * sign);
                        }
                    }
                }
            }
        }
        for (nodes, demands) in structure.spin_nodes.iter().zip(&self.spin_demand) {
            for (&node, &demand) in nodes.iter().zip(demands) {
                for dof in topology.nodes[node].dofs.clone().filter(is_passive) {
                    push(-self.rows[dof].power(demand));
                    if bordered {
                        push(-bodies.screws[dof].power(demand));
                    }
                }
            }
        }
        for weighed in &structure.weighed {
            match weighed.what {
                WeighedKind::CutDrive { column } => push(drive_weight(
                    topology,
                    parameters,
                    topology.cut_actuators[column - topology.constraints],
                )),
                WeighedKind::Drive { dof } => {
                    let weight = topology.dofs[dof]
                        .actuator
                        .map_or(T::zero(), |a| drive_weight(topology, parameters, a));
                    for &(a, sign_a) in &weighed.cuts {
                        for &k in &structure.columns_of[a] {
                            let left = bodies.screws[dof].power(self.columns[k]) * weight;
                            for &(b, sign_b) in &weighed.cuts {
                                let left = left * T::from_f64(sign_a * sign_b);
                                for &l in &structure.columns_of[b] {
                                    push(left * self.rows[dof].power(self.tilted[l]));
                                }
                            }
                        }
                    }
                }
                WeighedKind::Node(_) | WeighedKind::Cut(_) => {
                    let product = Product::at(topology, parameters, bodies, weighed.what);
                    for &(a, sign_a) in &weighed.cuts {
                        for &k in &structure.columns_of[a] {
                            for &(b, sign_b) in &weighed.cuts {
                                let sign = T::from_f64(sign_a * sign_b);
                                for &l in &structure.columns_of[b] {
                                    push(product.of(self.columns[k], self.tilted[l]) * sign);
                                }
                            }
                        }
                    }
                }
            }
        }
    }

    /// The right-hand side: what the present wrenches leave of every equation.
    fn measure(
        &mut self,
        topology: &Topology,
        structure: &BalanceStructure,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) {
        self.right.fill(T::zero());
        let first = structure.first_balance_row();
        for (right, &dof) in self.right[first..].iter_mut().zip(&structure.passive) {
            let wrench = self.node_wrenches[topology.dofs[dof].node];
            *right = self.rows[dof].power(wrench) - self.constants[dof];
        }
        if structure.weighting == Weighting::Determined {
            return;
        }
        // Multipliers act through the transposed balance, whose entries follow the balance's own.
        for (entry, value) in structure.entries.iter().zip(&self.entries) {
            if structure.multipliers().contains(&entry.column) {
                self.right[entry.row] -= *value * self.unknowns[entry.column];
            }
        }
        for weighed in &structure.weighed {
            match weighed.what {
                WeighedKind::CutDrive { column } => {
                    let actuator = topology.cut_actuators[column - topology.constraints];
                    let weight = drive_weight(topology, parameters, actuator);
                    self.right[column] -= weight * self.unknowns[column];
                }
                WeighedKind::Drive { dof } => {
                    let weight = topology.dofs[dof]
                        .actuator
                        .map_or(T::zero(), |a| drive_weight(topology, parameters, a));
                    let wrench = self.node_wrenches[topology.dofs[dof].node];
                    let drive = (self.rows[dof].power(wrench) - self.constants[dof]) * weight;
                    for &(cut, sign) in &weighed.cuts {
                        let drive = drive * T::from_f64(sign);
                        for &column in &structure.columns_of[cut] {
                            let change = bodies.screws[dof].power(self.columns[column]);
                            self.right[column] -= change * drive;
                        }
                    }
                }
                WeighedKind::Node(_) | WeighedKind::Cut(_) => {
                    let wrench = match weighed.what {
                        WeighedKind::Node(node) => self.node_wrenches[node],
                        WeighedKind::Cut(cut) => self.cut_wrenches[cut],
                        _ => Wrench::zero(),
                    };
                    let product = Product::at(topology, parameters, bodies, weighed.what);
                    for &(cut, sign) in &weighed.cuts {
                        for &column in &structure.columns_of[cut] {
                            let product = product.of(self.columns[column], wrench);
                            self.right[column] -= product * T::from_f64(sign);
                        }
                    }
                }
            }
        }
    }

    /// How well the equations of the tree's undriven freedoms hold: the largest residual, the
    /// largest demand of a body with all beyond, and the largest wrench at a joint; moments divided
    /// by the characteristic length.
    pub(super) fn size_of_residual(
        &self,
        topology: &Topology,
        structure: &BalanceStructure,
        parameters: &Parameters<T>,
    ) -> (f64, f64, f64) {
        let length = parameters.length.largest();
        let mut residual: f64 = 0.0;
        for &dof in &structure.passive {
            let content = &topology.dofs[dof];
            let wrench = self.node_wrenches[content.node];
            let error = (self.rows[dof].power(wrench) - self.constants[dof]).largest();
            let error = if topology.dof_translates(content) { error } else { error / length };
            residual = if error.is_nan() { f64::INFINITY } else { residual.max(error) };
        }
        let size = |wrench: &Wrench<T>| {
            let force = wrench.force.to_array().map(T::largest);
            let moment = wrench.moment.to_array().map(|m| m.largest() / length);
            force
                .into_iter()
                .chain(moment)
                .fold(0.0, |max, c| if c > max || c.is_nan() { c } else { max })
        };
        let largest = |wrenches: &[Wrench<T>]| wrenches.iter().map(size).fold(0.0, f64::max);
        (residual, largest(&self.demand), largest(&self.joint_wrenches))
    }

    /// Adds the correction to the unknowns and to all wrenches.
    fn correct(&mut self, topology: &Topology, structure: &BalanceStructure) {
        for (unknown, correction) in self.unknowns.iter_mut().zip(&self.correction) {
            *unknown += *correction;
        }
        for (cut, columns) in structure.columns_of.iter().enumerate() {
            let mut change = Wrench::zero();
            for &column in columns {
                change += self.tilted[column] * self.correction[column];
            }
            self.add_at_cut(topology, cut, change);
        }
        for (spin, nodes) in structure.spin_nodes.iter().enumerate() {
            let change = self.correction[structure.wrench_columns + spin];
            for (&node, &demand) in nodes.iter().zip(&self.spin_demand[spin]) {
                self.node_wrenches[node] += demand * change;
            }
        }
    }

    /// The complete wrench at every joint.
    fn collect(&mut self, topology: &Topology) {
        for (joint, role) in topology.role.iter().enumerate() {
            self.joint_wrenches[joint] = match *role {
                Role::Cut { cut } => self.cut_wrenches[cut],
                Role::Tree { node } => match topology.nodes[node].link {
                    Link::Joint { reversed: true, .. } => -self.node_wrenches[node],
                    _ => self.node_wrenches[node],
                },
            };
        }
    }
}

impl Balance<f64> {
    /// The entries of the matrix, after [`Self::assemble`].
    pub(super) fn into_entries(self) -> Vec<f64> {
        self.entries
    }

    /// The drives that belong to given unknowns and to no demand at all, without friction.
    pub(super) fn drives_of(
        &mut self,
        topology: &Topology,
        structure: &BalanceStructure,
        bodies: &Bodies<f64>,
        unknowns: &[f64],
    ) -> Vec<f64> {
        self.tilted.copy_from_slice(&self.columns);
        self.node_wrenches.fill(Wrench::zero());
        self.cut_wrenches.fill(Wrench::zero());
        self.unknowns.fill(0.0);
        self.correction[..unknowns.len()].copy_from_slice(unknowns);
        self.correct(topology, structure);
        let mut drives = vec![0.0; topology.actuators.len()];
        for (dof, content) in topology.dofs.iter().enumerate() {
            if let Some(actuator) = content.actuator {
                drives[actuator] = bodies.screws[dof].power(self.node_wrenches[content.node]);
            }
        }
        for (index, &actuator) in topology.cut_actuators.iter().enumerate() {
            drives[actuator] = self.unknowns[topology.constraints + index];
        }
        drives
    }
}

/// Adds the wrenches of children to those of their parents.
fn accumulate<T: Scalar>(topology: &Topology, wrenches: &mut [Wrench<T>]) {
    for (index, node) in topology.nodes.iter().enumerate().rev() {
        if let (Link::Joint { .. }, Some(parent)) = (node.link, node.parent) {
            let wrench = wrenches[index];
            wrenches[parent] += wrench;
        }
    }
}

/// The acceleration of a node's body in the response to a spin.
fn spin_twist<T: Scalar>(
    topology: &Topology,
    bodies: &Bodies<T>,
    node: usize,
    accelerations: &[T],
) -> Twist<T> {
    let mut twist = Twist::zero();
    let mut next = Some(node);
    while let Some(node) = next {
        for dof in topology.nodes[node].dofs.clone() {
            twist += bodies.screws[dof] * accelerations[dof];
        }
        next = topology.nodes[node].parent;
    }
    twist
}

/// Efforts of rotary actuators count divided by the characteristic length.
fn drive_weight<T: Scalar>(topology: &Topology, parameters: &Parameters<T>, actuator: usize) -> T {
    let actuator = topology.actuators[actuator];
    let freedom = &topology.joint_types[actuator.joint].freedoms()[actuator.freedom];
    match freedom.motion {
        Motion::Translation => T::one(),
        Motion::Rotation | Motion::Screw => (parameters.length * parameters.length).recip(),
    }
}

/// The product in which reactions are least, at one joint: see [`Weighting::LeastReactions`] and
/// [`Weighting::LeastEnergy`].
struct Product<'a, T> {
    frame_j: Pose<T>,
    length: T,
    declared: Option<&'a Weights<T>>,
}

impl<'a, T: Scalar> Product<'a, T> {
    fn at(
        topology: &Topology,
        parameters: &'a Parameters<T>,
        bodies: &Bodies<T>,
        what: WeighedKind,
    ) -> Self {
        let joint = match what {
            WeighedKind::Cut(cut) => Some(topology.cuts[cut].joint),
            WeighedKind::Node(node) => match topology.nodes[node].link {
                Link::Joint { joint, .. } => Some(joint),
                Link::Floating => None,
            },
            WeighedKind::Drive { .. } | WeighedKind::CutDrive { .. } => None,
        };
        Self {
            frame_j: joint.map_or(Pose::identity(), |joint| bodies.frame_j[joint]),
            length: parameters.length,
            declared: joint.and_then(|joint| parameters.compliance.as_ref()?.get(joint)),
        }
    }

    fn of(&self, a: Wrench<T>, b: Wrench<T>) -> T {
        if let Some(weights) = self.declared {
            return weights.product(&self.frame_j, a, b);
        }
        let point = self.frame_j.position;
        let moments = a.moment_about(point).dot(b.moment_about(point));
        a.force.dot(b.force) + moments / (self.length * self.length)
    }
}
