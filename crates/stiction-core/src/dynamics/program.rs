//! Results of the kernels that a recorded program computes along a motion, in their order.

use super::balance::WIDTH;
use super::contributions::{Response, Sharing};
use super::data::Data;
use super::model::Model;
use crate::friction_problem::normal_load::largest_load_change;
use crate::parameters::Parameters;
use crate::scalar::Scalar;

/// Returns the results of the stage [`Stage::Motion`](crate::kinematics::Stage::Motion): the side
/// (the sign of the determinant of the balance, 1 or -1), rates and accelerations of the spanning
/// tree, and the motion of all bodies. Requires a previous [`Model::evaluate`] without friction.
#[doc(hidden)]
pub fn motion_results<T: Scalar>(model: &Model, data: &Data<T>) -> Vec<T> {
    let mut side = T::one();
    for pivot in data.inverse.reciprocal_pivots(model) {
        side = pivot.if_positive(side, -side);
    }
    let mut results = Vec::new();
    results.push(side);
    results.extend_from_slice(&data.state.rates);
    results.extend_from_slice(&data.state.accelerations);
    data.kinematics.bodies.write(|numbers| results.extend_from_slice(numbers));
    results
}

/// Returns the results of the stage [`Stage::Forces`](crate::kinematics::Stage::Forces): forces
/// without friction, the responses of joint wrenches and efforts to a unit friction force at each
/// interface, in blocks of four interfaces, and the coupling matrix of friction and normal loads.
/// All interfaces must slide, with one friction component each. Requires a previous
/// [`Model::evaluate`] without friction.
#[doc(hidden)]
pub fn force_results<T: Scalar>(
    model: &Model,
    parameters: &Parameters<T>,
    data: &Data<T>,
) -> Vec<T> {
    let bodies = &data.kinematics.bodies;
    let inverse = &data.inverse;
    let responses = Sharing::new(model).responses_in(1, model, parameters, bodies, inverse);
    let mut results = Vec::new();
    inverse.write_frictionless(|numbers| results.extend_from_slice(numbers));
    let lanes = |block: &[Response<T>], of: &dyn Fn(&Response<T>) -> T| -> [T; WIDTH] {
        core::array::from_fn(|lane| block.get(lane).map_or(T::zero(), of))
    };
    for block in responses.chunks(WIDTH) {
        for joint in 0..model.topology().joint_types.len() {
            for axis in 0..3 {
                results.extend(lanes(block, &|one| one.wrenches[joint].force.component(axis)));
            }
            for axis in 0..3 {
                results.extend(lanes(block, &|one| one.wrenches[joint].moment.component(axis)));
            }
        }
    }
    for block in responses.chunks(WIDTH) {
        for actuator in 0..model.topology().actuators.len() {
            results.extend(lanes(block, &|one| one.efforts[actuator]));
        }
    }
    for (to, state) in parameters.interfaces.iter().zip(inverse.interfaces()) {
        let own = state.resistance.coefficient;
        let j = &bodies.frame_j[to.joint];
        let k = &bodies.frame_k[to.joint];
        let pitch = parameters.pitch[to.joint];
        for (response, from) in responses.iter().zip(inverse.interfaces()) {
            let wrench = response.wrenches[to.joint] * from.resistance.coefficient;
            results.push(largest_load_change(to, pitch, (j, k), wrench, own));
        }
    }
    results
}
