//! Merges chains of joints through massless bodies into one joint with more degrees of freedom.

use super::super::context::Context;
use super::super::description::{Coordinate, Description, GROUND, Joint};
use super::super::rotation::z_and_x;
use super::{SAME, are_parallel, are_perpendicular, remove, size_of};
use crate::diagnostic::quoted;
use stiction_core::joint::JointType::{
    self, Cylindrical, Planar, Prismatic, Revolute, Spherical, Universal,
};
use stiction_core::spatial::{Pose, Vec3};

/// Merges chains of passive hinges and slides, the longest first.
pub(super) fn merge(context: &Context<'_>, robot: &mut Description) {
    let size = size_of(robot);
    for length in [3, 2] {
        let mut start = 0;
        while start < robot.joints.len() {
            match chain_from(robot, start, length).and_then(|chain| replaced(robot, &chain, size)) {
                Some((joint, chain)) => {
                    replace(context, robot, joint, &chain);
                    start = 0;
                }
                None => start += 1,
            }
        }
    }
}

/// Returns the indices of `length` passive hinges and slides in series, from joint `start` on.
/// `None` unless the bodies between these joints are massless and no other part refers to these
/// bodies.
fn chain_from(robot: &Description, start: usize, length: usize) -> Option<Vec<usize>> {
    let mut chain = vec![start];
    while chain.len() < length {
        let body = robot.joints[*chain.last()?].to;
        let touching = |joint: &&Joint| joint.from == body || joint.to == body;
        let is_free = body != GROUND
            && robot.bodies[body].is_massless()
            && robot.joints.iter().filter(touching).count() == 2
            && !robot.springs.iter().any(|spring| spring.ends.contains(&body));
        let next = robot.joints.iter().position(|joint| joint.from == body);
        chain.push(next.filter(|next| is_free && !chain.contains(next))?);
    }
    let is_passive = |joint: &usize| {
        let content = &robot.joints[*joint];
        let is_simple = matches!(content.kind, Revolute | Prismatic);
        let geared = |gearing: &super::super::description::Gearing| {
            gearing.terms.iter().any(|term| term.0 == *joint)
        };
        is_simple
            && !content.closes
            && !content.is_extended()
            && !robot.gearings.iter().any(geared)
            && !robot
                .joint_motors
                .iter()
                .flat_map(|motor| &motor.terms)
                .any(|term| term.0 == *joint)
            && content
                .dofs
                .iter()
                .all(|dof| !dof.actuated && dof.armature == 0.0 && dof.spring.is_none())
    };
    chain.iter().all(is_passive).then_some(chain)
}

/// Geometry of a chain of joints at zero coordinates. All poses are expressed in the frame of the
/// body between the first and the second joint.
pub(super) struct Chain<'a> {
    joints: Vec<&'a Joint>,
    /// Pose of the frame of each joint.
    pub(super) frames: Vec<Pose<f64>>,
    /// Pose of the body before the chain.
    first: Pose<f64>,
    /// Pose of the body after the chain.
    last: Pose<f64>,
}

impl<'a> Chain<'a> {
    pub(super) fn new(robot: &'a Description, chain: &[usize]) -> Option<Self> {
        let joints: Vec<&Joint> = chain.iter().map(|&joint| &robot.joints[joint]).collect();
        let first = joints.first()?;
        let mut at = Pose::identity();
        let mut frames = vec![first.frame_k];
        for joint in joints.iter().skip(1) {
            frames.push(at * joint.frame_j);
            at = at * joint.frame_j * joint.frame_k.inverse();
        }
        let before = first.frame_k * first.frame_j.inverse();
        Some(Self { frames, first: before, last: at, joints })
    }

    pub(super) fn axis(&self, index: usize) -> Vec3<f64> {
        self.frames[index].rotation.columns[2]
    }

    fn kinds(&self) -> Vec<JointType> {
        self.joints.iter().map(|joint| joint.kind).collect()
    }

    /// Distance of a point from the axis of a joint.
    fn distance(&self, index: usize, point: Vec3<f64>) -> f64 {
        (point + -self.frames[index].position).cross(self.axis(index)).norm()
    }

    /// Point where the axes of two joints meet; `None` if they do not meet.
    pub(super) fn crossing(&self, a: usize, b: usize, size: f64) -> Option<Vec3<f64>> {
        let (u, v) = (self.axis(a), self.axis(b));
        let between = self.frames[b].position + -self.frames[a].position;
        let normal = u.cross(v);
        let square = normal.norm_squared();
        if square <= SAME {
            return None;
        }
        let along = between.cross(v).dot(normal) / square;
        let point = self.frames[a].position + u * along;
        (self.distance(b, point) <= SAME * size).then_some(point)
    }

    /// Creates a joint of this type whose frames coincide with `frame` at zero coordinates.
    pub(super) fn joint(&self, kind: JointType, frame: Pose<f64>, dofs: Vec<Coordinate>) -> Joint {
        let (first, last) = (self.joints[0], self.joints[self.joints.len() - 1]);
        let mut joint = Joint::new(self.name(), kind, (first.from, last.to));
        joint.frame_j = self.first.inverse() * frame;
        joint.frame_k = self.last.inverse() * frame;
        if !dofs.is_empty() {
            joint.dofs = dofs;
        }
        joint.place = first.place.clone();
        let names: Vec<String> = self.joints.iter().map(|joint| quoted(&joint.name)).collect();
        joint.comment =
            Some(format!("In the file: {}, with massless bodies between them.", names.join(", ")));
        joint
    }

    /// Name of the merged joint: the common beginning of the names of the chain's joints, or the
    /// name of the first joint if this beginning is too short.
    fn name(&self) -> String {
        let names: Vec<&str> = self.joints.iter().map(|joint| joint.name.as_str()).collect();
        let shared = names[1..].iter().fold(names[0], |shared, name| {
            let same = shared.char_indices().zip(name.chars()).find(|((_, a), b)| a != b);
            let end = same.map_or(shared.len().min(name.len()), |((at, _), _)| at);
            shared.get(..end).unwrap_or(shared)
        });
        let shared = shared.trim_end_matches(['_', '-', '.']);
        if shared.chars().count() >= 2 { shared.to_owned() } else { names[0].to_owned() }
    }

    fn dof(&self, index: usize) -> Coordinate {
        self.joints[index].dofs[0]
    }

    fn has_plain_dofs(&self) -> bool {
        let plain =
            |joint: &&Joint| joint.dofs.iter().all(|dof| dof.damping == 0.0 && dof.friction == 0.0);
        self.joints.iter().all(plain)
    }
}

/// Reverses the direction of a coordinate.
fn reversed(dof: Coordinate) -> Coordinate {
    let range = dof.range.map(|[least, greatest]| [-greatest, -least]);
    Coordinate { position: -dof.position, range, ..dof }
}

/// Finds a single joint that permits the same relative motion as a chain of joints. Returns this
/// joint, and the indices of the joints that it replaces.
fn replaced(robot: &Description, chain: &[usize], size: f64) -> Option<(Joint, Vec<usize>)> {
    let parts = Chain::new(robot, chain)?;
    let joint = match parts.kinds().as_slice() {
        [Revolute, Revolute, Revolute] => ball(&parts, size),
        [Prismatic, Prismatic, Revolute] => plate(&parts),
        [Revolute, Revolute] => cross(&parts, size).or_else(|| pin(&parts, size)),
        [Revolute, Prismatic] | [Prismatic, Revolute] => sleeve(&parts),
        _ => None,
    }?;
    Some((joint, chain.to_vec()))
}

/// Merges three hinges whose axes meet in one point into a ball joint.
fn ball(parts: &Chain<'_>, size: f64) -> Option<Joint> {
    let point = parts.crossing(0, 1, size)?;
    let meets = parts.distance(2, point) <= SAME * size;
    let turns = !are_parallel(parts.axis(1), parts.axis(2));
    if !meets || !turns || !parts.has_plain_dofs() {
        return None;
    }
    let frame = Pose::at(point);
    let mut joint = parts.joint(Spherical, frame, Vec::new());
    // Relative rotation of the ball joint in the file's configuration.
    let across =
        parts.joints.iter().zip(&parts.frames).fold(Pose::identity(), |at, (own, frame)| {
            at * *frame * own.across() * frame.inverse()
        });
    let rotation = across.rotation;
    joint.start = Some(Pose { rotation, position: Vec3::zero() });
    Some(joint)
}

/// Merges two hinges whose axes are perpendicular and meet in one point into a universal joint.
fn cross(parts: &Chain<'_>, size: f64) -> Option<Joint> {
    let (first, second) = (parts.axis(0), parts.axis(1));
    if !are_perpendicular(first, second) {
        return None;
    }
    let position = parts.crossing(0, 1, size)?;
    let frame = Pose { rotation: z_and_x(first, second)?, position };
    Some(parts.joint(Universal, frame, vec![parts.dof(0), parts.dof(1)]))
}

/// Merges two hinges about the same axis into a single hinge, whose angle is the sum of both
/// angles.
fn pin(parts: &Chain<'_>, size: f64) -> Option<Joint> {
    let same = are_parallel(parts.axis(0), parts.axis(1))
        && parts.distance(0, parts.frames[1].position) <= SAME * size;
    if !same || !parts.has_plain_dofs() {
        return None;
    }
    let sign = parts.axis(0).dot(parts.axis(1)).signum();
    let position = parts.dof(0).position + sign * parts.dof(1).position;
    let dof = Coordinate { position, ..Coordinate::default() };
    Some(parts.joint(Revolute, parts.frames[0], vec![dof]))
}

/// Merges a hinge and a slide along its axis into a cylindrical joint.
fn sleeve(parts: &Chain<'_>) -> Option<Joint> {
    let hinge = usize::from(parts.kinds()[0] != Revolute);
    let slide = 1 - hinge;
    if !are_parallel(parts.axis(hinge), parts.axis(slide)) {
        return None;
    }
    let same = parts.axis(hinge).dot(parts.axis(slide)) > 0.0;
    let along = if same { parts.dof(slide) } else { reversed(parts.dof(slide)) };
    Some(parts.joint(Cylindrical, parts.frames[hinge], vec![parts.dof(hinge), along]))
}

/// Merges two slides and a hinge about their common normal into a planar joint.
fn plate(parts: &Chain<'_>) -> Option<Joint> {
    let (x, y, z) = (parts.axis(0), parts.axis(1), parts.axis(2));
    let is_plane = are_perpendicular(x, y) && are_perpendicular(x, z) && are_perpendicular(y, z);
    if !is_plane || !parts.has_plain_dofs() {
        return None;
    }
    let right = x.cross(y).dot(z) > 0.0;
    let (first, order) = if right { (x, [0, 1]) } else { (y, [1, 0]) };
    let frame = Pose { rotation: z_and_x(z, first)?, position: parts.frames[2].position };
    let dofs = vec![parts.dof(order[0]), parts.dof(order[1]), parts.dof(2)];
    Some(parts.joint(Planar, frame, dofs))
}

fn replace(context: &Context<'_>, robot: &mut Description, joint: Joint, chain: &[usize]) {
    let what = match joint.kind {
        Spherical => "a ball joint",
        Universal => "a universal joint",
        Cylindrical => "a cylindrical joint",
        Planar => "a planar joint",
        _ => "one hinge joint",
    };
    let names: Vec<String> = chain.iter().map(|&k| quoted(&robot.joints[k].name)).collect();
    let lost = joint.kind == Spherical || joint.kind == Revolute;
    let ranges = chain.iter().any(|&k| robot.joints[k].dofs.iter().any(|dof| dof.range.is_some()));
    let more = if lost && ranges { "; their ranges are left out" } else { "" };
    let message = format!(
        "{}, with massless bodies between them, are replaced by {what}, {}{more} (--literal keeps \
         them)",
        names.join(", "),
        quoted(&joint.name)
    );
    context.note(message, joint.place.clone());
    let bodies: Vec<usize> =
        chain[..chain.len() - 1].iter().map(|&index| robot.joints[index].to).collect();
    let mut joint = joint;
    let taken = |name: &str| {
        let others = robot.joints.iter().enumerate().filter(|(index, _)| !chain.contains(index));
        others.into_iter().any(|(_, other)| other.name == name)
    };
    if taken(&joint.name) {
        joint.name = robot.joints[chain[0]].name.clone();
    }
    robot.joints[chain[0]] = joint;
    remove(robot, &chain[1..], &bodies);
}

#[cfg(test)]
mod tests {
    use super::super::super::description::Body;
    use super::super::super::rotation::z_to;
    use super::*;

    /// Creates a frame at a point, with z along a direction.
    fn along(axis: Vec3<f64>, position: Vec3<f64>) -> Pose<f64> {
        Pose { rotation: z_to(axis), position }
    }

    /// Creates a chain with the given joints, axes and points on the axes, at the coordinates 0.3,
    /// 0.5, 0.7.
    fn chain(parts: &[(JointType, Vec3<f64>, Vec3<f64>)]) -> Description {
        let mut robot = Description::new("URDF", "test", Vec3::zero());
        for (k, (kind, axis, point)) in parts.iter().enumerate() {
            robot.bodies.push(Body::massless(format!("b{k}"), None));
            let mut joint = Joint::new(format!("hip.{k}"), *kind, (k, k + 1));
            joint.frame_j = along(*axis, *point);
            joint.frame_k = along(*axis, *point);
            joint.dofs[0].position = 0.3 + 0.2 * k as f64;
            robot.joints.push(joint);
        }
        robot.bodies.last_mut().unwrap().mass = 1.0;
        robot
    }

    fn merged(parts: &[(JointType, Vec3<f64>, Vec3<f64>)]) -> Description {
        let files = |_: &str| Err(String::new());
        let before = chain(parts);
        let mut robot = before.clone();
        merge(&Context::new(&files, false), &mut robot);
        let end = |robot: &Description| robot.poses().pop().flatten().unwrap();
        let between = end(&before).inverse() * end(&robot);
        // Merging does not move the last body.
        assert!(between.position.norm() < 1e-14);
        assert!(between.rotation.rotation_vector().norm() < 1e-14);
        robot
    }

    #[test]
    fn chains_become_the_joints_that_they_are() {
        let [x, y, z] = [0, 1, 2].map(Vec3::unit);
        let p = Vec3::new(0.3, -0.2, 0.5);
        let skew = Vec3::new(0.6, 0.0, 0.8);
        for (parts, kind) in [
            (vec![(Revolute, x, p), (Revolute, y, p)], Universal),
            (vec![(Revolute, x, p + x), (Revolute, z, p + z)], Universal),
            (vec![(Revolute, x, p), (Revolute, -x, p + x)], Revolute),
            (vec![(Revolute, skew, p), (Prismatic, -skew, x)], Cylindrical),
            (vec![(Prismatic, z, p), (Revolute, z, x)], Cylindrical),
            (vec![(Revolute, x, p), (Revolute, y, p + y), (Revolute, skew, p)], Spherical),
            (vec![(Prismatic, x, p), (Prismatic, y, x), (Revolute, z, y)], Planar),
            (vec![(Prismatic, y, p), (Prismatic, x, x), (Revolute, z, y)], Planar),
        ] {
            let robot = merged(&parts);
            assert_eq!(robot.joints.len(), 1, "{kind:?}");
            assert_eq!((robot.joints[0].kind, robot.joints[0].name.as_str()), (kind, "hip"));
            assert_eq!(robot.bodies.len(), 2);
        }
    }

    #[test]
    fn other_chains_stay() {
        let [x, y, z] = [0, 1, 2].map(Vec3::unit);
        let skew = Vec3::new(0.6, 0.8, 0.0);
        for parts in [
            vec![(Revolute, x, z), (Revolute, y, Vec3::zero())],
            vec![(Revolute, x, Vec3::zero()), (Revolute, skew, Vec3::zero())],
            vec![(Revolute, x, Vec3::zero()), (Revolute, x, z)],
            vec![(Revolute, x, Vec3::zero()), (Prismatic, y, Vec3::zero())],
        ] {
            assert_eq!(merged(&parts).joints.len(), 2);
        }
    }
}
