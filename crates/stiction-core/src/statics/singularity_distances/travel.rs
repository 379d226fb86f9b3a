//! Bounds on the changes of the singularity indices between two configurations, by Weyl's
//! inequality: a singular value changes by at most the norm of the change of the matrix.

use super::super::distance::Distances;
use super::{Content, SingularityDistances};
use crate::joint::{Carrier, Constraint, Dof};
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::spatial::{Mat3, Vec3};

/// Places on which the unit wrenches of the joints depend.
#[derive(Clone, Debug, Default)]
pub(super) struct Places {
    /// Orientation and centre of mass of each body.
    bodies: Vec<(Mat3<f64>, Vec3<f64>)>,
    /// Origins of the frames J and K of each joint.
    joints: Vec<[Vec3<f64>; 2]>,
}

/// Sums of the norms of the changes of the blocks of a matrix: for each body, and the largest sum of
/// a joint. Both contain a sum for the constraints alone, then one for all unknowns.
#[derive(Clone, Debug, Default)]
pub(super) struct Changes {
    of_bodies: Vec<[f64; 2]>,
    of_joints: [f64; 2],
    of_joint: [f64; 2],
}

impl Changes {
    fn begin(&mut self, bodies: usize) {
        self.of_bodies.clear();
        self.of_bodies.resize(bodies, [0.0; 2]);
        self.of_joints = [0.0; 2];
    }

    /// Adds the block of a joint on the body with the index `body`, the ground not counted.
    /// `squares` are squared Frobenius norms: of the changes of the constraints, and of the
    /// actuators.
    fn add(&mut self, body: usize, squares: [f64; 2]) {
        let norms = [squares[0].sqrt(), (squares[0] + squares[1]).sqrt()];
        for (k, norm) in norms.into_iter().enumerate() {
            self.of_joint[k] += norm;
            self.of_bodies[body][k] += norm;
        }
    }

    fn end_joint(&mut self) {
        let sums = core::mem::take(&mut self.of_joint);
        self.of_joints = core::array::from_fn(|k| self.of_joints[k].max(sums[k]));
    }

    /// Returns bounds on the norms of the changes of both matrices: a norm is at most the geometric
    /// mean of the largest sum for a joint and the largest sum for a body.
    fn bounds(&self) -> Distances {
        let bound = |k: usize| {
            let most = self.of_bodies.iter().fold(0.0_f64, |most, sums| most.max(sums[k]));
            (self.of_joints[k] * most).sqrt()
        };
        Distances { constraint: bound(0), actuation: bound(1) }
    }
}

/// Numbers of the unit wrenches of a joint by the parts on which they depend.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Kinds {
    /// Forces, and wrenches of threads, through the origin of J in axes of J.
    forces: f64,
    /// Moments in axes of J.
    moments: f64,
    /// Moments along the common normal of an axis of J and an axis of K.
    normals: f64,
}

impl Kinds {
    pub(super) fn of(constraints: &[Constraint]) -> Self {
        let mut kinds = Self::default();
        for constraint in constraints {
            match constraint {
                Constraint::Force(_) | Constraint::Thread => kinds.forces += 1.0,
                Constraint::Moment(_) => kinds.moments += 1.0,
                Constraint::Normal => kinds.normals += 1.0,
            }
        }
        kinds
    }
}

impl SingularityDistances {
    /// Computes upper bounds on the magnitudes of the changes of both indices from the
    /// configuration of the preceding call of this method to that of `bodies`; infinite in the
    /// first call. The bounds follow from the rotations of the bodies and from the changes of the
    /// distances between joints and centres of mass, which cost less than the matrices.
    pub fn travel(&mut self, parameters: &Parameters<f64>, bodies: &Bodies<f64>) -> Distances {
        let Self { joints, places: Places { bodies: known, joints: origins }, changes, .. } = self;
        let is_first = known.is_empty();
        let (count, length) = (bodies.pose.len(), parameters.length);
        known.resize(2 * count, (Mat3::identity(), Vec3::zero()));
        origins.resize(2 * joints.len(), [Vec3::zero(); 2]);
        // The second halves contain the places of the preceding call.
        known.copy_within(..count, count);
        origins.copy_within(..joints.len(), joints.len());
        for (known, (pose, com)) in known.iter_mut().zip(bodies.pose.iter().zip(&parameters.com)) {
            *known = (pose.rotation, pose.apply(*com));
        }
        let (now, before) = known.split_at(count);
        changes.begin(count - 1);
        for (index, joint) in joints.iter().enumerate() {
            let at = [&bodies.frame_j[index], &bodies.frame_k[index]].map(|frame| frame.position);
            origins[index] = at;
            let at_before = origins[joints.len() + index];
            let turned = joint.ends.map(|body| turn(&now[body].0, &before[body].0));
            for end in 0..2 {
                let Some(body) = joint.ends[end].checked_sub(1) else { continue };
                let (com, com_before) = (now[body + 1].1, before[body + 1].1);
                // Arm of the forces through the origins of J and K, and its change.
                let arms: [(f64, f64); 2] = core::array::from_fn(|k| {
                    let (arm, arm_before) = (at[k] - com, at_before[k] - com_before);
                    (arm.norm(), (arm - arm_before).norm())
                });
                let pitch = parameters.pitch[index].abs();
                changes.add(body, squares(joint, turned, arms, (end, pitch, length)));
            }
            changes.end_joint();
        }
        match is_first {
            true => Distances { actuation: f64::INFINITY, constraint: f64::INFINITY },
            false => changes.bounds(),
        }
    }
}

/// Returns the norm of the difference of two rotation matrices: their difference has two equal
/// singular values and a zero.
fn turn(a: &Mat3<f64>, b: &Mat3<f64>) -> f64 {
    let pairs = a.columns.iter().zip(&b.columns);
    (0.5 * pairs.map(|(a, b)| (*a - *b).norm_squared()).sum::<f64>()).sqrt()
}

/// Bounds the squared Frobenius norms of the changes of the unit wrenches of a joint, constraints
/// and actuators, on its predecessor (`end` 0) or successor (`end` 1). `turned` are the norms of the
/// changes of the orientations of predecessor and successor. `arms` are the arms of forces through
/// the origins of J and K and their changes.
fn squares(
    joint: &Content,
    turned: [f64; 2],
    arms: [(f64, f64); 2],
    (end, pitch, length): (usize, f64, f64),
) -> [f64; 2] {
    // Change of a force that turns with the body `carrier` and acts at the origin of a frame, and
    // of its moment.
    let force = |carrier: usize, origin: usize, pitch: f64| {
        let ((arm, change), by) = (arms[origin], turned[carrier]);
        // Arms from the predecessor to J, and from the successor to K, turn with the body.
        let change = if origin == end && carrier == end { 0.0 } else { change };
        let moment = (arm * by + change + pitch * by) / length;
        by * by + moment * moment
    };
    let Kinds { forces, moments, normals } = joint.kinds;
    let [predecessor, successor] = turned;
    let normal = predecessor + successor;
    let constraints = forces * force(0, 0, pitch)
        + moments * predecessor * predecessor
        + normals * normal * normal;
    let drive = |dof: &Dof| {
        let carrier = match dof.carrier {
            Carrier::Predecessor => 0,
            Carrier::Successor => 1,
        };
        if dof.translates() { force(carrier, 1, 0.0) } else { turned[carrier].powi(2) }
    };
    [constraints, joint.drives.iter().map(drive).sum()]
}
