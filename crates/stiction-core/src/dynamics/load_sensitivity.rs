//! Changes of converged normal loads due to additional friction.
//!
//! Equation (I12) of the book's theory.

use super::data::Data;
use super::interfaces::InterfaceState;
use super::model::Model;
use super::responses::Responses;
use crate::friction::{InterfaceShape, OwnFriction};
use crate::friction_problem::normal_load::normal_load_between;
use crate::kinematics::Bodies;
use crate::parameters::{InterfaceParameters, Parameters};
use crate::scalar::{Dual, Scalar};
use crate::spatial::Wrench;
use nalgebra::DMatrix;

/// Changes of all normal loads per newton of friction that is added at one interface, while the
/// friction of all interfaces follows the changed loads.
///
/// The joint wrenches are linear in the friction forces, and the gradients of the normal loads are
/// known at a solution. The derivatives of the coupled problem therefore follow from one linear
/// system with as many unknowns as interfaces.
#[derive(Clone, Debug, Default)]
pub struct LoadSensitivity {
    responses: Responses,
}

impl LoadSensitivity {
    /// Computes the matrix whose entry (i, j) is the change of the normal load of interface i per
    /// newton of friction added at interface j, for the solution in `data` that `parameters` yield.
    /// An interface at rest adds no friction. `None` if the loads have no derivative, for example
    /// close to jamming.
    pub fn at(
        &mut self,
        model: &Model,
        parameters: &Parameters<f64>,
        data: &Data<f64>,
    ) -> Option<DMatrix<f64>> {
        let (inverse, bodies) = (&data.inverse, &data.kinematics.bodies);
        let states = inverse.interfaces();
        let count = states.len();
        // Changes of the loads for given friction forces.
        let mut fixed = DMatrix::zeros(count, count);
        self.responses.update(inverse, model, parameters, bodies, false, |_, units, responses| {
            let joints = parameters.interfaces.iter().map(|interface| interface.joint);
            for (row, (state, joint)) in states.iter().zip(joints).enumerate() {
                let change = state.load.gradient.lift().power(responses.wrenches[joint]);
                for (unit, change) in units.iter().zip(change.0) {
                    if states[unit.interface].sliding > 0.0 {
                        fixed[(row, unit.interface)] = change;
                    }
                }
            }
        });
        let mut coupled = DMatrix::identity(count, count);
        for (column, state) in states.iter().enumerate() {
            coupled.column_mut(column).axpy(
                -state.resistance.coefficient,
                &fixed.column(column),
                1.0,
            );
        }
        for (k, (interface, state)) in parameters.interfaces.iter().zip(states).enumerate() {
            let pitch = parameters.pitch[interface.joint];
            let wrench = inverse.joint_wrenches()[interface.joint];
            fixed[(k, k)] += by_own_friction(interface, pitch, bodies, (state, wrench));
        }
        let is_solved = coupled.lu().solve_mut(&mut fixed);
        (is_solved && fixed.iter().all(|x| x.is_finite())).then_some(fixed)
    }
}

/// Computes the change of a normal load per newton of the interface's own friction under a constant
/// wrench of the joint. Only the load of a thread depends on its own friction.
fn by_own_friction(
    interface: &InterfaceParameters<f64>,
    pitch: f64,
    bodies: &Bodies<f64>,
    (state, wrench): (&InterfaceState<f64>, Wrench<f64>),
) -> f64 {
    type D = Dual<f64, 1>;
    if interface.shape != InterfaceShape::Thread {
        return 0.0;
    }
    let OwnFriction { coefficient, constant, direction } = state.own_friction();
    let own = OwnFriction {
        coefficient: D::from_f64(coefficient),
        constant: D::variable(constant, 0),
        direction: D::from_f64(direction),
    };
    let [j, k] =
        [&bodies.frame_j, &bodies.frame_k].map(|frames| frames[interface.joint].lift::<D>());
    let surface = (interface.shape, D::from_f64(interface.radius));
    let map = interface.load.lift();
    normal_load_between(&map, surface, D::from_f64(pitch), (&j, &k), wrench.lift(), own).value.slope
        [0]
}
