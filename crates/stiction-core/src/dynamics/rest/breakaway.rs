//! Breakaway efforts of an actuator.
//!
//! Equation (R4) of the book's theory.

use super::bounds::{
    Goal, Position, StaticFriction, extreme, probe, resolve, set_static_frictions,
};
use crate::dynamics::inverse::Inverse;
use crate::kinematics::{Bodies, Coordinate, actuator_rate, body_twists};
use crate::mechanism::JointId;
use crate::topology::Topology;
use nalgebra::{DMatrix, DVector};

/// Efforts of one actuator at which the mechanism begins to move while all other actuators are
/// locked, N or N m.
///
/// In the impending motion, the rate of this actuator is positive (negative) and the rates of the
/// other actuators are zero. Every interface that slides in this motion exerts its static friction
/// limit against the sliding, coupled with the normal forces. An interface that does not slide may
/// exert any static friction. If this friction affects the normal forces, the breakaway effort is
/// an interval: the impending motion may begin at the first value, and the second sustains it
/// whatever this friction is. Within the effort interval of the actuator, other static friction may
/// still hold the mechanism. The values are infinite if friction locks the mechanism against the
/// impending motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breakaway {
    /// Efforts at which forward motion may begin, and that sustain it in any case, N or N m.
    pub forward: (f64, f64),
    /// Efforts at which backward motion may begin, and that sustain it in any case, N or N m.
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
    let mut response = |column: usize| {
        let mut rates = vec![0.0; topology.dofs()];
        kinematics.response_to_coordinate(&model.kinematic, column, &mut rates);
        rates
    };
    let actuators = topology.actuators.iter();
    let places: Option<Vec<usize>> = actuators
        .map(|actuator| {
            let own = Coordinate::Joint { joint: JointId(actuator.joint), dof: actuator.dof };
            model.constraints().coordinates().iter().position(|coordinate| *coordinate == own)
        })
        .collect();
    let motions: Vec<Option<Vec<f64>>> = match places {
        // The prescribed coordinates are those of the actuators.
        Some(places) => places.into_iter().map(|place| Some(response(place))).collect(),
        None => {
            let responses: Vec<Vec<f64>> = (0..count).map(response).collect();
            motions_of_actuators(topology, &kinematics.bodies, &responses)
        }
    };
    let mut bodies = kinematics.bodies.clone();
    let velocities = motions.into_iter().map(|rates| {
        let rates = rates.filter(|rates| rates.iter().all(|rate| rate.is_finite()))?;
        bodies.move_with(topology, &rates);
        let sliding = parameters.interfaces.iter().map(|interface| {
            bodies.surface_velocity(topology, interface, parameters.pitch[interface.joint])
        });
        Some(sliding.collect())
    });
    velocities.collect()
}

/// Computes, for each actuator, the rates of the spanning tree per unit rate of this actuator, with
/// zero rates of all other actuators. `responses` contains the rates per unit rate of each
/// prescribed coordinate. `None` if the actuators do not determine the motion.
fn motions_of_actuators(
    topology: &Topology,
    bodies: &Bodies<f64>,
    responses: &[Vec<f64>],
) -> Vec<Option<Vec<f64>>> {
    let count = responses.len();
    let mut matrix = DMatrix::zeros(count, count);
    for (column, rates) in responses.iter().enumerate() {
        let twists = body_twists(topology, bodies, rates);
        for (row, actuator) in topology.actuators.iter().enumerate() {
            matrix[(row, column)] = actuator_rate(topology, bodies, actuator, &twists);
        }
    }
    let factors = matrix.lu();
    let motions = (0..count).map(|actuator| {
        let unit = DVector::from_fn(count, |k, _| if k == actuator { 1.0 } else { 0.0 });
        let amounts = factors.solve(&unit)?;
        let mut rates = vec![0.0; topology.dofs()];
        for (response, amount) in responses.iter().zip(amounts.iter()) {
            rates.iter_mut().zip(response).for_each(|(rate, r)| *rate += r * amount);
        }
        Some(rates)
    });
    motions.collect()
}

/// Computes the breakaway efforts of one actuator from the sliding velocities in the impending
/// motion. `reach` lists the interfaces whose friction can change the effort of this actuator, in
/// ascending order. Changes the static friction in `inverse`.
pub(super) fn break_away(
    inverse: &mut Inverse<f64>,
    position: &mut Position<'_>,
    (actuator, reach): (usize, &[usize]),
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
        let free: Vec<StaticFriction> = reach
            .iter()
            .map(|&interface| frictions[interface])
            .filter(|friction| !friction.fixed)
            .collect();
        if free.is_empty() {
            return (effort, effort);
        }
        let slopes = probe(inverse, position, &free);
        let (mut least, mut greatest) = (effort, effort);
        for search in [1.0, -1.0] {
            let goal = Goal { actuator, sense: search, before: effort };
            let found = extreme(inverse, position, &free, &slopes, goal);
            (least, greatest) = (least.min(found.least), greatest.max(found.greatest));
        }
        if sense > 0.0 { (least, greatest) } else { (greatest, least) }
    };
    Breakaway { forward: towards(1.0), backward: towards(-1.0) }
}
