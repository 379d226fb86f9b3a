//! Effect of clearance in a joint on motions that are blocked at second order only.
//!
//! Along such a motion `x t`, the loops open by `q t^2 / 2` in the direction of the self-stress `s`
//! that blocks it, with `q = s . (second derivative of the loop errors along x)`. Let a joint with
//! the clearance `c` carry the force `F` in this self-stress. The clearance can compensate at most
//! `F c` of the opening, which permits `t = sqrt(2 F c / |q|)`: the motion grows with the square
//! root of the clearance. (For the robot of Zhang et al. 2018, a clearance `c = sqrt(3)/2 k roll^2`
//! permits the angle `roll`, where `k` is half the side of the platform.)
//!
//! Equation (M4) of the book's theory.

use super::count::NEGLIGIBLE;
use crate::dynamics::InverseDynamics;
use crate::kinematics::{LoopsAt, body_twists};
use crate::mechanism::JointId;
use crate::spatial::Twist;
use crate::statics::newton_euler::Unknown;
use crate::statics::{Constraints, GainedTwist, Statics};
use nalgebra::DVector;

/// A motion permitted by clearance in one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Play {
    /// The permitted motion, described by the motion of one body.
    pub motion: GainedTwist,
    /// Joint with the largest force in the self-stress that blocks the motion.
    pub joint: JointId,
    /// Displacement to either side of the body that describes `motion`, rad or m, per square root
    /// of the clearance in m.
    pub per_root_metre: f64,
}

impl Play {
    /// Computes the displacement to either side of the body that describes the motion, for a
    /// clearance in m. The result is in rad or, if this body does not turn, in m.
    pub fn with(&self, clearance: f64) -> f64 {
        self.per_root_metre * clearance.sqrt()
    }
}

/// A self-stress counts as free of forces if its largest force is below this fraction of its
/// largest moment divided by the characteristic length. Clearance in a joint then permits no
/// motion.
const NO_FORCE: f64 = 1e-9;

/// Finds the motions at the solver's configuration that are open at first order and blocked at
/// second order.
pub fn blocked_motions(solver: &InverseDynamics) -> Vec<GainedTwist> {
    let (topology, parameters) = (solver.topology(), solver.parameters());
    let state = solver.state();
    let statics = solver.statics();
    let mut loops = LoopsAt::new(topology, parameters, state, NEGLIGIBLE);
    let blocked = loops.blocked_motions();
    let twists = blocked.iter().map(|m| body_twists(topology, solver.bodies(), &m.rates));
    twists.map(|twists| statics.described(&of_bodies(&statics, &twists))).collect()
}

/// Finds the motions that clearance permits at the solver's configuration; `loops` are the loop
/// equations at this configuration.
pub(super) fn play(solver: &InverseDynamics, loops: &mut LoopsAt<'_>) -> Vec<Play> {
    let blocked = loops.blocked_motions();
    if blocked.is_empty() {
        return Vec::new();
    }
    let statics = solver.statics();
    let constraints = Constraints::new(&statics);
    let stresses = constraints.stress_vectors();
    if stresses.is_empty() {
        return Vec::new();
    }
    let topology = solver.topology();
    let mut row_of = Vec::new();
    for cut in &topology.cuts {
        let count = topology.joint_types[cut.joint].constraints().len();
        let joint = cut.joint;
        row_of.extend((0..count).map(|index| Unknown::Constraint { joint, index }));
    }
    row_of.extend(topology.gearings.iter().map(|own| Unknown::Gearing { gearing: own.gearing }));
    // For each unknown of `constraints`, the row of the loop equation whose multiplier it is.
    let rows: Vec<Option<usize>> = constraints
        .unknowns()
        .map(|unknown| match unknown {
            Unknown::Constraint { .. } | Unknown::Gearing { .. } => {
                row_of.iter().position(|known| *known == unknown)
            }
            Unknown::Drive { .. } => None,
        })
        .collect();
    blocked
        .iter()
        .filter_map(|motion| {
            let openings: Vec<f64> = stresses
                .iter()
                .map(|stress| {
                    let amounts = constraints.amounts(stress);
                    let pairs = rows.iter().zip(amounts);
                    pairs.filter_map(|(row, amount)| Some(motion.biases[(*row)?] * amount)).sum()
                })
                .collect();
            // Linear combination of self-stresses with the greatest resistance to this motion.
            let combined = stresses
                .iter()
                .zip(&openings)
                .fold(DVector::zeros(stresses[0].len()), |sum: DVector<f64>, (s, q)| sum + s * *q);
            let opening: f64 = openings.iter().map(|q| q * q).sum();
            let combined: Vec<_> = combined.iter().copied().enumerate().collect();
            let loads = constraints.loads(&combined);
            let strongest = loads
                .iter()
                .max_by(|a, b| a.force.norm().total_cmp(&(b.force.norm() * (1.0 + 1e-9))))?;
            let force = strongest.force.norm();
            let moments = loads.iter().map(|load| load.moment.norm()).fold(0.0, f64::max);
            if opening <= 0.0 || force <= NO_FORCE * moments / statics.length() {
                return None;
            }
            let twists = body_twists(topology, solver.bodies(), &motion.rates);
            let described = statics.described(&of_bodies(&statics, &twists));
            let size = size_of(&statics, &twists, &described);
            Some(Play {
                joint: strongest.joint,
                per_root_metre: size * (2.0 * force / opening).sqrt(),
                motion: described,
            })
        })
        .collect()
}

/// Stacks the velocity of the centre of mass and the angular velocity of each body except the
/// ground.
fn of_bodies(statics: &Statics, twists: &[Twist<f64>]) -> DVector<f64> {
    let each = twists.iter().enumerate().skip(1).flat_map(|(body, twist)| {
        let velocity = twist.velocity_at(statics.system().com(body));
        [velocity.to_array(), twist.angular.to_array()].concat()
    });
    DVector::from_iterator(6 * (twists.len() - 1), each)
}

/// Computes the speed of the body that describes `motion`: in rad/s if this body turns, otherwise
/// in m/s.
fn size_of(statics: &Statics, twists: &[Twist<f64>], motion: &GainedTwist) -> f64 {
    let twist = twists[motion.body];
    match motion.turns {
        true => twist.angular.norm(),
        false => twist.velocity_at(statics.system().com(motion.body)).norm(),
    }
}
