//! Matrix and residual of the balance. If there are more unknowns than equations, the matrix
//! includes the weighting that selects a solution.
//!
//! Equations (B5) and (B8) of the book's theory.

use super::Balance;
use crate::dynamics::plan::BalancePlan;
use crate::dynamics::structure::{WeighedKind, Weighting};
use crate::joint::Motion;
use crate::kinematics::Bodies;
use crate::parameters::{Parameters, Weights};
use crate::scalar::Scalar;
use crate::spatial::{Pose, Wrench};
use crate::topology::{Link, Topology};

impl<T: Scalar> Balance<T> {
    /// Computes the matrix entries in the order of
    /// [`BalanceStructure::pattern`](crate::dynamics::structure::BalanceStructure).
    pub(in crate::dynamics) fn assemble(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) {
        let BalancePlan { topology, structure, .. } = plan;
        let bordered = structure.weighting != Weighting::Determined;
        let mut at = 0;
        let mut push = |value: T| {
            self.entries[at] = value;
            at += 1;
        };
        let is_passive = |tree_dof: &usize| topology.tree_dofs[*tree_dof].actuator.is_none();
        for (cut, columns) in topology.cuts.iter().zip(&structure.columns_of) {
            for &(node, sign) in &cut.path {
                let sign = T::from_f64(sign);
                for tree_dof in topology.nodes[node].tree_dofs.clone().filter(is_passive) {
                    for &column in columns {
                        push(self.rows[tree_dof].power(self.tilted[column]) * sign);
                        if bordered {
                            push(bodies.screws[tree_dof].power(self.columns[column]) * sign);
                        }
                    }
                }
            }
        }
        for (nodes, demands) in structure.spin_nodes.iter().zip(&self.spin_demand) {
            for (&node, &demand) in nodes.iter().zip(demands) {
                for tree_dof in topology.nodes[node].tree_dofs.clone().filter(is_passive) {
                    push(-self.rows[tree_dof].power(demand));
                    if bordered {
                        push(-bodies.screws[tree_dof].power(demand));
                    }
                }
            }
        }
        for gearing in &structure.gearings {
            let coefficients = &parameters.gearings[gearing.gearing].coefficients;
            for ((_, equation), &coefficient) in gearing.dofs.iter().zip(coefficients) {
                if equation.is_some() {
                    push(coefficient);
                    if bordered {
                        push(coefficient);
                    }
                }
            }
        }
        for weighed in &structure.weighed {
            match weighed.what {
                WeighedKind::CutActuator { column } => push(effort_weight(
                    topology,
                    parameters,
                    topology.cut_actuators[column - topology.constraints],
                )),
                WeighedKind::Actuator { tree_dof } => {
                    let weight = topology.tree_dofs[tree_dof]
                        .actuator
                        .map_or(T::zero(), |a| effort_weight(topology, parameters, a));
                    for &(a, sign_a) in &weighed.cuts {
                        for &k in &structure.columns_of[a] {
                            let left = bodies.screws[tree_dof].power(self.columns[k]) * weight;
                            for &(b, sign_b) in &weighed.cuts {
                                let left = left * T::from_f64(sign_a * sign_b);
                                for &l in &structure.columns_of[b] {
                                    push(left * self.rows[tree_dof].power(self.tilted[l]));
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

    /// Computes the right-hand side: the residual of every equation at the present wrenches.
    pub(super) fn measure(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) {
        let BalancePlan { topology, structure, .. } = plan;
        self.right.fill(T::zero());
        let first = structure.first_balance_row();
        for (right, &tree_dof) in self.right[first..].iter_mut().zip(&structure.passive) {
            let wrench = self.node_wrenches[topology.tree_dofs[tree_dof].node];
            *right = self.rows[tree_dof].power(wrench) - self.constants[tree_dof];
        }
        for (index, gearing) in structure.gearings.iter().enumerate() {
            let multiplier = self.unknowns[structure.first_gearing() + index];
            let coefficients = &parameters.gearings[gearing.gearing].coefficients;
            for ((_, equation), &coefficient) in gearing.dofs.iter().zip(coefficients) {
                if let Some(equation) = equation {
                    self.right[first + equation] -= coefficient * multiplier;
                }
            }
        }
        if structure.weighting == Weighting::Determined {
            return;
        }
        // Lagrange multipliers act through the transposed balance matrix.
        for (entry, value) in structure.entries.iter().zip(&self.entries) {
            if structure.multipliers().contains(&entry.column) {
                self.right[entry.row] -= *value * self.unknowns[entry.column];
            }
        }
        for weighed in &structure.weighed {
            match weighed.what {
                WeighedKind::CutActuator { column } => {
                    let actuator = topology.cut_actuators[column - topology.constraints];
                    let weight = effort_weight(topology, parameters, actuator);
                    self.right[column] -= weight * self.unknowns[column];
                }
                WeighedKind::Actuator { tree_dof } => {
                    let weight = topology.tree_dofs[tree_dof]
                        .actuator
                        .map_or(T::zero(), |a| effort_weight(topology, parameters, a));
                    let wrench = self.node_wrenches[topology.tree_dofs[tree_dof].node];
                    let drive =
                        (self.rows[tree_dof].power(wrench) - self.constants[tree_dof]) * weight;
                    for &(cut, sign) in &weighed.cuts {
                        let drive = drive * T::from_f64(sign);
                        for &column in &structure.columns_of[cut] {
                            let change = bodies.screws[tree_dof].power(self.columns[column]);
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

    /// Returns three magnitudes, N: the largest residual in the equations of the unactuated tree
    /// DOFs, the largest inverse-dynamics wrench of a body including all its descendants in the
    /// spanning tree, and the largest joint wrench. Moments are divided by the characteristic
    /// length.
    pub(in crate::dynamics) fn size_of_residual(
        &self,
        plan: &BalancePlan,
        parameters: &Parameters<T>,
    ) -> (f64, f64, f64) {
        let BalancePlan { topology, structure, .. } = plan;
        let length = parameters.length.largest();
        let mut residual: f64 = 0.0;
        for (equation, &tree_dof) in structure.passive.iter().enumerate() {
            let content = &topology.tree_dofs[tree_dof];
            let wrench = self.node_wrenches[content.node];
            let mut error = self.rows[tree_dof].power(wrench) - self.constants[tree_dof];
            for (index, gearing) in structure.gearings.iter().enumerate() {
                let coefficients = &parameters.gearings[gearing.gearing].coefficients;
                let own = gearing.dofs.iter().position(|(_, known)| *known == Some(equation));
                if let Some(own) = own {
                    let multiplier = self.unknowns[structure.first_gearing() + index];
                    error -= coefficients[own] * multiplier;
                }
            }
            let error = error.largest();
            let error = if topology.tree_dof_translates(content) { error } else { error / length };
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
}

/// Returns the weight of the square of an actuator effort: one for a force, `1 / length^2` for a
/// torque, where `length` is the characteristic length.
fn effort_weight<T: Scalar>(topology: &Topology, parameters: &Parameters<T>, actuator: usize) -> T {
    let actuator = topology.actuators[actuator];
    let dof = &topology.joint_types[actuator.joint].dofs()[actuator.dof];
    match dof.motion {
        Motion::Translation => T::one(),
        Motion::Rotation | Motion::Screw => (parameters.length * parameters.length).recip(),
    }
}

/// Inner product of two wrenches at one joint. The weighting minimises the norm defined by this
/// product, see [`Weighting::LeastReactions`] and [`Weighting::LeastEnergy`].
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
            WeighedKind::Actuator { .. } | WeighedKind::CutActuator { .. } => None,
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
