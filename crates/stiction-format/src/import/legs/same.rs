//! Compares two models of a robot: one read from a text with groups of legs, the other from a text
//! without such groups.

use crate::model_file::ModelFile;
use std::collections::HashMap;
use stiction_core::friction::Combine;
use stiction_core::joint::JointType;
use stiction_core::mechanism::{
    BodyId, Bushing, DriveTrain, GearedDof, Gearing, Joint, JointId, JointSpring, Mechanism,
    RangeOf, Spring,
};
use stiction_core::spatial::{Mat3, Quaternion, Vec3};

/// Greatest relative difference of numbers that count as equal.
const TOLERANCE: f64 = 1e-12;

/// Tests if both models contain the same parts with the same names and numbers, in any order. Joint frames may differ by
/// rotations that do not change the motion or the friction of the joint.
pub(in crate::import) fn is_same(a: &ModelFile, b: &ModelFile) -> bool {
    let Some(map) = Map::new(&a.mechanism, &b.mechanism) else { return false };
    map.is_same(&a.mechanism, &b.mechanism)
        && a.visuals.len() == b.visuals.len()
        && a.default_friction == b.default_friction
        && a.motions.len() == b.motions.len()
}

/// For each body and joint of the first mechanism, the index in the second mechanism.
struct Map {
    bodies: Vec<usize>,
    joints: Vec<usize>,
}

/// Returns the index in `other` of each name in `own`; `None` unless both lists contain the same
/// names.
fn indices(own: &[&str], other: &[&str]) -> Option<Vec<usize>> {
    let known: HashMap<&str, usize> =
        other.iter().enumerate().map(|(index, name)| (*name, index)).collect();
    let found = own.iter().map(|name| known.get(name).copied()).collect::<Option<Vec<usize>>>();
    found.filter(|_| own.len() == other.len())
}

/// Applies `map` to copies of the parts, and sorts the copies by name.
fn mapped<T: Clone>(parts: &[T], map: impl FnMut(&mut T), name: fn(&T) -> &String) -> Vec<T> {
    let mut parts = parts.to_vec();
    parts.iter_mut().for_each(map);
    parts.sort_by(|a, b| name(a).cmp(name(b)));
    parts
}

impl Map {
    fn new(a: &Mechanism, b: &Mechanism) -> Option<Self> {
        let [bodies, joints] = [
            [a, b].map(|of| of.bodies().iter().map(|body| body.name.as_str()).collect()),
            [a, b].map(|of| of.joints().iter().map(|joint| joint.name.as_str()).collect()),
        ]
        .map(|[own, other]: [Vec<&str>; 2]| indices(&own, &other));
        Some(Self { bodies: bodies?, joints: joints? })
    }

    /// Creates the map of a mechanism to itself.
    fn identity(of: &Mechanism) -> Self {
        let (bodies, joints) = (of.bodies().len(), of.joints().len());
        Self { bodies: (0..bodies).collect(), joints: (0..joints).collect() }
    }

    fn body(&self, id: BodyId) -> BodyId {
        BodyId(self.bodies[id.0])
    }

    fn joint(&self, id: JointId) -> JointId {
        JointId(self.joints[id.0])
    }

    fn dofs(&self, dofs: &mut [GearedDof]) {
        dofs.iter_mut().for_each(|dof| dof.joint = self.joint(dof.joint));
        dofs.sort_by_key(|dof| (dof.joint.0, dof.dof));
    }

    fn is_same(&self, a: &Mechanism, b: &Mechanism) -> bool {
        let same_bodies = a.bodies().iter().zip(&self.bodies).all(|(one, other)| {
            let other = &b.bodies()[*other];
            let columns = one.inertia.columns.iter().zip(&other.inertia.columns);
            is_near(one.mass, other.mass)
                && is_near_point(one.com, other.com)
                && columns.into_iter().all(|(one, other)| is_near_point(*one, *other))
        });
        let same_joints = a
            .joints()
            .iter()
            .zip(&self.joints)
            .all(|(one, other)| self.is_same_joint(one, &b.joints()[*other]));
        same_bodies
            && same_joints
            && self.connections(a) == Self::identity(b).connections(b)
            && self.drives(a) == Self::identity(b).drives(b)
            && (a.gravity(), a.base()) == (b.gravity(), b.base())
    }

    /// Springs and bushings, sorted by name, with the body and joint indices of the second
    /// mechanism.
    fn connections(&self, of: &Mechanism) -> (Vec<Spring>, Vec<JointSpring>, Vec<Bushing>) {
        let ends = |ends: [BodyId; 2]| ends.map(|id| self.body(id));
        (
            mapped(of.springs(), |own| own.ends = ends(own.ends), |own| &own.name),
            mapped(of.joint_springs(), |own| own.joint = self.joint(own.joint), |own| &own.name),
            mapped(of.bushings(), |own| own.ends = ends(own.ends), |own| &own.name),
        )
    }

    /// Drive trains and gearings, sorted by name, with the joint indices of the second mechanism.
    fn drives(&self, of: &Mechanism) -> (Vec<DriveTrain>, Vec<Gearing>) {
        let train = |own: &mut DriveTrain| {
            self.dofs(&mut own.dofs);
            if let Some(axis) = &mut own.rotor_axis {
                axis.body = self.body(axis.body);
            }
        };
        (
            mapped(of.drive_trains(), train, |own| &own.name),
            mapped(of.gearings(), |own| self.dofs(&mut own.dofs), |own| &own.name),
        )
    }

    fn is_same_joint(&self, a: &Joint, b: &Joint) -> bool {
        self.body(a.predecessor) == b.predecessor
            && self.body(a.successor) == b.successor
            && (a.joint_type, a.pitch, &a.actuated) == (b.joint_type, b.pitch, &b.actuated)
            && a.friction == b.friction
            && a.compliance == b.compliance
            && a.ranges == b.ranges
            && is_near_point(a.frame_j.position, b.frame_j.position)
            && is_near_point(a.frame_k.position, b.frame_k.position)
            && has_same_axes(a, b)
            && has_same_start(a, b)
    }
}

fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() <= TOLERANCE * a.abs().max(b.abs())
}

fn is_near_point(a: Vec3<f64>, b: Vec3<f64>) -> bool {
    (a + -b).norm() <= TOLERANCE * a.norm().max(b.norm()).max(1e-3)
}

fn is_near_rotation(a: Mat3<f64>, b: Mat3<f64>) -> bool {
    a.columns.iter().zip(&b.columns).all(|(a, b)| is_near_point(*a, *b))
}

/// Rotation of the successor relative to the predecessor at zero coordinates.
fn between(joint: &Joint) -> Mat3<f64> {
    joint.frame_j.rotation * joint.frame_k.rotation.transpose()
}

/// Tests if the joint frames of two joints have the same orientations, as far as the motion, the
/// ranges and the friction depend on these orientations.
fn has_same_axes(a: &Joint, b: &Joint) -> bool {
    let are_equal = is_near_rotation(a.frame_j.rotation, b.frame_j.rotation)
        && is_near_rotation(a.frame_k.rotation, b.frame_k.rotation);
    // The normal load of pads depends on the direction of the x axis.
    let has_pads = a.friction.iter().any(|own| own.load.combine == Combine::Pads);
    if are_equal || has_pads {
        return are_equal;
    }
    let z = |joint: &Joint| joint.frame_j.rotation.columns[2];
    let is_turned = is_near_rotation(between(a), between(b));
    match a.joint_type {
        JointType::Revolute
        | JointType::Prismatic
        | JointType::Helical
        | JointType::Cylindrical => is_near_point(z(a), z(b)) && is_turned,
        JointType::Fixed => is_turned,
        JointType::Spherical => a.ranges.iter().all(|range| range.of != RangeOf::Tilt),
        JointType::Universal | JointType::Planar | JointType::Free => false,
    }
}

/// Tests if two joints have the same initial guess. For spherical joints, the relative rotations of
/// the bodies are compared.
fn has_same_start(a: &Joint, b: &Joint) -> bool {
    if a.joint_type == JointType::Spherical {
        let turn = |joint: &Joint| {
            let start = joint.start.as_deref();
            let start =
                start.map_or(Mat3::identity(), |q| Quaternion::from_coordinates(q).rotation());
            joint.frame_j.rotation * start * joint.frame_k.rotation.transpose()
        };
        return is_near_rotation(turn(a), turn(b));
    }
    match (&a.start, &b.start) {
        (Some(a), Some(b)) => a.iter().zip(b).all(|(a, b)| is_near(*a, *b)),
        (a, b) => a == b,
    }
}
