//! The effort at which an actuator begins to move a mechanism.
//!
//! Equation (R4) of the book's theory.

use super::bounds::{Held, Position, Way, extreme, hold, probe, resolve};
use crate::dynamics::inverse::Inverse;
use crate::kinematics::{actuator_rate, body_twists};
use nalgebra::{DMatrix, DVector};

/// The effort of one actuator at which the mechanism begins to move, all other actuators holding
/// where they are, N or N m.
///
/// The motion that impends is that of a positive (negative) rate of this actuator and none of the
/// others. Every contact that slides in it has its greatest static friction against it, coupled
/// with the loads. A contact that does not slide in it may have any static friction; where that
/// matters, through the loads, the effort is an interval: at the first number it may begin, at the
/// second it does. Infinite where friction locks the mechanism against that motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breakaway {
    /// Of a motion forward, the efforts in the order in which they are met.
    pub forward: (f64, f64),
    /// Of a motion backward.
    pub backward: (f64, f64),
}

/// Slower than this part of the fastest contact does not slide.
const STILL: f64 = 1e-9;

/// For each actuator the sliding velocities of all contacts for its unit rate, the other actuators
/// at rest; none where they do not determine the motion, or leave none.
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

/// The breakaway efforts of one actuator, from the velocities of its impending motion. Leaves the
/// contacts as they come.
pub(super) fn break_away(
    inverse: &mut Inverse<f64>,
    position: &mut Position<'_>,
    actuator: usize,
    velocities: &[[f64; 3]],
) -> Breakaway {
    let size = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let fastest = velocities.iter().map(size).fold(0.0, f64::max);
    let mut towards = |sense: f64| {
        let held: Vec<Held> = velocities
            .iter()
            .enumerate()
            .map(|(interface, velocity)| {
                let speed = size(velocity);
                let fixed = speed > STILL * fastest;
                let over = if fixed { sense / speed } else { 0.0 };
                Held { interface, direction: velocity.map(|v| v * over), fixed }
            })
            .collect();
        hold(inverse, &held);
        let settled = resolve(inverse, position);
        let effort = inverse.efforts()[actuator];
        if !settled {
            return (sense * f64::INFINITY, sense * f64::INFINITY);
        }
        if held.iter().all(|held| held.fixed) {
            return (effort, effort);
        }
        let slopes = probe(inverse, position, &held);
        let (mut least, mut greatest) = (effort, effort);
        for way in [1.0, -1.0] {
            let way = Way { actuator, sense: way, before: effort };
            let found = extreme(inverse, position, &held, &slopes, way);
            (least, greatest) = (least.min(found.least), greatest.max(found.greatest));
        }
        if sense > 0.0 { (least, greatest) } else { (greatest, least) }
    };
    Breakaway { forward: towards(1.0), backward: towards(-1.0) }
}
