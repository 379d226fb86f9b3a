//! Breakaway efforts of an actuator.
//!
//! Equation (R4) of the book's theory.

use super::bounds::{
    Goal, Position, StaticFriction, extreme, probe, resolve, set_static_frictions,
};
use crate::dynamics::inverse::Inverse;
use crate::kinematics::{actuator_rate, body_twists};
use nalgebra::{DMatrix, DVector};

/// Efforts of one actuator at which the mechanism begins to move while all other actuators are
/// locked, N or N m.
///
/// In the impending motion, the rate of this actuator is positive (negative) and the rates of the
/// other actuators are zero. Every interface that slides in this motion exerts its static friction
/// limit against the sliding, coupled with the normal forces. An interface that does not slide may
/// exert any static friction. If this friction affects the normal forces, the breakaway effort is
/// an interval: motion may begin at the first value, and has certainly begun at the second. The
/// values are infinite if friction locks the mechanism against the impending motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breakaway {
    /// Efforts at which forward motion may begin and at which it has certainly begun, N or N m.
    pub forward: (f64, f64),
    /// Efforts at which backward motion may begin and at which it has certainly begun, N or N m.
    pub backward: (f64, f64),
}

/// Interfaces count as not sliding if their sliding speed is below this fraction of the largest.
const STILL: f64 = 1e-9;

/// Computes, for each actuator, the sliding velocities of all interfaces per unit rate of this
/// actuator, with zero rates of all other actuators. `None` if the actuators do not determine the
/// motion.
pub(super) fn impending(position: &mut Position<'_>) -> Vec<Option<Vec<[f64; 3]>>> {
    let Position { model, parameters, kinematics, .. } = position;
    let topology = model.topology();
    let count = topology.actuators.len();
    if model.constraints().coordinates().len() != count {
        return vec![None; count];
    }
    let mut responses = Vec::with_capacity(count);
    let mut matrix = DMatrix::zeros(count, count);
    for column in 0..count {
        let mut rates = vec![0.0; topology.dofs()];
        kinematics.response_to_coordinate(&model.kinematic, column, &mut rates);
        let twists = body_twists(topology, &kinematics.bodies, &rates);
        for (row, actuator) in topology.actuators.iter().enumerate() {
            matrix[(row, column)] = actuator_rate(topology, &kinematics.bodies, actuator, &twists);
        }
        responses.push(rates);
    }
    let factors = matrix.lu();
    let mut bodies = kinematics.bodies.clone();
    let velocities = (0..count).map(|actuator| {
        let unit = DVector::from_fn(count, |k, _| if k == actuator { 1.0 } else { 0.0 });
        let amounts = factors.solve(&unit)?;
        let mut rates = vec![0.0; topology.dofs()];
        for (response, amount) in responses.iter().zip(amounts.iter()) {
            rates.iter_mut().zip(response).for_each(|(rate, r)| *rate += r * amount);
        }
        if rates.iter().any(|rate| !rate.is_finite()) {
            return None;
        }
        bodies.move_with(topology, &rates);
        let sliding = parameters.interfaces.iter().map(|interface| {
            bodies.surface_velocity(topology, interface, parameters.pitch[interface.joint])
        });
        Some(sliding.collect())
    });
    velocities.collect()
}

/// Computes the breakaway efforts of one actuator from the sliding velocities in the impending
/// motion. Changes the static friction in `inverse`.
pub(super) fn break_away(
    inverse: &mut Inverse<f64>,
    position: &mut Position<'_>,
    actuator: usize,
    velocities: &[[f64; 3]],
) -> Breakaway {
    let size = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let fastest = velocities.iter().map(size).fold(0.0, f64::max);
    let mut towards = |sense: f64| {
        let frictions: Vec<StaticFriction> = velocities
            .iter()
            .enumerate()
            .map(|(interface, velocity)| {
                let speed = size(velocity);
                let fixed = speed > STILL * fastest;
                let over = if fixed { sense / speed } else { 0.0 };
                StaticFriction { interface, direction: velocity.map(|v| v * over), fixed }
            })
            .collect();
        set_static_frictions(inverse, &frictions);
        let settled = resolve(inverse, position);
        let effort = inverse.efforts()[actuator];
        if !settled {
            return (sense * f64::INFINITY, sense * f64::INFINITY);
        }
        if frictions.iter().all(|friction| friction.fixed) {
            return (effort, effort);
        }
        let slopes = probe(inverse, position, &frictions);
        let (mut least, mut greatest) = (effort, effort);
        for search in [1.0, -1.0] {
            let goal = Goal { actuator, sense: search, before: effort };
            let found = extreme(inverse, position, &frictions, &slopes, goal);
            (least, greatest) = (least.min(found.least), greatest.max(found.greatest));
        }
        if sense > 0.0 { (least, greatest) } else { (greatest, least) }
    };
    Breakaway { forward: towards(1.0), backward: towards(-1.0) }
}
