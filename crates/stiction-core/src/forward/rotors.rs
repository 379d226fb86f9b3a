//! Rotors and motor friction of drive trains, reflected to the joints.
//!
//! Equation (G7) of the book's theory.

use super::Forward;
use super::constraint_jacobian::{each_dof, opening};
use crate::friction::{InterfaceShape, Law, NormalLoadMap};
use crate::kinematics::Bodies;
use crate::mechanism::{DriveTrain, Mechanism};
use crate::parameters::{InterfaceParameters, Parameters};
use crate::spatial::{Twist, Wrench};
use crate::topology::{Role, Topology};

/// Rotors of all motors that drive one degree of freedom.
#[derive(Clone, Debug)]
pub(super) struct Rotor {
    joint: usize,
    dof: usize,
    /// Reflected inertia, kg m^2 or kg.
    inertia: f64,
}

/// Rotor at one position and velocity.
#[derive(Clone, Debug)]
pub(super) struct RotorTerm {
    pub(super) joint: usize,
    /// Bodies of the joint.
    ends: (usize, usize),
    pub(super) inertia: f64,
    /// Unit effort on its degree of freedom.
    pub(super) covector: Wrench<f64>,
    /// Its acceleration at zero accelerations of the tree.
    pub(super) bias: f64,
}

impl Rotor {
    /// The rotors of a mechanism.
    pub(super) fn all(mechanism: &Mechanism) -> Vec<Self> {
        let mut rotors: Vec<Self> = Vec::new();
        for train in mechanism.drive_trains() {
            let (joint, dof, inertia) = (train.joint.0, train.dof, train.reflected_inertia());
            match rotors.iter_mut().find(|known| (known.joint, known.dof) == (joint, dof)) {
                Some(known) => known.inertia += inertia,
                None => rotors.push(Self { joint, dof, inertia }),
            }
        }
        rotors.retain(|rotor| rotor.inertia > 0.0);
        rotors
    }

    /// The rotor at a position and velocity; writes its rate per rate of each tree DOF to `row`.
    pub(super) fn at(
        &self,
        (topology, parameters): (&Topology, &Parameters<f64>),
        bodies: &Bodies<f64>,
        row: &mut [f64],
    ) -> RotorTerm {
        let &Self { joint, dof, inertia } = self;
        let covector = bodies.effort(&topology.joint_types[joint].dofs()[dof], joint);
        each_dof(topology, joint, |tree_dof, sign| {
            row[tree_dof] = sign * bodies.screws[tree_dof].power(covector);
        });
        // In a joint of the tree the joint rate is a rate of the tree.
        let bias = match topology.role[joint] {
            Role::Tree { .. } => 0.0,
            Role::Cut { .. } => opening(topology, parameters, bodies, joint).power(covector),
        };
        RotorTerm { joint, ends: topology.ends[joint], inertia, covector, bias }
    }
}

impl RotorTerm {
    /// Kinetic energy, J, for the twists of all bodies.
    pub(super) fn kinetic(&self, twists: &[Twist<f64>]) -> f64 {
        let (predecessor, successor) = self.ends;
        let rate = (twists[successor] - twists[predecessor]).power(self.covector);
        0.5 * self.inertia * rate * rate
    }
}

/// Friction of all motors on one degree of freedom: a constant normal load with the coefficient one.
pub(super) fn motor_friction(mechanism: &Mechanism) -> Vec<InterfaceParameters<f64>> {
    let mut frictions: Vec<InterfaceParameters<f64>> = Vec::new();
    for train in mechanism.drive_trains().iter().filter(|train| train.has_motor_friction()) {
        let (n, friction) = (train.transmission().abs(), train.motor_friction);
        let (joint, shape) = (train.joint.0, InterfaceShape::Shaft { dof: train.dof });
        let known = frictions.iter_mut().find(|known| (known.joint, known.shape) == (joint, shape));
        let (load, viscous) = (n * friction.constant, n * n * friction.viscous);
        match known {
            Some(known) => {
                known.load.preload += load;
                known.law.viscous += viscous;
            }
            None => frictions.push(InterfaceParameters {
                joint,
                shape,
                radius: 1.0,
                law: Law::coulomb_viscous(1.0, viscous),
                backward: None,
                load: NormalLoadMap { preload: load, ..NormalLoadMap::force_only() },
            }),
        }
    }
    for friction in frictions.iter_mut().filter(|friction| friction.load.preload == 0.0) {
        friction.law.mu = 0.0;
    }
    frictions
}

impl Forward {
    /// First drive train with a loss that depends on its load, which simulations do not include.
    pub(super) fn lossy_gear(&self) -> Option<&DriveTrain> {
        let mut trains = self.mechanism.drive_trains().iter();
        trains.find(|train| train.gear.efficiencies() != (1.0, 1.0))
    }
}
