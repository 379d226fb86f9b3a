//! Fast computation of singularity indices along a motion, for statically determinate mechanisms.
//!
//! The smallest singular value is the square root of the smallest eigenvalue of the Gram matrix,
//! which is the balance matrix times its transpose. If the rows belong to bodies, the Gram matrix
//! couples only bodies with a common joint; if they belong to joints, only joints with a common
//! body. The cost of factoring the Gram matrix is proportional to the number of legs: the joints of
//! a platform on many legs are coupled by a matrix of rank six.
//!
//! Equation (M6) of the book's theory.

mod bounds;
mod bracket;
mod factor;
mod inverse_iteration;
#[cfg(test)]
mod tests;
mod travel;

use super::distance::Distances;
use super::newton_euler::NewtonEuler;
use super::prediction::{Prediction, Shift};
use crate::joint::{Dof, JointType};
use crate::kinematics::Bodies;
use crate::linalg::{
    BLOCK, BlockCholesky, ColumnOrder, Lanczos, Part, Slot, add_outer_products, add_squares,
};
use crate::mechanism::Mechanism;
use crate::parameters::Parameters;
use crate::spatial::Wrench;
use inverse_iteration::{shift_below, weakest};
use travel::{Changes, Kinds, Places};

/// Singular values below this fraction of the largest entry are computed from the triangular factor
/// of the balance matrix itself, because the Gram matrix loses digits: its round-off is about
/// 1e-14. The error is quadratic in the ratio of this round-off to the squared singular value.
const SMALL: f64 = 1e-4;
/// Singular values below this fraction of the largest entry are computed by a dense decomposition,
/// because they are of the order of round-off.
const TINY: f64 = 1e-12;

/// Round-off of a Gram matrix and of its Cholesky decomposition for each row, relative to the square
/// of the largest entry of the balance matrix: usually the precision of the numbers, with a margin,
/// because bounds of the error contain the number of rows twice (Higham 2002, theorem 10.3).
const ROUNDED: f64 = 2e-14;

/// Number of joints of one body from which their pairs have no blocks in the Gram matrix of the
/// constraints.
const MANY: usize = 7;

/// Computes [`Distances`] at many configurations of one mechanism. It is fastest for successive
/// configurations along a motion: each value is extrapolated from the previous ones, and inverse
/// iteration about the extrapolated value converges in few steps. The results therefore depend on
/// the previous configurations, within round-off.
#[derive(Clone, Debug)]
pub struct SingularityDistances {
    /// Number of bodies, not counting the ground.
    bodies: usize,
    joints: Vec<Content>,
    /// Gram matrix of constraints and actuators, one block per pair of bodies with a common joint.
    by_bodies: BlockCholesky,
    body_slots: Vec<[Option<Slot>; 3]>,
    /// Gram matrix of the constraints, one block per pair of joints with a common body. The joints
    /// of a body with many joints, such as a platform on many legs, are coupled by a matrix of low
    /// rank instead.
    by_joints: BlockCholesky,
    joint_slots: Vec<Meeting>,
    /// Joints of a body with many joints, each with the index of this body's end. Their pairs have
    /// no blocks; empty if there is no such body.
    hub_rows: Vec<(usize, usize)>,
    /// Scaled unit wrenches of each joint, constraints before actuators, on the joint's predecessor
    /// and successor.
    on: Vec<[[Part; BLOCK]; 2]>,
    /// Places at the preceding configuration, for [`Self::travel`].
    places: Places,
    changes: Changes,
    /// Transposed constraint wrenches of each joint on its predecessor and successor: one value per
    /// constraint for each component of the wrench.
    across: Vec<[[Part; BLOCK]; 2]>,
    actuation: Prediction,
    constraint: Prediction,
    /// Resultant of the constraint wrenches on each body, for constraint multipliers equal to the
    /// computed eigenvector.
    carried: Vec<Part>,
    /// Buffer for an extrapolated eigenvector.
    vector: Vec<f64>,
    lanczos: Lanczos,
    /// Column orders of the triangular factors for the actuation index and the constraint index.
    orders: [Option<ColumnOrder>; 2],
}

/// Singularity index to compute, one of the [`Distances`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SingularityIndex {
    /// Actuation index, [`Distances::actuation`].
    Actuation,
    /// Constraint index, [`Distances::constraint`].
    Constraint,
}

#[derive(Clone, Debug)]
struct Content {
    joint_type: JointType,
    /// Indices of the predecessor and the successor of the joint.
    ends: [usize; 2],
    constraints: usize,
    /// Total number of constraints and actuators of the joint.
    unknowns: usize,
    drives: Vec<Dof>,
    kinds: Kinds,
}

/// Two joints with a common body. An entry of `ends` is 0 if the common body is the predecessor of
/// the joint, and 1 if it is the successor.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    joints: [usize; 2],
    ends: [usize; 2],
    slot: Slot,
}

impl SingularityDistances {
    /// Prepares the computation for a mechanism. Returns `None` if the mechanism has gearings, or
    /// if its balance has different numbers of unknowns and equations.
    pub fn new(mechanism: &Mechanism) -> Option<Self> {
        // Each unknown must load the bodies of one joint only, but the multiplier of a gearing
        // loads several joints.
        if !mechanism.gearings().is_empty() {
            return None;
        }
        let bodies = mechanism.bodies().len() - 1;
        let joints: Vec<Content> = mechanism
            .joints()
            .iter()
            .map(|joint| {
                let dofs = joint.joint_type.dofs();
                let drives: Vec<Dof> = joint.actuated_dofs().map(|dof| dofs[dof]).collect();
                let constraints = joint.joint_type.constraints().len();
                let ends = [joint.predecessor.0, joint.successor.0];
                let unknowns = constraints + drives.len();
                let kinds = Kinds::of(joint.joint_type.constraints());
                Content { joint_type: joint.joint_type, ends, constraints, unknowns, drives, kinds }
            })
            .collect();
        if joints.iter().map(|joint| joint.unknowns).sum::<usize>() != BLOCK * bodies {
            return None;
        }
        let moving = |joint: &Content| joint.ends.map(|end| end.checked_sub(1));
        let pairs = joints.iter().filter_map(|joint| {
            let [a, b] = moving(joint);
            a.zip(b)
        });
        let by_bodies = BlockCholesky::new(bodies, pairs);
        let body_slots = joints
            .iter()
            .map(|joint| {
                let [a, b] = moving(joint);
                let slot = |a: Option<usize>, b: Option<usize>| by_bodies.slot(a?, b?);
                [slot(a, a), slot(b, b), slot(a, b)]
            })
            .collect();

        let mut at = vec![Vec::new(); bodies + 1];
        for (index, joint) in joints.iter().enumerate() {
            for end in 0..2 {
                at[joint.ends[end]].push((index, end));
            }
        }
        let meetings = || {
            at.iter().skip(1).flat_map(|at: &Vec<(usize, usize)>| {
                let pairs = at.iter().enumerate();
                pairs.flat_map(move |(k, a)| at[k..].iter().map(move |b| (*a, *b)))
            })
        };
        let sizes: Vec<usize> = joints.iter().map(|joint| joint.constraints).collect();
        let busiest = (1..=bodies).max_by_key(|body| at[*body].len());
        let hub = busiest.filter(|body| at[*body].len() >= MANY);
        let at_hub = |(joint, end): (usize, usize)| Some(joints[joint].ends[end]) == hub;
        let mut hub_rows = hub.map_or_else(Vec::new, |body| at[body].clone());
        let hub_joints: Vec<usize> = hub_rows.iter().map(|(joint, _)| *joint).collect();
        let others = meetings().filter(|(a, _)| !at_hub(*a)).map(|(a, b)| (a.0, b.0));
        let by_joints = BlockCholesky::with_hub(&sizes, others, &hub_joints);
        let has_hub = by_joints.has_hub();
        if !has_hub {
            hub_rows.clear();
        }
        let joint_slots = meetings()
            .filter(|(a, _)| !(has_hub && at_hub(*a)))
            .filter_map(|(a, b)| {
                let slot = by_joints.slot(a.0, b.0)?;
                Some(Meeting { joints: [a.0, b.0], ends: [a.1, b.1], slot })
            })
            .collect();
        let count = joints.len();
        Some(Self {
            bodies,
            joints,
            by_bodies,
            body_slots,
            by_joints,
            joint_slots,
            hub_rows,
            on: vec![[[[0.0; BLOCK]; BLOCK]; 2]; count],
            places: Places::default(),
            changes: Changes::default(),
            across: vec![[[[0.0; BLOCK]; BLOCK]; 2]; count],
            actuation: Prediction::default(),
            constraint: Prediction::default(),
            carried: vec![[0.0; BLOCK]; bodies],
            vector: Vec::new(),
            lanczos: Lanczos::default(),
            orders: [None, None],
        })
    }

    /// Computes both indices at the current configuration of `bodies`.
    pub fn measure(
        &mut self,
        mechanism: &Mechanism,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
    ) -> Distances {
        self.place(parameters, bodies);
        let largest = self.largest();
        let actuation = self.smallest(SingularityIndex::Actuation, largest);
        let constraint =
            actuation.and_then(|_| self.smallest(SingularityIndex::Constraint, largest));
        match (actuation, constraint) {
            (Some(actuation), Some(constraint)) => Distances { actuation, constraint },
            _ => self.measure_dense(mechanism, parameters, bodies),
        }
    }

    /// Computes the index `index` at the configuration of `bodies`. If the value is known
    /// approximately, pass it as `expected`.
    pub fn measure_one(
        &mut self,
        index: SingularityIndex,
        expected: Option<f64>,
        (mechanism, parameters, bodies): (&Mechanism, &Parameters<f64>, &Bodies<f64>),
    ) -> f64 {
        self.place(parameters, bodies);
        let largest = self.largest();
        if let Some(expected) = expected {
            self.prediction(index).expect(expected * expected);
        }
        self.smallest(index, largest).unwrap_or_else(|| {
            let distances = self.measure_dense(mechanism, parameters, bodies);
            match index {
                SingularityIndex::Actuation => distances.actuation,
                SingularityIndex::Constraint => distances.constraint,
            }
        })
    }

    /// Returns the round-off of the eigenvalues of Gram matrices with the largest entry `largest` of
    /// the scaled balance matrix.
    fn round_off(&self, largest: f64) -> f64 {
        ROUNDED * (BLOCK * self.bodies) as f64 * largest * largest
    }

    /// Computes an index at the configuration set by [`Self::place`]. `largest` is the largest
    /// entry of the scaled balance matrix. Returns `None` if the value is of the order of
    /// round-off.
    fn smallest(&mut self, index: SingularityIndex, largest: f64) -> Option<f64> {
        let prediction = self.prediction(index);
        if !prediction.is_below(SMALL * largest) {
            let found = self
                .smallest_in_bracket(index, largest)
                .or_else(|| self.smallest_by_iteration(index));
            if let Some(value) = found.filter(|value| *value > SMALL * largest) {
                return Some(value);
            }
        }
        let found = self.smallest_by_factor(index).filter(|value| *value > TINY * largest);
        let prediction = self.prediction(index);
        prediction.forget();
        prediction.expect(found.map_or(0.0, |value| value * value));
        found
    }

    fn prediction(&mut self, index: SingularityIndex) -> &mut Prediction {
        match index {
            SingularityIndex::Actuation => &mut self.actuation,
            SingularityIndex::Constraint => &mut self.constraint,
        }
    }

    fn measure_dense(
        &self,
        mechanism: &Mechanism,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
    ) -> Distances {
        let types: Vec<JointType> = self.joints.iter().map(|joint| joint.joint_type).collect();
        Distances::of_square(&NewtonEuler::new(mechanism, parameters, bodies), &types)
    }

    /// Computes an index at the configuration set by [`Self::place`] by inverse iteration with its
    /// Gram matrix: the actuation index from constraints and actuators together, the constraint index
    /// from the constraints alone. Returns `None` if the iteration fails.
    fn smallest_by_iteration(&mut self, index: SingularityIndex) -> Option<f64> {
        if index == SingularityIndex::Constraint
            && self.joints.iter().all(|joint| joint.constraints == 0)
        {
            return Some(1.0);
        }
        let near = self.prediction(index).shift();
        let found = near.and_then(|shift| self.smallest_at(index, shift));
        found.or_else(|| self.smallest_at(index, Shift::NONE)).or_else(|| {
            let shift = shift_below(self.gram_matrix(index))?;
            self.smallest_at(index, shift)
        })
    }

    /// Computes an index as [`Self::smallest_by_iteration`], with the given shift of the matrix.
    fn smallest_at(&mut self, index: SingularityIndex, shift: Shift) -> Option<f64> {
        let mut lanczos = core::mem::take(&mut self.lanczos);
        let found = self.smallest_with(&mut lanczos, index, shift);
        self.lanczos = lanczos;
        found
    }

    /// Computes an index as [`Self::smallest_at`], with `lanczos` as the buffers of the iteration.
    fn smallest_with(
        &mut self,
        lanczos: &mut Lanczos,
        index: SingularityIndex,
        shift: Shift,
    ) -> Option<f64> {
        self.gram_matrix(index);
        let vector = match index {
            SingularityIndex::Actuation => {
                let start = self.actuation.start((0..self.bodies).map(|_| BLOCK));
                weakest(&mut self.by_bodies, lanczos, start, shift)?
            }
            SingularityIndex::Constraint => {
                let sizes = self.joints.iter().map(|joint| joint.constraints);
                let start = self.constraint.start(sizes);
                weakest(&mut self.by_joints, lanczos, start, shift)?
            }
        };
        let square = self.square_of(index, vector);
        if !shift.is_certain(square) {
            return None;
        }
        self.prediction(index).add(square, vector);
        Some(square.sqrt())
    }

    /// Computes the Gram matrix of an index at the configuration set by [`Self::place`].
    fn gram_matrix(&mut self, index: SingularityIndex) -> &mut BlockCholesky {
        match index {
            SingularityIndex::Actuation => {
                self.multiply_between_bodies();
                &mut self.by_bodies
            }
            SingularityIndex::Constraint => {
                self.multiply_between_joints();
                &mut self.by_joints
            }
        }
    }

    /// Returns the largest magnitude of an entry of the scaled balance matrix at the configuration
    /// set by [`Self::place`].
    fn largest(&self) -> f64 {
        let greater = |a: f64, b: f64| if a > b { a } else { b };
        let mut largest = [0.0; BLOCK];
        for (joint, on) in self.joints.iter().zip(&self.on) {
            for (_, columns) in joint.ends.iter().zip(on).filter(|(body, _)| **body > 0) {
                for column in &columns[..joint.unknowns] {
                    (0..BLOCK).for_each(|i| largest[i] = greater(column[i].abs(), largest[i]));
                }
            }
        }
        largest.into_iter().fold(0.0, greater)
    }

    /// Computes the scaled unit wrenches of all joints at the configuration of `bodies`.
    fn place(&mut self, parameters: &Parameters<f64>, bodies: &Bodies<f64>) {
        let length = parameters.length;
        for (index, joint) in self.joints.iter().enumerate() {
            let (j, k) = (&bodies.frame_j[index], &bodies.frame_k[index]);
            let mut wrenches = [Wrench::zero(); BLOCK];
            let constraints = joint.joint_type.constraints();
            for (wrench, constraint) in wrenches.iter_mut().zip(constraints) {
                let scale = if constraint.is_moment() { length } else { 1.0 };
                *wrench = constraint.wrench(j, k, parameters.pitch[index]) * scale;
            }
            for (wrench, dof) in wrenches[joint.constraints..].iter_mut().zip(&joint.drives) {
                let scale = if dof.translates() { 1.0 } else { length };
                *wrench = dof.effort(j, k) * scale;
            }
            for (end, sense) in [(0, -1.0), (1, 1.0)] {
                let body = joint.ends[end];
                let com = bodies.pose[body].apply(parameters.com[body]);
                if body == 0 {
                    continue;
                }
                let columns = &mut self.on[index][end];
                for (column, wrench) in columns.iter_mut().zip(&wrenches[..joint.unknowns]) {
                    let force = (wrench.force * sense).to_array();
                    let moment = (wrench.moment_about(com) * (sense / length)).to_array();
                    for i in 0..3 {
                        (column[i], column[i + 3]) = (force[i], moment[i]);
                    }
                }
            }
        }
    }

    /// Computes the Gram matrix of constraints and actuators with one block row for each body, at
    /// the configuration set by [`Self::place`].
    fn multiply_between_bodies(&mut self) {
        let matrix = &mut self.by_bodies;
        matrix.clear();
        for (index, joint) in self.joints.iter().enumerate() {
            let [on_a, on_b] = &self.on[index];
            let (on_a, on_b) = (&on_a[..joint.unknowns], &on_b[..joint.unknowns]);
            let [slot_a, slot_b, slot_ab] = self.body_slots[index];
            for (slot, on) in [(slot_a, on_a), (slot_b, on_b)] {
                let Some(slot) = slot else { continue };
                add_squares(matrix.block(slot).0, on, BLOCK);
            }
            let Some(slot) = slot_ab else { continue };
            match matrix.block(slot) {
                (block, true) => add_outer_products(block, on_b, on_a, BLOCK),
                (block, false) => add_outer_products(block, on_a, on_b, BLOCK),
            }
        }
    }

    /// Computes the Gram matrix of the constraints with one block row for each joint, at the
    /// configuration set by [`Self::place`].
    fn multiply_between_joints(&mut self) {
        for ((joint, on), across) in self.joints.iter().zip(&self.on).zip(&mut self.across) {
            for ((end, on), across) in joint.ends.iter().zip(on).zip(across) {
                if *end == 0 {
                    continue;
                }
                for (k, column) in on[..joint.constraints].iter().enumerate() {
                    across.iter_mut().zip(column).for_each(|(row, entry)| row[k] = *entry);
                }
            }
        }
        let matrix = &mut self.by_joints;
        matrix.clear();
        for Meeting { joints: [a, b], ends: [end_a, end_b], slot } in &self.joint_slots {
            let (on_a, on_b) = (&self.across[*a][*end_a], &self.across[*b][*end_b]);
            let size = |joint: usize| self.joints[joint].constraints;
            match matrix.block(*slot) {
                (block, _) if a == b => add_squares(block, on_a, size(*a)),
                (block, true) => add_outer_products(block, on_b, on_a, size(*b)),
                (block, false) => add_outer_products(block, on_a, on_b, size(*a)),
            }
        }
        for &(joint, end) in &self.hub_rows {
            matrix.set_hub_row(joint, &self.across[joint][end]);
        }
    }
}
