//! Changes of converged normal loads due to additional friction and to additional wrenches that
//! bodies require.
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
use crate::spatial::{Vec3, Wrench};
use nalgebra::DMatrix;

/// Number of components of a wrench.
const COMPONENTS: usize = 6;

/// Computation of [`LoadChanges`].
///
/// The joint wrenches are linear in the friction forces and in the wrenches that the bodies require,
/// and the gradients of the normal loads are known at a solution. The derivatives of the coupled
/// problem therefore follow from one linear system with as many unknowns as interfaces.
#[derive(Clone, Debug, Default)]
pub struct LoadSensitivity {
    responses: Responses,
}

/// Changes of all normal loads, while the friction of all interfaces follows the changed loads. Each
/// row belongs to an interface.
#[derive(Clone, Debug)]
pub struct LoadChanges {
    /// Changes per newton of friction that is added at one interface (columns). An interface at rest
    /// adds no friction.
    pub by_friction: DMatrix<f64>,
    /// Changes per unit of the wrench that each of the given bodies requires, in six columns for each
    /// body: force, per N, then moment about the reference point, per N m, in world axes.
    pub by_demand: DMatrix<f64>,
}

impl LoadSensitivity {
    /// Computes the changes of the normal loads for the solution in `data` that `parameters` yield,
    /// with the wrenches that `loaded` bodies require. `None` if the loads have no derivative, for
    /// example close to jamming.
    pub fn at(
        &mut self,
        model: &Model,
        parameters: &Parameters<f64>,
        data: &Data<f64>,
        loaded: &[usize],
    ) -> Option<LoadChanges> {
        let (inverse, bodies) = (&data.inverse, &data.kinematics.bodies);
        let states = inverse.interfaces();
        let count = states.len();
        let joints = || parameters.interfaces.iter().map(|interface| interface.joint);
        // Changes of the loads for given friction forces, then for given wrenches of bodies.
        let mut changes = DMatrix::zeros(count, count + COMPONENTS * loaded.len());
        self.responses.update(inverse, model, parameters, bodies, false, |_, units, responses| {
            for (row, (state, joint)) in states.iter().zip(joints()).enumerate() {
                let change = state.load.gradient.lift().power(responses.wrenches[joint]);
                for (unit, change) in units.iter().zip(change.0) {
                    if states[unit.interface].sliding > 0.0 {
                        changes[(row, unit.interface)] = change;
                    }
                }
            }
        });
        for (place, &body) in loaded.iter().enumerate() {
            for component in 0..COMPONENTS {
                let unit = Vec3::unit(component % 3);
                let wrench = match component < 3 {
                    true => Wrench { force: unit, moment: Vec3::zero() },
                    false => Wrench { force: Vec3::zero(), moment: unit },
                };
                let wrenches =
                    self.responses.under_demand(model, parameters, bodies, (body, wrench));
                let column = count + COMPONENTS * place + component;
                for (row, (state, joint)) in states.iter().zip(joints()).enumerate() {
                    changes[(row, column)] = state.load.gradient.power(wrenches[joint]);
                }
            }
        }
        let mut coupled = DMatrix::identity(count, count);
        for (column, state) in states.iter().enumerate() {
            let coefficient = -state.resistance.coefficient;
            coupled.column_mut(column).axpy(coefficient, &changes.column(column), 1.0);
        }
        for (k, (interface, state)) in parameters.interfaces.iter().zip(states).enumerate() {
            let pitch = parameters.pitch[interface.joint];
            let wrench = inverse.joint_wrenches()[interface.joint];
            changes[(k, k)] += by_own_friction(interface, pitch, bodies, (state, wrench));
        }
        let is_solved = coupled.lu().solve_mut(&mut changes);
        let by_demand = changes.columns(count, COMPONENTS * loaded.len()).into_owned();
        let by_friction = changes.columns(0, count).into_owned();
        (is_solved && changes.iter().all(|x| x.is_finite()))
            .then_some(LoadChanges { by_friction, by_demand })
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
