//! Wrenches that gears transmit from their motors to the driven joints.
//!
//! A gear connects its motor to a joint, and the loss of the gear depends on the effort that the
//! gear transmits. The transmitted effort is the effort of the complete joint wrench, without the
//! friction of the joint itself and without the efforts of gearings at this joint. The constraints
//! exert the efforts of actuators with prescribed motion at the joints of these actuators. If
//! motors with added shafts move such a joint, the gears of these motors also transmit a part of
//! these efforts.
//!
//! Equations (G8) and (G14) of the book's theory.

use super::Forward;
use super::constraint_jacobian::{ConstraintRow, StickingDof};
use crate::friction::InterfaceShape;
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::spatial::Wrench;

/// Returns true if the friction of the interface `other` acts between the gear of the interface
/// `gear` and the load of this gear.
pub(super) fn is_behind(parameters: &Parameters<f64>, gear: usize, other: usize) -> bool {
    let [gear, other] = [gear, other].map(|interface| &parameters.interfaces[interface]);
    let is_shaft = |shape: InterfaceShape| matches!(shape, InterfaceShape::Shaft { .. });
    gear.load.gear.is_some() && gear.joint == other.joint && !is_shaft(other.shape)
}

/// Returns the part of the wrench at the joint of the interface `gear` that its gear does not
/// transmit: the wrench of gearings, which act in parallel with the gear. For an added motor shaft,
/// the motor's share of the efforts of prescribed actuators is subtracted, because the gear
/// transmits this share although the share does not act on the joint of the shaft.
pub(super) fn parallel_to_gear<T: Scalar>(
    model: &Forward,
    bodies: &Bodies<f64>,
    gear: usize,
    multipliers: &[T],
) -> Wrench<T> {
    let Forward { topology, parameters, .. } = model;
    let gear = &parameters.interfaces[gear];
    let mut sum = Wrench::zero();
    let Some(node) = topology.node_of(gear.joint).filter(|_| gear.load.gear.is_some()) else {
        return sum;
    };
    let dofs = topology.joint_types[gear.joint].dofs();
    if let Some(shaft) = model.shaft_at(gear.joint) {
        let effort = bodies.effort(&dofs[0], gear.joint);
        let first = topology.closures();
        for (actuator, multiplier) in model.prescribed.iter().zip(&multipliers[first..]) {
            let share = shaft.motor.share_of(*actuator);
            sum -= (effort * share).lift() * *multiplier;
        }
    }
    for (own, multiplier) in topology.gearings.iter().zip(&multipliers[topology.constraints..]) {
        for (tree_dof, coefficient) in own.terms(parameters) {
            if node.tree_dofs.contains(&tree_dof) {
                let effort = bodies.effort(&dofs[tree_dof - node.tree_dofs.start], gear.joint);
                sum += (effort * coefficient).lift() * *multiplier;
            }
        }
    }
    sum
}

/// Frictions and gearings that act on the load side of gears, between each gear and its load.
#[derive(Clone, Copy)]
pub(super) struct LoadSide<'a> {
    pub(super) model: &'a Forward,
    pub(super) bodies: &'a Bodies<f64>,
    pub(super) sticking: &'a [StickingDof],
    /// Rows of all constraints, including those of the sticking DOFs.
    pub(super) rows: &'a [ConstraintRow],
}

impl LoadSide<'_> {
    /// Returns true if the friction of the interface `other` acts between the gear of the interface
    /// `gear` and its load, see [`is_behind`].
    pub(super) fn is_behind(&self, gear: usize, other: usize) -> bool {
        is_behind(&self.model.parameters, gear, other)
    }

    /// Lists the interfaces whose friction acts between the gear of an interface and its load.
    pub(super) fn behind(self, gear: usize) -> impl Iterator<Item = usize> {
        // Most interfaces have no gear, and a search for every interface would take quadratic time.
        let interfaces = &self.model.parameters.interfaces;
        let all = interfaces[gear].load.gear.is_some().then_some(0..interfaces.len());
        all.into_iter().flatten().filter(move |&o| self.is_behind(gear, o))
    }

    /// Returns the sum of the wrenches of static frictions and gearings that act between the gear
    /// of an interface and the load of this gear.
    pub(super) fn held<T: Scalar>(&self, gear: usize, multipliers: &[T]) -> Wrench<T> {
        if self.model.parameters.interfaces[gear].load.gear.is_none() {
            return Wrench::zero();
        }
        let mut sum = parallel_to_gear(self.model, self.bodies, gear, multipliers);
        for dof in self.sticking.iter().filter(|dof| self.is_behind(gear, dof.interface)) {
            let row = self.model.topology.closures() + dof.row;
            sum += self.rows[row].covector.lift() * multipliers[row];
        }
        sum
    }
}
