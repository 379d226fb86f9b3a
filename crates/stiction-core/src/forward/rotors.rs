//! Rotors, motor friction and gear friction of drive trains, reflected to the joints.
//!
//! Equations (G7) to (G10) of the book's theory.

use super::constraint_jacobian::{each_dof, opening};
use crate::friction::{InterfaceShape, Law, NormalLoadMap};
use crate::kinematics::Bodies;
use crate::mechanism::{Mechanism, RotorAxis};
use crate::parameters::{InterfaceParameters, Parameters};
use crate::spatial::{Twist, Vec3, Wrench};
use crate::topology::{Role, Topology};
use core::ops::Range;

/// All rotors that turn with one output coordinate. The output coordinate is either the coordinate
/// of one degree of freedom or, for a motor that moves several joints, a linear combination of
/// joint coordinates.
#[derive(Clone, Debug)]
pub(super) struct Rotor {
    /// Degrees of freedom as (joint, index in the joint, coefficient in the output coordinate).
    dofs: Vec<(usize, usize, f64)>,
    /// Inertia reflected to the output coordinate, kg m^2 or kg.
    inertia: f64,
    /// Body that carries the rotor, the spin axis in the frame of this body, and the angular
    /// momentum per unit output rate. `None` for a rotor without a declared axis, whose inertia
    /// acts only on the output coordinate.
    spinning: Option<(usize, Vec3<f64>, f64)>,
}

/// Terms of a rotor in the equations of motion at one configuration and velocity.
#[derive(Clone, Debug)]
pub(super) struct RotorTerm {
    /// Joints that move the rotor, as a range of indices in
    /// [`MassMatrix::rotor_parts`](super::mass_matrix::MassMatrix).
    pub(super) parts: Range<usize>,
    inertia: f64,
    /// Effort on the output coordinate that accelerates the rotor if all accelerations of the
    /// spanning tree are zero.
    pub(super) bias: f64,
    /// Index of the body that carries the rotor, and the angular momentum per unit output rate,
    /// world axes.
    pub(super) carrier: Option<(usize, Vec3<f64>)>,
}

/// Joint that moves a rotor.
#[derive(Clone, Debug)]
pub(super) struct RotorPart {
    pub(super) joint: usize,
    /// Predecessor and successor of the joint.
    ends: (usize, usize),
    /// Joint wrench per unit effort on the output coordinate.
    pub(super) covector: Wrench<f64>,
}

impl Rotor {
    /// Lists the rotors of a mechanism. Rotors without an axis that share an output coordinate are
    /// combined.
    pub(super) fn all(mechanism: &Mechanism) -> Vec<Self> {
        let mut rotors: Vec<Self> = Vec::new();
        for train in mechanism.drive_trains() {
            let inertia = train.reflected_inertia();
            let momentum = train.transmission() * train.rotor_inertia;
            let spinning =
                train.rotor_axis.map(|RotorAxis { body, axis }| (body.0, axis, momentum));
            let dofs: Vec<_> =
                train.output_parts().map(|(joint, dof, part)| (joint.0, dof, part)).collect();
            let is_same = |known: &&mut Self| {
                known.spinning.is_none() && spinning.is_none() && known.dofs == dofs
            };
            match rotors.iter_mut().find(is_same) {
                Some(known) => known.inertia += inertia,
                None => rotors.push(Self { dofs, inertia, spinning }),
            }
        }
        rotors.retain(|rotor| rotor.inertia > 0.0);
        rotors
    }

    /// Computes the terms of the rotor at a configuration and velocity. Writes the output rate per
    /// rate of each tree DOF to `row`, and the effort that accelerates the rotor per acceleration
    /// of each tree DOF to `taken`. Appends the joints that move the rotor to `parts`.
    pub(super) fn at(
        &self,
        (topology, parameters): (&Topology, &Parameters<f64>),
        bodies: &Bodies<f64>,
        (row, taken): (&mut [f64], &mut [f64]),
        parts: &mut Vec<RotorPart>,
    ) -> RotorTerm {
        let &Self { ref dofs, inertia, spinning } = self;
        let first = parts.len();
        let mut bias = 0.0;
        for &(joint, dof, part) in dofs {
            let covector = bodies.effort(&topology.joint_types[joint].dofs()[dof], joint) * part;
            each_dof(topology, joint, |tree_dof, sign| {
                row[tree_dof] += sign * bodies.screws[tree_dof].power(covector);
            });
            // The rate of a joint of the spanning tree is itself a rate of the tree, so only cut
            // joints contribute to the bias.
            if let Role::Cut { .. } = topology.role[joint] {
                bias += opening(topology, parameters, bodies, joint).power(covector);
            }
            parts.push(RotorPart { joint, ends: topology.ends[joint], covector });
        }
        taken.iter_mut().zip(&*row).for_each(|(taken, row)| *taken = inertia * row);
        let mut bias = inertia * bias;
        let carrier = spinning.map(|(body, axis, momentum)| {
            let momentum = bodies.pose[body].rotation * (axis * momentum);
            bias += momentum.dot(bodies.bias[body].angular);
            let mut next = topology.node_of_body[body];
            while let Some(node) = next {
                for tree_dof in topology.nodes[node].tree_dofs.clone() {
                    taken[tree_dof] += momentum.dot(bodies.screws[tree_dof].angular);
                }
                next = topology.nodes[node].parent;
            }
            (body, momentum)
        });
        RotorTerm { parts: first..parts.len(), inertia, bias, carrier }
    }
}

impl RotorTerm {
    /// Returns the kinetic energy of the rotor, J, minus the kinetic energy that the rotor would
    /// have if it did not turn relative to the body that carries it. `parts` are the joints of all
    /// rotors, and `twists` the twists of all bodies.
    pub(super) fn kinetic(&self, parts: &[RotorPart], twists: &[Twist<f64>]) -> f64 {
        let of_joint = |part: &RotorPart| {
            let (predecessor, successor) = part.ends;
            (twists[successor] - twists[predecessor]).power(part.covector)
        };
        let rate: f64 = parts[self.parts.clone()].iter().map(of_joint).sum();
        let spin = |(body, momentum): (usize, Vec3<f64>)| momentum.dot(twists[body].angular);
        rate * (0.5 * self.inertia * rate + self.carrier.map_or(0.0, spin))
    }
}

/// Returns the friction of all motors and gears on each degree of freedom, as interfaces with the
/// friction coefficient one (zero if the friction is purely viscous). The normal load of such an
/// interface is the constant motor friction plus the gear loss, which is affine in the magnitude of
/// the transmitted effort. Gears that act on the same degree of freedom have the same losses and
/// transmit efforts in constant ratios; all other gears have separate shafts.
pub(super) fn shaft_friction(mechanism: &Mechanism) -> Vec<InterfaceParameters<f64>> {
    let mut frictions: Vec<InterfaceParameters<f64>> = Vec::new();
    for train in mechanism.drive_trains().iter().filter(|train| train.has_friction()) {
        // Motors with friction that move several joints are simulated on separate shafts.
        let Some((joint, dof)) = train.only_dof() else { continue };
        let (n, friction) = (train.transmission().abs(), train.motor_friction);
        let (joint, joint_type) = (joint.0, mechanism.joints()[joint.0].joint_type);
        let shape = InterfaceShape::Shaft { dof, joint_type };
        let known = frictions.iter_mut().find(|known| (known.joint, known.shape) == (joint, shape));
        let (load, viscous) = (n * friction.constant, n * n * friction.viscous);
        match known {
            Some(known) => {
                known.load.preload += load;
                known.law.viscous += viscous;
                known.load.gear = known.load.gear.or(train.losses());
            }
            None => frictions.push(InterfaceParameters {
                joint,
                shape,
                radius: 1.0,
                law: Law::coulomb_viscous(1.0, viscous),
                backward: None,
                load: NormalLoadMap {
                    preload: load,
                    gear: train.losses(),
                    ..NormalLoadMap::force_only()
                },
            }),
        }
    }
    let is_viscous = |load: &NormalLoadMap<f64>| load.preload == 0.0 && load.gear.is_none();
    for friction in frictions.iter_mut().filter(|friction| is_viscous(&friction.load)) {
        friction.law.mu = 0.0;
    }
    frictions
}
