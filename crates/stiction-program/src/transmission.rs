//! What a leg transmits: the wrenches that do no work on its passive joints.
//!
//! Friction elsewhere reaches a leg only through them, and they are few: one for a UPS leg, two for an RPS
//! leg.
//!
//! Equation (P4) of the book's theory.

use crate::samples::Sample;
use stiction::dynamics::InverseDynamics;
use stiction::kinematics::Bodies;
use stiction::mechanism::Mechanism;
use stiction::parameters::Parameters;
use stiction::scalar::Scalar;
use stiction::spatial::{Vec3, Wrench};
use stiction::topology::Topology;

/// A chain of joints from one body where chains meet to another.
#[derive(Clone, Debug)]
pub(crate) struct Leg {
    /// Its joints, each with the sign by which it passes the wrench of `reference` on.
    pub(crate) joints: Vec<(usize, f64)>,
    /// The joint in whose frame J wrenches are told.
    pub(crate) reference: usize,
    /// Freedoms without actuator: joint, place among its own.
    passive: Vec<(usize, usize)>,
    /// Row and component of each step of elimination.
    pivots: Vec<(usize, usize)>,
    /// The components of a wrench that determine it.
    pub(crate) free: Vec<usize>,
}

/// The legs of a mechanism, if all its bodies but those where chains meet are in legs.
pub(crate) fn legs(solver: &InverseDynamics, samples: &[Sample]) -> Option<Vec<Leg>> {
    let (mechanism, topology) = (solver.mechanism(), solver.topology());
    let mut legs = chains(mechanism, topology)?;
    let places: Vec<Bodies<f64>> = samples
        .iter()
        .map(|sample| {
            let mut bodies = Bodies::new(topology);
            bodies.place(topology, solver.parameters(), &sample.state.coordinates);
            bodies
        })
        .collect();
    for leg in &mut legs {
        leg.plan(mechanism, solver.parameters(), &places);
    }
    Some(legs)
}

/// Chains without their plans.
fn chains(mechanism: &Mechanism, topology: &Topology) -> Option<Vec<Leg>> {
    let joints = mechanism.joints();
    let mut is_hub = vec![false; mechanism.bodies().len()];
    is_hub[0] = true;
    topology.floating().for_each(|(body, ..)| is_hub[body.0] = true);
    let mut taken = vec![false; joints.len()];
    let mut legs = Vec::new();
    for first in 0..joints.len() {
        let ends = [joints[first].predecessor.0, joints[first].successor.0];
        let Some(start) = ends.into_iter().find(|body| is_hub[*body]) else { continue };
        if taken[first] {
            continue;
        }
        let (mut body, mut next) = (start, Some(first));
        let mut chain = Vec::new();
        while let Some(joint) = next {
            taken[joint] = true;
            let (predecessor, successor) = (joints[joint].predecessor.0, joints[joint].successor.0);
            let outwards = predecessor == body;
            chain.push((joint, if outwards { 1.0 } else { -1.0 }));
            body = if outwards { successor } else { predecessor };
            let meets =
                |k: &usize| joints[*k].predecessor.0 == body || joints[*k].successor.0 == body;
            let mut others = (0..joints.len()).filter(|k| *k != joint && meets(k));
            next = if is_hub[body] { None } else { others.next() };
            if !is_hub[body] && (next.is_none() || others.next().is_some()) {
                return None;
            }
        }
        let most_freedoms = |joint: &usize| joints[*joint].joint_type.freedoms().len();
        let reference = chain.iter().map(|(joint, _)| *joint).max_by_key(most_freedoms)?;
        let own = chain.iter().find(|(joint, _)| *joint == reference)?.1;
        let joints_of_chain = chain.iter().map(|(joint, sign)| (*joint, sign * own)).collect();
        let passive = chain.iter().flat_map(|(joint, _)| {
            let driven: Vec<usize> = joints[*joint].actuated_freedoms().collect();
            let freedoms = 0..joints[*joint].joint_type.freedoms().len();
            freedoms.filter(move |k| !driven.contains(k)).map(|k| (*joint, k))
        });
        let passive = passive.collect();
        let (pivots, free) = (Vec::new(), Vec::new());
        legs.push(Leg { joints: joints_of_chain, reference, passive, pivots, free });
    }
    taken.iter().all(|taken| *taken).then_some(legs)
}

impl Leg {
    /// The power of each component of a wrench on each passive freedom.
    fn powers<T: Scalar>(
        &self,
        mechanism: &Mechanism,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) -> Vec<[T; 6]> {
        let to_reference = bodies.frame_j[self.reference].inverse();
        let row = |&(joint, place): &(usize, usize)| {
            let freedom = &mechanism.joints()[joint].joint_type.freedoms()[place];
            let [j, k] = [bodies.frame_j[joint], bodies.frame_k[joint]].map(|f| to_reference * f);
            let twist = freedom.twist(&j, &k, parameters.pitch[joint]);
            let [a, b, c] = twist.linear.to_array();
            let [d, e, f] = twist.angular.to_array();
            [a, b, c, d, e, f]
        };
        self.passive.iter().map(row).collect()
    }

    /// Chooses pivots that are good at all places.
    fn plan(
        &mut self,
        mechanism: &Mechanism,
        parameters: &Parameters<f64>,
        places: &[Bodies<f64>],
    ) {
        // Forces and moments, as large as each other.
        let length = parameters.length;
        let scale = [1.0, 1.0, 1.0, 1.0 / length, 1.0 / length, 1.0 / length].map(|s| s * length);
        let mut matrices: Vec<Vec<[f64; 6]>> =
            places.iter().map(|bodies| self.powers(mechanism, parameters, bodies)).collect();
        let (mut rows, mut columns): (Vec<usize>, Vec<usize>) =
            ((0..self.passive.len()).collect(), (0..6).collect());
        loop {
            let size = |row: usize, column: usize| {
                let at = |matrix: &Vec<[f64; 6]>| (matrix[row][column] / scale[column]).abs();
                matrices.iter().map(at).fold(f64::INFINITY, f64::min)
            };
            let all = rows.iter().flat_map(|row| columns.iter().map(|column| (*row, *column)));
            let best = all.max_by(|a, b| size(a.0, a.1).total_cmp(&size(b.0, b.1)));
            let Some((row, column)) = best.filter(|(row, column)| size(*row, *column) > 1e-6)
            else {
                break;
            };
            self.pivots.push((row, column));
            rows.retain(|other| *other != row);
            columns.retain(|other| *other != column);
            for matrix in &mut matrices {
                eliminate(matrix, &rows, &columns, (row, column));
            }
        }
        self.free = columns;
    }

    /// The wrenches that it transmits, in the reference joint's frame: each has one in its own component
    /// of `free` and zero in the others.
    pub(crate) fn transmitted<T: Scalar>(
        &self,
        mechanism: &Mechanism,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) -> Vec<Wrench<T>> {
        let mut matrix = self.powers(mechanism, parameters, bodies);
        let mut rows: Vec<usize> = (0..self.passive.len()).collect();
        let mut columns: Vec<usize> = (0..6).collect();
        for &(row, column) in &self.pivots {
            rows.retain(|other| *other != row);
            columns.retain(|other| *other != column);
            eliminate(&mut matrix, &rows, &columns, (row, column));
        }
        let wrench = |free: &usize| {
            let mut w = [T::zero(); 6];
            w[*free] = T::one();
            for (k, &(row, column)) in self.pivots.iter().enumerate().rev() {
                // Columns of later pivots and the free ones are known.
                let later = self.pivots[k + 1..].iter().map(|(_, column)| *column);
                let mut sum = T::zero();
                for known in later.chain(self.free.iter().copied()) {
                    sum += matrix[row][known] * w[known];
                }
                w[column] = -(sum / matrix[row][column]);
            }
            let [a, b, c, d, e, f] = w;
            Wrench { force: Vec3::new(a, b, c), moment: Vec3::new(d, e, f) }
        };
        self.free.iter().map(wrench).collect()
    }
}

/// Takes a pivot's column out of other rows.
fn eliminate<T: Scalar>(
    matrix: &mut [[T; 6]],
    rows: &[usize],
    columns: &[usize],
    (row, column): (usize, usize),
) {
    let over = matrix[row][column].recip();
    let pivot = matrix[row];
    for &other in rows {
        let factor = matrix[other][column] * over;
        for &column in columns {
            let change = factor * pivot[column];
            matrix[other][column] -= change;
        }
    }
}
