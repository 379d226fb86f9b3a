//! Data with which generated source code computes the singularity index of type 2 (actuation).
//!
//! The index is the smallest singular value of the dimensionless balance A of all bodies, see
//! [`Distances::actuation`](stiction_core::statics::Distances). With the bodies in a spanning tree,
//! `A x = y` and its transpose are solved by recursion along the tree and by a dense system whose
//! size is the number of free motions of the tree's joints. In a joint of the tree, the unit
//! wrenches of the constraints, about the joint's origin, are orthonormal and span all directions
//! except those of the free motions; the wrench of the joint therefore replaces the unknowns of the
//! joint. All other unknowns (those of joints that close loops, and of gearings) are columns of the
//! dense system.
//!
//! Equation (P9) of the book's theory.

use std::collections::VecDeque;
use stiction_core::joint::{Constraint, Dof, JointType};
use stiction_core::kinematics::Bodies;
use stiction_core::mechanism::{Joint, Mechanism};
use stiction_core::parameters::Parameters;
use stiction_core::scalar::Scalar;
use stiction_core::spatial::{Twist, Vec3, Wrench};

/// Largest number of passes of the inverse iteration.
pub(crate) const INDEX_PASSES: usize = 40;

/// Spanning tree, free motions of its joints, and columns of the dense system.
#[derive(Clone, Debug)]
pub(crate) struct IndexLayout {
    /// For the ground and each body, in the order of the tree, the tree index of its parent. Index
    /// 0 is the ground; parents precede their children.
    pub(crate) parents: Vec<usize>,
    /// For each free motion of a joint of the tree, the tree index of the body that the joint
    /// connects to its parent.
    pub(crate) motions: Vec<usize>,
    /// Unit wrenches that make up the columns of the dense system.
    pub(crate) terms: Vec<Term>,
    /// For each free motion and term: +1 or -1 if the motion moves only the first or only the
    /// second body of the term, otherwise 0.
    pub(crate) signs: Vec<Vec<i8>>,
    /// Number of columns of the dense system. The last `spins` columns resist local passive degrees
    /// of freedom.
    pub(crate) columns: usize,
    /// Number of local passive degrees of freedom.
    pub(crate) spins: usize,
    /// For each body of the tree except the ground, the index of the body in the mechanism, and the
    /// index of the joint that connects the body to its parent.
    outer: Vec<(usize, usize)>,
    free: Vec<Free>,
    wrenches: Vec<Source>,
}

/// Unit wrench that belongs to a column of the dense system. It acts on one body, and its opposite
/// acts on another body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Term {
    pub(crate) column: usize,
    /// Tree indices of the body on which the wrench acts, and of the body on which its opposite
    /// acts.
    pub(crate) on: [usize; 2],
}

/// Free motion of a joint of the tree.
#[derive(Clone, Copy, Debug)]
enum Free {
    /// Degree of freedom of the joint with this index.
    Dof(usize, Dof),
    /// Rotation about a world axis (second index) through the origin of a spherical joint (first
    /// index).
    Rotation(usize, usize),
    /// One of the six unit motions about the reference point: translations 0 to 2, rotations 3 to
    /// 5.
    Any(usize),
}

/// Source of the unit wrench of a term.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// Constraint of the joint with this index.
    Constraint(usize, Constraint),
    /// Force along a world axis (second index) through the origin of a joint (first index) that
    /// resists all forces.
    Force(usize, usize),
    /// Moment about the world axis with this index, in a joint that resists all rotations.
    Moment(usize),
    /// Effort of an actuator, by the index of its joint and its degree of freedom.
    Effort(usize, Dof),
    /// Part of the effort of a gearing that acts on one joint.
    Gearing { gearing: usize, part: usize, joint: usize, dof: Dof, is_length: bool },
    /// Moment about an axis that is fixed in a body, against a local passive degree of freedom.
    Spin { body: usize, axis: Vec3<f64> },
}

/// Returns true if, for joints of this type, the unit wrenches of constraints and actuators about
/// the origin of the joint are orthonormal.
fn is_orthonormal(joint_type: JointType) -> bool {
    !matches!(joint_type, JointType::Helical | JointType::Planar | JointType::Free)
}

/// Lists the unknowns of a joint: constraint wrenches and actuator efforts.
fn unknowns(index: usize, joint: &Joint) -> Vec<Source> {
    let (mut forces, mut moments, mut others) = (Vec::new(), Vec::new(), Vec::new());
    for constraint in joint.joint_type.constraints() {
        let source = Source::Constraint(index, *constraint);
        match constraint {
            Constraint::Force(_) => forces.push(source),
            Constraint::Moment(_) => moments.push(source),
            Constraint::Thread | Constraint::Normal => others.push(source),
        }
    }
    // Three orthonormal forces (or moments) span all directions, so forces (or moments) along the
    // world axes can replace them, and need fewer operations.
    if forces.len() == 3 {
        forces = (0..3).map(|axis| Source::Force(index, axis)).collect();
    }
    if moments.len() == 3 {
        moments = (0..3).map(Source::Moment).collect();
    }
    let dofs = joint.joint_type.dofs();
    let efforts = joint.actuated_dofs().map(|dof| Source::Effort(index, dofs[dof]));
    forces.into_iter().chain(moments).chain(others).chain(efforts).collect()
}

impl IndexLayout {
    /// Chooses the spanning tree, and lists its free motions and the columns of the dense system.
    /// `spins` are the local passive degrees of freedom, each given by the index of a body and an
    /// axis in the frame of this body.
    pub(crate) fn new(mechanism: &Mechanism, spins: &[(usize, Vec3<f64>)]) -> Self {
        let joints = mechanism.joints();
        let mut place_of = vec![None; mechanism.bodies().len()];
        place_of[0] = Some(0);
        let (mut parents, mut outer) = (vec![0], Vec::new());
        let mut is_in_tree = vec![false; joints.len()];
        let mut open = VecDeque::from([0]);
        while let Some(body) = open.pop_front() {
            for (index, joint) in joints.iter().enumerate() {
                let ends = [joint.predecessor.0, joint.successor.0];
                let Some(at) = ends.iter().position(|end| *end == body) else { continue };
                let next = ends[1 - at];
                if let (Some(parent), None) = (place_of[body], place_of[next]) {
                    place_of[next] = Some(parents.len());
                    parents.push(parent);
                    outer.push((next, index));
                    is_in_tree[index] = true;
                    open.push_back(next);
                }
            }
        }
        let place = |body: usize| place_of[body].unwrap_or(0);
        let (mut motions, mut free) = (Vec::new(), Vec::new());
        for (k, (_, index)) in outer.iter().enumerate() {
            let joint = &joints[*index];
            let driven: Vec<usize> = joint.actuated_dofs().collect();
            let dofs = joint.joint_type.dofs();
            let found: Vec<Free> = match joint.joint_type {
                JointType::Spherical if driven.is_empty() => {
                    (0..3).map(|axis| Free::Rotation(*index, axis)).collect()
                }
                joint_type if is_orthonormal(joint_type) => (0..dofs.len())
                    .filter(|dof| !driven.contains(dof))
                    .map(|dof| Free::Dof(*index, dofs[dof]))
                    .collect(),
                _ => (0..6).map(Free::Any).collect(),
            };
            motions.extend(found.iter().map(|_| k + 1));
            free.extend(found);
        }
        let (mut terms, mut wrenches, mut columns) = (Vec::new(), Vec::new(), 0);
        for (index, joint) in joints.iter().enumerate() {
            if is_in_tree[index] && is_orthonormal(joint.joint_type) {
                continue;
            }
            let on = [place(joint.successor.0), place(joint.predecessor.0)];
            for source in unknowns(index, joint) {
                terms.push(Term { column: columns, on });
                wrenches.push(source);
                columns += 1;
            }
        }
        for (gearing, content) in mechanism.gearings().iter().enumerate() {
            for (part, geared) in content.dofs.iter().enumerate() {
                let joint = &joints[geared.joint.0];
                let on = [place(joint.successor.0), place(joint.predecessor.0)];
                terms.push(Term { column: columns, on });
                let dof = joint.joint_type.dofs()[geared.dof];
                let (joint, is_length) = (geared.joint.0, content.is_length());
                wrenches.push(Source::Gearing { gearing, part, joint, dof, is_length });
            }
            columns += 1;
        }
        for &(body, axis) in spins {
            terms.push(Term { column: columns, on: [place(body), 0] });
            wrenches.push(Source::Spin { body, axis });
            columns += 1;
        }
        let moves = |outer: usize, mut place: usize| {
            while place > outer {
                place = parents[place];
            }
            place == outer
        };
        let sign = |outer: usize, term: &Term| match term.on.map(|place| moves(outer, place)) {
            [true, false] => 1,
            [false, true] => -1,
            _ => 0,
        };
        let signs = motions
            .iter()
            .map(|outer| terms.iter().map(|term| sign(*outer, term)).collect())
            .collect();
        Self { parents, motions, terms, signs, columns, spins: spins.len(), outer, free, wrenches }
    }

    /// Number of columns of the dense system that are not needed for equilibrium.
    pub(crate) fn redundant(&self) -> usize {
        self.columns.saturating_sub(self.motions.len())
    }

    /// Number of values that the inverse iteration keeps in memory at the same time.
    pub(crate) fn numbers(&self) -> usize {
        let (bodies, motions, columns) = (self.outer.len(), self.motions.len(), self.columns);
        let null = self.redundant() * (6 * bodies + columns) + self.spins * 6 * bodies;
        let vectors = 2 * 12 * (bodies + 1) + 6 * bodies + 4 * columns + 2 * motions;
        columns * motions + null + vectors
    }

    /// Computes the dimensionless data at a position: the centre of mass of each body, the origin
    /// of each joint of the tree, the free motions and the terms. Each motion (velocity and angular
    /// velocity) and each term (force and moment) has six components about the reference point.
    pub(crate) fn places<T: Scalar>(
        &self,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) -> Vec<T> {
        let over = parameters.length.recip();
        let frames = |joint: usize| (&bodies.frame_j[joint], &bodies.frame_k[joint]);
        let mut all = Vec::new();
        for (body, _) in &self.outer {
            all.push(bodies.pose[*body].apply(parameters.com[*body]) * over);
        }
        all.extend(self.outer.iter().map(|(_, joint)| bodies.frame_j[*joint].position * over));
        for free in &self.free {
            let Twist { linear, angular } = match *free {
                Free::Dof(joint, dof) => {
                    let (j, k) = frames(joint);
                    dof.twist(j, k, parameters.pitch[joint])
                }
                Free::Rotation(joint, axis) => {
                    Twist::rotation(Vec3::unit(axis), bodies.frame_j[joint].position)
                }
                Free::Any(k) if k < 3 => Twist::translation(Vec3::unit(k)),
                Free::Any(k) => Twist { linear: Vec3::zero(), angular: Vec3::unit(k - 3) },
            };
            let is_length = match free {
                Free::Dof(_, dof) => dof.translates(),
                Free::Rotation(..) => false,
                Free::Any(_) => true,
            };
            all.extend([if is_length { linear } else { linear * over }, angular]);
        }
        for source in &self.wrenches {
            let (wrench, is_moment) = match *source {
                Source::Constraint(joint, constraint) => {
                    let (j, k) = frames(joint);
                    (constraint.wrench(j, k, parameters.pitch[joint]), constraint.is_moment())
                }
                Source::Force(joint, axis) => {
                    let at = bodies.frame_j[joint].position;
                    (Wrench::force_through(Vec3::unit(axis), at), false)
                }
                Source::Moment(axis) => (Wrench::couple(Vec3::unit(axis)), true),
                Source::Effort(joint, dof) => {
                    let (j, k) = frames(joint);
                    (dof.effort(j, k), !dof.translates())
                }
                Source::Gearing { gearing, part, joint, dof, is_length } => {
                    let (j, k) = frames(joint);
                    let coefficient = parameters.gearings[gearing].coefficients[part];
                    (dof.effort(j, k) * coefficient, !is_length)
                }
                Source::Spin { body, axis } => {
                    (Wrench::couple(bodies.pose[body].rotation * axis.lift()), true)
                }
            };
            let Wrench { force, moment } = wrench;
            all.extend(match is_moment {
                true => [force * parameters.length, moment],
                false => [force, moment * over],
            });
        }
        all.into_iter().flat_map(|vector| vector.to_array()).collect()
    }
}
